"""Hardware errors from simulated causes, and what a shutdown does."""

import pytest

from firmware_sim.firmware.codes import HardwareError, StatusError

from .solo import Solo

ALERT = 0x80
FAR = {"Torque_Enable": 1, "Goal_Position": 4000}


def until_error(solo: Solo, seconds: float) -> float:
    """How long it takes to an error, s, looked for every 10 ms."""
    for tick in range(1, round(seconds * 100) + 1):
        solo.wait(0.01)
        if solo.read("Hardware Error Status"):
            return tick / 100
    return float("inf")


def test_a_blocked_horn_overloads() -> None:
    solo = Solo()
    solo.axis.jam(on=True)
    solo.set(**FAR)
    assert until_error(solo, 3.0) == pytest.approx(2.0, abs=0.02)
    assert solo.read("Hardware Error Status") == HardwareError.OVERLOAD
    assert solo.read("Torque Enable") == solo.read("Present PWM") == 0
    assert solo.servo.alert == ALERT
    assert solo.servo.error_bits == 0x20


def test_a_long_unasked_wait_finds_the_same() -> None:
    solo = Solo()
    solo.axis.jam(on=True)
    solo.set(**FAR)
    solo.wait(1.99)
    assert solo.servo.alert == 0
    solo.wait(100.0)
    assert solo.read("Hardware Error Status") == HardwareError.OVERLOAD
    assert solo.read("Present Temperature") < 60  # it shut down after 2 s


def test_a_horn_that_moves_or_pushes_less_does_not_overload() -> None:
    turning = Solo(Operating_Mode=1)
    turning.set(Torque_Enable=1, Goal_Velocity=200)
    holding = Solo()
    holding.set(Torque_Enable=1)
    holding.axis.apply_load(2.0)
    capped = Solo(PWM_Limit=400)
    capped.axis.jam(on=True)
    capped.set(**FAR)
    for solo in (turning, holding, capped):
        solo.wait(10.0)
        assert solo.read("Hardware Error Status") == 0


def test_pushing_against_too_large_a_load_overloads() -> None:
    """A stalled horn is not blocked: the load is as large as its stall torque."""
    solo = Solo()
    solo.set(**FAR)
    solo.wait(2.0)
    solo.axis.apply_load(4.1 * 1.005)
    assert until_error(solo, 5.0) < 4.0


def test_a_held_load_overheats_in_the_time_of_the_closed_form() -> None:
    """T = 25 + 8 R i^2 (1 - exp(-t / 240 s)) with R = 12 V / 2.3 A and i for 3 N m."""
    current = (3.0 / 4.1 - 0.01) * 2.3
    final = 8.0 * 12.0 / 2.3 * current**2
    solo = Solo(Temperature_Limit=60)
    solo.set(Torque_Enable=1)
    solo.axis.apply_load(3.0)
    from math import log

    wanted = -240.0 * log(1.0 - (60.0 - 25.0) / final)
    assert until_error(solo, 2.0 * wanted) == pytest.approx(wanted, rel=0.06)
    assert solo.read("Hardware Error Status") == HardwareError.OVERHEATING
    assert solo.read("Torque Enable") == 0
    position = solo.read("Present Position")
    solo.wait(0.5)
    assert solo.read("Present Position") < position  # nothing holds the load


@pytest.mark.parametrize("voltage", [9.0, 17.0])
def test_a_wrong_supply_is_noticed_after_a_tenth_of_a_second(voltage: float) -> None:
    solo = Solo()
    solo.wait(1.0)
    solo.axis.set_supply(voltage)
    assert until_error(solo, 1.0) == pytest.approx(0.1, abs=0.021)
    assert solo.read("Hardware Error Status") == HardwareError.INPUT_VOLTAGE
    assert solo.read("Present Input Voltage") == round(10 * voltage)


def test_a_short_dip_is_not() -> None:
    solo = Solo()
    for _ in range(5):
        solo.axis.set_supply(9.0)
        solo.wait(0.05)
        solo.axis.set_supply(12.0)
        solo.wait(0.05)
    assert solo.read("Hardware Error Status") == 0


def test_a_weak_supply_sags_under_load() -> None:
    """The supply of 12 V through 2 ohm, loaded by a stalled motor: 12 R / (R + 2)."""
    from firmware_sim.physics.plant import JointsPlant

    solo = Solo(plant=lambda axes: JointsPlant(axes, 2.0))
    solo.axis.jam(on=True)
    solo.set(**FAR)
    solo.wait(0.05)
    winding = 12.0 / 2.3
    assert solo.read("Present Input Voltage") == round(120 * winding / (winding + 2.0))
    solo.wait(0.1)
    assert solo.read("Hardware Error Status") == HardwareError.INPUT_VOLTAGE
    assert solo.read("Torque Enable") == 1  # Shutdown(63) has it not on this model


def test_too_little_for_the_electronics_is_a_shock_with_torque_only() -> None:
    off, on = Solo(), Solo()
    on.set(Torque_Enable=1)
    for solo in (off, on):
        solo.wait(0.5)
        solo.axis.set_supply(4.0)
        solo.wait(0.05)
    assert off.read("Hardware Error Status") == 0
    assert on.read("Hardware Error Status") == HardwareError.ELECTRICAL_SHOCK
    assert on.read("Torque Enable") == 0


@pytest.mark.parametrize(("shutdown", "torque"), [(52, 1), (60, 0)])
def test_a_stuck_encoder_is_noticed_when_the_horn_turns(shutdown: int, torque: int) -> None:
    solo = Solo(Shutdown=shutdown)
    solo.set(Torque_Enable=1)
    solo.axis.stick_encoder(on=True)
    solo.wait(1.0)
    assert solo.read("Hardware Error Status") == 0  # nothing has moved
    solo.set(Goal_Position=3000)
    solo.wait(0.5)
    assert solo.read("Hardware Error Status") == HardwareError.MOTOR_ENCODER
    assert solo.read("Torque Enable") == torque
    assert solo.read("Present Position") == 2048


def test_an_error_outside_shutdown_only_alerts() -> None:
    solo = Solo(Shutdown=0)
    solo.axis.jam(on=True)
    solo.set(**FAR)
    solo.wait(3.0)
    assert solo.read("Hardware Error Status") == HardwareError.OVERLOAD
    assert solo.read("Torque Enable") == 1
    assert solo.servo.alert == ALERT
    assert solo.read("Present PWM") == 885


def test_only_a_reboot_brings_the_torque_back() -> None:
    solo = Solo()
    solo.servo.raise_hardware_error(HardwareError.OVERLOAD)
    assert solo.write("Torque Enable", 1) == StatusError.RESULT_FAIL
    assert solo.write("Hardware Error Status", 0) == StatusError.ACCESS
    solo.wait(10.0)
    assert solo.write("Torque Enable", 1) == StatusError.RESULT_FAIL
    assert solo.write("Torque Enable", 0) == StatusError.NONE
    solo.servo.reboot()
    solo.wait(0.2)
    assert (solo.servo.alert, solo.read("Hardware Error Status")) == (0, 0)
    assert solo.write("Torque Enable", 1) == StatusError.NONE


def test_a_goal_does_not_bring_it_back_either() -> None:
    solo = Solo(Drive_Mode=8)
    solo.servo.raise_hardware_error(HardwareError.OVERHEATING)
    solo.set(Goal_Position=3000)
    solo.wait(1.0)
    assert (solo.read("Torque Enable"), solo.read("Present Position")) == (0, 2048)


def test_errors_add_up() -> None:
    solo = Solo()
    solo.servo.raise_hardware_error(HardwareError.OVERLOAD)
    solo.servo.raise_hardware_error(HardwareError.OVERHEATING)
    assert solo.read("Hardware Error Status") == 0x24
    assert solo.servo.error_bits == 0x24


def test_a_power_cycle_leaves_no_torque_and_no_answer() -> None:
    solo = Solo()
    solo.set(**FAR)
    solo.wait(0.2)
    solo.servo.power_cycle(off_for=0.5)
    assert not solo.servo.hears
    assert not solo.axis.torque_on
    solo.wait(0.55)
    assert not solo.servo.hears
    solo.wait(0.06)
    assert solo.servo.hears
    assert solo.read("Goal Position") == solo.read("Present Position")
    assert solo.read("Realtime Tick") == pytest.approx(110, abs=1)


@pytest.mark.parametrize(("firmware", "blinks"), [(45, True), (41, True), (40, False)])
def test_the_led_blinks_every_second_after_a_shutdown(firmware: int, blinks: bool) -> None:
    solo = Solo(firmware=firmware)
    assert solo.servo.firmware.led == 0
    solo.set(LED=1)
    assert solo.servo.firmware.led == 1
    solo.set(LED=0)
    solo.servo.raise_hardware_error(HardwareError.OVERLOAD)
    seen = []
    for _ in range(8):
        solo.wait(0.25)
        seen.append(solo.servo.firmware.led)
    assert sum(seen) == (4 if blinks else 0)
    assert solo.read("LED") == 0


def test_a_model_without_an_led_shows_none() -> None:
    assert Solo("xw540-t140").servo.firmware.led == 0


@pytest.mark.parametrize(("pwm", "errors"), [(788, 0), (805, HardwareError.OVERLOAD)])
def test_nine_tenths_of_the_pwm_overload(pwm: int, errors: int) -> None:
    """788 of 885 are 89.0 %, 805 are 91.0 %: what the horn could push with counts, not its cap."""
    solo = Solo(PWM_Limit=pwm)
    solo.axis.jam(on=True)
    solo.set(**FAR)
    solo.wait(1.9)
    assert solo.read("Hardware Error Status") == 0
    solo.wait(0.2)
    assert solo.read("Hardware Error Status") == errors


@pytest.mark.parametrize("name", ["xl330-m288", "xl330-m077", "xc330-t288"])
def test_the_330_series_detects_no_encoder_error(name: str) -> None:
    solo = Solo(name, Shutdown=0x3D)
    solo.servo.raise_hardware_error(HardwareError.MOTOR_ENCODER)
    solo.axis.stick_encoder(on=True)
    solo.set(Torque_Enable=1, Goal_Position=2148)
    solo.wait(0.5)
    assert solo.read("Hardware Error Status") & HardwareError.MOTOR_ENCODER == 0
