"""Paths, path time and straight ways against closed forms."""

import contextlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from armsyn.arm import ArmDescription
from armsyn.driver.path import BLEND, MOST_FRAMES, Path, PathTime, minimum_jerk, straight_way
from armsyn.errors import CollisionError, RefusedMotionError
from armsyn.motion import Motion
from armsyn.safety import check_trajectory

ANGLES = st.lists(st.floats(-3.0, 3.0, allow_nan=False), min_size=2, max_size=12)


def motion(values: list[float], step: float = 0.1) -> Motion:
    return Motion(
        time=np.arange(len(values)) * step, joint_names=("a",), angles=np.array(values)[:, None]
    )


@given(ANGLES)
def test_between_samples_a_path_never_leaves_their_range(values: list[float]) -> None:
    path = Path(motion(values))
    for k in range(len(values) - 1):
        low, high = sorted(values[k : k + 2])
        for part in (0.0, 0.2, 0.5, 0.9, 1.0):
            assert low - 1e-9 <= path.at((k + part) * 0.1)[0] <= high + 1e-9


@given(ANGLES)
def test_interpolation_of_scipy(values: list[float]) -> None:
    # scipy's slopes at the two ends differ; in between both are Fritsch and Butland's
    path = Path(motion(values))
    with np.errstate(over="ignore"):  # scipy divides by slopes, however small
        other = PchipInterpolator(np.arange(len(values)) * 0.1, values)
    for k in range(1, len(values) - 2):
        assert path.at((k + 0.3) * 0.1)[0] == pytest.approx(float(other((k + 0.3) * 0.1)), abs=1e-9)


def test_before_and_after_a_path_are_its_ends() -> None:
    path = Path(motion([1.0, 2.0, 5.0]))
    assert path.duration == pytest.approx(0.2)
    assert path.at(-1.0)[0] == 1.0
    assert path.at(9.0)[0] == 5.0


def test_the_start_fades_into_the_path() -> None:
    path = Path(motion([0.0] * 21), start=np.array([0.04]))
    assert path.at(0.0)[0] == pytest.approx(0.04)
    assert path.at(BLEND / 2)[0] == pytest.approx(0.02)
    assert path.at(BLEND)[0] == 0.0


@given(ANGLES, st.sampled_from([None, 0.0, 0.04]))
def test_many_postures_are_the_same_as_one_by_one(values: list[float], off: float | None) -> None:
    start = None if off is None else np.array([values[0] + off])
    path = Path(motion(values), start=start)
    times = np.linspace(-0.1, path.duration + 0.1, 57)
    one_by_one = [path.at(t) for t in times.tolist()]
    np.testing.assert_allclose(path.at_times(times), one_by_one, rtol=0.0, atol=1e-12)
    assert path.at_times(times[:0]).shape == (0, 1)


def test_a_path_begins_and_ends_at_rest() -> None:
    path = Path(motion([0.0, 0.1, 0.3, 0.4]))
    for end in (0.0, 0.3):
        assert abs(path.at(end + 1e-4)[0] - path.at(end - 1e-4)[0]) < 1e-6


def test_a_short_motion_is_blended_into_as_slowly_as_a_long_one() -> None:
    path = Path(motion([0.0, 0.0]), start=np.array([0.04]))
    assert path.duration == BLEND
    assert path.at(BLEND / 2)[0] == pytest.approx(0.02)
    assert path.at(BLEND)[0] == 0.0
    assert Path(motion([0.0, 0.0]), start=np.zeros(1)).duration == pytest.approx(0.1)


def test_path_time_runs_like_time_until_it_is_stopped() -> None:
    path_time = PathTime()
    for _ in range(100):
        path_time.advance(0.005)
    assert path_time.now == pytest.approx(0.5)
    path_time.stop(0.4)
    ticks = 0
    while not path_time.stopped:
        path_time.advance(0.005)
        ticks += 1
    assert ticks in (80, 81)
    assert path_time.now == pytest.approx(0.5 + 0.5 * 0.4, abs=0.003)  # the ramp's triangle
    assert path_time.stopping


@pytest.mark.fault(27)
def test_path_time_after_a_stall_starts_from_rest() -> None:
    path_time = PathTime()
    path_time.advance(0.005)
    path_time.resume_from_rest(0.2)
    assert not path_time.stopped
    first = path_time.now
    path_time.advance(0.005)
    assert path_time.now - first < 0.0002
    for _ in range(200):
        path_time.advance(0.005)
    assert not path_time.stopping
    before = path_time.now
    assert path_time.advance(0.005) - before == pytest.approx(0.005)


def test_minimum_jerk_has_its_known_peaks() -> None:
    x = np.linspace(0.0, 1.0, 10_001)
    speed = np.gradient(minimum_jerk(x), x)
    assert speed.max() == pytest.approx(15 / 8, rel=1e-4)
    assert np.abs(np.gradient(speed, x)).max() == pytest.approx(10 / np.sqrt(3), rel=1e-3)
    assert minimum_jerk([-1.0, 0.5, 2.0]).tolist() == [0.0, 0.5, 1.0]


@settings(deadline=None)  # the first example compiles
@given(st.lists(st.floats(0.05, 0.95), min_size=7, max_size=7))
def test_a_straight_way_keeps_the_limits_and_uses_them(
    human7: ArmDescription, where: list[float]
) -> None:
    lower, upper = human7.chain.lower, human7.chain.upper
    goal = lower + np.array(where) * (upper - lower)
    way = straight_way(human7.rest, goal, human7, 200.0)
    with contextlib.suppress(CollisionError):  # looked for after all limits
        check_trajectory(way, human7, human7.rest)
    assert way.angles is not None
    assert way.angles[-1] == pytest.approx(goal)
    velocity = np.abs(np.diff(way.angles, axis=0) * 200.0).max(axis=0)
    acceleration = np.abs(np.diff(way.angles, 2, axis=0) * 200.0**2).max(axis=0)
    used = max(
        (velocity / human7.max_velocity).max(), (acceleration / human7.max_acceleration).max()
    )
    assert used > 0.8 or way.duration < 0.31


def test_a_way_that_is_too_slow_is_refused_before_it_is_laid_out(human7: ArmDescription) -> None:
    goal = human7.rest + 0.1
    with pytest.raises(RefusedMotionError, match=r"at 200 Hz 600 s is the longest .*move faster"):
        straight_way(human7.rest, goal, human7.slowed(1e6), 200.0)
    slow = straight_way(human7.rest, goal, human7.slowed(500.0), 200.0)
    assert len(slow.time) <= MOST_FRAMES


def test_a_ramp_of_path_time_asks_for_no_leap_of_acceleration() -> None:
    path_time = PathTime()
    path_time.advance(0.005)
    path_time.stop(0.4)
    times = [path_time.now, *(path_time.advance(0.005) for _ in range(85))]
    acceleration = np.diff(times, 2) / 0.005**2
    assert np.abs(acceleration).max() <= 1.5 / 0.4 * 1.001  # smoothstep's steepest
    # which it comes to by at most smoothstep's second derivative, 6 / T^2, a tick
    assert np.abs(np.diff(acceleration)).max() <= 6.0 / 0.4**2 * 0.005 * 1.01
