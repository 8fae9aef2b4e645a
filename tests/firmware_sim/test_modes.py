"""Operating modes: which a model has, and what a change of mode resets."""

import pytest

from firmware_sim.firmware.codes import StatusError
from firmware_sim.tables import MODEL_NAMES, find_model

from .solo import Solo

X_MODELS = [name for name in MODEL_NAMES if find_model(name).family == "x"]
ALL = {0, 1, 3, 4, 5, 16}
WITHOUT_CURRENT = {"xl430-w250", "2xl430-w250", "xc430-w150", "xc430-w240", "2xc430-w250"}


@pytest.mark.parametrize("name", X_MODELS)
def test_a_model_takes_its_modes_and_no_others(name: str) -> None:
    solo = Solo(name)
    taken = {mode for mode in range(20) if solo.write("Operating Mode", mode) == StatusError.NONE}
    assert taken == (ALL - {0, 5} if name in WITHOUT_CURRENT else ALL)


@pytest.mark.parametrize(
    ("name", "modes"), [("mx-28", ALL - {0, 5}), ("mx-64", ALL), ("mx-106", ALL)]
)
def test_mx_with_protocol_2_works_as_the_x_series(name: str, modes: set[int]) -> None:
    solo = Solo(name, protocol=2)
    taken = {mode for mode in range(20) if solo.write("Operating Mode", mode) == StatusError.NONE}
    assert taken == modes
    solo.set(Operating_Mode=3, Torque_Enable=1, Goal_Position=3000)
    solo.wait(2.0)
    assert solo.read("Present Position") == pytest.approx(3000, abs=3)
    assert solo.servo.alert == 0


@pytest.mark.parametrize("mode", sorted(ALL))
def test_a_change_of_mode_resets_gains_profile_and_goals(mode: int) -> None:
    solo = Solo(Operating_Mode=4 if mode == 3 else 3, Current_Limit=700, PWM_Limit=600)
    changed = {
        "Position_P_Gain": 100,
        "Position_I_Gain": 9,
        "Position_D_Gain": 8,
        "Velocity_P_Gain": 7,
        "Velocity_I_Gain": 6,
        "Feedforward_1st_Gain": 5,
        "Feedforward_2nd_Gain": 4,
        "Profile_Velocity": 50,
        "Profile_Acceleration": 3,
    }
    solo.set(**changed, Goal_PWM=2, Goal_Current=1)
    solo.set(Operating_Mode=mode)
    for name in (key.replace("_", " ") for key in changed):
        assert solo.read(name) == solo.table[name].default, name
    assert solo.read("Goal PWM") == (0 if mode == 16 else 600)
    assert solo.read("Goal Current") == (0 if mode == 0 else 700)


def test_the_same_mode_again_resets_nothing() -> None:
    solo = Solo()
    solo.set(Position_P_Gain=100, Profile_Velocity=50)
    solo.set(Operating_Mode=3)
    assert (solo.read("Position P Gain"), solo.read("Profile Velocity")) == (100, 50)


def test_the_mode_is_locked_while_the_torque_is_on() -> None:
    solo = Solo()
    solo.set(Torque_Enable=1)
    assert solo.write("Operating Mode", 1) == StatusError.ACCESS


@pytest.mark.parametrize("mode", sorted(ALL))
def test_torque_on_after_a_change_of_mode_turns_nothing(mode: int) -> None:
    solo = Solo(Operating_Mode=4 if mode == 3 else 3)
    solo.set(Operating_Mode=mode, Torque_Enable=1)
    solo.wait(1.0)
    assert solo.read("Present Position") == 2048
    assert solo.read("Moving") == 0


@pytest.mark.parametrize("mode", [0, 1, 16])
def test_a_boot_in_a_mode_without_position_control_turns_nothing(mode: int) -> None:
    solo = Solo(Operating_Mode=mode)
    solo.set(Torque_Enable=1)
    solo.wait(1.0)
    assert solo.read("Present Position") == 2048


def test_lowered_limits_lower_the_goals() -> None:
    solo = Solo()
    solo.set(PWM_Limit=300, Current_Limit=200, Velocity_Limit=100)
    goals = [solo.read(name) for name in ("Goal PWM", "Goal Current", "Goal Velocity")]
    assert goals == [300, 200, 100]


@pytest.mark.parametrize("mode", [4, 5])
def test_multi_turn_modes_take_512_turns(mode: int) -> None:
    solo = Solo(Operating_Mode=mode)
    for goal in (-1_048_575, 1_048_575):
        assert solo.write("Goal Position", goal) == StatusError.NONE
        assert solo.write("Goal Position", goal * 2) == StatusError.DATA_RANGE
