"""What is wrong, or worth knowing, with an arm whose status was read; each with its cure.

Pure functions of an `ArmStatus`. A problem keeps the arm from being used, or harms it; a note does
not.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from armsyn.driver import registers as reg
from armsyn.driver.checks import LARGEST_HOMING_OFFSET, PAIR_TOLERANCE_TICKS, cure_of_error
from armsyn.driver.models import a_model, model_name
from armsyn.driver.power import GOAL_TOLERANCE, ticks_of
from armsyn.driver.status import ArmStatus, ServoStatus
from armsyn.driver.timing import SHORTEST_LATENCY

USUAL_RATE = 200.0
"""Hz at which motions are streamed unless asked otherwise."""

SUPPLY_TOLERANCE = 0.15
"""Part of the described supply voltage by which the measured one may differ."""

NEARLY_HOT = 10.0
"""Degrees Celsius below its limit from which on a servo is said to be warm."""

LIMIT_TOLERANCE = math.radians(0.5)
"""How far beyond its range a joint may be found: where a limp arm leans on its stop."""

RELEASE = "support the arm, armsyn release, then"


@dataclass(frozen=True)
class Finding:
    """Something about an arm.

    Attributes
    ----------
    level : {"problem", "note"}
    where : str
        A servo, joint, or the port.
    what : str
    cure : str
        What to do; empty where there is nothing to be done.
    """

    level: Literal["problem", "note"]
    where: str
    what: str
    cure: str = ""

    def __str__(self) -> str:
        """One line."""
        return f"{self.where}: {self.what}" + (f": {self.cure}" if self.cure else "")


def find(status: ArmStatus) -> tuple[Finding, ...]:
    """All there is to say, problems first.

    Parameters
    ----------
    status : ArmStatus

    Returns
    -------
    tuple of Finding
    """
    if not any(servo.answers or servo.stranger for servo in status.servos):
        findings = [_nobody(status), *_strangers(status)]
    else:
        findings = [
            *(finding for servo in status.servos for finding in _of_servo(servo, status)),
            *_of_pairs(status),
            *_of_joints(status),
            *_watched(status),
            *_strangers(status),
        ]
    findings += _of_bus(status)
    return tuple(sorted(findings, key=lambda finding: finding.level != "problem"))


def _problem(servo: ServoStatus, what: str, cure: str) -> Finding:
    return Finding("problem", servo.title, what, cure)


def _nobody(status: ArmStatus) -> Finding:
    return Finding(
        "problem",
        status.port,
        f"no reply at {status.baud} baud from any servo of {status.arm.name}",
        "check the servos' supply and cable; armsyn scan finds other baud rates and IDs",
    )


def _of_servo(servo: ServoStatus, status: ArmStatus) -> Iterator[Finding]:
    described = servo.described
    if servo.stranger:
        what = f"answers in protocol {3 - described.protocol}, described {described.protocol}"
        yield _problem(servo, what, "armsyn setup, or correct protocol in the description")
        return
    if not servo.answers:
        cure = "check its power and cable; armsyn scan finds another ID or baud rate"
        yield _problem(servo, "no reply", cure)
        return
    if servo.model is None or servo.model.name != described.model:
        is_a = a_model(model_name(servo.number or 0))
        cure = "check the ID, or the model in the description"
        yield _problem(servo, f"is {is_a}, described as {described.model}", cure)
    if servo.model is None:
        return
    if "Present Position" not in servo.values:
        cure = "its Status Return Level may be 0: armsyn setup"
        yield _problem(servo, "answers a ping but no reads", cure)
        return
    yield from _faults(servo)
    yield from _supply(servo)
    yield from _heat(servo)
    if servo.described != status.arm.gripper_servo:  # which may be in any mode
        yield from _mode(servo)
    yield from _drive_mode(servo)
    yield from _delay(servo)
    yield from _holding(servo)


def _faults(servo: ServoStatus) -> Iterator[Finding]:
    if servo.hardware_error:
        names = reg.hardware_error_names(servo.hardware_error)
        yield _problem(servo, f"hardware error: {names}", cure_of_error(servo.described))
    elif servo.values.get("Torque Limit") == 0:
        cure = cure_of_error(servo.described)
        yield _problem(servo, "has shut itself down (Torque Limit reads 0)", cure)
    watchdog = servo.values.get("Bus Watchdog", 0)
    if watchdog == reg.WATCHDOG_EXPIRED:
        yield _problem(
            servo,
            "was stopped by its bus watchdog: the program that moved the arm ended or stalled",
            "look at the arm, then armsyn clear",
        )
    elif watchdog > 0:
        yield _problem(
            servo,
            f"its bus watchdog is armed ({watchdog * reg.WATCHDOG_UNIT * 1e3:.0f} ms): a program"
            " ended with a fault",
            "look at the arm, then armsyn clear",
        )


def _supply(servo: ServoStatus) -> Iterator[Finding]:
    voltage, supply = servo.voltage, servo.described.supply_voltage
    if voltage is None:
        return
    low, high = (
        servo.values.get(f"{end} Voltage Limit", default) * reg.VOLTAGE_UNIT
        for end, default in (("Min", 0), ("Max", 10_000))
    )
    text = f"{voltage:.1f} V, its limits are {low:.1f} to {high:.1f} V"
    if not low <= voltage <= high:
        yield _problem(servo, text, f"its supply should have {supply:g} V")
    elif abs(voltage - supply) > SUPPLY_TOLERANCE * supply:
        yield _problem(servo, f"{voltage:.1f} V, described {supply:g} V", "check its supply")


def _watched(status: ArmStatus) -> Iterator[Finding]:
    lacking = [
        servo for servo in status.servos if servo.values and "Bus Watchdog" not in servo.values
    ]
    if lacking:
        named = ", ".join(str(servo.described.id) for servo in lacking)
        yield Finding(
            "note",
            f"servo {named}",
            "no bus watchdog: goes on to its last goal if the host dies",
            "motions ask for --accept-no-watchdog",
        )


def _heat(servo: ServoStatus) -> Iterator[Finding]:
    temperature, limit = servo.temperature, servo.values.get("Temperature Limit")
    if temperature is None or limit is None or temperature < limit - NEARLY_HOT:
        return
    what = f"{temperature:.0f} degrees C, its limit is {limit}"
    cure = "let it rest where it carries nothing: armsyn park"
    if temperature >= limit:
        yield _problem(servo, what, cure)
    else:
        yield Finding("note", servo.title, what, cure)


def _mode(servo: ServoStatus) -> Iterator[Finding]:
    if servo.model is None or servo.model.layout is not reg.X:
        return
    mode = servo.values.get("Operating Mode", reg.POSITION_MODE)
    if mode not in (reg.POSITION_MODE, reg.EXTENDED_POSITION_MODE):
        yield _problem(servo, f"operating mode {mode}", f"{RELEASE} armsyn setup (3 is position)")
    yield from _offset(servo, mode)


def _delay(servo: ServoStatus) -> Iterator[Finding]:
    delay, described = servo.return_delay, servo.described.return_delay_us
    if delay is not None and round(delay * 1e6) != described:
        what = f"waits {delay * 1e6:.0f} us before it answers, described {described}"
        yield Finding("note", servo.title, what, "armsyn setup")


def _offset(servo: ServoStatus, mode: int) -> Iterator[Finding]:
    offset = servo.values.get("Homing Offset", 0)
    if mode == reg.POSITION_MODE and abs(offset) > LARGEST_HOMING_OFFSET:
        what = f"a homing offset of {offset}, which position mode ignores"
        yield _problem(servo, what, f"bring it within +-{LARGEST_HOMING_OFFSET}: armsyn setup")


def _drive_mode(servo: ServoStatus) -> Iterator[Finding]:
    mode = servo.values.get("Drive Mode")
    if mode is None:
        return
    cure = f"{RELEASE} armsyn setup"
    if (mode ^ servo.described.drive_mode) & reg.DRIVE_MODE_REVERSE:
        yield _problem(servo, "counts positions the other way round than described", cure)
    if mode & reg.DRIVE_MODE_SLAVE:
        yield _problem(servo, "is set to be the slave of a dual-joint cable", cure)
    if mode & reg.DRIVE_MODE_TORQUE_BY_GOAL:
        yield _problem(servo, "switches its torque on by itself when it gets a goal", cure)


def _holding(servo: ServoStatus) -> Iterator[Finding]:
    goal, present = servo.values.get("Goal Position"), servo.values["Present Position"]
    if not servo.torque or goal is None or servo.described.shadow_of is not None:
        return
    if abs(goal - present) > ticks_of(GOAL_TOLERANCE, servo.described):
        off = math.degrees(abs((servo.goal or 0.0) - (servo.angle or 0.0)))
        yield Finding(
            "note",
            servo.title,
            f"holds {off:.1f} degrees off its goal",
            "something is in its way, it carries too much, or it is moving",
        )


def _of_pairs(status: ArmStatus) -> Iterator[Finding]:
    found = {servo.described.id: servo for servo in status.servos}
    for servo in status.servos:
        follows = servo.values.get("Secondary ID", reg.NO_SECONDARY_ID)
        wanted = servo.described.shadow_of
        if wanted is None and follows < reg.NO_SECONDARY_ID and follows != servo.described.id:
            cure = f"{RELEASE} armsyn setup"
            yield _problem(servo, f"obeys servo {follows} as well (Secondary ID)", cure)
        if wanted is None or not servo.answers or "Secondary ID" not in servo.values:
            continue
        if follows != wanted:
            what = f"does not follow servo {wanted}: its Secondary ID is {follows}"
            yield _problem(servo, what, f"{RELEASE} armsyn setup")
        yield from _apart(servo, found[wanted])
        if servo.torque is not None and servo.torque != found[wanted].torque:
            yield _problem(
                servo,
                f"its torque is {_on(servo)}, that of servo {wanted} on the same joint is"
                f" {_on(found[wanted])}",
                "support the arm, then armsyn release",
            )


def _apart(shadow: ServoStatus, leader: ServoStatus) -> Iterator[Finding]:
    ticks = [servo.values.get("Present Position") for servo in (shadow, leader)]
    if ticks[0] is None or ticks[1] is None or abs(ticks[0] - ticks[1]) <= PAIR_TOLERANCE_TICKS:
        return
    yield _problem(
        shadow,
        f"reads {abs(ticks[0] - ticks[1])} ticks off servo {leader.described.id} on the same joint,"
        f" {PAIR_TOLERANCE_TICKS} are allowed: they would fight each other",
        "armsyn calibrate",
    )


def _on(servo: ServoStatus) -> str:
    return {True: "on", False: "off", None: "unknown"}[servo.torque]


def _of_joints(status: ArmStatus) -> Iterator[Finding]:
    for name, angle, room in zip(
        status.arm.joint_names, status.posture.tolist(), status.to_limits.tolist(), strict=True
    ):
        if room < -LIMIT_TOLERANCE:
            yield Finding(
                "problem",
                name,
                f"at {math.degrees(angle):.1f} degrees, {math.degrees(-room):.1f} beyond its limit",
                "bring it back by hand (armsyn release); if it is not there, armsyn calibrate",
            )


def _strangers(status: ArmStatus) -> Iterator[Finding]:
    for servo_id, number in status.unexpected.items():
        yield Finding(
            "note",
            f"servo {servo_id}",
            f"{a_model(model_name(number))} that {status.arm.name} does not have",
            "is it the right arm (--arm), and the right ID?",
        )


def _of_bus(status: ArmStatus) -> Iterator[Finding]:
    if status.latency > SHORTEST_LATENCY:
        yield Finding(
            "problem" if _too_slow(status) else "note",
            status.port,
            f"its adapter keeps bytes for {status.latency * 1e3:.0f} ms",
            "set its latency timer to 1 ms (latency_timer in the port's folder under"
            " /sys/bus/usb-serial/devices)",
        )
    elif _too_slow(status):
        yield Finding(
            "problem",
            status.port,
            f"carries {status.fitting_rate:.0f} cycles a second, {USUAL_RATE:.0f} are usual",
            "Return Delay Time 0 and a higher baud rate (armsyn setup), or motions with --rate",
        )
    if status.foreign_packets:
        yield Finding(
            "problem",
            status.port,
            f"{status.foreign_packets} packet(s) of another program were heard",
            "end it: two programs on one bus lose each other's answers",
        )


def _too_slow(status: ArmStatus) -> bool:
    rate = status.fitting_rate
    return rate is not None and rate < USUAL_RATE
