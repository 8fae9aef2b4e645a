"""A calibration on the terminal, as JSON, and in its file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription, ServoDescription
    from armsyn.arm.calibration_file import ArmCalibration, ServoCalibration


def show(arm: ArmDescription, calibration: ArmCalibration) -> None:
    """Print the calibration beside the description, on standard error."""
    from rich.console import Console
    from rich.table import Table

    table = Table(
        "servo", "joint", "zero", "described", "direction", "range, deg", "described", box=None
    )
    described = {servo.id: servo for servo in arm.servo}
    limits = {joint.name: (joint.lower, joint.upper) for joint in arm.joint}
    if arm.gripper is not None:
        first, second = sorted((arm.gripper.closed, arm.gripper.open))
        limits[arm.gripper.name] = first, second
    for servo in calibration.servo:
        table.add_row(*_row(servo, described[servo.id], limits.get(servo.joint)))
    Console(stderr=True).print(table)


def _row(
    servo: ServoCalibration, described: ServoDescription, limits: tuple[float, float] | None
) -> tuple[str, ...]:
    from armsyn.arm.calibration_file import angle_of

    turned = "" if servo.direction == described.direction else ", described the other way"
    found = None
    if servo.range_ticks is not None:
        first, second = sorted(angle_of(servo, tick) for tick in servo.range_ticks)
        found = first, second
    return (
        str(servo.id),
        servo.joint,
        str(servo.zero_tick),
        str(described.zero_tick),
        f"{servo.direction:+d}{turned}",
        _degrees(found),
        _degrees(limits),
    )


def _degrees(ends: tuple[float, float] | None) -> str:
    return "" if ends is None else " to ".join(f"{math.degrees(end):z.0f}" for end in ends)


def document(calibration: ArmCalibration, path: Path | None) -> dict[str, Any]:
    """The calibration and where it was written."""
    import msgspec

    found = msgspec.to_builtins(calibration)
    return {"calibration": found, "file": None if path is None else str(path)}


def write(calibration: ArmCalibration, path: Path) -> None:
    """Write the file as a whole; one that is there is kept as ``.old``.

    Raises
    ------
    InputError
        It cannot be written.
    """
    from armsyn.arm.calibration_file import format_calibration
    from armsyn.errors import InputError
    from armsyn.motion.formats.files import replacing

    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists():
            with replacing(path.with_name(f"{path.name}.old")) as kept:
                kept.write_bytes(path.read_bytes())
    except OSError as error:
        raise InputError(f"{path}: cannot write it: {error.strerror or error}") from error
    with replacing(path) as temporary:
        temporary.write_bytes(format_calibration(calibration))
