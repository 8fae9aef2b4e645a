"""Onset and offset against the closed form of minimum jerk."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from armsyn.errors import CaptureError, InputError
from armsyn.motion.segmentation import movement_times, onset_and_offset

PHASE = np.linspace(0, 1, 100_001)
SPEED = 30 * PHASE**2 * (1 - PHASE) ** 2


def test_cut_of_minimum_jerk_is_exact() -> None:
    onset, offset = onset_and_offset(SPEED)
    duration = PHASE[offset] - PHASE[onset]
    travelled = 10 * PHASE**3 - 15 * PHASE**4 + 6 * PHASE**5
    displacement = travelled[offset] - travelled[onset]
    assert duration == pytest.approx(0.88113, abs=2e-5)
    assert displacement == pytest.approx(0.99617, abs=1e-5)
    assert 1.875 * duration / displacement == pytest.approx(1.65848, abs=4e-5)


def test_at_100_hz_it_keeps_89_samples() -> None:
    assert onset_and_offset(SPEED[::1000]) == (6, 94)


def test_only_the_movement_around_the_highest_peak_is_kept() -> None:
    two = np.concatenate([0.5 * SPEED[::1000], np.zeros(20), SPEED[::1000]])
    assert onset_and_offset(two) == (121 + 6, 121 + 94)


def test_a_profile_that_never_rests_is_kept_whole() -> None:
    assert onset_and_offset(np.array([1.0, 2.0, 1.5])) == (0, 2)
    assert onset_and_offset(SPEED[::1000], 0.0) == (0, 100)


@given(
    speed=arrays(np.float64, st.integers(1, 60), elements=st.floats(0, 5)).filter(np.any),
    fraction=st.floats(0, 0.99),
)
def test_kept_samples_are_one_stretch_above_the_fraction(
    speed: np.ndarray, fraction: float
) -> None:
    onset, offset = onset_and_offset(speed, fraction)
    level = fraction * speed.max()
    assert onset <= np.argmax(speed) <= offset
    assert (speed[onset : offset + 1] >= level).all()
    assert onset == 0 or speed[onset - 1] < level
    assert offset == speed.size - 1 or speed[offset + 1] < level


def test_refusals() -> None:
    with pytest.raises(CaptureError, match="does not move"):
        onset_and_offset(np.zeros(5))
    with pytest.raises(CaptureError, match="gaps"):
        onset_and_offset(np.array([0.0, np.nan]))
    with pytest.raises(CaptureError, match="gaps"):
        onset_and_offset(np.array([]))
    with pytest.raises(InputError, match="fraction"):
        onset_and_offset(np.ones(5), 1.0)


@pytest.mark.parametrize("step", [500, 1000, 2000])
def test_times_between_samples_do_not_depend_on_the_grid(step: int) -> None:
    onset, offset = movement_times(PHASE[::step], SPEED[::step])
    assert offset - onset == pytest.approx(0.88113, abs=0.0015)
    assert onset + offset == pytest.approx(1, abs=1e-9)


def test_times_of_a_profile_that_never_rests_are_its_ends() -> None:
    assert movement_times(np.arange(3.0), np.array([1.0, 2.0, 1.5])) == (0.0, 2.0)
