"""``<arm>.calibration.json``: how one real arm is assembled, as ``armsyn calibrate`` found it.

A description says what all arms of a kind share; two of them differ in how the horns were screwed
on. `armsyn.arm.load_arm` lays the file over the description: zero, direction and, where the joint
was moved to its ends by hand, its range; of a gripper, its open and closed. A **simulated** arm is
started from the description alone, with the description's zeros: load it with
``calibrated=False``.

Several arms of one kind on one machine are told apart by a name: ``koch.left.calibration.json``.
"""

from __future__ import annotations

import math
import re
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import msgspec

from armsyn.arm.calibration import RADIANS_PER_TICK, radians_per_tick
from armsyn.arm.search import HERE, search_path, user_folder
from armsyn.arm.servos import GripperDescription, ServoDescription, ServoId, Tick
from armsyn.errors import DescriptionError, InputError

if TYPE_CHECKING:
    from armsyn.arm.description import ArmDescription

SUFFIX = ".calibration.json"
MAXIMUM_BYTES = 1_000_000

RANGE_MARGIN = 0.02
"""rad that a joint keeps from the ends to which it was moved by hand."""

REST_TOLERANCE = 0.09
"""rad by which the rest posture may lie beyond an end: arms rest on their stops."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_]{0,31}")
_REVERSE = 0b0001
_POSITION_MODE = 3
"""Operating mode in which positions end where the encoder's turn does."""

Byte = Annotated[int, msgspec.Meta(ge=0, le=255)]


class ServoCalibration(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One servo of a calibrated arm.

    Attributes
    ----------
    id, protocol : int
        As it answered.
    joint, model : str
        As described.
    model_number, firmware : int
        What the servo said of itself; these servos have no serial number.
    zero_tick : int
        Position register at the joint's zero.
    direction : {1, -1}
        Sign between ticks and the joint's angle.
    range_ticks : 2-tuple of int, or None
        Least and greatest position that the joint was moved to by hand, counted on across the
        end of the encoder's turn; None where it was not. A gripper's are closed and open.
    homing_offset, drive_mode, operating_mode : int
        Registers as found, in the X series' numbers; 0 for an offset or a drive mode that the
        servo does not have.
    """

    id: ServoId
    joint: str
    model: str
    model_number: Annotated[int, msgspec.Meta(ge=0, le=65535)]
    firmware: Byte
    protocol: Literal[1, 2]
    zero_tick: Tick
    direction: Literal[1, -1]
    homing_offset: Tick
    drive_mode: Byte
    operating_mode: Byte
    range_ticks: tuple[Tick, Tick] | None = None


class ArmCalibration(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A calibrated arm.

    Attributes
    ----------
    schema : str
        ``armsyn-calibration-1``.
    arm : str
        Whose description it belongs to.
    name : str or None
        Which of several arms of that kind.
    date : str
        ISO 8601, with its offset from UTC.
    method : {"rest", "hand"}
        Zeros from the rest posture only, or ranges and directions by hand as well.
    port : str
        That the arm was on.
    servo : tuple of ServoCalibration
    """

    schema: Literal["armsyn-calibration-1"]
    arm: str
    date: str
    method: Literal["rest", "hand"]
    port: str
    servo: tuple[ServoCalibration, ...]
    name: str | None = None


def file_stem(arm: str, name: str | None) -> str:
    """Begin of the file's name; InputError for a name of other than letters, digits and _.

    The two are parted by a point, which no arm's name has: ``koch-left`` is an arm of its own.
    """
    if name is None:
        return arm
    if not _NAME.fullmatch(name):
        raise InputError(f"--name {name!r}: up to 32 letters, digits and _ only")
    return f"{arm}.{name}"


def find_calibration(arm: str, name: str | None, directory: Path | None = None) -> Path | None:
    """Find an arm's calibration file where its description is searched.

    Parameters
    ----------
    arm : str
    name : str, optional
        Which of several arms of that kind.
    directory : Path, optional
        Search only here.

    Returns
    -------
    Path or None
        None where there is none and no `name` was given.

    Raises
    ------
    DescriptionError
        None for the arm that was named.
    """
    stem = file_stem(arm, name)
    places = search_path(directory)
    for place in places:
        if (place / f"{stem}{SUFFIX}").is_file():
            return place / f"{stem}{SUFFIX}"
    if name is None:
        return None
    raise DescriptionError(
        f"no {stem}{SUFFIX} in {', '.join(str(place) for place in dict.fromkeys(places))}: run"
        f" armsyn calibrate --arm {arm} --name {name}"
    )


def read_calibration(path: Path) -> ArmCalibration:
    """Read a calibration file.

    Raises
    ------
    DescriptionError
        Unreadable, or a field that is missing, unknown or out of range; file and field are named.
    """
    try:
        if path.stat().st_size > MAXIMUM_BYTES:
            raise DescriptionError(f"{path}: larger than {MAXIMUM_BYTES} bytes")
        return parse_calibration(path.read_bytes(), str(path))
    except OSError as error:
        raise DescriptionError(f"{path}: {error.strerror or error}") from error


def parse_calibration(text: bytes, where: str) -> ArmCalibration:
    """Read a calibration from JSON; `where` is the file, errors as `read_calibration`."""
    try:
        calibration = msgspec.json.decode(text, type=ArmCalibration)
        _check(calibration)
    except (msgspec.DecodeError, InputError, UnicodeDecodeError, RecursionError) as error:
        raise DescriptionError(f"{where}: {error}") from error
    return calibration


def format_calibration(calibration: ArmCalibration) -> bytes:
    """JSON of a calibration, for `parse_calibration` to read back."""
    return msgspec.json.format(msgspec.json.encode(calibration), indent=2) + b"\n"


def _check(calibration: ArmCalibration) -> None:
    try:
        moment = datetime.fromisoformat(calibration.date)
    except ValueError as error:
        raise InputError(f"date: {error}") from error
    if moment.tzinfo is None:
        raise InputError(f"date: {calibration.date} has no offset from UTC")
    ids = [servo.id for servo in calibration.servo]
    if not ids or len(set(ids)) != len(ids):
        raise InputError("servo: every ID once, and at least one")
    for servo in calibration.servo:
        if servo.range_ticks is not None and servo.range_ticks[0] >= servo.range_ticks[1]:
            raise InputError(f"servo {servo.id}: range_ticks {servo.range_ticks} is empty")


def last_tick(model: str) -> int:
    """Last position of a servo model's turn, which begins at 0."""
    return 1023 if radians_per_tick(model) > RADIANS_PER_TICK else 4095


def with_calibration(arm: ArmDescription, calibration: ArmCalibration) -> ArmDescription:
    """Lay a calibration over a description.

    Zeros and directions are the calibration's. A joint's limits stay within those described,
    keep `RANGE_MARGIN` from the ends that it was moved to by hand, and in position mode also end
    where the encoder's turn does, which a servo cannot cross. A gripper is closed and open at the
    ends that it was moved to by hand, with the described widths there.

    Parameters
    ----------
    arm : ArmDescription
    calibration : ArmCalibration

    Returns
    -------
    ArmDescription

    Raises
    ------
    InputError
        It is another arm's, or the rest posture is beyond the ends of a joint.
    """
    _check_belongs(arm, calibration)
    found = {servo.id: servo for servo in calibration.servo}
    rest = {joint.name: joint.rest for joint in arm.joint}
    if arm.gripper is not None:
        rest[arm.gripper.name] = arm.gripper.rest_angle
    servos = tuple(_servo(s, found[s.id], rest[s.joint]) for s in arm.servo)
    joints = []
    for joint in arm.joint:
        lower, upper = joint.lower, joint.upper
        for servo in (found[s.id] for s in arm.servo if s.joint == joint.name):
            low, high = _reach(servo, joint.rest)
            lower, upper = max(lower, low), min(upper, high)
        joints.append(msgspec.structs.replace(joint, lower=lower, upper=upper))
    gripper, leader = arm.gripper, arm.gripper_servo
    if gripper is not None and leader is not None:
        gripper = _gripper(gripper, found[leader.id])
    return msgspec.structs.replace(arm, servo=servos, joint=tuple(joints), gripper=gripper)


def _check_belongs(arm: ArmDescription, calibration: ArmCalibration) -> None:
    if calibration.arm != arm.name:
        raise InputError(f"it is of arm {calibration.arm!r}, not of {arm.name!r}")
    described = {servo.id: servo for servo in arm.servo}
    ids = {servo.id for servo in calibration.servo}
    if ids != set(described):
        raise InputError(f"its servos are {sorted(ids)}, those described {sorted(described)}")
    for servo in calibration.servo:
        mate = described[servo.id]
        for field in ("joint", "model", "protocol"):
            here, there = getattr(servo, field), getattr(mate, field)
            if here != there:
                raise InputError(
                    f"servo {servo.id}: {field} is {here!r}, in the description {there!r}"
                )
        if (servo.drive_mode ^ mate.drive_mode) & _REVERSE:
            raise InputError(
                f"servo {servo.id}: it counted the other way round than described (bit 0 of"
                " drive_mode): run armsyn setup, then armsyn calibrate"
            )


def _servo(servo: ServoDescription, found: ServoCalibration, rest: float) -> ServoDescription:
    turned = found.direction * rest / radians_per_tick(servo.model)
    return msgspec.structs.replace(
        servo,
        zero_tick=found.zero_tick,
        direction=found.direction,
        rest_tick=round(found.zero_tick + turned),
    )


def _reach(servo: ServoCalibration, rest: float) -> tuple[float, float]:
    """Angles between which a servo can be sent, rad."""
    low, high = -math.inf, math.inf
    if servo.range_ticks is not None:
        ends = _ends(servo, servo.range_ticks, rest)
        low, high = min(ends[0] + RANGE_MARGIN, rest), max(ends[1] - RANGE_MARGIN, rest)
    if servo.operating_mode == _POSITION_MODE:
        # positions go to 0 and 4095, and the encoder's turn ends a homing offset away from there
        last, offset = last_tick(servo.model), servo.homing_offset
        ticks = max(0, offset), min(last, last + offset)
        turn = sorted(angle_of(servo, tick) for tick in ticks)
        low, high = max(low, turn[0]), min(high, turn[1])
    if not low <= rest <= high:
        raise InputError(
            f"servo {servo.id} ({servo.joint}): its encoder's turn ends between zero and rest"
            f" (zero is tick {servo.zero_tick}): screw the horn on in another position"
        )
    return low, high


def _gripper(gripper: GripperDescription, servo: ServoCalibration) -> GripperDescription:
    """Take the ends that it was moved to by hand as closed and open."""
    if servo.range_ticks is None:
        return gripper
    rest = gripper.rest_angle
    ends = _ends(servo, servo.range_ticks, rest)
    low, high = min(ends[0], rest), max(ends[1], rest)
    opened, closed = (high, low) if gripper.open > gripper.closed else (low, high)
    return msgspec.structs.replace(gripper, open=opened, closed=closed, rest=rest)


def _ends(servo: ServoCalibration, ticks: tuple[int, int], rest: float) -> tuple[float, float]:
    """Angles that a servo was moved to by hand, rad; rest must be within them."""
    low, high = sorted(angle_of(servo, tick) for tick in ticks)
    if not low - REST_TOLERANCE <= rest <= high + REST_TOLERANCE:
        raise InputError(
            f"servo {servo.id} ({servo.joint}): the rest posture, {rest:.3f} rad, is beyond the"
            f" ends it was moved to, {low:.3f} and {high:.3f} rad: calibrate again"
        )
    return low, high


def angle_of(servo: ServoCalibration, tick: float) -> float:
    """Joint's angle at a position of its servo, rad."""
    return servo.direction * (tick - servo.zero_tick) * radians_per_tick(servo.model)


def folder_for_writing(arm: str, directory: Path | None = None) -> Path:
    """Where commands write an arm's files.

    Parameters
    ----------
    arm : str
        Its name.
    directory : Path, optional
        That the user named.

    Returns
    -------
    Path
        `directory`, or ``$ARMSYN_CALIBRATION``; else ``./calibration`` if the arm's description
        is there, and the user's own folder, which is searched from everywhere, if it is not.
    """
    first = search_path(directory)[0]
    if first != HERE or directory is not None or (HERE / f"{arm}.toml").is_file():
        return first
    return user_folder() or HERE


def is_found_from_everywhere(file: Path) -> bool:
    """Whether a file's folder is searched whatever folder a command runs in."""
    fixed = (place for place in search_path() if place.is_absolute())
    return file.parent.resolve() in {place.resolve() for place in fixed}
