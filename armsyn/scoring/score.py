"""A whole score: distances, human-likeness and its place in bands, of two motions by name."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from armsyn.errors import FormatError, InputError
from armsyn.motion import Motion
from armsyn.motion.base_transform import BaseTransform
from armsyn.motion.filtering import CUTOFF, hand_speed
from armsyn.motion.segmentation import CUT_FRACTION
from armsyn.scoring.bands import Band, Bands
from armsyn.scoring.comparison import Comparison, compare
from armsyn.scoring.floor import HumanFloor, human_floor
from armsyn.scoring.human_likeness import How, human_likeness
from armsyn.scoring.joint_map import JointMap, mapped
from armsyn.scoring.movements import bouts, only_movement
from armsyn.scoring.pairing import ANGLES_ALONE, neighbours
from armsyn.scoring.repeats import repeats_of
from armsyn.scoring.report import as_dict


class Which(NamedTuple):
    """A movement of a recording."""

    number: int
    """From 1."""
    of: int
    """How many there are."""


@dataclass(frozen=True)
class Settings:
    """How two motions are scored.

    Parameters
    ----------
    cutoff, fraction : float
        Hz of the low-pass (None: none), and share of the peak speed at onset and offset.
    rebuild : bool
        Whether the other's segments are rebuilt on the captured lengths, where the landmarks are
        an arm's: by their names, or by the joint map.
    transform : BaseTransform or None
        Of the session, from the other's base to the captured one.
    joint_map : tuple of (str, str)
        Landmarks to compare, captured and other's, the hand last; empty for those named alike.
    captured_movement, movement : int or None
        Which movement of each, from 1; None for the one of the highest speed.
    bands : Bands or None
        To place both in.
    """

    cutoff: float | None = CUTOFF
    fraction: float = CUT_FRACTION
    rebuild: bool = True
    transform: BaseTransform | None = None
    joint_map: JointMap = ()
    captured_movement: int | None = None
    movement: int | None = None
    bands: Bands | None = None


@dataclass(frozen=True, eq=False)
class Score:
    """One motion scored against a captured one.

    Parameters
    ----------
    captured_name, other_name : str
        As the user named them.
    captured, other : Motion
        As compared, before trimming and rebuilding: the other in the captured base.
    comparison : Comparison
        Distances, and how they were taken.
    captured_movement, other_movement : Which
        What was scored of each.
    captured_likeness, other_likeness : dict of str to float
        By the keys of `armsyn.scoring.human_likeness.MEASURES`; NaN where not defined.
    how : How
        Those were measured.
    bands : Bands or None
    """

    captured_name: str
    other_name: str
    captured: Motion
    other: Motion
    comparison: Comparison
    captured_movement: Which
    other_movement: Which
    captured_likeness: dict[str, float]
    other_likeness: dict[str, float]
    how: How
    bands: Bands | None


def score_motions(
    captured: tuple[str, Motion], other: tuple[str, Motion], settings: Settings
) -> Score:
    """Score a motion against a captured one.

    Parameters
    ----------
    captured, other : (str, Motion)
        Names and motions. A name of a captured reach that its person repeated brings its floor.
    settings : Settings

    Returns
    -------
    Score

    Raises
    ------
    InputError
        When bands were measured another way, there is no such movement, or the motions cannot be
        compared (also as FormatError or CaptureError).
    """
    name = captured[0]
    first = mapped(captured[1], settings.joint_map, other=False)
    second = mapped(other[1], settings.joint_map, other=True)
    cutoff, fraction = settings.cutoff, settings.fraction
    how = _how_of(settings, max(first.rate, second.rate))
    first, first_movement = _one_movement(first, settings.captured_movement, settings)
    second, second_movement = _one_movement(second, settings.movement, settings)
    if settings.transform is not None:
        second = settings.transform.apply(second)
    comparison = compare(
        first,
        second,
        transform=settings.transform,
        rebuild=(True if settings.joint_map else None) if settings.rebuild else False,
        neighbours=_mapped_neighbours(captured[1], other[1], settings.joint_map),
        cutoff=cutoff,
        fraction=fraction,
    )
    floor = _floor(name, comparison.landmarks, settings)
    cut_out = _cut_out(first_movement, second_movement)
    comparison = dataclasses.replace(comparison, floor=floor, cut_out=cut_out)
    if settings.joint_map:
        theirs = tuple(names[1] for names in settings.joint_map)
        comparison = dataclasses.replace(comparison, other_landmarks=theirs)
    return Score(
        captured_name=name,
        other_name=other[0],
        captured=first,
        other=second,
        comparison=comparison,
        captured_movement=first_movement,
        other_movement=second_movement,
        captured_likeness=human_likeness(first, how),
        other_likeness=human_likeness(second, how),
        how=how,
        bands=settings.bands,
    )


def _mapped_neighbours(captured: Motion, other: Motion, pairs: JointMap) -> tuple[bool, ...] | None:
    """Which of a map's landmarks follow each other in both motions as they were."""
    if not pairs:
        return None
    ours, theirs = zip(*pairs, strict=True)
    return neighbours((captured.landmark_names, ours), (other.landmark_names, theirs))


def _one_movement(
    recording: Motion, number: int | None, settings: Settings
) -> tuple[Motion, Which]:
    """Return the wanted movement, or the one with the highest speed, and which it is."""
    if recording.landmarks is None:
        raise FormatError(f"{recording.source or 'motion'}: {ANGLES_ALONE}")
    found = bouts(recording, cutoff=settings.cutoff, fraction=settings.fraction)
    if number is None and len(found) < 2:
        return recording, Which(1, len(found))
    if number is None:
        peak = hand_speed(recording.time, recording.hand, cutoff=settings.cutoff)
        at = float(peak.time[np.argmax(peak.speed)])
        number = next(place for place, one in enumerate(found, 1) if at <= one.end)
    taken = only_movement(recording, number, cutoff=settings.cutoff, fraction=settings.fraction)
    return taken, Which(number, len(found))


def _cut_out(captured: Which, other: Which) -> str:
    parts = [
        f"{label}: movement {which.number} of {which.of}"
        for label, which in (("A", captured), ("B", other))
        if which.of > 1
    ]
    return ", ".join(parts)


def _how_of(settings: Settings, rate: float) -> How:
    """Measure as the bands do, which must have the same filter and cut as the distances."""
    if settings.bands is None:
        return How(settings.cutoff, settings.fraction, max(rate, How().rate))
    how = settings.bands.how
    if (how.cutoff, how.fraction) != (settings.cutoff, settings.fraction):
        low_pass = "none" if how.cutoff is None else f"{how.cutoff:g}"
        raise InputError(
            f"the bands were measured with --cutoff {low_pass} --cut {how.fraction:g}:"
            " score with the same"
        )
    return how


def _floor(name: str, landmarks: tuple[str, ...], settings: Settings) -> HumanFloor | None:
    repeats = repeats_of(name)
    if repeats is None:
        return None
    return human_floor(
        *repeats, landmarks=landmarks, cutoff=settings.cutoff, fraction=settings.fraction
    )


def score_as_dict(score: Score) -> dict[str, Any]:
    """Return a score as a JSON document: SI units, angles in degrees, names say which.

    Parameters
    ----------
    score : Score

    Returns
    -------
    dict
        What is not defined is None.
    """
    document = {
        "a": score.captured_name,
        "b": score.other_name,
        "a_movement": score.captured_movement._asdict(),
        "b_movement": score.other_movement._asdict(),
        **as_dict(score.comparison),
        "human_likeness": {
            "rate_hz": score.how.rate,
            "captured": _defined(score.captured_likeness),
            "other": _defined(score.other_likeness),
        },
    }
    if score.bands is None:
        return document
    places = {key: _placed(score, key, band) for key, band in score.bands.measures.items()}
    about = {"captures": score.bands.captures, "reaches": score.bands.reaches}
    return document | {"bands": {**about, "measures": places}}


def _placed(score: Score, key: str, band: Band) -> dict[str, Any]:
    return {
        "median": band.median,
        "p5": band.low,
        "p95": band.high,
        "n": band.n,
        "captured": band.place(score.captured_likeness[key]),
        "other": band.place(score.other_likeness[key]),
    }


def _defined(values: dict[str, float]) -> dict[str, float | None]:
    return {key: value if math.isfinite(value) else None for key, value in values.items()}
