"""What the servos on the bus are and how they are set up, as read before torque."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from armsyn.arm import ServoDescription
from armsyn.driver import registers as reg
from armsyn.driver.models import a_model, model_name
from armsyn.driver.presence import hardware_error
from armsyn.driver.servos import ServoGroup, title_of
from armsyn.errors import (
    BusTimeoutError,
    ServoMismatchError,
    ServoMissingError,
)

PROFILES = ("Profile Velocity", "Profile Acceleration", "Moving Speed", "Goal Acceleration")
"""Registers that shape a servo's way to its goal, velocities first: they bound accelerations."""


@dataclass(frozen=True)
class ServoFacts:
    """One servo as it was found. Values are in the registers' own units.

    What its family does not have reads as what means the same: no offset, no mode of driving.

    Attributes
    ----------
    servo : ServoDescription
        What it should be.
    firmware : int or None
        Version; None where nobody has asked.
    return_delay : float
        s.
    drive_mode, operating_mode, homing_offset, minimum_position, maximum_position : int
        Operating Mode in the X series' numbers, whatever the family.
    secondary_id : int
        Whose writes it hears too; 253 and more for nobody's.
    torque_enabled : bool
    hardware_error : int
        Hardware Error Status, in the bits of the X series; of the status byte in protocol 1.0.
    bus_watchdog : int or None
        None for a servo that has none.
    velocity_limit : int or None
        Greatest value of Profile Velocity.
    torque_limit : int or None
        Torque Limit; 0 after a shutdown. None where there is none.
    temperature_limit, minimum_voltage, maximum_voltage : int
        In degrees Celsius and 0.1 V.
    current_limit : int or None
        Current Limit, which acts in the modes that control a current.
    profiles : mapping of str to int
        Those of `PROFILES` that it has.
    goal_position, present_position : int
    """

    servo: ServoDescription
    firmware: int | None
    return_delay: float
    drive_mode: int
    operating_mode: int
    homing_offset: int
    minimum_position: int
    maximum_position: int
    secondary_id: int
    torque_enabled: bool
    hardware_error: int
    bus_watchdog: int | None
    velocity_limit: int | None
    torque_limit: int | None
    temperature_limit: int
    minimum_voltage: int
    maximum_voltage: int
    current_limit: int | None
    profiles: Mapping[str, int]
    goal_position: int
    present_position: int

    @property
    def servo_id(self) -> int:
        """On the bus."""
        return self.servo.id

    @property
    def joint(self) -> str:
        """That it moves."""
        return self.servo.joint

    @property
    def title(self) -> str:
        """Name for messages."""
        return title_of(self.servo)


def check_models(group: ServoGroup, arm: str) -> None:
    """Make sure that every servo answers and is the model it should be.

    The group knows the servos' firmware from then on.

    Parameters
    ----------
    group : ServoGroup
    arm : str
        Its name.

    Raises
    ------
    ServoMissingError
        Some do not answer; all of them are named.
    ServoMismatchError
        Another model.
    """
    bus, numbers = group.bus, {}
    for servo_id in group.ids:
        try:
            numbers[servo_id], group.firmware[servo_id] = bus.ping(servo_id)
        except BusTimeoutError:
            continue
    missing = [servo for servo in group.servos if servo.id not in numbers]
    if missing:
        named = ", ".join(f"{servo.id} ({servo.joint})" for servo in missing)
        raise ServoMissingError(
            f"no answer from servo {named} of {arm} on {bus.port_name} at {bus.baudrate}"
            f" baud (answering: {_answering(group)}): check power, cable, ID and baud rate"
            " (armsyn scan looks at all of them)",
            tuple(servo.id for servo in missing),
        )
    for servo in group.servos:
        check_model(group, servo, numbers[servo.id], arm)


def check_model(group: ServoGroup, servo: ServoDescription, number: int, arm: str) -> None:
    """Refuse a servo that answers with another model number; ServoMismatchError."""
    if number != group.models[servo.id].number:
        raise ServoMismatchError(
            f"{group.title(servo.id)} on {group.bus.port_name} is {a_model(model_name(number))},"
            f" {arm} has {a_model(servo.model)} there: check the ID or the description"
        )


def _answering(group: ServoGroup) -> str:
    bus = group.bus
    found = bus.broadcast_ping() if 2 in bus.protocols.values() else {}
    found |= {
        servo.id: group.models[servo.id].number
        for servo in group.servos
        if servo.protocol == 1 and servo.id in group.firmware
    }
    return ", ".join(f"{i} ({model_name(number)})" for i, number in sorted(found.items())) or "none"


def read_facts(group: ServoGroup) -> tuple[ServoFacts, ...]:
    """Read how the servos are set up; the bus keeps their return delays in mind from then on.

    Parameters
    ----------
    group : ServoGroup

    Returns
    -------
    tuple of ServoFacts
        In the group's order.

    Raises
    ------
    ServoMismatchError
        Servos that answer a ping but do not answer reads.
    BusTimeoutError
        Servos that have stopped answering since they were found.
    BusError, PortLostError
        As the bus.
    """
    names = (
        "Return Delay Time",
        "Drive Mode",
        "Operating Mode",
        "Homing Offset",
        "Min Position Limit",
        "Max Position Limit",
        "Secondary ID",
        "Torque Enable",
        "Hardware Error Status",
        "Bus Watchdog",
        "Velocity Limit",
        "Torque Limit",
        "Temperature Limit",
        "Min Voltage Limit",
        "Max Voltage Limit",
        *PROFILES,
        "Goal Position",
        "Present Position",
    )
    try:
        delays = group.read(names[0])
        group.bus.return_delays.update(
            {i: value * reg.RETURN_DELAY_UNIT for i, value in delays.items()}
        )
        values = {name: group.read(name) for name in names[1:]}
        measuring = [i for i in group.ids if group.models[i].current_unit is not None]
        values["Current Limit"] = group.read("Current Limit", measuring)
    except BusTimeoutError as error:
        _check_still_there(group, error.servo_ids)
        address = group.models[error.servo_ids[0]].layout["Status Return Level"].address
        raise ServoMismatchError(
            f"servos {error.servo_ids} on {group.bus.port_name} answer a ping but not a read: their"
            f" Status Return Level (register {address}) may be 0, it must be 1 or 2"
        ) from error
    lacking = [i for i in group.ids if "Hardware Error Status" not in group.models[i].layout]
    values["Hardware Error Status"] |= {i: hardware_error(group, i) for i in lacking}
    return tuple(_facts(group, servo, values) for servo in group.servos)


def _check_still_there(group: ServoGroup, servo_ids: tuple[int, ...]) -> None:
    """Tell servos that have gone from those that only do not answer reads; BusTimeoutError."""
    gone = []
    for servo_id in servo_ids:
        try:
            group.bus.ping(servo_id)
        except BusTimeoutError:
            gone.append(servo_id)
    if gone:
        named = ", ".join(group.title(servo_id) for servo_id in gone)
        raise BusTimeoutError(
            f"{named} on {group.bus.port_name} has stopped answering while the arm was checked:"
            " check its power and cable",
            tuple(gone),
        )


def _facts(
    group: ServoGroup, servo: ServoDescription, values: Mapping[str, Mapping[int, int]]
) -> ServoFacts:
    layout = group.models[servo.id].layout
    own = {name: read[servo.id] for name, read in values.items() if servo.id in read}
    return ServoFacts(
        servo=servo,
        firmware=group.firmware.get(servo.id),
        return_delay=group.bus.return_delays[servo.id],
        drive_mode=own.get("Drive Mode", 0),
        operating_mode=_operating_mode(layout, own),
        homing_offset=own.get("Homing Offset", 0),
        minimum_position=own["Min Position Limit"],
        maximum_position=own["Max Position Limit"],
        secondary_id=own.get("Secondary ID", reg.NO_SECONDARY_ID),
        torque_enabled=bool(own["Torque Enable"]),
        hardware_error=layout.hardware_error(own["Hardware Error Status"]),
        bus_watchdog=own.get("Bus Watchdog"),
        velocity_limit=own.get("Velocity Limit"),
        torque_limit=own.get("Torque Limit"),
        temperature_limit=own["Temperature Limit"],
        minimum_voltage=own["Min Voltage Limit"],
        maximum_voltage=own["Max Voltage Limit"],
        current_limit=own.get("Current Limit"),
        profiles={name: own[name] for name in PROFILES if name in own},
        goal_position=own["Goal Position"],
        present_position=own["Present Position"],
    )


def _operating_mode(layout: reg.Layout, values: Mapping[str, int]) -> int:
    """Operating mode in the X series' numbers.

    AX and MX with Protocol 1.0 have no such register: limits that are both 0 make a wheel, an
    MX's that are both 4095 count turns (e-Manual, MX-28, "CW/CCW Angle Limit(6, 8)").
    """
    if layout is reg.X:
        return values["Operating Mode"]
    if layout is reg.XL320:
        joint = values["Operating Mode"] == reg.XL320_JOINT_MODE
        return reg.POSITION_MODE if joint else reg.VELOCITY_MODE
    limits = values["Min Position Limit"], values["Max Position Limit"]
    if limits == (0, 0):
        return reg.VELOCITY_MODE
    turns = layout is reg.MX1 and limits == (reg.LAST_TICK, reg.LAST_TICK)
    return reg.EXTENDED_POSITION_MODE if turns else reg.POSITION_MODE
