"""The control loops against hand calculations."""

import math

import pytest

from firmware_sim.physics.kernel import STATIC_FRICTION, STEP
from firmware_sim.physics.profile import Profile, ProfileType, time_profile, velocity_profile

from .one_axis import TICK, OneAxis
from .profiles import at

PWM_COUNT = 1.0 / 885
P_800 = 800 / 128 * PWM_COUNT / TICK  # duty per rad


@pytest.mark.parametrize("load", [-1.0, 0.5, 1.0, 2.0])
def test_a_load_pulls_a_p_loop_off_its_goal(load: float) -> None:
    """Holding 1 N m of 4.1 takes 24.4 % PWM, which P = 800 / 128 makes of 34.5 ticks.

    Friction may carry its part either way, and the encoder a count.
    """
    rig = OneAxis().held(P_800)
    rig.axis.apply_load(load)
    rig.run(3.0)
    assert rig.axis.settled
    error = rig.axis.reference - rig.axis.angle
    expected = load / rig.motor.stall_torque / P_800
    carried = STATIC_FRICTION * rig.motor.friction / P_800
    assert error == pytest.approx(expected, abs=carried + TICK)
    torque = rig.relative_torque * rig.motor.stall_torque
    assert torque == pytest.approx(load, abs=STATIC_FRICTION * rig.friction)
    assert rig.axis.duty == pytest.approx(rig.relative_torque, rel=1e-9)


def test_an_integral_gain_takes_the_error_away() -> None:
    rig = OneAxis().held(P_800)
    rig.axis.set_position_gains(P_800, i=200 / 65536 * PWM_COUNT / TICK)
    rig.axis.apply_load(1.0)
    rig.run(20.0)
    assert rig.axis.ticks == 0


@pytest.mark.parametrize(
    ("gains", "expected"),
    [
        ((800 / 128, 0.0, 0.0), 20 * 800 / 128),
        ((0.0, 6554 / 65536, 0.0), 20 * 6554 / 65536),
        ((0.0, 0.0, 160 / 16), 20 * 160 / 16),
        ((1.0, 0.5, 2.0), 20 * 3.5),
    ],
    ids=["P", "I", "D", "PID"],
)
def test_gains_make_the_duty_of_a_first_period(
    gains: tuple[float, float, float], expected: float
) -> None:
    """After one period with an error of 20 ticks, in PWM counts."""
    rig = OneAxis()
    rig.axis.hold()
    rig.axis.set_position_gains(*(gain * PWM_COUNT / TICK for gain in gains))
    rig.axis.follow(velocity_profile(0.0, 0.0, 20.0 * TICK, 0.0, 0.0))
    rig.run(STEP)
    assert rig.axis.duty / PWM_COUNT == pytest.approx(expected, rel=1e-9)


def test_feed_forward_adds_velocity_and_acceleration() -> None:
    rig = OneAxis()
    rig.axis.hold()
    rig.axis.set_position_gains(0.0, ff1=0.1, ff2=0.02)
    rig.axis.follow(velocity_profile(0.0, 0.0, 10.0, 2.0, 4.0))
    rig.run(0.25)
    assert rig.axis.reference_velocity == pytest.approx(1.0)
    assert rig.axis.duty == pytest.approx(0.1 * 1.0 + 0.02 * 4.0)
    rig.run(0.5)
    assert rig.axis.duty == pytest.approx(0.1 * 2.0)


def test_the_derivative_brakes_what_runs_ahead_of_the_trajectory() -> None:
    """Duty is ff1 v* + d (v* - v) / 1000, of which f + v (1 - f) / v0 is needed."""
    rig = OneAxis()
    rig.axis.hold()
    rig.axis.set_position_gains(0.0, d=200.0, ff1=0.4)
    rig.axis.follow(velocity_profile(0.0, 0.0, 100.0, 1.0, 0.0))
    rig.run(2.0)
    friction, derivative = rig.motor.friction, 200.0 * STEP
    share = (1.0 - friction) / rig.no_load_speed
    speed = (0.4 + derivative - friction) / (share + derivative)
    assert rig.axis.velocity == pytest.approx(speed, rel=1e-6)


def test_a_ramp_is_followed_with_the_lag_of_the_gain() -> None:
    """Duty for speed v is f + v (1 - f)/v0, which P makes of the lag; feed-forward removes it."""
    lags = []
    for feed_forward in (0.0, 1.0):
        rig = OneAxis().held(P_800)
        share = (1.0 - rig.motor.friction) / rig.no_load_speed
        rig.axis.set_position_gains(P_800, ff1=feed_forward * share)
        rig.axis.follow(velocity_profile(0.0, 0.0, 100.0, 1.0, 10.0))
        rig.run(3.0)
        lags.append(rig.axis.reference - rig.axis.angle)
        assert rig.axis.velocity == pytest.approx(1.0, rel=0.02)
    friction = rig.motor.friction / P_800
    assert lags[0] == pytest.approx(friction + share / P_800, abs=TICK)
    assert lags[1] == pytest.approx(friction, abs=TICK)


def test_the_cap_of_the_duty_bounds_the_speed() -> None:
    rig = OneAxis().held(P_800)
    rig.axis.set_caps(duty=0.25)
    rig.axis.follow(velocity_profile(0.0, 0.0, 50.0, 0.0, 0.0))
    rig.run(1.0)
    assert rig.axis.duty == 0.25
    friction = rig.motor.friction
    speed = (0.25 - friction) / (1.0 - friction) * rig.no_load_speed
    assert rig.axis.velocity == pytest.approx(speed, rel=1e-6)


def test_the_integral_stops_at_the_cap() -> None:
    """After five seconds against a jam it lets go as soon as after a tenth of one."""
    overshoots = []
    for jammed in (0.1, 5.0):
        rig = OneAxis().held(P_800)
        rig.axis.set_position_gains(P_800, i=200 / 65536 * PWM_COUNT / TICK)
        rig.axis.jam(on=True)
        rig.axis.follow(velocity_profile(0.0, 0.0, 1.0, 0.0, 0.0))
        rig.run(jammed)
        rig.axis.jam(on=False)
        highest = 0.0
        for _ in range(1000):
            rig.run(STEP)
            highest = max(highest, rig.axis.angle)
        overshoots.append(highest - 1.0)
    assert overshoots[1] == pytest.approx(overshoots[0], abs=TICK)
    assert overshoots[1] < 0.1


@pytest.mark.parametrize("load", [0.0, 1.0, -1.0])
def test_a_velocity_loop_reaches_its_goal_under_a_load(load: float) -> None:
    """Gains of an XM430: 100 / 128 and 1920 / 65536 PWM counts per 0.229 rev/min."""
    unit = 0.229 * 2.0 * math.pi / 60.0
    rig = OneAxis()
    rig.axis.set_velocity_gains(100 / 128 * PWM_COUNT / unit, 1920 / 65536 * PWM_COUNT / unit)
    rig.axis.drive_velocity(2.0)
    rig.axis.apply_load(load)
    rig.run(4.0)
    assert rig.axis.velocity == pytest.approx(2.0, rel=1e-6)
    torque = rig.relative_torque * rig.motor.stall_torque
    assert torque == pytest.approx(load + rig.friction + 2.0 * rig.drag, rel=1e-5)


def test_without_integral_a_velocity_loop_lacks_what_the_losses_take() -> None:
    """Gain times lack is f + v (1 - f) / v0."""
    rig = OneAxis()
    rig.axis.set_velocity_gains(1.0, 0.0)
    rig.axis.drive_velocity(2.0)
    rig.run(2.0)
    friction = rig.motor.friction
    share = (1.0 - friction) / rig.no_load_speed
    assert rig.axis.velocity == pytest.approx((2.0 - friction) / (1.0 + share), rel=1e-9)


def test_a_velocity_goal_is_reached_along_a_ramp() -> None:
    rig = OneAxis()
    rig.axis.set_velocity_gains(1.0, 0.01)
    rig.axis.drive_velocity(3.0, acceleration=2.0)
    assert rig.axis.under_way
    rig.run(0.5)
    assert rig.axis.reference_velocity == pytest.approx(1.0)
    assert rig.axis.kind is ProfileType.TRAPEZOIDAL
    rig.run(1.5)
    assert rig.axis.reference_velocity == 3.0
    assert not rig.axis.under_way
    rig.axis.drive_velocity(-1.0, acceleration=2.0)
    rig.run(1.0)
    assert rig.axis.reference_velocity == pytest.approx(1.0)
    assert rig.axis.velocity == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("amperes", [0.5, -0.5, 1.0])
def test_a_current_balances_its_torque(amperes: float) -> None:
    """The load may differ from kt i by friction either way, not by more."""
    for excess, moves in ((0.9, False), (1.1 * STATIC_FRICTION, True)):
        for sign in (1.0, -1.0):
            rig = OneAxis()
            torque = rig.motor.stall_torque / rig.motor.stall_current * amperes
            rig.axis.drive_current(amperes)
            rig.axis.apply_load(torque + sign * excess * rig.friction)
            rig.run(0.5)
            assert rig.axis.current == pytest.approx(amperes, rel=0.01)
            assert (rig.axis.angle != 0.0) is moves
            assert math.copysign(1.0, rig.axis.angle) == -sign or not moves


def test_a_constant_current_accelerates_evenly() -> None:
    """J dv/dt = kt i - Tf - b v; the back-EMF does not slow it before the voltage is used up."""
    rig = OneAxis()
    rig.axis.drive_current(0.3)
    rig.run(0.020)
    pull = rig.motor.stall_torque / rig.motor.stall_current * 0.3 - rig.friction
    lag = rig.motor.inertia / rig.drag
    speed = pull / rig.drag * (1.0 - math.exp(-0.020 / lag))
    assert rig.axis.velocity == pytest.approx(speed, rel=0.01)
    assert rig.axis.current == pytest.approx(0.3, rel=0.01)
    rig.run(2.0)
    assert rig.axis.duty == 1.0
    assert rig.axis.velocity == pytest.approx(rig.no_load_speed, rel=1e-6)


def test_a_goal_above_the_cap_of_the_current_is_cut() -> None:
    rig = OneAxis()
    rig.axis.set_caps(current=0.2)
    rig.axis.jam(on=True)
    rig.axis.drive_current(-1.0)
    rig.run(0.1)
    assert rig.axis.current == pytest.approx(-0.2)


def test_current_based_position_pushes_no_harder_than_its_cap() -> None:
    rig = OneAxis().held(P_800)
    rig.axis.set_caps(duty=1.0, current=0.4)
    rig.axis.jam(on=True)
    rig.axis.follow(velocity_profile(0.0, 0.0, 1.0, 0.0, 0.0))
    rig.run(0.5)
    assert rig.axis.current == pytest.approx(0.4)
    rig.axis.jam(on=False)
    for _ in range(300):
        rig.run(STEP)
        assert abs(rig.axis.current) <= 0.4 * 1.06
    rig.run(2.0)
    assert rig.axis.angle == pytest.approx(1.0, abs=3 * TICK)


def test_compliance_pushes_by_margin_punch_and_slope() -> None:
    """Counter-clockwise beyond 0.02 rad with 2 / rad, clockwise beyond 0.05 rad with 0.5 / rad."""

    def duty_at(error: float) -> float:
        rig = OneAxis(start=-error)
        rig.axis.jam(on=True)
        goal = velocity_profile(0.0, 0.0, 0.0, 0.0, 0.0)
        rig.axis.drive_compliance(goal, (0.02, 0.05), (2.0, 0.5), punch=0.03)
        rig.run(0.01)
        return rig.axis.duty

    assert duty_at(0.015) == duty_at(-0.045) == 0.0
    assert duty_at(0.12) == pytest.approx(0.03 + 2.0 * 0.1, abs=2.0 * TICK)
    assert duty_at(-0.25) == pytest.approx(-0.03 - 0.5 * 0.2, abs=0.5 * TICK)
    assert duty_at(3.0) == 1.0


def test_compliance_stops_within_its_margin() -> None:
    rig = OneAxis()
    goal = velocity_profile(0.0, 0.0, 1.0, 2.0, 0.0)
    rig.axis.drive_compliance(goal, (0.01, 0.01), (3.0, 3.0), punch=0.03)
    rig.run(0.25)
    assert rig.axis.reference_velocity == 2.0
    rig.run(2.0)
    assert rig.axis.settled
    assert rig.axis.angle == pytest.approx(1.0, abs=0.01 + TICK)


@pytest.mark.parametrize(
    "profile",
    [
        velocity_profile(0.1, 0.0, 2.0, 1.5, 3.0),
        velocity_profile(0.1, -1.0, 2.0, 1.5, 3.0),
        velocity_profile(0.1, 0.0, -0.4, 9.0, 3.0),
        velocity_profile(0.1, 0.0, 1.0, 2.0, 0.0),
        time_profile(0.1, 0.5, 1.0, 0.8, 0.2),
        time_profile(0.1, 0.0, 1.0, 0.8, 0.4),
    ],
)
def test_the_trajectory_is_the_profile(profile: Profile) -> None:
    rig = OneAxis(start=0.1).held()
    rig.axis.follow(profile)
    for step in range(1, round(profile.duration / STEP) + 20):
        assert rig.axis.under_way is (step - 1 < profile.duration / STEP - 1e-6)
        rig.run(STEP)
        seen = (rig.axis.reference, rig.axis.reference_velocity)
        assert seen == pytest.approx(at(profile, step * STEP), abs=1e-9) or step in {
            math.floor(piece[0] / STEP + 1e-6) for piece in profile.pieces
        }
    assert (rig.axis.reference, rig.axis.kind) == (profile.goal, profile.kind)


def test_torque_on_holds_where_the_encoder_sees_the_horn() -> None:
    rig = OneAxis(start=100.3 * TICK)
    rig.held(P_800)
    assert rig.axis.reference == pytest.approx(100 * TICK)
    rig.run(0.5)
    assert rig.axis.angle == 100.3 * TICK
    assert rig.axis.settled


def test_without_position_control_the_trajectory_is_where_the_horn_is() -> None:
    """So that position control entered from another mode begins there."""
    rig = OneAxis()
    rig.axis.drive_duty(0.5)
    rig.run(0.3)
    assert rig.axis.reference == pytest.approx(rig.axis.angle, abs=TICK)
    rig.axis.set_velocity_gains(1.0, 0.0)
    rig.axis.drive_velocity(1.0)
    rig.run(0.3)
    assert rig.axis.reference == pytest.approx(rig.axis.angle, abs=TICK)
    rig.axis.release()
    rig.run(0.02)
    assert rig.axis.velocity > 0.0
    assert rig.axis.reference == pytest.approx(rig.axis.angle, abs=TICK)
    assert rig.axis.reference_velocity == rig.axis.velocity


MODES = ["duty", "position", "capped position", "current", "compliance"]


@pytest.mark.parametrize("share", [0.89, 0.91])
@pytest.mark.parametrize("mode", MODES)
def test_nine_tenths_of_all_effort_against_a_jam_are_timed(mode: str, share: float) -> None:
    """However the loop is capped: a jam takes 2.3 A at full duty."""
    rig = OneAxis().held(P_800)
    rig.axis.jam(on=True)
    far = velocity_profile(0.0, 0.0, 2.0, 0.0, 0.0)
    capped_current = mode in {"capped position", "current"}
    rig.axis.set_caps(
        duty=1.0 if capped_current else share, current=2.3 * share if capped_current else math.inf
    )
    if mode == "duty":
        rig.axis.drive_duty(1.0)
    elif mode == "current":
        rig.axis.drive_current(2.3 * share)
    elif mode == "compliance":
        rig.axis.drive_compliance(far, (0.0, 0.0), (3.0, 3.0), 0.03)
    else:
        rig.axis.follow(far)
    rig.run(1.5)
    assert rig.axis.duty == pytest.approx(share)
    assert rig.axis.saturated_for == pytest.approx(1.5 if share > 0.9 else 0.0, abs=2 * STEP)
    rig.axis.jam(on=False)
    rig.run(0.1)
    assert rig.axis.saturated_for == 0.0


def test_torque_off_ends_full_effort() -> None:
    rig = OneAxis()
    rig.axis.jam(on=True)
    rig.axis.drive_duty(1.0)
    rig.run(1.0)
    assert rig.axis.saturated_for == pytest.approx(1.0)
    rig.axis.release()
    rig.run(STEP)
    assert rig.axis.saturated_for == 0.0


def test_full_effort_that_is_pushed_back_is_timed() -> None:
    rig = OneAxis().held(P_800)
    rig.axis.apply_load(1.3 * rig.motor.stall_torque)
    rig.run(1.0)
    assert rig.axis.velocity < -1.0
    assert 0.9 < rig.axis.saturated_for < 1.0


def test_running_at_full_duty_is_not_timed() -> None:
    rig = OneAxis()
    rig.axis.drive_duty(-1.0)
    rig.run(1.0)
    assert rig.axis.velocity == pytest.approx(-rig.no_load_speed, rel=1e-6)
    assert rig.axis.saturated_for == 0.0
