"""The servos to simulate: what is known of each before it is powered up."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from firmware_sim.errors import RigError
from firmware_sim.firmware.checking import check_value
from firmware_sim.firmware.codes import MAX_ID
from firmware_sim.firmware.control_table import Access, Area
from firmware_sim.firmware.model import ServoModel
from firmware_sim.tables import find_model
from firmware_sim.wire.line import same_rate

_FACTORY: Mapping[str, int] = MappingProxyType({})
GRIPPER = "gripper"
"""What servos name as their joint that move fingers, where no file says otherwise."""

_RATES_SHOWN = 12
"""Of a model that has far more, most of which are of no use to anybody."""


@dataclass(frozen=True, slots=True)
class Mount:
    """How a servo sits on its joint.

    Parameters
    ----------
    joint : str
        The joint's name, in the arm's MJCF if its bodies are simulated; servos that name one joint
        share it. Empty for a joint without a name.
    direction : int
        1 where the horn's positive direction is the joint's, -1 where it is the other.
    zero_tick : int
        What Present Position reads at the joint's zero.
    """

    joint: str
    direction: int = 1
    zero_tick: int = 2048


@dataclass(frozen=True, slots=True)
class ServoSettings:
    """One servo to be simulated.

    Parameters
    ----------
    model : ServoModel
        What it is, with the table of its firmware and protocol.
    servo_id : int
        0 to 252.
    start_tick : int
        Where it lies at the start, as Present Position reads.
    supply_voltage : float or None
        V; None for the motor's nominal voltage.
    registers : mapping of str to int
        EEPROM registers that differ from the factory's, by name; the ID is not among them.
    mount : Mount or None
        Where it sits on an arm, if a file says so.
    shadow_of : int or None
        ID of the servo whose joint it moves too, and whose goals it follows.
    """

    model: ServoModel
    servo_id: int
    start_tick: int = 2048
    supply_voltage: float | None = None
    registers: Mapping[str, int] = field(default_factory=lambda: _FACTORY)
    mount: Mount | None = None
    shadow_of: int | None = None

    @property
    def name(self) -> str:
        """``MODEL:ID``, as a command line names it."""
        return f"{self.model.name}:{self.servo_id}"

    def with_registers(self, registers: Mapping[str, int]) -> ServoSettings:
        """Return the same servo with more registers set; none of them is checked."""
        return replace(self, registers=MappingProxyType({**self.registers, **registers}))


@dataclass(frozen=True, slots=True)
class Supply:
    """What feeds all servos.

    Parameters
    ----------
    voltage : float or None
        With no load, V; None for each motor's nominal voltage.
    resistance : float or None
        Of the supply and its cables, ohm: the voltage falls by it times the current. None for that
        of a good one.
    """

    voltage: float | None = None
    resistance: float | None = None


@dataclass(frozen=True, slots=True)
class Rig:
    """Everything that a simulation is made of.

    Parameters
    ----------
    servos : sequence of ServoSettings
        At least one.
    supply : Supply
        What feeds them.
    mjcf : str or None
        The arm's bodies as MuJoCo's XML, if a file has them.
    gripper : str
        What servos name as their joint that move fingers; the bodies need not have it.
    """

    servos: Sequence[ServoSettings]
    supply: Supply = field(default_factory=Supply)
    mjcf: str | None = None
    gripper: str = GRIPPER


def highest_tick(model: ServoModel) -> int:
    """Return the largest position within one turn (or within the range of a joint), ticks."""
    for name in ("Max Position Limit", "CCW Angle Limit"):
        register = model.table.by_name.get(name)
        if register is not None:
            return register.maximum
    raise RigError(f"{model.name} has no position limit", field="model")


def centre_tick(model: ServoModel) -> int:
    """Return the middle of a model's positions, ticks: 2048 of 4096, 512 of 1024."""
    return (highest_tick(model) + 1) // 2


def parse_servo(text: str) -> ServoSettings:
    """Return the servo that ``MODEL:ID`` or ``MODEL@FIRMWARE:ID`` names.

    Raises
    ------
    RigError
        If the text is of another form, or the model, firmware or ID is not possible.
    """
    name, colon, number = text.rpartition(":")
    name, at, firmware = name.partition("@")
    if not colon or not _is_number(number) or (at and not _is_number(firmware)):
        raise RigError(
            f"--servo {text!r} is not of the form MODEL:ID or MODEL@FIRMWARE:ID,"
            " as in xm430-w350:1 or xl330-m288@46:2"
        )
    if int(number) > MAX_ID:
        raise RigError(f"--servo {text!r}: IDs go from 0 to {MAX_ID}")
    model = find_model(name, int(firmware) if at else None)
    return ServoSettings(model, int(number), centre_tick(model))


def _is_number(text: str) -> bool:
    return text.isascii() and text.isdecimal() and len(text) <= 3


def with_baud_rate(settings: ServoSettings, baud_rate: int) -> ServoSettings:
    """Return the same servo set to another baud rate, bit/s.

    One that its own comes near enough to will do: an AX that is asked for 57600 has 57143.

    Raises
    ------
    RigError
        If the model has no such rate.
    """
    codes = {rate: code for code, rate in settings.model.baud_rates.items()}
    nearest = min(codes, key=lambda rate: abs(rate - baud_rate))
    if not same_rate(nearest, baud_rate):
        known = rates_in_words(codes)
        raise RigError(
            f"baud = {baud_rate} is none of {settings.model.name}'s {known}", field="baud"
        )
    return settings.with_registers({"Baud Rate": codes[nearest]})


def rates_in_words(rates: Iterable[int]) -> str:
    """Return a model's baud rates, bit/s; of very many only the highest."""
    known = sorted(rates)
    if len(known) <= _RATES_SHOWN:
        return ", ".join(map(str, known))
    return ", ".join(map(str, known[: -_RATES_SHOWN - 1 : -1])) + ", ..."


def with_protocol(settings: ServoSettings, protocol: int) -> ServoSettings:
    """Return the same servo speaking Protocol 1.0 (1) or 2.0 (2).

    An MX gets the firmware of that protocol, an X-series servo the Protocol Type.

    Raises
    ------
    RigError
        If the model cannot speak it; names the servo.
    """
    model = settings.model
    try:
        speaking = find_model(model.name, protocol=protocol)
    except RigError:
        raise RigError(
            f"{settings.name} speaks Protocol {model.protocol}.0 only:"
            f" protocol = {protocol} is not possible",
            field="protocol",
        ) from None
    if speaking.number != model.number:  # an MX has a firmware for each
        model = replace(speaking, motor=model.motor)
    found = replace(settings, model=model)
    register = model.table.by_name.get("Protocol Type")
    if register is not None and register.default != protocol:
        return found.with_registers({"Protocol Type": protocol})
    return found


def with_settings(settings: ServoSettings, registers: Mapping[str, int]) -> ServoSettings:
    """Return the same servo with EEPROM registers set to values.

    Raises
    ------
    RigError
        If a register is not one of the model's EEPROM, or a value is outside its range.
    """
    for name, value in registers.items():
        _check_register(settings.model, name, value)
    return settings.with_registers(registers)


def _check_register(model: ServoModel, name: str, value: object) -> None:
    register = model.table.by_name.get(name)
    if register is None or register.area is not Area.EEPROM or register.access is Access.READ:
        raise RigError(f"{name!r} is no EEPROM register that {model.name} lets be set", field=name)
    if name == "ID":
        raise RigError("the ID is given by id, not as a register", field=name)
    check_value(model, name, value)


def check_ids(servos: Sequence[ServoSettings]) -> None:
    """Refuse servos that share an ID.

    Raises
    ------
    RigError
        If two do.
    """
    seen: set[int] = set()
    for servo in servos:
        if servo.servo_id in seen:
            raise RigError(f"ID {servo.servo_id} is given twice: IDs must differ", field="id")
        seen.add(servo.servo_id)
