"""Profiles against their closed forms."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_sim.physics.profile import Profile, ProfileType, time_profile, velocity_profile

from .profiles import at

VELOCITY_UNIT = 0.229 * 4096 / 60  # ticks/s of a count (e-Manual, "Profile Velocity(112)")
ACCELERATION_UNIT = 214.577 * 4096 / 3600  # ticks/s^2 ("Profile Acceleration(108)")
POSITIONS = st.floats(-1e5, 1e5)
SPEEDS = st.floats(-5e3, 5e3)


def integral(profile: Profile, samples: int = 4000) -> float:
    """Way covered, by the midpoint rule on the velocity, which is exact for linear pieces but for
    the few samples that hold a corner.
    """
    step = profile.duration / samples
    return sum(at(profile, (i + 0.5) * step)[1] * step for i in range(samples))


def test_a_profile_velocity_of_zero_is_a_step() -> None:
    profile = velocity_profile(0.0, 0.0, 500.0, 0.0, 30.0)
    assert (profile.duration, profile.kind, at(profile, 0.0)) == (
        0.0,
        ProfileType.STEP,
        (500.0, 0.0),
    )
    assert at(time_profile(0.0, 0.0, 500.0, 0.0, 0.3), 0.0) == (500.0, 0.0)


def test_without_acceleration_it_is_rectangular() -> None:
    profile = velocity_profile(100.0, 0.0, 500.0, 200.0, 0.0)
    assert (profile.duration, profile.kind) == (2.0, ProfileType.RECTANGULAR)
    assert at(profile, 0.5) == (200.0, 200.0)
    assert at(velocity_profile(500.0, 0.0, 100.0, 200.0, 0.0), 0.5) == (400.0, -200.0)


def test_trapezoid_has_the_manuals_acceleration_time() -> None:
    """t1 = 64 V / A milliseconds ("What is the Profile"), for V in 0.229 rev/min."""
    velocity, acceleration = 100, 10
    speed = velocity * VELOCITY_UNIT
    profile = velocity_profile(0.0, 0.0, 4000.0, speed, acceleration * ACCELERATION_UNIT)
    ramp = 64e-3 * velocity / acceleration
    assert profile.kind is ProfileType.TRAPEZOIDAL
    assert profile.duration == pytest.approx(ramp + 4000.0 / speed, rel=1e-3)
    assert at(profile, ramp) == pytest.approx((0.5 * speed * ramp, speed), rel=1e-3)
    assert at(profile, 0.5 * ramp) == pytest.approx((0.125 * speed * ramp, 0.5 * speed), rel=1e-3)
    assert at(profile, profile.duration - 0.5 * ramp)[0] == pytest.approx(
        4000.0 - 0.125 * speed * ramp, rel=1e-3
    )


def test_a_short_way_makes_a_triangle() -> None:
    """Half way is covered at constant acceleration: duration 2 sqrt(d / a), peak sqrt(d a)."""
    profile = velocity_profile(0.0, 0.0, 100.0, 1e4, 400.0)
    assert profile.kind is ProfileType.TRIANGULAR
    assert profile.duration == pytest.approx(2.0 * math.sqrt(100.0 / 400.0))
    assert at(profile, 0.5) == pytest.approx((50.0, math.sqrt(100.0 * 400.0)))


@pytest.mark.parametrize("ramp_ms", [0, 200, 400])
def test_a_time_based_profile_takes_its_time(ramp_ms: int) -> None:
    """Area of the trapezoid: peak = d / (T - t1)."""
    profile = time_profile(0.0, 0.0, 1000.0, 1.0, ramp_ms * 1e-3)
    assert profile.duration == pytest.approx(1.0)
    assert at(profile, 0.5) == pytest.approx((500.0, 1000.0 / (1.0 - ramp_ms * 1e-3)))


def test_a_ramp_of_over_half_the_time_is_cut_to_half() -> None:
    profile = time_profile(0.0, 0.0, 1000.0, 1.0, 0.9)
    assert (profile.duration, profile.kind) == (pytest.approx(1.0), ProfileType.TRIANGULAR)


@given(POSITIONS, SPEEDS, POSITIONS, st.floats(1.0, 5e3), st.floats(10.0, 5e4))
def test_velocity_profiles_arrive_from_any_start(
    start: float, velocity: float, goal: float, speed: float, acceleration: float
) -> None:
    profile = velocity_profile(start, velocity, goal, speed, acceleration)
    at_start = at(profile, 0.0)
    assert at_start == pytest.approx((start, velocity), abs=1e-6) or profile.duration == 0.0
    last, final = at(profile, profile.duration * (1.0 - 1e-12))
    assert last == pytest.approx(goal, abs=1e-3)
    assert final == pytest.approx(0.0, abs=1e-2)
    fastest = max(abs(at(profile, profile.duration * i / 50)[1]) for i in range(51))
    assert fastest <= max(speed, abs(velocity)) * (1.0 + 1e-9)


@given(POSITIONS, SPEEDS, POSITIONS, st.floats(0.05, 30.0), st.floats(0.0, 20.0))
def test_time_profiles_cover_the_way_in_their_time(
    start: float, velocity: float, goal: float, duration: float, ramp: float
) -> None:
    profile = time_profile(start, velocity, goal, duration, ramp)
    assert profile.duration == pytest.approx(duration)
    way = goal - start
    size = max(1.0, abs(way), abs(velocity) * duration)
    assert integral(profile) == pytest.approx(way, abs=2e-3 * size)
