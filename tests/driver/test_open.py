"""What opening a session finds out before anything is written to the servos."""

from collections.abc import Callable

import pytest
from msgspec.structs import replace

from armsyn.arm import ArmDescription
from armsyn.driver import ArmSession, clear_watchdogs, session
from armsyn.errors import (
    ArmsynError,
    BusRateError,
    BusTimeoutError,
    DescriptionError,
    HardwareFaultError,
    PortError,
    ServoMismatchError,
    ServoMissingError,
)
from firmware_sim.firmware.codes import HardwareError
from firmware_sim.firmware.servo import Servo
from tests.driver.stepped import SteppedArm, without


def written(stepped: SteppedArm) -> set[int]:
    """Instructions of everything that was sent."""
    return {packet[7] for packet in stepped.bus.serial_port.written}


@pytest.mark.fault(43)
def test_opening_only_reads(stepped: SteppedArm) -> None:
    session = stepped.session()
    assert session.read_posture() == pytest.approx(stepped.description.rest, abs=1.6e-3)
    assert written(stepped) == {0x01, 0x82}  # ping, sync read
    assert stepped.torque() == [0] * 7


@pytest.mark.fault(8)
def test_missing_servos_are_all_named(stepped: SteppedArm) -> None:
    lost = [without(2), without(6)]
    stepped.damage = lambda data: lost[1](lost[0](data))
    with pytest.raises(ServoMissingError) as caught:
        stepped.session()
    assert caught.value.servo_ids == (2, 6)
    message = str(caught.value)
    assert "servo 2 (shoulder_abduction), 6 (wrist_flexion) of human7" in message
    assert "answering: 1 (xm540-w270), 3 (xm540-w270)" in message
    assert caught.value.exit_status == 3


@pytest.mark.fault(14)
def test_nobody_there(stepped: SteppedArm) -> None:
    stepped.damage = lambda _: b""
    with pytest.raises(ServoMissingError, match=r"at 1000000 baud \(answering: none\)"):
        stepped.session()


@pytest.mark.fault(7)
def test_another_model(human7: ArmDescription) -> None:
    servos = [replace(s, model="xm430-w350") if s.id == 2 else s for s in human7.servo]
    stepped = SteppedArm(replace(human7, servo=tuple(servos)))
    stepped.description = human7
    with pytest.raises(ServoMismatchError) as caught:
        stepped.session()
    assert "servo 2 (shoulder_abduction)" in str(caught.value)
    assert "is an xm430-w350, human7 has an xm540-w270 there" in str(caught.value)


def store(register: str, value: int) -> Callable[[Servo], None]:
    return lambda servo: servo.memory.store(register, value)


CASES: list[tuple[Callable[[Servo], None], type[ArmsynError], str]] = [
    (store("Operating Mode", 1), ServoMismatchError, "operating mode 1: write 3"),
    (store("Drive Mode", 8), ServoMismatchError, "clear bit 3 of register 10"),
    (store("Drive Mode", 1), ServoMismatchError, "counts positions the other way round"),
    (store("Drive Mode", 5), ServoMismatchError, "bit 0 of register 10, Drive Mode, reads 1"),
    (store("Drive Mode", 2), ServoMismatchError, "clear bit 1 of register 10"),
    (store("Homing Offset", 1025), ServoMismatchError, "homing offset of 1025"),
    (
        lambda servo: servo.raise_hardware_error(HardwareError.MOTOR_ENCODER),
        HardwareFaultError,
        "hardware error: encoder",
    ),
    (store("Bus Watchdog", 255), HardwareFaultError, "armsyn clear"),
]


@pytest.mark.fault(23, 25)
@pytest.mark.parametrize(("spoil", "kind", "text"), CASES, ids=[case[2][:18] for case in CASES])
def test_servos_that_must_not_be_moved(
    stepped: SteppedArm, spoil: Callable[[Servo], None], kind: type[ArmsynError], text: str
) -> None:
    spoil(stepped.servos[3])
    with pytest.raises(kind) as caught:
        stepped.session()
    assert "servo 4 (elbow_flexion)" in str(caught.value)
    assert text in str(caught.value)
    assert "\n" not in str(caught.value)
    assert written(stepped) == {0x01, 0x82}


def test_the_time_based_profile_is_accepted(stepped: SteppedArm) -> None:
    for servo in stepped.servos:
        servo.memory.store("Drive Mode", 4)
        servo.memory.store("Profile Velocity", 2000)  # two seconds for each goal
    recording = stepped.session().run(stepped.way(0.3, 0, 0, 0.4))
    assert recording.tracking_rms() < 0.1
    assert stepped.value("Profile Velocity") == [2000] * 7  # put back


def test_a_servo_that_is_reversed_as_described(human7: ArmDescription) -> None:
    servo = tuple(replace(s, drive_mode=1) if s.id == 4 else s for s in human7.servo)
    stepped = SteppedArm(replace(human7, servo=servo))
    stepped.session()
    stepped.servos[3].memory.store("Drive Mode", 0)
    with pytest.raises(ServoMismatchError, match=r"servo 4 \(elbow_flexion\) .* reads 0"):
        stepped.session()


def test_servos_that_answer_only_pings(stepped: SteppedArm) -> None:
    for servo in stepped.servos:
        servo.write(68, b"\x00")
    with pytest.raises(ServoMismatchError, match=r"Status Return Level \(register 68\)"):
        stepped.session()


def test_a_servo_that_dies_while_it_is_checked(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    check = session.check_models

    def and_dies(*arguments: object) -> None:
        check(*arguments)  # type: ignore[arg-type]
        stepped.port.simulation.inject("silent-servo:id=4")

    monkeypatch.setattr(session, "check_models", and_dies)
    with pytest.raises(BusTimeoutError, match=r"servo 4 \(elbow_flexion\) .* stopped answering"):
        stepped.session()


def test_status_return_level_1_is_enough(stepped: SteppedArm) -> None:
    for servo in stepped.servos:
        servo.write(68, b"\x01")
    stepped.session().run(stepped.way(0.2))


@pytest.mark.fault(16)
def test_the_factory_return_delay_is_refused(human7: ArmDescription) -> None:
    old = {servo.id: 42 for servo in human7.servo}  # too old to answer with one packet together
    stepped = SteppedArm(human7, return_delay=250, firmware=old)
    with pytest.raises(BusRateError, match=r"3\.50 ms of return delay"):
        stepped.session()
    assert stepped.torque() == [0] * 7
    stepped.session(rate=100.0)


def test_fast_reads_wait_for_one_return_delay_only(human7: ArmDescription) -> None:
    SteppedArm(human7, return_delay=250).session(rate=200.0)


@pytest.mark.fault(15)
def test_a_slow_adapter_is_refused(stepped: SteppedArm) -> None:
    stepped.bus.latency = 0.016
    with pytest.raises(BusRateError, match="keeps both replies for up to 16 ms"):
        stepped.session()
    assert stepped.torque() == [0] * 7
    stepped.session(rate=25.0)


def test_a_rate_too_slow_for_the_watchdog_is_refused(stepped: SteppedArm) -> None:
    with pytest.raises(BusRateError, match="which must hold two periods"):
        stepped.session(rate=5.0)


def test_an_arm_without_servos(human7: ArmDescription) -> None:
    with pytest.raises(DescriptionError, match="model only"):
        ArmSession.open("/nowhere", replace(human7, servo=()), 200.0)
    with pytest.raises(DescriptionError, match="model only"):
        clear_watchdogs("/nowhere", replace(human7, servo=()))


def test_an_unknown_model(human7: ArmDescription) -> None:
    servo = tuple(replace(s, model="ax-12a") for s in human7.servo)
    with pytest.raises(DescriptionError, match="'ax-12a' does not speak protocol 2"):
        ArmSession.open("/nowhere", replace(human7, servo=servo), 200.0)
    with pytest.raises(DescriptionError, match="'ax-12a' does not speak protocol 2"):
        clear_watchdogs("/nowhere", replace(human7, servo=servo))


def test_a_port_that_does_not_exist(human7: ArmDescription) -> None:
    with pytest.raises(PortError, match="/nowhere does not exist"):
        ArmSession.open("/nowhere", human7, 200.0)
