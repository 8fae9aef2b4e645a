"""Aligning the two servos of a dual joint: the same ticks in the same posture.

Both get the same goal ticks, so what they read must be the same, too, or they fight each other.
How the second horn sits is made up for by its Homing Offset, which is added to what the encoder
counts (e-Manual, "Homing Offset(20)").
"""

from __future__ import annotations

from dataclasses import dataclass

from armsyn.arm import ServoDescription
from armsyn.driver.calibrating import ArmCalibrator
from armsyn.driver.calibrating_follow import turn_of
from armsyn.driver.checks import LARGEST_HOMING_OFFSET
from armsyn.driver.eeprom import EepromImage, read_eeprom, row_of
from armsyn.driver.scan import FoundServo
from armsyn.driver.servos import title_of
from armsyn.driver.setup_plan import Change
from armsyn.driver.setup_write import write_changes
from armsyn.errors import ServoMismatchError

ALIGNED_TICKS = 8
"""How far apart they may read and be left alone (0.7 degrees)."""

_OFFSET = "Homing Offset"


@dataclass(frozen=True)
class Misalignment:
    """A shadow that does not read what its leader does.

    Attributes
    ----------
    shadow : ServoDescription
    apart : int
        Ticks that the leader reads more.
    image : EepromImage
        The shadow's EEPROM.
    change : Change
        Of its homing offset.
    """

    shadow: ServoDescription
    apart: int
    image: EepromImage
    change: Change

    @property
    def title(self) -> str:
        """Name for messages."""
        return title_of(self.shadow)


def misalignments(calibrator: ArmCalibrator) -> tuple[Misalignment, ...]:
    """Dual joints whose servos read differently, with the arm held still.

    Raises
    ------
    ServoMismatchError
        By more than a homing offset can make up for, or with the end of a turn between them.
    BusError, PortLostError
        As the bus.
    """
    present = calibrator.group.read("Present Position")
    offsets = {facts.servo_id: facts.homing_offset for facts in calibrator.facts}
    described = {servo.id: servo for servo in calibrator.arm.servo}
    found = []
    for shadow in calibrator.arm.shadows:
        leader = described[-1 if shadow.shadow_of is None else shadow.shadow_of]
        apart = _nearest(present[leader.id] - present[shadow.id], shadow)
        change = apart if abs(apart) > ALIGNED_TICKS else 0
        there = _folded(present[leader.id], offsets[leader.id], leader)
        here = _folded(present[shadow.id], offsets[shadow.id], shadow) + change
        if abs(there - here) > ALIGNED_TICKS:
            raise ServoMismatchError(
                f"{title_of(shadow)} would read {abs(there - here)} ticks off servo {leader.id},"
                " whose goals it follows, as soon as both have torque: its encoder's turn ends"
                " between them, which no homing offset makes up for: screw its horn on anew, in"
                " another position"
            )
        if change:
            found.append(_misalignment(calibrator, shadow, apart))
    return tuple(found)


def _folded(ticks: int, offset: int, servo: ServoDescription) -> int:
    """Return what a servo reads once it has forgotten the turns that it was moved by."""
    turn = turn_of(servo.model)
    return ticks if turn is None else (ticks - offset) % turn + offset


def _nearest(ticks: int, servo: ServoDescription) -> int:
    turn = turn_of(servo.model)
    return ticks if turn is None else (ticks + turn // 2) % turn - turn // 2


def _misalignment(calibrator: ArmCalibrator, shadow: ServoDescription, apart: int) -> Misalignment:
    group, bus = calibrator.group, calibrator.bus
    model = group.models[shadow.id]
    place = FoundServo(
        bus.baudrate, shadow.protocol, shadow.id, model.number, group.firmware.get(shadow.id)
    )
    image = read_eeprom(bus, place)
    offset = image.registers.get(_OFFSET)
    wanted = None if offset is None else offset + apart
    if wanted is None or offset is None or abs(wanted) > LARGEST_HOMING_OFFSET:
        raise ServoMismatchError(
            f"{title_of(shadow)} reads {abs(apart)} ticks off servo {shadow.shadow_of}, whose goals"
            " it follows, and its homing offset cannot make up for that: screw its horn on in"
            f" another position ({apart * 360 / 4096:+.0f} degrees)"
        )
    return Misalignment(shadow, apart, image, Change(row_of(model.layout, _OFFSET), offset, wanted))


def align(calibrator: ArmCalibrator, misalignment: Misalignment) -> None:
    """Write a shadow's homing offset and make sure that the two read alike then.

    Raises
    ------
    ServoMismatchError
        They do not: the old offset is written back.
    TorqueOnError, HardwareFaultError, BusError, PortLostError
        As `write_changes`.
    """
    shadow, change = misalignment.shadow, misalignment.change
    image = write_changes(calibrator.bus, misalignment.image, (change,), misalignment.title)
    present = calibrator.group.read("Present Position")
    leader = shadow.shadow_of
    apart = present[-1 if leader is None else leader] - present[shadow.id]
    if abs(apart) > ALIGNED_TICKS:
        back = Change(change.register, change.wanted, change.found)
        write_changes(calibrator.bus, image, (back,), misalignment.title)
        raise ServoMismatchError(
            f"{misalignment.title} reads {abs(apart)} ticks off servo {leader} also with a homing"
            f" offset of {change.wanted}: the arm moved, or its horn is loose; the old offset is"
            " back, calibrate again"
        )
