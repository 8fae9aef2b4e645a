"""Control table backup, startup configuration, and what a state file keeps."""

import json

import pytest

from firmware_sim.firmware.codes import StatusError

from .solo import Solo

EEPROM = {"Homing_Offset": 77, "Temperature_Limit": 60, "Shutdown": 5, "Operating_Mode": 4}
GAINS = {
    "Position_P_Gain": 123,
    "Velocity_I_Gain": 45,
    "Feedforward_1st_Gain": 6,
    "Profile_Velocity": 50,
    "Profile_Acceleration": 3,
    "Indirect_Address_5": 65,
}


def stored(**more: int) -> Solo:
    solo = Solo()
    solo.set(**EEPROM, **more)
    solo.set(**GAINS, LED=1)
    assert solo.servo.backup() == StatusError.NONE
    return solo


def holds(solo: Solo, values: dict[str, int]) -> bool:
    return all(solo.read(name.replace("_", " ")) == value for name, value in values.items())


def test_backup_ready_tells_of_a_copy() -> None:
    solo = Solo()
    assert solo.read("Backup Ready") == 0
    assert solo.servo.backup() == StatusError.NONE
    assert solo.read("Backup Ready") == 1
    solo.servo.reboot()
    assert solo.read("Backup Ready") == 1


def test_it_is_refused_with_the_torque_on() -> None:
    solo = Solo()
    solo.set(Torque_Enable=1)
    assert solo.servo.backup() == solo.servo.restore() == StatusError.RESULT_FAIL
    assert solo.read("Backup Ready") == 0


def test_there_is_nothing_to_restore_at_first() -> None:
    assert Solo().servo.restore() == StatusError.RESULT_FAIL


@pytest.mark.parametrize(("name", "firmware"), [("xm430-w350", 44), ("xl330-m288", 45)])
def test_older_firmware_does_not_know_it(name: str, firmware: int) -> None:
    assert Solo(name, firmware=firmware).servo.backup() == StatusError.INSTRUCTION


def test_a_restore_brings_the_eeprom_back_and_reboots() -> None:
    solo = stored()
    solo.set(Homing_Offset=0, Temperature_Limit=70, Shutdown=52, Operating_Mode=3)
    assert solo.servo.restore() == StatusError.NONE
    assert not solo.servo.hears
    solo.wait(0.2)
    assert holds(solo, EEPROM)
    assert solo.read("Position P Gain") == solo.table["Position P Gain"].default
    assert solo.read("LED") == 0


def test_a_restored_id_counts_at_once() -> None:
    solo = stored()
    solo.set(ID=9)
    assert solo.servo.servo_id == 9
    solo.servo.restore()
    assert solo.servo.servo_id == 1


def test_startup_configuration_restores_ram_from_the_backup() -> None:
    solo = stored(Startup_Configuration=2)
    for value in (2, 0):
        solo.set(Startup_Configuration=value)
        solo.servo.reboot()
        solo.wait(0.2)
        assert holds(solo, GAINS) == bool(value)
        assert solo.read("LED") == 0  # not among what is kept


def test_restored_gains_and_aims_act() -> None:
    solo = stored(Startup_Configuration=3)
    solo.set(Indirect_Address_5=65)
    solo.servo.reboot()
    assert solo.read("Torque Enable") == 1
    solo.axis.apply_load(1.0)
    solo.wait(2.0)
    error = solo.read("Goal Position") - solo.read("Present Position")
    assert solo.read("Present PWM") == pytest.approx(123 / 128 * error, abs=1)
    solo.set(Indirect_Data_5=1)
    assert solo.read("LED") == 1


@pytest.mark.parametrize("on", [0, 1])
def test_startup_configuration_switches_the_torque_on(on: int) -> None:
    solo = Solo(Startup_Configuration=on)
    assert solo.read("Torque Enable") == on
    solo.servo.power_cycle(off_for=1.0)
    assert solo.read("Torque Enable") == 0
    solo.wait(1.2)
    assert solo.read("Torque Enable") == on
    assert solo.axis.torque_on == bool(on)


def test_a_snapshot_is_json_and_makes_another_servo_this_one() -> None:
    solo = stored()
    solo.set(Torque_Enable=1, Goal_Position=3000)
    solo.wait(5.0)
    text = json.dumps(solo.servo.snapshot())
    other = Solo()
    other.servo.restore_snapshot(json.loads(text))
    assert holds(other, EEPROM)
    assert other.read("Present Position") == solo.read("Present Position") > 2900
    assert (other.read("Backup Ready"), other.read("Torque Enable")) == (1, 0)
    assert other.servo.hears
    assert json.dumps(other.servo.snapshot()) == text


@pytest.mark.parametrize(
    "wrong",
    [
        {},
        {"model": "xl330-m288"},
        {"eeprom": {"Goal Position": 1}},
        {"eeprom": {"ID": 300}},
        {"eeprom": {"ID": "1"}},
        {"eeprom": [1]},
        {"backup": {"LED": 1}},
        {"backup": 7},
        {"angle": "0"},
        {"angle": float("nan")},
        {"angle": True},
        {"angle": 1e300},
        {"more": 1},
    ],
)
def test_a_wrong_snapshot_is_refused_whole(wrong: dict[str, object]) -> None:
    solo = Solo()
    before = solo.servo.snapshot()
    with pytest.raises(ValueError, match=r"^[^\n]+$"):
        solo.servo.restore_snapshot({**before, "angle": 1.0, **wrong} if wrong else {})
    assert solo.servo.snapshot() == before
