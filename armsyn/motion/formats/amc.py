"""AMC, Acclaim motion capture: the angles of an ASF skeleton, frame by frame.

::

    :FULLY-SPECIFIED
    :DEGREES
    1
    root 9.37 17.87 -17.32 -2.02 -7.60 -3.23
    lowerback 2.30 -0.40 1.17
    ...
    2
    ...

The skeleton is looked for beside the motion: ``01_01.asf``, then ``01.asf`` for ``01_01.amc``. The
format states no rate and no axis up: 120 Hz (the rate of the CMU database, where these files come
from) and y up are assumed and said, unless told otherwise.
"""

from __future__ import annotations

from array import array
from contextlib import closing
from pathlib import Path

import numpy as np

from armsyn.errors import FormatError, InputError
from armsyn.kinematics import quaternion
from armsyn.kinematics.rotation import from_quaternion_xyzw
from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion.body import BodyMotion
from armsyn.motion.formats.asf import ROOT, Acclaim, read_asf
from armsyn.motion.formats.bvh import MOST_POSTURES
from armsyn.motion.formats.options import Reading, ReadOptions, fact, metres, z_up
from armsyn.motion.formats.text import Lines
from armsyn.motion.motion import FloatArray

RATE_HZ = 120.0
_ANGLES = {":DEGREES": np.pi / 180, ":RADIANS": 1.0}


def read(path: Path, options: ReadOptions) -> Reading:
    """Read an AMC file with its skeleton.

    Parameters
    ----------
    path : Path
    options : ReadOptions
        `skeleton`, `rate`, `up` and `unit` (instead of the skeleton's) are heard.

    Returns
    -------
    Reading
        Joint positions as landmarks, and the body.

    Raises
    ------
    FormatError
        One line with the file and the line that is wrong, or where a skeleton was looked for.
    """
    skeleton_path = options.skeleton or _beside(path)
    acclaim = read_asf(skeleton_path)
    if options.unit:
        acclaim.length = metres(options.unit)
    with closing(Lines(path)) as lines:
        values = _read_frames(lines, acclaim, acclaim.skeleton(skeleton_path).joints)
    up, rate = options.up or "y", options.rate or RATE_HZ
    try:
        body = _assemble(acclaim, skeleton_path, values, up, rate, path.name)
        return Reading(body.as_motion(), _facts(acclaim, skeleton_path, options), body)
    except InputError as error:
        raise FormatError(f"{path}: {error}") from error


def _facts(acclaim: Acclaim, skeleton: Path, options: ReadOptions) -> dict[str, str]:
    return {
        "skeleton": str(skeleton),
        "unit": f"{acclaim.length:.6g} m" + ("" if options.unit else f" (of {skeleton.name})"),
        "up": fact(options.up or "y", options.up),
        "rate": fact(f"{options.rate or RATE_HZ:g} Hz", options.rate),
    }


def _beside(path: Path) -> Path:
    names = dict.fromkeys([path.stem, path.stem.partition("_")[0]])
    tried = [path.with_name(f"{name}.asf") for name in names]
    for candidate in tried:
        if candidate.is_file():
            return candidate
    looked = " nor ".join(str(candidate) for candidate in tried)
    raise FormatError(f"{path}: no skeleton {looked}: name its .asf file")


def _read_frames(lines: Lines, acclaim: Acclaim, joints: int) -> FloatArray:
    """Return all channels of all bones, in the bones' order, shape (frames, channels)."""
    places, width = {}, 0
    for bone in acclaim.bones.values():
        if bone.dofs:
            places[bone.name] = slice(width, width + len(bone.dofs))
            width += len(bone.dofs)
    values = array("d")
    frame, row, missing = 0, [0.0] * width, set[str]()
    for line in lines:
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0].startswith(":"):
            acclaim.angle = _ANGLES.get(words[0].upper(), acclaim.angle)
        elif len(words) == 1 and words[0].isdigit():
            _end_frame(lines, values, frame, row, missing)
            if lines.whole(words[0], MOST_POSTURES // joints) != frame + 1:
                lines.fail(f"frame {words[0]} follows frame {frame}")
            frame, missing = frame + 1, set(places)
        elif frame == 0:
            lines.fail("a frame's number, 1, expected")
        elif words[0] not in missing:
            lines.fail(f"bone '{words[0][:40]}' is unknown, never moves, or comes twice")
        else:
            place = places[words[0]]
            if len(words) - 1 != place.stop - place.start:
                lines.fail(f"'{words[0]}' has {place.stop - place.start} degrees of freedom")
            row[place] = lines.numbers(words[1:])
            missing.remove(words[0])
    _end_frame(lines, values, frame, row, missing)
    return lines.table(values, width)


def _end_frame(
    lines: Lines, values: array[float], frame: int, row: list[float], missing: set[str]
) -> None:
    if missing:
        lines.fail(f"frame {frame} has no '{min(missing)}': the file was cut")
    if frame:
        values.extend(row)


def _assemble(
    acclaim: Acclaim, skeleton_path: Path, values: FloatArray, up: str, rate: float, source: str
) -> BodyMotion:
    tree = acclaim.skeleton(skeleton_path)
    rotations = np.zeros((len(values), tree.joints, 3))
    translations = np.zeros_like(rotations)
    column = 0
    for bone in acclaim.bones.values():
        own = values[:, column : column + len(bone.dofs)]
        column += len(bone.dofs)
        joint = tree.index(bone.name)
        to_body = from_quaternion_xyzw(bone.axis)
        turns = [place for place, dof in reversed(list(enumerate(bone.dofs))) if dof[0] == "r"]
        axes = "".join(bone.dofs[place][1] for place in turns)
        turned = quaternion.from_euler(axes, own[:, turns] * acclaim.angle)
        # C exp(w) C^-1 = exp(C w)
        rotations[:, joint] = quaternion.to_expmap(turned) @ to_body.T
        for place, dof in enumerate(bone.dofs):
            if dof[0] == "t":
                along = to_body[:, "xyz".index(dof[1])]
                translations[:, joint] += np.outer(own[:, place] * acclaim.length, along)
    root = tree.offsets[0] + translations[:, 0]
    moved = z_up(translations, up) if any(_moves(acclaim)) else None
    turned_tree = Skeleton(tree.names, tree.parents, z_up(tree.offsets, up))
    time = np.arange(len(values)) / rate
    return BodyMotion(time, turned_tree, z_up(rotations, up), z_up(root, up), moved, source)


def _moves(acclaim: Acclaim) -> list[bool]:
    """Whether each bone but the root has channels of translation."""
    return [
        any(dof[0] == "t" for dof in bone.dofs)
        for bone in acclaim.bones.values()
        if bone.name != ROOT
    ]
