"""Scores: how close a motion is to a captured one, and how much it looks like a person's."""

from armsyn.scoring.measures import (
    ProfileMeasures,
    measure,
    movement,
    normalised_speed,
    profile_measures,
)
from armsyn.scoring.profile import correlation, minimum_jerk_speed

__all__ = [
    "ProfileMeasures",
    "correlation",
    "measure",
    "minimum_jerk_speed",
    "movement",
    "normalised_speed",
    "profile_measures",
]
