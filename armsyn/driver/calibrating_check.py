"""Comparing an arm on a bus with its calibration file. Nothing is written."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from armsyn.arm import ArmDescription
from armsyn.arm.calibration_file import (
    REST_TOLERANCE,
    ArmCalibration,
    ServoCalibration,
    angle_of,
    with_calibration,
)
from armsyn.driver.calibrating import rest_angles
from armsyn.driver.calibrating_pairs import ALIGNED_TICKS
from armsyn.driver.facts import ServoFacts, check_models, read_facts
from armsyn.driver.servos import ServoGroup, title_of
from armsyn.driver.transactions import Bus
from armsyn.errors import InputError, ServoMismatchError, ServoMissingError

OUTSIDE = 0.09
"""rad by which a limp joint may lie beyond its limits."""


@dataclass(frozen=True)
class CheckedServo:
    """A servo beside its calibration.

    Attributes
    ----------
    calibration : ServoCalibration
    present : int
        Where it is, ticks.
    angle, rest : float
        Of its joint now by the calibration, and at rest, rad.
    """

    calibration: ServoCalibration
    present: int
    angle: float
    rest: float


@dataclass(frozen=True)
class CheckedArm:
    """What a check has found.

    Attributes
    ----------
    servos : tuple of CheckedServo
        Empty where the servos are not those of the file.
    problems : tuple of str
        One line each; none if all is well.
    """

    servos: tuple[CheckedServo, ...]
    problems: tuple[str, ...]


def check_calibration(
    bus: Bus, arm: ArmDescription, calibration: ArmCalibration, *, at_rest: bool = False
) -> CheckedArm:
    """Compare an arm with its calibration file.

    Compared are IDs, models and firmware; drive modes, operating modes and homing offsets; that
    every joint is within its limits, which a wrong zero or direction breaks soon; that servos of
    a dual joint agree.

    Parameters
    ----------
    bus : Bus
    arm : ArmDescription
        Without the calibration.
    calibration : ArmCalibration
    at_rest : bool
        Somebody says that the arm is in its rest posture: zeros are compared with it.

    Returns
    -------
    CheckedArm

    Raises
    ------
    BusError, PortLostError
        As the bus.
    """
    try:
        calibrated = with_calibration(arm, calibration)
    except InputError as error:
        return CheckedArm((), (f"the file does not fit the description: {error}",))
    group = ServoGroup(bus, arm.servo)
    try:
        check_models(group, arm.name)
        facts = read_facts(group)
    except (ServoMissingError, ServoMismatchError) as error:
        return CheckedArm((), (str(error),))
    by_id = {servo.id: servo for servo in calibration.servo}
    rest = rest_angles(arm)
    servos = tuple(_beside(f, by_id[f.servo_id], rest[f.joint]) for f in facts)
    limits = {joint.name: (joint.lower, joint.upper) for joint in calibrated.joint}
    problems = [
        problem
        for found, servo in zip(facts, servos, strict=True)
        for problem in (*_settings(found, servo, arm), *_place(servo, limits, at_rest=at_rest))
    ]
    present = {servo.calibration.id: servo.present for servo in servos}
    for shadow in arm.shadows:
        apart = abs(present[shadow.id] - present[shadow.shadow_of or 0])
        if apart > ALIGNED_TICKS:
            problems.append(
                f"{title_of(shadow)} reads {apart} ticks off its leader: armsyn calibrate aligns it"
            )
    return CheckedArm(servos, tuple(problems))


def _beside(facts: ServoFacts, calibration: ServoCalibration, rest: float) -> CheckedServo:
    angle = angle_of(calibration, facts.present_position)
    return CheckedServo(calibration, facts.present_position, angle, rest)


def _settings(facts: ServoFacts, servo: CheckedServo, arm: ArmDescription) -> Iterator[str]:
    wanted = servo.calibration
    # a gripper changes its mode as it grips
    grips = arm.gripper is not None and facts.joint == arm.gripper.name
    mode = wanted.operating_mode if grips else facts.operating_mode
    for name, now, then in (
        ("firmware", facts.firmware, wanted.firmware),
        ("drive mode", facts.drive_mode, wanted.drive_mode),
        ("operating mode", mode, wanted.operating_mode),
        ("homing offset", facts.homing_offset, wanted.homing_offset),
    ):
        if now != then:
            yield f"{facts.title}: {name} is {now}, was {then} when it was calibrated"


def _place(
    servo: CheckedServo, limits: dict[str, tuple[float, float]], *, at_rest: bool
) -> Iterator[str]:
    joint, angle = servo.calibration.joint, servo.angle
    named = f"servo {servo.calibration.id} ({joint})"
    lower, upper = limits.get(joint, (-float("inf"), float("inf")))
    if not lower - OUTSIDE <= angle <= upper + OUTSIDE:
        yield (
            f"{named} is at {angle:.3f} rad by the file, beyond its limits {lower:.3f} and"
            f" {upper:.3f}: its zero is wrong, or it has turned by a whole turn"
        )
    if at_rest and abs(angle - servo.rest) > REST_TOLERANCE:
        yield (
            f"{named} is at {angle:.3f} rad by the file, {angle - servo.rest:+.3f} off rest: its"
            " zero is wrong, or the arm is not at rest"
        )
