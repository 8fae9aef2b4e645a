"""What the servos on the bus are and how they are set up, read and judged before torque."""

from __future__ import annotations

from dataclasses import dataclass

from armsyn.arm import ArmDescription
from armsyn.driver import registers as reg
from armsyn.driver.models import model_name, servo_model
from armsyn.driver.transactions import Bus
from armsyn.errors import (
    BusTimeoutError,
    HardwareFaultError,
    ServoMismatchError,
    ServoMissingError,
)

LARGEST_HOMING_OFFSET = 1024
"""Ticks; position mode ignores a homing offset beyond (e-Manual, Homing Offset)."""


@dataclass(frozen=True)
class ServoFacts:
    """One servo as it was found. Values are in the registers' own units.

    Attributes
    ----------
    servo_id : int
    joint, model : str
        From the description.
    return_delay : float
        s.
    drive_mode, operating_mode, homing_offset, minimum_position, maximum_position : int
    torque_enabled : bool
    hardware_error, bus_watchdog : int
    profile_velocity, profile_acceleration : int
    goal_position, present_position : int
    """

    servo_id: int
    joint: str
    model: str
    return_delay: float
    drive_mode: int
    operating_mode: int
    homing_offset: int
    minimum_position: int
    maximum_position: int
    torque_enabled: bool
    hardware_error: int
    bus_watchdog: int
    profile_velocity: int
    profile_acceleration: int
    goal_position: int
    present_position: int

    @property
    def title(self) -> str:
        """Name for messages."""
        return f"servo {self.servo_id} ({self.joint})"


def check_models(bus: Bus, arm: ArmDescription) -> None:
    """Make sure that every servo of the description answers and is the model it should be.

    Parameters
    ----------
    bus : Bus
    arm : ArmDescription

    Raises
    ------
    ServoMissingError
        Some do not answer; all of them are named.
    ServoMismatchError
        Another model.
    """
    numbers: dict[int, int] = {}
    for servo in arm.servo:
        try:
            numbers[servo.id], _ = bus.ping(servo.id)
        except BusTimeoutError:
            continue
    missing = [servo for servo in arm.servo if servo.id not in numbers]
    if missing:
        named = ", ".join(f"{servo.id} ({servo.joint})" for servo in missing)
        raise ServoMissingError(
            f"no answer from servo {named} of {arm.name} on {bus.port_name} at {bus.baudrate}"
            f" baud (answering: {_answering(bus)}): check power, cable, ID and baud rate",
            tuple(servo.id for servo in missing),
        )
    for servo in arm.servo:
        if numbers[servo.id] != servo_model(servo.model, servo.protocol).number:
            raise ServoMismatchError(
                f"servo {servo.id} ({servo.joint}) on {bus.port_name} is a"
                f" {model_name(numbers[servo.id])}, {arm.name} has a {servo.model} there:"
                " check the ID or the description"
            )


def _answering(bus: Bus) -> str:
    found = bus.broadcast_ping()
    return ", ".join(f"{i} ({model_name(number)})" for i, number in found.items()) or "none"


def read_facts(bus: Bus, arm: ArmDescription) -> tuple[ServoFacts, ...]:
    """Read how the servos are set up; they keep their return delays in mind from then on.

    Parameters
    ----------
    bus : Bus
    arm : ArmDescription

    Returns
    -------
    tuple of ServoFacts
        In the joints' order.

    Raises
    ------
    ServoMismatchError
        Servos that answer a ping but do not answer reads.
    BusError, PortLostError
        As the bus.
    """
    ids = tuple(servo.id for servo in arm.servo)
    rows = {
        "return_delay": reg.RETURN_DELAY_TIME,
        "drive_mode": reg.DRIVE_MODE,
        "operating_mode": reg.OPERATING_MODE,
        "homing_offset": reg.HOMING_OFFSET,
        "minimum_position": reg.MIN_POSITION_LIMIT,
        "maximum_position": reg.MAX_POSITION_LIMIT,
        "torque_enabled": reg.TORQUE_ENABLE,
        "hardware_error": reg.HARDWARE_ERROR_STATUS,
        "bus_watchdog": reg.BUS_WATCHDOG,
        "profile_velocity": reg.PROFILE_VELOCITY,
        "profile_acceleration": reg.PROFILE_ACCELERATION,
        "goal_position": reg.GOAL_POSITION,
        "present_position": reg.PRESENT_POSITION,
    }
    try:
        values = {field: bus.read_all(register, ids) for field, register in rows.items()}
    except BusTimeoutError as error:
        raise ServoMismatchError(
            f"servos {error.servo_ids} on {bus.port_name} answer a ping but not a read: their"
            " Status Return Level (register 68) may be 0, it must be 1 or 2"
        ) from error
    facts = []
    for servo in arm.servo:
        row: dict[str, int] = {field: read[servo.id] for field, read in values.items()}
        delay, torque = row.pop("return_delay"), row.pop("torque_enabled")
        bus.return_delays[servo.id] = delay * reg.RETURN_DELAY_UNIT
        facts.append(
            ServoFacts(
                servo_id=servo.id,
                joint=servo.joint,
                model=servo.model,
                return_delay=delay * reg.RETURN_DELAY_UNIT,
                torque_enabled=bool(torque),
                **row,
            )
        )
    return tuple(facts)


def check_facts(facts: tuple[ServoFacts, ...], arm: ArmDescription) -> None:
    """Refuse servos that must not be given torque as they are.

    Of Drive Mode, bit 0 (reverse) must be as described, bits 1 (dual-joint slave) and 3 (torque
    on by a goal) must be clear. Bit 2 (time-based profile) may differ from the description: it
    only says what the profile registers mean, and they are 0 (no profile) while goals stream.

    Parameters
    ----------
    facts : tuple of ServoFacts
        In the order of the description's servos.
    arm : ArmDescription

    Raises
    ------
    HardwareFaultError
        A latched hardware error, or a bus watchdog that has expired or is about to.
    ServoMismatchError
        An operating mode, drive mode or homing offset that this driver cannot stream to, or
        another direction than described.
    """
    for servo, described in zip(facts, arm.servo, strict=True):
        _check_setup(servo)
        _check_drive_mode(servo, described.drive_mode)
    for servo in facts:
        _check_faults(servo)


def _check_setup(servo: ServoFacts) -> None:
    if servo.operating_mode not in (reg.POSITION_MODE, reg.EXTENDED_POSITION_MODE):
        raise ServoMismatchError(
            f"{servo.title} is in operating mode {servo.operating_mode}: write 3 (position) to"
            " register 11 with its torque off"
        )
    in_position_mode = servo.operating_mode == reg.POSITION_MODE
    if in_position_mode and abs(servo.homing_offset) > LARGEST_HOMING_OFFSET:
        raise ServoMismatchError(
            f"{servo.title} has a homing offset of {servo.homing_offset}, which position mode"
            f" ignores: bring register 20 within +-{LARGEST_HOMING_OFFSET}"
        )


def _check_drive_mode(servo: ServoFacts, described: int) -> None:
    if servo.drive_mode & reg.DRIVE_MODE_TORQUE_BY_GOAL:
        raise ServoMismatchError(
            f"{servo.title} switches its torque on by itself when it gets a goal: clear bit 3 of"
            " register 10 (Drive Mode) with its torque off"
        )
    if servo.drive_mode & reg.DRIVE_MODE_SLAVE:
        raise ServoMismatchError(
            f"{servo.title} is the slave of a dual joint and does not follow its own goals: clear"
            " bit 1 of register 10 (Drive Mode) with its torque off"
        )
    if (servo.drive_mode ^ described) & reg.DRIVE_MODE_REVERSE:
        raise ServoMismatchError(
            f"{servo.title} counts positions the other way round than described (bit 0 of register"
            f" 10, Drive Mode, reads {servo.drive_mode & reg.DRIVE_MODE_REVERSE}): set it with the"
            " torque off, or correct drive_mode, direction and zero_tick in the description"
        )


def _check_faults(servo: ServoFacts) -> None:
    if servo.hardware_error:
        raise HardwareFaultError(
            f"{servo.title} reports a hardware error:"
            f" {reg.hardware_error_names(servo.hardware_error)}"
            "; see to the cause, support the arm, then reboot the servo (its torque drops)",
            servo.servo_id,
        )
    if servo.bus_watchdog > 0 and servo.torque_enabled:
        raise HardwareFaultError(
            f"{servo.title} holds with its bus watchdog armed (register 98 reads"
            f" {servo.bus_watchdog}): another program moves the arm, or has just ended with a"
            " fault; end it, look at the arm, then write 0 to register 98 of its servos"
            " (armsyn.driver.clear_watchdogs does)",
            servo.servo_id,
        )
    if servo.bus_watchdog == reg.WATCHDOG_EXPIRED:
        raise HardwareFaultError(
            f"{servo.title} was stopped by its bus watchdog: the program that moved the arm ended"
            " or stalled; look at the arm, then write 0 to register 98 of its servos"
            " (armsyn.driver.clear_watchdogs does)",
            servo.servo_id,
        )
