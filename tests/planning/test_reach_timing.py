"""Motions over phase made samples in time: eased, slowed, and the same path."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from armsyn.arm import ArmDescription, load_arm
from armsyn.errors import LimitError
from armsyn.planning import planner_for
from armsyn.planning.timing import CUT_TIME, PhasePath, in_time, phases
from tests.planning.apart import pace

PHASE = np.linspace(0.0, 1.0, 101)
RATE = 200.0


@pytest.fixture(scope="module")
def arm() -> ArmDescription:
    return load_arm("human7")


def minimum_jerk(x: np.ndarray) -> np.ndarray:
    return np.asarray(x**3 * (10 - 15 * x + 6 * x**2))


def cut_reach(arm: ArmDescription, size: float = 1.0) -> np.ndarray:
    """A minimum-jerk reach as captures are cut: from and to 5 % of its peak speed."""
    edge = 0.5 * (1.0 - 0.88113)
    course = minimum_jerk(edge + (1.0 - 2.0 * edge) * PHASE)
    way = size * np.array([1.0, -0.3, 0.2, 0.7, 0.1, 0.1, -0.1])
    return np.asarray(arm.rest + (course - course[0])[:, None] * way)


def test_the_spline_is_scipys() -> None:
    angles = np.random.default_rng(0).normal(size=(101, 5)).cumsum(axis=0)
    phase = np.linspace(0.0, 1.0, 777)
    wanted = CubicSpline(PHASE, angles, bc_type="not-a-knot")(phase)
    np.testing.assert_allclose(PhasePath(angles).at(phase), wanted, atol=1e-11)


@pytest.mark.parametrize(("start", "end"), [(0.1, 0.2), (0.0, 0.15), (0.0, 0.0), (0.13, 0.0)])
def test_phase_is_the_integral_of_a_rate_that_rises_and_falls(start: float, end: float) -> None:
    whole = 1.0 + 0.5 * (start + end)
    time = np.linspace(0.0, whole, 20_001)
    rate = np.ones_like(time)
    for ramp, at in ((start, time), (end, whole - time)):
        if ramp:
            rate *= np.where(at < ramp, minimum_jerk(np.clip(at / ramp, 0.0, 1.0)), 1.0)
    wanted = np.append(0.0, np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(time)))
    found = phases(time.size, start, end)
    np.testing.assert_allclose(found, wanted, atol=1e-7)
    assert (np.diff(found) >= 0.0).all()
    assert (found[0], found[-1]) == (0.0, 1.0)


def test_the_ramps_are_what_the_cut_took_off(arm: ArmDescription) -> None:
    """Of a reach that rests at its ends, nothing."""
    assert PhasePath(cut_reach(arm)).ramps() == pytest.approx((2 * CUT_TIME,) * 2, rel=0.01)
    whole = arm.rest + minimum_jerk(PHASE)[:, None]
    assert PhasePath(whole).ramps() == pytest.approx((0.0, 0.0), abs=0.005)


def test_a_cut_reach_takes_as_long_as_before_the_cut(arm: ArmDescription) -> None:
    timed = in_time(cut_reach(arm, 0.2), 0.88113, arm, RATE)
    assert timed.time_scale == 1.0
    assert (len(timed.angles) - 1) / RATE == pytest.approx(1.0, abs=0.006)


@pytest.mark.parametrize("duration", [0.3, 0.6, 1.2])
@pytest.mark.parametrize("rate", [100.0, 200.0, 500.0])
def test_it_is_slowed_until_the_limits_hold_and_no_more(
    arm: ArmDescription, duration: float, rate: float
) -> None:
    timed = in_time(cut_reach(arm), duration, arm, rate)
    resting = np.vstack([timed.angles[:1]] * 2 + [timed.angles] + [timed.angles[-1:]] * 2)
    velocity = np.diff(resting, axis=0) * rate
    acceleration = np.diff(velocity, axis=0) * rate
    used = max(
        (np.abs(velocity) / arm.max_velocity).max(),
        np.sqrt((np.abs(acceleration) / arm.max_acceleration).max()),
    )
    assert used <= 1.0
    assert timed.time_scale == 1.0 or used > 0.9
    assert timed.time_scale >= 1.0


def test_what_would_take_hours_is_refused_before_it_is_sampled(arm: ArmDescription) -> None:
    """A reach of a second, slowed 10,000 times."""
    slow = arm.slowed(1e4)
    with pytest.raises(LimitError, match="more than an hour, for") as told:
        in_time(cut_reach(arm), 1.0, slow, RATE)
    assert 3600.0 < told.value.value < 1e5
    assert pace(slow, cut_reach(arm)[None], np.ones(1), RATE).lengths.tolist() == [0]
    for plan in ("minjerk", "synergy"):
        with pytest.raises(LimitError, match="more than an hour, for"):
            planner_for(slow, plan).plan(slow.rest, [0.35, -0.1, -0.15])


def test_a_reach_of_minutes_is_paced_among_others_as_it_is_alone(arm: ArmDescription) -> None:
    """At a 900th of the speed, a third of a person's time is at first 1,500 times too little."""
    slow = arm.slowed(900.0)
    alone, among = (
        in_time(cut_reach(arm), 0.3, slow, RATE),
        pace(slow, cut_reach(arm)[None], np.array([0.3]), RATE),
    )
    assert among.lengths.tolist() == [len(alone.angles)]
    assert among.scales[0] == pytest.approx(alone.time_scale, rel=1e-9)
    assert among.scales[0] > 1000.0


def test_slowing_leaves_angles_over_phase(arm: ArmDescription) -> None:
    """Every sample lies on the spline: the phase found from one joint gives all the others."""
    angles = cut_reach(arm)
    angles[:, 1] += 0.1 * np.sin(3 * PHASE)
    timed = in_time(angles, 0.2, arm, RATE)
    assert timed.time_scale > 2.0
    path = PhasePath(angles)
    fine = np.linspace(0.0, 1.0, 20_001)
    phase = np.interp(timed.angles[:, 0], path.at(fine)[:, 0], fine)
    np.testing.assert_allclose(timed.angles, path.at(phase), atol=1e-6)
    np.testing.assert_array_equal(timed.angles[[0, -1]], angles[[0, -1]])


@pytest.mark.parametrize(("plan", "ik"), [("minjerk", None), ("synergy", None), ("synergy", "svd")])
def test_a_reach_of_few_frames_is_a_finer_one_thinned(
    arm: ArmDescription, plan: str, ik: str | None
) -> None:
    """So limits hold between the frames of a plan for 50 Hz, too, as between generate's."""
    planner = planner_for(arm, plan, ik=ik)
    fine, few = (planner.plan(arm.rest, [0.35, -0.1, -0.15], rate) for rate in (200.0, 50.0))
    assert few.time_scale == fine.time_scale
    assert few.trajectory.rate == pytest.approx(50.0)
    moving = int(np.flatnonzero((few.angles != few.angles[-1]).any(axis=1))[-1]) + 1
    np.testing.assert_array_equal(few.angles[:moving], fine.angles[::4][:moving])
    np.testing.assert_array_equal(few.angles[-1], fine.angles[-1])
