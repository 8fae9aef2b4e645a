"""Limits that are set after a goal, and offsets that move the count."""

import pytest

from firmware_sim.firmware.codes import StatusError

from .solo import Solo


@pytest.mark.parametrize(
    ("limits", "end"),
    [({"Max_Position_Limit": 2500}, 2500), ({"Min_Position_Limit": 3500}, 3500)],
)
def test_no_goal_leads_out_of_limits_that_were_set_later(limits: dict[str, int], end: int) -> None:
    solo = Solo()
    solo.set(Goal_Position=3000, **limits)
    solo.set(Torque_Enable=1)
    solo.wait(3.0)
    assert solo.read("Present Position") == pytest.approx(end, abs=3)
    assert solo.read("Goal Position") == 3000
    assert solo.read("Moving Status") & 0x01 == 0


@pytest.mark.parametrize("mode", [4, 5])
def test_position_limits_hold_in_position_mode_only(mode: int) -> None:
    solo = Solo(Operating_Mode=mode, Max_Position_Limit=2500)
    solo.set(Torque_Enable=1, Goal_Position=3000)
    solo.wait(3.0)
    assert solo.read("Present Position") == pytest.approx(3000, abs=3)


@pytest.mark.parametrize(
    ("mode", "offset", "shift"), [(3, 500, 500), (3, 1025, 0), (4, 5000, 5000)]
)
def test_the_goal_means_the_same_angle_after_a_homing_offset(
    mode: int, offset: int, shift: int
) -> None:
    solo = Solo(Operating_Mode=mode)
    solo.set(Homing_Offset=offset)
    assert solo.read("Present Position") == solo.read("Goal Position") == 2048 + shift
    solo.set(Torque_Enable=1)
    solo.wait(1.0)
    assert solo.read("Present Position") == 2048 + shift
    assert solo.axis.angle == pytest.approx(2048 / 4096 * 6.283185307, abs=1e-6)


def test_an_offset_counts_once_after_a_turn_was_folded() -> None:
    solo = Solo(Operating_Mode=4)
    solo.set(Torque_Enable=1, Goal_Position=9000)
    solo.wait(6.0)
    solo.set(Torque_Enable=0)
    solo.set(Operating_Mode=3, Torque_Enable=1)
    solo.set(Torque_Enable=0)
    before = solo.read("Goal Position")
    solo.set(Homing_Offset=100)
    assert solo.read("Goal Position") == before + 100


@pytest.mark.parametrize(("limit", "speed"), [(50, 50), (150, 100)])
def test_velocity_limit_caps_a_profile(limit: int, speed: int) -> None:
    solo = Solo(Velocity_Limit=limit)
    solo.set(Profile_Velocity=100, Torque_Enable=1, Goal_Position=4000)
    solo.wait(0.3)
    assert solo.read("Velocity Trajectory") == speed


def test_acceleration_limit_is_a_limit() -> None:
    """Acceleration Limit(40) of the MX pages: Profile Acceleration cannot exceed it."""
    solo = Solo("mx-28", protocol=2, Acceleration_Limit=100)
    assert solo.write("Profile Acceleration", 101) == StatusError.DATA_LIMIT
    assert solo.write("Profile Acceleration", 100) == StatusError.NONE
    solo.set(Acceleration_Limit=50)
    assert solo.read("Profile Acceleration") == 50


@pytest.mark.parametrize(("away", "bit"), [(10, 1), (11, 0)])
@pytest.mark.parametrize("sign", [1, -1])
def test_in_position_is_near_the_goal_without_torque_too(away: int, bit: int, sign: int) -> None:
    solo = Solo()
    solo.set(Goal_Position=2048 + sign * away)
    assert solo.read("Moving Status") & 0x01 == bit


@pytest.mark.parametrize(("away", "bits"), [(100, 0), (101, 0x08), (400, 0x08)])
def test_a_following_error_is_more_than_100_ticks(away: int, bits: int) -> None:
    solo = Solo()
    solo.axis.jam(on=True)
    solo.set(Torque_Enable=1, Goal_Position=2048 + away)
    solo.wait(0.01)
    assert solo.read("Moving Status") & 0x08 == bits


def test_present_load_is_the_output() -> None:
    """Present Load(126) is inferred from the internal output, not measured."""
    solo = Solo("xl430-w250", Operating_Mode=16)
    solo.set(Torque_Enable=1, Goal_PWM=442)
    solo.wait(1.0)
    assert solo.read("Present Load") == pytest.approx(499, abs=1)  # turning without a load
    solo.set(Goal_PWM=-885)
    solo.wait(0.5)
    assert solo.read("Present Load") == -1000
