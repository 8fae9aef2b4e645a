"""BVH, the Biovision hierarchy: a skeleton and its Euler angles in one text file.

::

    HIERARCHY
    ROOT Hips
    {
        OFFSET 0 0 0
        CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation
        JOINT Spine
        {
            OFFSET 0 9.9 0
            CHANNELS 3 Zrotation Yrotation Xrotation
            End Site
            {
                OFFSET 0 8.0 0
            }
        }
    }
    MOTION
    Frames: 2
    Frame Time: 0.033333
    (one line of numbers a frame: the channels in the order of the hierarchy)

Rotations are degrees; a joint's are multiplied in the order of its channels (Z, Y, X is Rz Ry Rx).
Position channels stand in place of the joint's OFFSET. An End Site becomes a joint of its own that
never turns, ``PARENT_end`` (a second one ``PARENT_end2``).

The format states no unit and no axis up: centimetres and y up are assumed and said, unless told
otherwise. Written files have centimetres, y up, and ZYX rotations.
"""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from armsyn.errors import FormatError, InputError
from armsyn.kinematics import quaternion
from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion.body import BodyMotion
from armsyn.motion.formats.options import Reading, ReadOptions, fact, metres, z_up
from armsyn.motion.formats.text import Lines
from armsyn.motion.motion import FloatArray

MOST_JOINTS = 1_000
MOST_POSTURES = 10_000_000
"""Frames times joints of one body motion: 36 minutes of 38 joints at 120 Hz, 240 MB an array."""
_CHANNELS = {
    f"{axis}{kind}": (kind, axis.lower()) for kind in ("position", "rotation") for axis in "XYZ"
}


@dataclass
class _Joint:
    name: str
    parent: int
    offset: list[float] = field(default_factory=list)
    channels: list[tuple[str, str]] = field(default_factory=list)
    is_end: bool = False


def read(path: Path, options: ReadOptions) -> Reading:
    """Read a BVH file.

    Parameters
    ----------
    path : Path
    options : ReadOptions
        `unit`, `up` and `rate` are heard.

    Returns
    -------
    Reading
        Joint positions as landmarks, and the body.

    Raises
    ------
    FormatError
        One line with the file and the line that is wrong.
    """
    with closing(Lines(path)) as lines:
        joints = _read_hierarchy(lines)
        frame_time, values = _read_motion(lines, joints)
    unit, up = options.unit or "cm", options.up or "y"
    rate = options.rate or 1.0 / frame_time
    try:
        body = _assemble(joints, values, metres(unit), up, rate, path.name)
        facts = {"unit": fact(unit, options.unit), "up": fact(up, options.up)}
        return Reading(body.as_motion(), facts, body)
    except InputError as error:
        raise FormatError(f"{path}: {error}") from error


def _read_hierarchy(lines: Lines) -> list[_Joint]:
    if lines.next("HIERARCHY").split() != ["HIERARCHY"]:
        lines.fail("a BVH file begins with the line HIERARCHY")
    joints: list[_Joint] = []
    above: list[int] = []  # the joints whose braces are open
    opening = False  # a joint was named, its brace is still to come
    for line in lines:
        for word, rest in _statements(line):
            if word == "{" and opening:
                above.append(len(joints) - 1)
                opening = False
            elif opening:
                lines.fail(f"'{{' expected after '{joints[-1].name}', not '{word[:40]}'")
            elif word == "}" and above:
                if not joints[above.pop()].offset:
                    lines.fail("a joint ends without an OFFSET")
            elif word in ("ROOT", "JOINT", "End"):
                joints.append(_named(lines, joints, above, word, rest))
                opening = True
            elif word in ("OFFSET", "CHANNELS") and above:
                _describe(lines, joints[above[-1]], word, rest)
            elif word == "MOTION" and joints and not above:
                return joints
            else:
                lines.fail(f"'{word[:40]}' is not expected here")
    raise FormatError(f"{lines.path}: line {lines.number + 1}: the file was cut: no MOTION")


def _statements(line: str) -> list[tuple[str, list[str]]]:
    """Split a line into keywords with their arguments; braces are keywords too."""
    found: list[tuple[str, list[str]]] = []
    for word in line.replace("{", " { ").replace("}", " } ").split():
        if not found or word in "{}" or found[-1][0] in "{}":
            found.append((word, []))
        else:
            found[-1][1].append(word)
    return found


def _named(
    lines: Lines, joints: list[_Joint], above: list[int], word: str, rest: list[str]
) -> _Joint:
    if bool(joints) == (word == "ROOT") or (word != "ROOT" and not above):
        lines.fail("a hierarchy has one ROOT, and every JOINT and End Site stands inside another")
    if len(joints) == MOST_JOINTS:
        lines.fail(f"more than {MOST_JOINTS} joints")
    if word == "End":
        ends = sum(joint.parent == above[-1] and joint.is_end for joint in joints)
        number = str(ends + 1) if ends else ""
        return _Joint(f"{joints[above[-1]].name}_end{number}", above[-1], is_end=True)
    if not rest:
        lines.fail(f"{word} without a name")
    return _Joint(" ".join(rest), above[-1] if above else -1)


def _describe(lines: Lines, joint: _Joint, word: str, rest: list[str]) -> None:
    if word == "OFFSET":
        if len(rest) != 3 or joint.offset:
            lines.fail(f"'{joint.name}' needs one OFFSET of three numbers")
        joint.offset = lines.numbers(rest)
        return
    names = rest[1:]
    if not rest or str(len(names)) != rest[0] or joint.channels:
        lines.fail(f"'{joint.name}' needs one CHANNELS: a count, then so many names")
    for name in names:
        if name not in _CHANNELS:
            lines.fail(f"unknown channel '{name[:40]}'; known: {', '.join(_CHANNELS)}")
    if len(set(names)) != len(names):
        lines.fail(f"a channel of '{joint.name}' is named twice")
    joint.channels = [_CHANNELS[name] for name in names]


def _read_motion(lines: Lines, joints: list[_Joint]) -> tuple[float, FloatArray]:
    head = lines.next("Frames:").replace(":", ": ").split()
    if len(head) != 2 or head[0] != "Frames:":
        lines.fail("'Frames: COUNT' expected")
    frames = lines.whole(head[1], MOST_POSTURES // len(joints))
    head = lines.next("Frame Time:").replace(":", ": ").split()
    if len(head) != 3 or head[:2] != ["Frame", "Time:"]:
        lines.fail("'Frame Time: SECONDS' expected")
    (frame_time,) = lines.numbers(head[2:])
    if not 1e-6 < frame_time < 1e6:
        lines.fail(f"a frame time of {head[2]} s")
    width = sum(len(joint.channels) for joint in joints)
    values = lines.rows(width, frames)
    if len(values) != frames:
        raise FormatError(
            f"{lines.path}: line {lines.number + 1}: the file was cut: {len(values)} of {frames}"
            " frames"
        )
    return frame_time, values


def _assemble(
    joints: list[_Joint], values: FloatArray, scale: float, up: str, rate: float, source: str
) -> BodyMotion:
    offsets = z_up(np.array([joint.offset for joint in joints]) * scale, up)
    rotations = np.zeros((len(values), len(joints), 3))
    moved = {}
    column = 0
    for index, joint in enumerate(joints):
        own = values[:, column : column + len(joint.channels)]
        column += len(joint.channels)
        turns = [place for place, (kind, _) in enumerate(joint.channels) if kind == "rotation"]
        axes = "".join(joint.channels[place][1] for place in turns)
        turned = quaternion.from_euler(axes, np.deg2rad(own[:, turns]))
        rotations[:, index] = z_up(quaternion.to_expmap(turned), up)
        if len(turns) < len(joint.channels):
            place_of = np.tile(joint.offset, (len(values), 1))
            for place, (kind, axis) in enumerate(joint.channels):
                if kind == "position":
                    place_of[:, "xyz".index(axis)] = own[:, place]
            moved[index] = z_up(place_of * scale, up)
    root = moved.pop(0, np.tile(offsets[0], (len(values), 1)))
    translations = np.zeros_like(rotations) if moved else None
    for index, position in moved.items():
        assert translations is not None  # noqa: S101 - there is one when something is moved
        translations[:, index] = position - offsets[index]
    skeleton = Skeleton(
        tuple(joint.name for joint in joints), tuple(joint.parent for joint in joints), offsets
    )
    time = np.arange(len(values)) / rate
    return BodyMotion(time, skeleton, rotations, root, translations, source)
