"""Judging servos before they get torque: set up as described, sound, and stopped by nobody."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from armsyn.arm import ArmDescription, ServoDescription, calibration_of
from armsyn.arm.calibration import RADIANS_PER_TICK, radians_per_tick
from armsyn.driver import registers as reg
from armsyn.driver.facts import ServoFacts
from armsyn.errors import HardwareFaultError, NoWatchdogError, ServoMismatchError

LARGEST_HOMING_OFFSET = 1024
"""Ticks; position mode ignores a homing offset beyond (e-Manual, Homing Offset)."""

PAIR_TOLERANCE_TICKS = 20
"""How far apart the two servos of a dual joint may read (1.8 degrees). Both hold the same goal, so
each then pushes with half of that, an XM540 at its usual gain with 7 % of its stall torque."""

CONSENT = "--accept-no-watchdog"

TICKS_PER_TURN = reg.LAST_TICK + 1

_OUTSIDE_TICKS = 256
"""How far outside its range a limp or sagging joint may lie (22 degrees)."""

_END_TICKS = 64
"""How near its range's end the other turn's tick tells nothing: a full turn begins as it ends."""

_TURNS = 8
_ROUNDING = 1e-9


def check_facts(facts: Sequence[ServoFacts], arm: ArmDescription) -> None:
    """Refuse servos that must not be given torque as they are.

    Of Drive Mode, bit 0 (reverse) must be as described, bits 1 (dual-joint slave) and 3 (torque
    on by a goal) must be clear. Bit 2 (time-based profile) may differ from the description: it
    only says what the profile registers mean. The gripper's servo may be in any operating mode:
    its goals are not streamed.

    Parameters
    ----------
    facts : sequence of ServoFacts
        Of servos of the arm.
    arm : ArmDescription

    Raises
    ------
    HardwareFaultError
        A latched hardware error, a shutdown, or a bus watchdog that has expired or is about to.
    ServoMismatchError
        An operating mode, drive mode, homing offset or secondary ID that this driver cannot
        stream to, another direction than described, or turns that nobody has counted.
    """
    for servo in facts:
        if servo.joint in arm.joint_names:
            _check_mode(servo)
            _check_turns(servo, arm)
            _check_drive_mode(servo)
        _check_secondary(servo)
    for servo in facts:
        _check_faults(servo)
        _check_watchdog(servo)


def check_pairs(facts: Sequence[ServoFacts]) -> None:
    """Refuse torque to a dual joint whose two servos would fight each other.

    Parameters
    ----------
    facts : sequence of ServoFacts

    Raises
    ------
    ServoMismatchError
        They read more than `PAIR_TOLERANCE_TICKS` apart.
    """
    by_id = {servo.servo_id: servo for servo in facts}
    for shadow in facts:
        leader = by_id.get(-1 if shadow.servo.shadow_of is None else shadow.servo.shadow_of)
        if leader is None:
            continue
        apart = abs(shadow.present_position - leader.present_position)
        if apart > PAIR_TOLERANCE_TICKS:
            raise ServoMismatchError(
                f"{shadow.title} reads {apart} ticks off servo {leader.servo_id}, whose goals it"
                f" follows, {PAIR_TOLERANCE_TICKS} are allowed: they would fight each other; align"
                " them with armsyn calibrate"
            )


def unwatched(facts: Iterable[ServoFacts]) -> tuple[ServoFacts, ...]:
    """Servos that go on to their last goal, whatever becomes of the host: no bus watchdog."""
    return tuple(servo for servo in facts if servo.bus_watchdog is None)


def check_watchdogs(facts: Iterable[ServoFacts], *, accepted: bool) -> None:
    """Refuse servos without a bus watchdog, unless somebody has accepted that.

    Parameters
    ----------
    facts : iterable of ServoFacts
        Of the servos that are to move.
    accepted : bool
        Somebody has.

    Raises
    ------
    NoWatchdogError
        All of them are named.
    """
    lacking = unwatched(facts)
    if accepted or not lacking:
        return
    named = ", ".join(
        f"{servo.servo_id} ({servo.joint}, {why_unwatched(servo)})" for servo in lacking
    )
    raise NoWatchdogError(
        f"servo {named} has no bus watchdog: if this program or its computer dies, it goes on to"
        f" its last goal and holds it until its power is cut; if you accept that, add {CONSENT}",
        tuple(servo.servo_id for servo in lacking),
    )


def why_unwatched(servo: ServoFacts) -> str:
    """Why a servo has no bus watchdog, in a few words."""
    if servo.servo.protocol == 1:
        return f"{servo.servo.model}, protocol 1"
    if servo.servo.model == "xl-320" or servo.firmware is None:
        return servo.servo.model
    return f"{servo.servo.model} with firmware {servo.firmware}"


def _check_mode(servo: ServoFacts) -> None:
    if servo.operating_mode not in (reg.POSITION_MODE, reg.EXTENDED_POSITION_MODE):
        if servo.servo.protocol == 1:
            raise ServoMismatchError(
                f"{servo.title} turns as a wheel (registers 6 and 8 are 0): write its angle limits"
                " (armsyn setup does)"
            )
        raise ServoMismatchError(
            f"{servo.title} is in operating mode {servo.operating_mode}: write 3 (position) to"
            " register 11 with its torque off (armsyn setup does)"
        )
    in_position_mode = servo.operating_mode == reg.POSITION_MODE
    if in_position_mode and abs(servo.homing_offset) > LARGEST_HOMING_OFFSET:
        raise ServoMismatchError(
            f"{servo.title} has a homing offset of {servo.homing_offset}, which position mode"
            f" ignores: bring register 20 within +-{LARGEST_HOMING_OFFSET}"
        )


def _check_turns(servo: ServoFacts, arm: ArmDescription) -> None:
    """Refuse a servo whose count of turns is not, or may not be, the description's.

    It starts within one turn when it boots, whatever turn it was in.
    """
    if abs(radians_per_tick(servo.servo.model) - RADIANS_PER_TICK) > _ROUNDING:
        return  # does not turn all the way round
    joint = arm.joint[arm.joint_names.index(servo.joint)]
    low, high = sorted(
        int(calibration_of((servo.servo,)).to_ticks([angle])[0])
        for angle in (joint.lower, joint.upper)
    )
    here = servo.present_position
    turns = [here + turn * TICKS_PER_TURN for turn in range(-_TURNS, _TURNS + 1) if turn]
    inside = low - _OUTSIDE_TICKS <= here <= high + _OUTSIDE_TICKS
    if not inside and any(low <= tick <= high for tick in turns):
        raise ServoMismatchError(
            f"{servo.title} reads tick {here}, a whole turn or more away from its joint's range"
            f" ({low} to {high}): it has lost count of its turns; support the arm, then armsyn"
            " reboot brings it back to one turn, or armsyn calibrate finds its zero again"
        )
    extended = servo.operating_mode == reg.EXTENDED_POSITION_MODE
    if extended and any(low + _END_TICKS < tick < high - _END_TICKS for tick in turns):
        raise ServoMismatchError(
            f"{servo.title} reads tick {here}, but its joint's range ({low} to {high}) is more than"
            " a turn, and a servo forgets its turns without power: limit the joint to one turn"
        )


def _check_drive_mode(servo: ServoFacts) -> None:
    if servo.drive_mode & reg.DRIVE_MODE_TORQUE_BY_GOAL:
        raise ServoMismatchError(
            f"{servo.title} switches its torque on by itself when it gets a goal: clear bit 3 of"
            " register 10 (Drive Mode) with its torque off (armsyn setup does)"
        )
    if servo.drive_mode & reg.DRIVE_MODE_SLAVE:
        raise ServoMismatchError(
            f"{servo.title} is the slave of a dual joint and does not follow its own goals: clear"
            " bit 1 of register 10 (Drive Mode) with its torque off (armsyn setup does)"
        )
    if (servo.drive_mode ^ servo.servo.drive_mode) & reg.DRIVE_MODE_REVERSE:
        raise ServoMismatchError(
            f"{servo.title} counts positions the other way round than described (bit 0 of register"
            f" 10, Drive Mode, reads {servo.drive_mode & reg.DRIVE_MODE_REVERSE}): set it with the"
            " torque off, or correct drive_mode, direction and zero_tick in the description"
        )


def _check_secondary(servo: ServoFacts) -> None:
    """Make sure that a shadow follows its leader, and that nobody else follows anybody."""
    leader = servo.servo.shadow_of
    follows = servo.secondary_id if servo.secondary_id < reg.NO_SECONDARY_ID else None
    if follows == leader or (leader is None and follows == servo.servo_id):
        return
    if leader is None:
        raise ServoMismatchError(
            f"{servo.title} follows the goals of servo {follows} (register 12, Secondary ID), which"
            " is not described: write 255 there with its torque off (armsyn setup does)"
        )
    found = "nobody" if follows is None else f"servo {follows}"
    raise ServoMismatchError(
        f"{servo.title} follows {found}: write {leader} to register 12 (Secondary ID) with its"
        " torque off (armsyn setup does)"
    )


def _check_faults(servo: ServoFacts) -> None:
    if servo.hardware_error:
        raise HardwareFaultError(
            f"{servo.title} reports a hardware error:"
            f" {reg.hardware_error_names(servo.hardware_error)}; {cure_of_error(servo.servo)}",
            servo.servo_id,
        )
    if servo.torque_limit == 0:
        raise HardwareFaultError(
            f"{servo.title} has shut itself down (Torque Limit reads 0);"
            f" {cure_of_error(servo.servo)}",
            servo.servo_id,
        )


def cure_of_error(servo: ServoDescription) -> str:
    """What to do about a hardware error: protocol 1.0 has no reboot."""
    if servo.protocol == 1:
        return (
            "see to the cause, support the arm, then cut its power for a moment (its torque is off)"
        )
    return "see to the cause, support the arm, then armsyn reboot (its torque drops)"


def _check_watchdog(servo: ServoFacts) -> None:
    watchdog = servo.bus_watchdog
    if watchdog is None:
        return
    if watchdog > 0 and servo.torque_enabled:
        raise HardwareFaultError(
            f"{servo.title} holds with its bus watchdog armed (register 98 reads {watchdog}):"
            " another program moves the arm, or has just ended with a fault; end it, look at the"
            " arm, then armsyn clear",
            servo.servo_id,
        )
    if watchdog == reg.WATCHDOG_EXPIRED:
        raise HardwareFaultError(
            f"{servo.title} was stopped by its bus watchdog: the program that moved the arm ended"
            " or stalled; look at the arm, then armsyn clear",
            servo.servo_id,
        )
