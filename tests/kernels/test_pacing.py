"""Any number of joints is paced as by arrays, though eight of them stand side by side."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from armsyn.kernels.pacing import fill_beyond, hold_within, pace_reaches, sample_reaches
from armsyn.kernels.rates import RateLimits
from armsyn.kernels.sampling import Ease
from armsyn.planning.timing import CUT_SPEED, CUT_TIME, PhasePath, Rates, phases

FloatArray = NDArray[np.float64]
RATE, COUNT = 200.0, 5
JOINTS = [1, 3, 7, 8, 9, 17]


def motions_of(n: int) -> FloatArray:
    phase, rng = np.linspace(0.0, 1.0, 101)[:, None], np.random.default_rng(n)
    bell = phase**3 * (10.0 - 15.0 * phase + 6.0 * phase**2)
    return np.asarray(bell * rng.normal(0.0, 2.0, (COUNT, 1, n)) + rng.normal(size=(COUNT, 1, n)))


def in_arrays(motion: FloatArray, duration: float, rates: Rates) -> tuple[FloatArray, float]:
    """What `armsyn.planning.timing.in_time` does, of joints without an arm."""
    path, scale = PhasePath(motion), 1.0
    start, end = path.ramps()
    while True:
        time = (1.0 + 0.5 * (start + end)) * duration * scale
        sampled = path.at(phases(int(np.ceil(time * RATE)) + 1, start, end))
        if (excess := float(rates.excess(sampled, RATE).max())) <= 1.0:
            return sampled, scale
        scale *= max(excess, 1.01)


@pytest.mark.parametrize("n", JOINTS)
def test_joints_are_paced_as_in_arrays(n: int) -> None:
    motions, durations = motions_of(n), np.linspace(0.3, 1.0, COUNT)
    bounds = np.random.default_rng(n).uniform(1.0, 3.0, n)
    rates = Rates(2.0 * bounds, 10.0 * bounds, 2000.0 * bounds)
    ease, frames, scales = Ease(2.0 * CUT_TIME, CUT_SPEED), np.zeros(COUNT, int), np.zeros(COUNT)
    pace_reaches(motions, durations, RateLimits(*rates), RATE, 1, ease, frames, scales)
    first = np.concatenate([[0], np.cumsum(frames)])
    paths = np.empty((first[-1], n))
    sample_reaches(motions, ease, first, paths)
    for row in range(COUNT):
        wanted, scale = in_arrays(motions[row], durations[row], rates)
        assert scales[row] == pytest.approx(scale, rel=1e-9)
        found = paths[first[row] : first[row + 1]]
        np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("n", JOINTS)
@pytest.mark.parametrize("frame", [0, 60, 100])
def test_what_leaves_a_range_is_found_in_every_joint_and_frame(n: int, frame: int) -> None:
    lower, upper = np.full(n, -1.0), np.full(n, 1.0)
    for row in range(COUNT):
        for joint in range(n):
            motions = np.random.default_rng(7).uniform(-0.9, 0.9, (COUNT, 101, n))
            motions[row, frame, joint] = 1.2
            wanted = np.arange(COUNT) == row
            found = np.empty(COUNT, dtype=np.bool_)
            fill_beyond(lower, upper, 0.1, motions, found)
            assert (found == wanted).all()
            clipped = np.clip(motions, -1.0, 1.0).reshape(-1, n)
            paths, first = motions.reshape(-1, n).copy(), 101 * np.arange(COUNT + 1)
            hold_within(lower, upper, 0.1, first, paths, found)
            assert (found == wanted).all()
            np.testing.assert_array_equal(paths, clipped)


def test_short_motions_are_looked_at_one_by_one() -> None:
    """Of one joint and four phases, two motions are less than what is loaded at once."""
    lower, upper, found = np.full(1, -1.0), np.full(1, 1.0), np.empty(3, dtype=np.bool_)
    for row in range(3):
        motions = np.zeros((3, 4, 1))
        motions[row, 3] = 1.2
        fill_beyond(lower, upper, 0.1, motions, found)
        assert (found == (np.arange(3) == row)).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize(("phase", "joint"), [(0, 0), (1, 6), (50, 3), (99, 2), (100, 6)])
def test_what_is_no_number_is_not_paced(bad: float, phase: int, joint: int) -> None:
    motions, frames, scales = motions_of(7), np.zeros(COUNT, int), np.zeros(COUNT)
    motions[2, phase, joint] = bad
    bounds, ease = RateLimits(*np.full((3, 7), 1e6)), Ease(2.0 * CUT_TIME, CUT_SPEED)
    pace_reaches(motions, np.ones(COUNT), bounds, RATE, 1, ease, frames, scales)
    assert ((frames == 0) == (np.arange(COUNT) == 2)).all()


@pytest.mark.parametrize("frame", [0, 20, 39])
def test_what_is_no_number_is_not_clipped_to_one(frame: int) -> None:
    paths, found = np.zeros((40, 7)), np.empty(2, dtype=np.bool_)
    paths[frame, 4] = np.nan
    wanted = paths.copy()
    hold_within(np.full(7, -1.0), np.full(7, 1.0), 0.1, np.array([0, 20, 40]), paths, found)
    np.testing.assert_array_equal(paths, wanted)
