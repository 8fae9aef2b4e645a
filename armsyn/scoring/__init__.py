"""Scores: how close a motion is to a captured one, and how much it looks like a person's."""

from armsyn.scoring.comparison import Comparison, compare
from armsyn.scoring.distance import mean_distance, paper_distance
from armsyn.scoring.measures import (
    ProfileMeasures,
    measure,
    movement,
    normalised_speed,
    profile_measures,
)
from armsyn.scoring.profile import correlation, minimum_jerk_speed

__all__ = [
    "Comparison",
    "ProfileMeasures",
    "compare",
    "correlation",
    "mean_distance",
    "measure",
    "minimum_jerk_speed",
    "movement",
    "normalised_speed",
    "paper_distance",
    "profile_measures",
]
