"""Servos of all families and both protocols on one bus, and those that have no watchdog."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from msgspec.structs import replace

from armsyn.arm import ArmDescription, calibration_of, load_arm
from armsyn.driver import Ending
from armsyn.driver.servos import ServoGroup
from armsyn.driver.timing import WATCHDOG_UNITS
from armsyn.errors import (
    ArmsynError,
    BusRateError,
    FollowingError,
    HardwareFaultError,
    NoWatchdogError,
    ServoMismatchError,
    TorqueOnError,
)
from firmware_sim.firmware.codes import HardwareError
from firmware_sim.firmware.servo import Servo
from tests.driver.stepped import SteppedArm, deafen

MODELS = (
    ("xm540-w270", 2),
    ("mx-64", 1),
    ("mx-106", 2),
    ("ax-12a", 1),
    ("xl-320", 2),
    ("xm430-w350", 2),
    ("xl430-w250", 2),
)
"""A zoo on the joints of the human-like arm."""

MOVE = (0.3, 0.2, -0.3, 0.4, 0.3, 0.2)
UNWATCHED = (2, 4, 5)
RATE = 100.0


@pytest.fixture(scope="module")
def zoo(human7: ArmDescription) -> ArmDescription:
    servos = []
    for servo, joint, (model, protocol) in zip(human7.servo, human7.joint, MODELS, strict=True):
        zero = 512 if model in ("ax-12a", "xl-320") else 2048
        made = replace(servo, model=model, protocol=protocol, zero_tick=zero, supply_voltage=12.0)
        if model == "xl-320":
            made = replace(made, supply_voltage=7.4)
        tick = int(calibration_of((made,)).to_ticks([joint.rest])[0])
        servos.append(replace(made, rest_tick=tick))
    slow = tuple(replace(joint, max_velocity=1.5) for joint in human7.joint)
    return replace(human7, name="zoo", servo=tuple(servos), joint=slow)


@pytest.fixture
def stepped(zoo: ArmDescription) -> SteppedArm:
    return SteppedArm(zoo)


def test_all_families_go_where_they_are_sent(stepped: SteppedArm) -> None:
    session = stepped.session(RATE, accept_no_watchdog=True)
    assert session.unwatched == UNWATCHED
    way = stepped.way(*MOVE)
    watchdogs: list[list[int]] = []
    recording = session.run(way, on_tick=lambda *_: watchdogs.append(stepped.value("Bus Watchdog")))
    assert recording.ending is Ending.COMPLETED
    assert way.angles is not None
    assert np.abs(stepped.positions() - way.angles[-1]).max() < 0.02
    assert recording.command_success_rate == 1.0
    assert not recording.stale.any()
    assert watchdogs[-1] == [WATCHDOG_UNITS] * 4  # of those that have one
    assert stepped.value("Bus Watchdog") == [0] * 4
    assert stepped.torque() == [1] * 7
    assert np.isnan(recording.current_a).any(axis=0).tolist() == [
        m[0] not in CURRENT for m in MODELS
    ]


CURRENT = ("xm540-w270", "mx-106", "xm430-w350")


def test_velocities_have_the_sign_of_the_motion(stepped: SteppedArm) -> None:
    recording = stepped.session(RATE, accept_no_watchdog=True).run(stepped.way(*MOVE))
    moved = recording.measured_rad[-1] - recording.measured_rad[0]
    integral = np.trapezoid(recording.velocity_rad_s, recording.time_s, axis=0)
    assert integral == pytest.approx(moved, abs=0.06)


def test_one_packet_of_goals_a_protocol(stepped: SteppedArm) -> None:
    session = stepped.session(RATE, accept_no_watchdog=True)
    stepped.bus.serial_port.written.clear()
    session.run(stepped.way(*MOVE))
    packets = [p for p in stepped.bus.serial_port.written if b"\xfe" in p[:6] and p[7:8] == b"\x83"]
    assert packets
    # X and MX 2.0 at 116, XL-320 at 30 with protocol 2.0; MX at 30 and AX at 30 with 1.0
    assert any(p[8:10] == b"\x74\x00" for p in packets)


def test_consent_is_asked_for_by_name(stepped: SteppedArm) -> None:
    with pytest.raises(NoWatchdogError) as caught:
        stepped.session(RATE)
    assert caught.value.servo_ids == UNWATCHED
    message = str(caught.value)
    for words in (
        "2 (shoulder_abduction, mx-64, protocol 1)",
        "4 (elbow_flexion, ax-12a, protocol 1)",
        "5 (forearm_pronation, xl-320)",
        "--accept-no-watchdog",
    ):
        assert words in message
    assert caught.value.exit_status == 3
    assert stepped.torque() == [0] * 7


def test_firmware_before_38_has_no_watchdog(human7: ArmDescription) -> None:
    old = SteppedArm(human7)
    old.by_id[6].model = dataclasses.replace(old.by_id[6].model, firmware=37)
    with pytest.raises(NoWatchdogError, match=r"servo 6 \(.*, xm430-w350 with firmware 37\)"):
        old.session()
    recording = old.session(accept_no_watchdog=True).run(old.way(0.3, 0.0, 0.2))
    assert recording.ending is Ending.COMPLETED


def test_a_gripper_needs_no_consent() -> None:
    arm = load_arm("openmanipulator_x")
    servos = tuple(
        replace(s, model="ax-12a", protocol=1, zero_tick=512, rest_tick=512, drive_mode=0)
        if s.id == 15
        else s
        for s in arm.servo
    )
    stepped = SteppedArm(replace(arm, servo=servos))
    assert stepped.session(RATE).run(stepped.way(0.3)).ending is Ending.COMPLETED


def test_what_a_fault_leaves_names_the_unwatched(stepped: SteppedArm) -> None:
    stepped.at(0.3, lambda: stepped.servos[0].raise_hardware_error(HardwareError.OVERLOAD))
    session = stepped.session(RATE, accept_no_watchdog=True)
    with pytest.raises(HardwareFaultError) as caught:
        session.run(stepped.way(*MOVE))
    assert "servo 2, 4, 5 has none: it holds until it is released" in str(caught.value)


def fault_of(stepped: SteppedArm, kind: type[ArmsynError]) -> str:
    session = stepped.session(RATE, accept_no_watchdog=True)
    with pytest.raises(kind) as caught:
        session.run(stepped.way(*MOVE))
    return str(caught.value)


@pytest.mark.fault(18)
@pytest.mark.parametrize("row", [1, 3, 4], ids=["mx 1.0", "ax", "xl-320"])
@pytest.mark.parametrize(
    ("error", "words"),
    [(HardwareError.OVERHEATING, "overheating"), (HardwareError.OVERLOAD, "overload")],
)
def test_errors_of_older_families_stop_the_arm(
    stepped: SteppedArm, row: int, error: HardwareError, words: str
) -> None:
    stepped.at(0.2, lambda: stepped.servos[row].raise_hardware_error(error))
    message = fault_of(stepped, HardwareFaultError)
    assert f"servo {row + 1} (" in message
    assert words in message
    assert ("cut its power" in message) == (row in (1, 3))  # protocol 1.0 has no reboot


@pytest.mark.parametrize("row", [1, 3, 4], ids=["mx 1.0", "ax", "xl-320"])
def test_a_shutdown_is_found_at_opening(stepped: SteppedArm, row: int) -> None:
    stepped.servos[row].memory.store("Torque Limit", 0)
    with pytest.raises(HardwareFaultError, match=rf"servo {row + 1} .* \(Torque Limit reads 0\)"):
        stepped.session(RATE, accept_no_watchdog=True)


@pytest.mark.fault(10)
@pytest.mark.parametrize("row", range(7))
def test_restarts_of_all_families_stop_the_arm(stepped: SteppedArm, row: int) -> None:
    stepped.at(0.2, stepped.servos[row].reboot)
    message = fault_of(stepped, ArmsynError)
    assert f"servo {row + 1} (" in message
    assert "restarted" in message or "has been silent" in message


@pytest.mark.fault(9)
def test_a_silent_older_servo_is_named(stepped: SteppedArm) -> None:
    stepped.at(0.2, lambda: setattr(stepped.servos[3], "silenced", True))
    assert "servo 4 (elbow_flexion) has been silent" in fault_of(stepped, ArmsynError)


@pytest.mark.fault(35)
def test_held_older_servos_give_way(stepped: SteppedArm) -> None:
    stepped.at(0.2, lambda: stepped.servos[3].apply_load(5.0))
    assert "joint elbow_flexion" in fault_of(stepped, FollowingError)


def wheel(servo: Servo) -> None:
    servo.memory.store("CW Angle Limit", 0)
    servo.memory.store("CCW Angle Limit", 0)


def xl320_wheel(servo: Servo) -> None:
    servo.memory.store("Control Mode", 1)


@pytest.mark.parametrize(
    ("row", "spoil", "words"),
    [
        (1, wheel, "turns as a wheel"),
        (3, wheel, "turns as a wheel"),
        (4, xl320_wheel, "operating mode 1"),
    ],
)
def test_wheels_are_refused(
    stepped: SteppedArm, row: int, spoil: Callable[[Servo], None], words: str
) -> None:
    spoil(stepped.servos[row])
    with pytest.raises(ServoMismatchError, match=words):
        stepped.session(RATE, accept_no_watchdog=True)


@pytest.mark.fault(42)
def test_what_was_found_is_put_back_in_all_families(stepped: SteppedArm) -> None:
    for row, servo in enumerate(stepped.servos):
        speed = (
            "Moving Speed" if "Moving Speed" in servo.model.table.by_name else "Profile Velocity"
        )
        servo.memory.store(speed, 60 + row)
    speeds = stepped.value("Moving Speed") + stepped.value("Profile Velocity")
    deafen(stepped.servos[6], 64, 1)
    session = stepped.session(RATE, accept_no_watchdog=True)
    with pytest.raises(HardwareFaultError, match="servo 7"):
        session.run(stepped.way(*MOVE))
    assert stepped.torque() == [0] * 7
    assert stepped.value("Moving Speed") + stepped.value("Profile Velocity") == speeds
    assert session.fault is None


def test_parking_lets_all_families_go(stepped: SteppedArm) -> None:
    out = stepped.way(*MOVE)
    back = type(out)(time=out.time, joint_names=out.joint_names, angles=out.angles[::-1])
    recording = stepped.session(RATE, accept_no_watchdog=True).run(out, park=back)
    assert recording.ending is Ending.PARKED
    assert stepped.torque() == [0] * 7


def test_single_reads_behind_a_slow_adapter_are_counted(stepped: SteppedArm) -> None:
    stepped.bus.latency = 0.001
    stepped.session(RATE, accept_no_watchdog=True)
    stepped.bus.latency = 0.004
    with pytest.raises(BusRateError, match="keeps each of 5 replies for up to 4 ms"):
        stepped.session(RATE, accept_no_watchdog=True)


@pytest.mark.fault(22)
def test_eeprom_is_not_written_under_torque(stepped: SteppedArm) -> None:
    group = ServoGroup(stepped.bus, stepped.description.servo)
    group.set("Torque Enable", {3: 1})
    stepped.bus.serial_port.written.clear()
    with pytest.raises(
        TorqueOnError, match=r"servo 3 .*Return Delay Time \(register 9\)"
    ) as caught:
        group.set("Return Delay Time", dict.fromkeys(group.ids, 10))
    assert caught.value.servo_id == 3
    assert {p[7] for p in stepped.bus.serial_port.written if p[:3] == b"\xff\xff\xfd"} <= {2, 0x82}
    assert stepped.torque()[2] == 1  # and nothing is dropped for it
    group.set("Torque Enable", {3: 0})
    group.set("Return Delay Time", dict.fromkeys(group.ids, 10))
    assert stepped.value("Return Delay Time") == [10] * 7
