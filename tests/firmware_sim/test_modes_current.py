"""Current mode, and position mode with a capped current."""

import pytest

from firmware_sim.firmware.codes import StatusError

from .solo import Solo

AMPERE = 2.69e-3  # of one count (e-Manual, "Goal Current(102)")
STALL_TORQUE, STALL_CURRENT = 4.1, 2.3  # XM430-W350 at 12.0 V


@pytest.mark.parametrize("goal", [200, -200])
def test_a_blocked_horn_carries_the_goal_current(goal: int) -> None:
    solo = Solo(Operating_Mode=0)
    solo.axis.jam(on=True)
    solo.set(Torque_Enable=1, Goal_Current=goal)
    solo.wait(0.1)
    assert solo.read("Present Current") == pytest.approx(goal, abs=1)
    duty = goal * AMPERE / STALL_CURRENT
    assert solo.read("Present PWM") == pytest.approx(duty * 885, abs=1)


def test_torque_beats_a_smaller_load_and_yields_to_a_larger_one() -> None:
    torque = 300 * AMPERE * STALL_TORQUE / STALL_CURRENT
    for load, sign in ((0.8 * torque, 1), (1.2 * torque, -1)):
        solo = Solo(Operating_Mode=0)
        solo.axis.apply_load(load)
        solo.set(Torque_Enable=1, Goal_Current=300)
        solo.wait(0.5)
        assert solo.read("Present Velocity") * sign > 0


def test_a_free_horn_runs_up_to_the_voltage() -> None:
    solo = Solo(Operating_Mode=0)
    solo.set(Torque_Enable=1, Goal_Current=400)
    solo.wait(3.0)
    assert solo.read("Present PWM") == 885
    assert solo.read("Present Velocity") == pytest.approx(46.0 / 0.229, abs=2)


def test_the_current_limit_is_a_limit() -> None:
    solo = Solo(Operating_Mode=0, Current_Limit=500)
    assert solo.write("Goal Current", 501) == StatusError.DATA_LIMIT
    assert solo.write("Goal Current", -500) == StatusError.NONE


def test_goal_current_caps_the_push_of_current_based_position() -> None:
    """A blocked horn with a far goal: the current is the cap, and there is no overload."""
    solo = Solo(Operating_Mode=5)
    solo.axis.jam(on=True)
    solo.set(Torque_Enable=1, Goal_Current=150, Goal_Position=4000)
    solo.wait(5.0)
    assert solo.read("Present Current") == pytest.approx(150, abs=1)
    assert solo.read("Hardware Error Status") == 0
    assert solo.read("Torque Enable") == 1


def test_current_based_position_holds_a_load_below_its_cap_only() -> None:
    cap = 300 * AMPERE * STALL_TORQUE / STALL_CURRENT
    held, dropped = Solo(Operating_Mode=5), Solo(Operating_Mode=5)
    for solo, load in ((held, 0.5 * cap), (dropped, 1.5 * cap)):
        solo.set(Torque_Enable=1, Goal_Current=300, Goal_Position=2048)
        solo.axis.apply_load(load)
        solo.wait(1.0)
    sag = 0.5 * cap / STALL_TORQUE * 885 / (800 / 128)  # P control: ticks of error for that PWM
    assert held.read("Present Position") == pytest.approx(2048 - sag, abs=3)
    assert dropped.read("Present Position") < 1500


def test_current_based_position_reaches_goals_of_many_turns() -> None:
    solo = Solo(Operating_Mode=5)
    solo.set(Torque_Enable=1, Goal_Position=9000)
    solo.wait(5.0)
    assert solo.read("Present Position") == pytest.approx(9000, abs=2)
    assert solo.read("Moving Status") & 0x01


@pytest.mark.parametrize("mode", [1, 3, 4])
def test_goal_current_does_not_limit_the_other_modes(mode: int) -> None:
    solo = Solo(Operating_Mode=mode)
    solo.axis.jam(on=True)
    solo.set(Torque_Enable=1, Goal_Current=10)
    solo.set(**({"Goal_Velocity": 200} if mode == 1 else {"Goal_Position": 4000}))
    solo.wait(1.0)
    assert solo.read("Present Current") > 400


def test_a_new_cap_counts_at_once() -> None:
    solo = Solo(Operating_Mode=5)
    solo.axis.jam(on=True)
    solo.set(Torque_Enable=1, Goal_Position=4000, Goal_Current=100)
    solo.wait(0.1)
    solo.set(Goal_Current=250)
    solo.wait(0.01)
    assert solo.read("Present Current") == pytest.approx(250, abs=1)


@pytest.mark.parametrize("name", ["xl330-m288", "xc330-m288"])
@pytest.mark.parametrize("sign", [1, -1])
def test_the_330_series_measures_what_comes_from_the_supply(name: str, sign: int) -> None:
    """Power is passed on: at half duty the winding takes half, the supply gives a quarter."""
    stall = {"xl330-m288": 1470, "xc330-m288": 1800}[name]  # mA at 5.0 V
    solo = Solo(name, Operating_Mode=16)
    solo.axis.jam(on=True)
    solo.set(Torque_Enable=1, Goal_PWM=sign * 442)
    solo.wait(0.1)
    assert solo.axis.current == pytest.approx(sign * stall / 2000, rel=0.002)
    assert solo.read("Present Current") == pytest.approx(sign * stall / 4, abs=2)


@pytest.mark.parametrize("mode", [0, 5])
def test_goal_current_of_the_330_series_is_that_of_the_supply(mode: int) -> None:
    """U (u V / R) = 147 mA, a tenth of the stall current: u is the root of a tenth."""
    solo = Solo("xl330-m288", Operating_Mode=mode)
    solo.axis.jam(on=True)
    solo.set(Torque_Enable=1, Goal_Current=147)
    if mode == 5:
        solo.set(Goal_Position=4000)
    solo.wait(0.2)
    assert solo.read("Present Current") == pytest.approx(147, abs=1)
    assert solo.read("Present PWM") == pytest.approx(0.3162 * 885, abs=1)


def test_no_goal_current_lets_a_horn_of_the_330_series_turn() -> None:
    solo = Solo("xl330-m288", Operating_Mode=0)
    solo.set(Torque_Enable=1)
    solo.axis.apply_load(0.02)
    solo.wait(0.1)
    assert solo.read("Present Velocity") < -80
    assert abs(solo.axis.current) < 0.01
