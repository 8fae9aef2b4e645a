"""ASF, the Acclaim skeleton file that AMC motions need.

Sections begin with a colon: ``:units`` (``length`` and ``angle``), ``:root``, ``:bonedata`` (one
``begin`` ... ``end`` a bone) and ``:hierarchy``. A bone has a direction and a length, both in the
frame of the whole body at rest, the axes C in which its angles are told, and its degrees of
freedom. With M the product of its turns, its rotation in the body's rest frame is C M C^-1; turns
named ``rx ry rz`` are about fixed axes in this order, so that M = Rz Ry Rx.

A length of the file is 1 / ``length`` inches (the unit of Acclaim's own bodies: with CMU's 0.45,
5.6444 cm). A bone becomes a joint at its head; a bone that carries no other ends in a joint that
never turns, ``BONE_end``.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from armsyn.errors import FormatError
from armsyn.kinematics import quaternion
from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion.formats.text import Lines
from armsyn.motion.motion import FloatArray

INCH = 0.0254
MOST_BONES = 1_000
ROOT = "root"
_ANGLES = {"deg": np.pi / 180, "rad": 1.0}
_DOFS = ("rx", "ry", "rz", "tx", "ty", "tz")


@dataclass
class Bone:
    """One bone of the file, in the file's units.

    Parameters
    ----------
    name : str
    direction : list of float
        Unit vector, in the body's frame at rest.
    length : float
    axis : array, shape (4,)
        Quaternion of the axes C in which its angles are told.
    dofs : tuple of str
        Its channels in the order of the AMC file, of rx, ry, rz, tx, ty, tz.
    """

    name: str
    direction: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    length: float = 0.0
    axis: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 0.0, 1.0]))
    dofs: tuple[str, ...] = ()


@dataclass
class Acclaim:
    """A skeleton file.

    Parameters
    ----------
    bones : dict of str to Bone
        The root's, named `ROOT`, first.
    children : dict of str to list of str
    length, angle : float
        Metres and radians of the file's units.
    position : list of float
        Where the root is at rest, in the file's unit.
    """

    bones: dict[str, Bone]
    children: dict[str, list[str]] = field(default_factory=dict)
    length: float = INCH
    angle: float = _ANGLES["deg"]
    position: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])

    def skeleton(self, path: Path) -> Skeleton:
        """Return the tree of joints, m, in the file's axes.

        Raises
        ------
        FormatError
            When a bone does not hang from the root.
        """
        names, parents, offsets = [ROOT], [-1], [np.array(self.position)]
        for joint, name in enumerate(names):  # which grows as it goes
            bone = self.bones.get(name)
            if bone is None:
                continue  # an end
            tip = np.array(bone.direction) * bone.length
            below = self.children.get(name) or ([] if name == ROOT else [f"{name}_end"])
            names.extend(below)
            parents.extend([joint] * len(below))
            offsets.extend([tip] * len(below))
        loose = sorted(self.bones.keys() - set(names))
        if loose:
            raise FormatError(f"{path}: bone '{loose[0]}' hangs from nothing in :hierarchy")
        return Skeleton(tuple(names), tuple(parents), np.array(offsets) * self.length)


def read_asf(path: Path) -> Acclaim:
    """Read a skeleton file.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Acclaim

    Raises
    ------
    FormatError
        One line with the file and the line that is wrong.
    """
    found = Acclaim({ROOT: Bone(ROOT)})
    with closing(Lines(path)) as lines:
        section = ""
        for words in _statements(lines):
            if words[0].startswith(":"):
                section = words[0][1:].lower()
                continue
            if section == "units":
                _read_unit(lines, found, words)
            elif section == "root":
                _read_root(lines, found, words)
            elif section == "bonedata" and words[0] == "begin":
                _read_bone(lines, found)
            elif section == "hierarchy" and words[0] not in ("begin", "end"):
                _read_children(lines, found, words)
    if len(found.bones) == 1 or not found.children:
        raise FormatError(f"{path}: no :bonedata or no :hierarchy: not a skeleton, or cut")
    return found


def _statements(lines: Lines) -> Iterator[list[str]]:
    for line in lines:
        words = line.partition("#")[0].split()
        if words:
            yield words


def _read_unit(lines: Lines, found: Acclaim, words: list[str]) -> None:
    key, value = (words[0].lower(), words[1:2])
    if key == "length":
        (length,) = lines.numbers(value) or [0.0]
        if not 1e-6 < length < 1e6:
            lines.fail("the unit of length is not a positive number")
        found.length = INCH / length
    elif key == "angle":
        if not value or value[0].lower() not in _ANGLES:
            lines.fail("the unit of angle is neither deg nor rad")
        found.angle = _ANGLES[value[0].lower()]


def _read_root(lines: Lines, found: Acclaim, words: list[str]) -> None:
    root = found.bones[ROOT]
    if words[0] == "order":
        root.dofs = _dofs(lines, words[1:])
    elif words[0] == "position":
        found.position = _three(lines, words[1:])
    elif words[0] == "orientation" and any(_three(lines, words[1:])):
        # C only changes the axes; a body that rests turned would need more, and none does
        lines.fail("a root that is turned at rest: not supported")


def _read_bone(lines: Lines, found: Acclaim) -> None:
    bone = Bone("")
    for words in _statements(lines):
        key, rest = words[0], words[1:]
        if key == "end":
            if not bone.name or bone.name in found.bones:
                lines.fail("a bone without a name, or a name that two bones have")
            if len(found.bones) > MOST_BONES:
                lines.fail(f"more than {MOST_BONES} bones")
            found.bones[bone.name] = bone
            return
        if key == "name" and rest:
            bone.name = rest[0]
        elif key == "direction":
            bone.direction = _three(lines, rest)
        elif key == "length":
            bone.length = (lines.numbers(rest[:1]) or [0.0])[0]
        elif key == "axis":
            bone.axis = _axes(lines, rest, found.angle)
        elif key == "dof":
            bone.dofs = _dofs(lines, rest)
    lines.fail("the file was cut: a bone has no end")


def _axes(lines: Lines, rest: list[str], angle: float) -> FloatArray:
    order = rest[3].lower() if len(rest) == 4 else ""
    if sorted(order) != ["x", "y", "z"]:
        lines.fail("an axis is three angles and their order, such as XYZ")
    values = dict(zip("xyz", lines.numbers(rest[:3]), strict=True))
    turned = [values[axis] * angle for axis in reversed(order)]
    return quaternion.from_euler(order[::-1], turned)


def _dofs(lines: Lines, words: list[str]) -> tuple[str, ...]:
    dofs = tuple(word.lower() for word in words)
    if len(set(dofs)) != len(dofs) or not set(dofs) <= set(_DOFS):
        lines.fail(f"degrees of freedom '{' '.join(words)[:60]}': known: {', '.join(_DOFS)}")
    return dofs


def _three(lines: Lines, words: list[str]) -> list[float]:
    if len(words) != 3:
        lines.fail("three numbers expected")
    return lines.numbers(words)


def _read_children(lines: Lines, found: Acclaim, words: list[str]) -> None:
    known = {child for children in found.children.values() for child in children}
    for word in words:
        if word not in found.bones:
            lines.fail(f"no bone '{word[:40]}'")
    if words[0] in found.children or ROOT in words[1:] or known & set(words[1:]):
        lines.fail("a bone that hangs from two others")
    if len(set(words)) != len(words):
        lines.fail("a bone is named twice")
    if words[1:]:
        found.children[words[0]] = words[1:]
