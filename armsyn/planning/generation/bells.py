"""Many reaches at once: whether each one's hand speeds up once (`armsyn.planning.evenness`)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from armsyn.kernels.distance import ShapeArrays
from armsyn.kinematics import SerialChain
from armsyn.motion.filtering import CUTOFF, LOWEST_RATE, REST
from armsyn.motion.peaks import PEAK_RISE, PEAK_SPACING
from armsyn.motion.segmentation import CUT_FRACTION, SHORTEST_REST, SLIP
from armsyn.planning.evenness import uneven_speed
from armsyn.planning.generation.hands import count_each, count_movements, place_hands
from armsyn.planning.generation.pacing import Paced

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_AT_ONCE = 256
"""Reaches that are filtered together: a few megabytes."""


def hands_along(chain: SerialChain, paths: FloatArray) -> FloatArray:
    """Return where the hand is at many postures, shape (frames, n) to (frames, 3), m."""
    hands = np.empty((len(paths), 3))
    place_hands(chain.arrays, _tip_of(chain), paths, hands)
    return hands


def uneven_reaches(chain: SerialChain, paced: Paced) -> BoolArray:
    """Return which hands speed up more than once, as `armsyn.planning.evenness.uneven_speed` does.

    Parameters
    ----------
    chain : SerialChain
    paced : Paced
        M reaches.

    Returns
    -------
    array of bool, shape (M,)
    """
    hands, rate = hands_along(chain, paced.paths), paced.rate_hz
    counts = np.empty(len(paced.scales), dtype=np.int64)
    count_each(hands, paced.first, rate, PEAK_RISE, PEAK_SPACING * rate, counts)
    uneven = counts > 1
    rows = np.flatnonzero(uneven)
    paths = [hands[paced.first[row] : paced.first[row + 1]] for row in rows.tolist()]
    if rate < LOWEST_RATE:  # interpolated before it is filtered
        uneven[rows] = [uneven_speed(path, rate) is not None for path in paths]
        return uneven
    for begin in range(0, len(rows), _AT_ONCE):
        some = slice(begin, begin + _AT_ONCE)
        uneven[rows[some]] = _filtered_peaks(paths[some], rate) > 1
    return uneven


def _tip_of(chain: SerialChain) -> ShapeArrays:
    """The tip as a shape without extent, which is what is placed at many postures at once."""
    tip = chain.arrays.translation[-1:]
    return ShapeArrays(
        np.array([chain.dof - 1]),
        tip,
        tip,
        np.zeros(1),
        np.empty((0, 4)),
        np.empty((0, 3, 3)),
        np.empty((0, 3)),
        np.empty((0, 3)),
        np.empty((0, 3), dtype=np.int64),
    )


def _filtered_peaks(paths: list[FloatArray], rate: float) -> NDArray[np.int64]:
    """Peaks of hands' speeds as `armsyn.scoring.movement` measures them, from onset to offset."""
    rest = round(REST * rate)
    lengths = np.array([len(path) + 2 * rest for path in paths])
    speeds = np.ascontiguousarray(_filtered_speeds(paths, rate, rest))
    counts = np.empty(len(paths), dtype=np.int64)
    count_movements(
        speeds,
        lengths,
        CUT_FRACTION,
        SLIP,
        max(1, round(SHORTEST_REST * rate)),
        PEAK_RISE,
        PEAK_SPACING * rate,
        counts,
    )
    return counts


def _filtered_speeds(paths: list[FloatArray], rate: float, rest: int) -> FloatArray:
    """Speeds through the filter of `armsyn.motion.filtering`, shape (M, samples), m/s.

    Hands rest before and after, where their velocity is nought: there the two passes are one
    product of spectra, by |H|^2 = 1 / (1 + (tan(w / 2) / tan(w_c / 2))^4) of the bilinear transform
    (Oppenheim and Schafer, *Discrete-Time Signal Processing*, section 7.2).
    """
    samples = max(map(len, paths)) + 2 * rest
    velocity = np.zeros((len(paths), samples, 3))
    for row, path in enumerate(paths):
        still = np.concatenate([path[:1], path[:1], path, path[-1:], path[-1:]])
        velocity[row, rest - 1 : rest + 1 + len(path)] = (still[2:] - still[:-2]) * (0.5 * rate)
    size = 1 << (samples - 1).bit_length()
    bend = np.tan(np.pi * np.arange(size // 2 + 1) / size * (1.0 - 1e-12))
    passed = 1.0 / (1.0 + (bend / math.tan(math.pi * CUTOFF / rate)) ** 4)
    spectrum = np.fft.rfft(velocity, size, axis=1) * passed[:, None]
    filtered = np.fft.irfft(spectrum, size, axis=1)[:, :samples]
    return np.asarray(np.sqrt(np.einsum("mfk,mfk->mf", filtered, filtered)))
