"""Resampling by time stamps against numpy's interpolation and straight lines."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.errors import CaptureError, InputError
from armsyn.motion import Motion
from armsyn.motion.resample import interpolate, resample, uniform_times


def line_motion(time: np.ndarray) -> Motion:
    return Motion(
        time=time,
        joint_names=("elbow",),
        angles=2 * time[:, None],
        landmark_names=("hand",),
        landmarks=time[:, None, None] * [[1.0, -1.0, 3.0]],
        source="line",
    )


@given(
    steps=st.lists(st.floats(1e-3, 1), min_size=1, max_size=30),
    rate=st.floats(1, 300),
)
def test_a_straight_line_stays_itself_however_it_is_stamped(
    steps: list[float], rate: float
) -> None:
    time = np.concatenate([[5.0], 5.0 + np.cumsum(steps)])
    if (time[-1] - time[0]) * rate < 1:
        return
    motion = resample(line_motion(time), rate)
    assert motion.time[0] == time[0]
    assert 0 <= time[-1] - motion.time[-1] < 1 / rate
    gaps = np.diff(motion.time)
    np.testing.assert_allclose(gaps[:-1], 1 / rate, atol=1e-9)
    # a last frame that lies a hair beyond its stamp is kept, at its stamp
    assert gaps[-1] == pytest.approx(1 / rate, rel=1.001e-3)
    np.testing.assert_allclose(motion.hand, motion.time[:, None] * [1, -1, 3], atol=1e-9)
    np.testing.assert_allclose(motion.angles, 2 * motion.time[:, None], atol=1e-9)
    assert (motion.joint_names, motion.source) == (("elbow",), "line")


def test_interpolate_is_numpys_on_every_column() -> None:
    generator = np.random.default_rng(3)
    time = np.cumsum(generator.uniform(0.01, 0.1, 50))
    values = generator.normal(size=(50, 2, 3))
    at = generator.uniform(time[0] - 0.5, time[-1] + 0.5, 200)
    mine = interpolate(time, values, at)
    for i, j in np.ndindex(2, 3):
        np.testing.assert_allclose(mine[:, i, j], np.interp(at, time, values[:, i, j]))


def test_the_last_frame_survives_rounding() -> None:
    time = np.arange(121) / 120.0
    assert resample(line_motion(time), 120.0).frames == 121
    assert resample(line_motion(time), 100.0).frames == 101


def test_a_gap_spreads_to_its_neighbouring_intervals_only() -> None:
    time = np.arange(5.0)
    landmarks = np.zeros((5, 1, 3))
    landmarks[2] = np.nan
    motion = Motion(time=time, landmark_names=("hand",), landmarks=landmarks)
    gaps = np.isnan(resample(motion, 2.0).hand[:, 0])
    assert gaps.tolist() == [False, False, False, True, True, True, False, False, False]


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), float("inf")])
def test_a_rate_must_be_positive(rate: float) -> None:
    with pytest.raises(InputError, match="rate"):
        uniform_times(0.0, 1.0, rate)


@pytest.mark.parametrize("rate", [0.5, 1e9])
def test_too_few_or_too_many_samples_are_refused(rate: float) -> None:
    with pytest.raises(CaptureError, match="samples"):
        uniform_times(0.0, 1.0, rate)
