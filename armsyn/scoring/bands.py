"""Bands of human-likeness: what captured people measure, for other motions to be placed in.

Minimum jerk is not the human, and no one number is: what a task's captured reaches measure is the
reference for a motion of the same task.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from armsyn.errors import CaptureError, InputError
from armsyn.motion import FloatArray, Motion
from armsyn.scoring.human_likeness import How, human_likeness, relative_speed
from armsyn.scoring.repeats import MeanFloor, mean_floor

FEWEST = 5
"""Captures that a band needs."""
PERCENTILES = (5.0, 50.0, 95.0)

Place = Literal["below", "within", "above"]


class Band(NamedTuple):
    """What captures measure: median, 5th and 95th percentile, and of how many."""

    median: float
    low: float
    high: float
    n: int

    def place(self, value: float) -> Place | None:
        """Say where a value lies; None for NaN."""
        if math.isnan(value):
            return None
        return "below" if value < self.low else "above" if value > self.high else "within"


@dataclass(frozen=True, eq=False)
class Bands:
    """Bands of every measure over a set of captures.

    Parameters
    ----------
    captures : str
        The selection, for people.
    how : How
        Filter, cut and rate; what is placed in the bands is measured the same way.
    measures : dict of str to Band
        By the keys of `MEASURES`; without those that too few captures have.
    speed : array, shape (3, 101)
        5th, 50th and 95th percentile of the hand's relative speed over normalised time.
    reaches : int
        Captures measured.
    floor : MeanFloor or None
        Of the captures; None where none is repeated often enough.
    left_out : dict of str to str
        Captures that could not be measured, and why.
    inputs_sha256 : str
        Of all captures' time stamps, landmarks and angles.
    """

    captures: str
    how: How
    measures: dict[str, Band]
    speed: FloatArray
    reaches: int
    floor: MeanFloor | None
    left_out: dict[str, str]
    inputs_sha256: str


def bands_of(
    captures: str,
    motions: Sequence[tuple[str, Motion]],
    how: How,
    on_progress: Callable[[str, int, int], None] = lambda _stage, _done, _total: None,
) -> Bands:
    """Measure a set of captures.

    Parameters
    ----------
    captures : str
        The selection, for people.
    motions : sequence of (str, Motion)
        Captures, by the names that `load_captures` gives them or any other.
    how : How
        Filter, cut and rate.
    on_progress : callable
        Given the stage, how many are done and of how many, after each.

    Returns
    -------
    Bands
        Of every measure that five captures have at least.

    Raises
    ------
    CaptureError
        When fewer than five captures can be measured.
    """
    found, speeds, left_out = [], [], {}
    digest = hashlib.sha256()
    for done, (name, motion) in enumerate(motions, 1):
        for array in (motion.time, motion.landmarks, motion.angles):
            digest.update(b"-" if array is None else array.astype("<f8").tobytes())
        try:
            measured = human_likeness(motion, how)
            speeds.append(relative_speed(motion, how))
            found.append(measured)
        except InputError as error:
            left_out[name] = str(error)
        on_progress("measuring", done, len(motions))
    if len(found) < FEWEST:
        why = next(iter(left_out.values()), "there are no more")
        raise CaptureError(
            f"{captures}: {len(found)} usable captures, a band needs {FEWEST}: {why}"
        )
    bands = {key: _band([values[key] for values in found]) for key in found[0]}
    return Bands(
        captures=captures,
        how=how,
        measures={key: band for key, band in bands.items() if band.n >= FEWEST},
        speed=np.percentile(speeds, PERCENTILES, axis=0),
        reaches=len(found),
        floor=mean_floor(
            motions, how.cutoff, how.fraction, lambda *done: on_progress("human floor", *done)
        ),
        left_out=left_out,
        inputs_sha256=digest.hexdigest(),
    )


def _band(values: list[float]) -> Band:
    known = np.array([value for value in values if math.isfinite(value)])
    if not known.size:
        return Band(math.nan, math.nan, math.nan, 0)
    low, median, high = (float(value) for value in np.percentile(known, PERCENTILES))
    return Band(median, low, high, int(known.size))
