"""Bodies written as BVH: see `armsyn.motion.formats.bvh` for the layout."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from armsyn.errors import FormatError
from armsyn.kinematics.rotation import from_expmap, to_rpy
from armsyn.motion.body import BodyMotion
from armsyn.motion.formats.files import replacing
from armsyn.motion.formats.options import from_z_up
from armsyn.motion.motion import FloatArray

_POSITIONS = ("Xposition", "Yposition", "Zposition")
_TURNS = ("Zrotation", "Yrotation", "Xrotation")


def write(path: Path, body: BodyMotion) -> None:
    """Write a body's motion as BVH: centimetres, y up, ZYX rotations in degrees.

    Angles are written to 1e-8 degrees and lengths to 1e-8 cm. A pre-rotation becomes part of its
    joint's rotation. A leaf that never turns nor moves, below a joint with no other child, becomes
    an End Site, which has no name of its own.

    Parameters
    ----------
    path : Path
        The file appears whole or not at all.
    body : BodyMotion
        Evenly sampled.

    Raises
    ------
    FormatError
        When its frames are not evenly spaced, or a name would not read back.
    InputError
        When the file cannot be written.
    """
    step = float(body.time[-1] - body.time[0]) / (body.frames - 1)
    if np.abs(np.diff(body.time) - step).max() > 1e-3 * step:
        raise FormatError(
            f"{path}: BVH has one frame time: resample the motion to an even rate, --resample HZ"
        )
    for name in body.skeleton.names:
        if " ".join(name.split()) != name or not name.isprintable() or set("{}") & set(name):
            raise FormatError(f"{path}: a joint of BVH cannot be named {name!r}: rename it")
    ends = _ends(body)
    hierarchy = "\n".join(_hierarchy(body, ends))
    columns = _channel_values(body, ends)
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8") as file:
        file.write(f"HIERARCHY\n{hierarchy}\nMOTION\nFrames: {body.frames}\n")
        file.write(f"Frame Time: {step!r}\n")
        np.savetxt(file, columns, fmt="%.8f")


def _ends(body: BodyMotion) -> set[int]:
    parents = body.skeleton.parents
    still = np.array(~body.rotations.any(axis=(0, 2)))
    if body.translations is not None:
        still &= np.array(~body.translations.any(axis=(0, 2)))
    straight = np.all(np.asarray(body.skeleton.prerotations) == np.eye(3), axis=(1, 2))
    return {
        joint
        for joint, parent in enumerate(parents)
        if joint and joint not in parents and parents.count(parent) == 1
        if still[joint] and straight[joint]
        if body.skeleton.names[joint] == f"{body.skeleton.names[parent]}_end"
    }


def _hierarchy(body: BodyMotion, ends: set[int]) -> Iterator[str]:
    """Give the lines of the hierarchy, braces closed as the tree goes back."""
    above: list[int] = []
    for joint in _written_order(body):
        while above and above[-1] != body.skeleton.parents[joint]:
            above.pop()
            yield "\t" * len(above) + "}"
        indent = "\t" * len(above)
        name = f"{'JOINT' if joint else 'ROOT'} {body.skeleton.names[joint]}"
        yield indent + ("End Site" if joint in ends else name)
        yield indent + "{"
        offset = from_z_up(body.skeleton.offsets[joint] * 100, "y")
        yield f"{indent}\tOFFSET {' '.join(f'{value:.8f}' for value in offset)}"
        if joint not in ends:
            kinds = _POSITIONS + _TURNS if _is_moved(body, joint) else _TURNS
            yield f"{indent}\tCHANNELS {len(kinds)} {' '.join(kinds)}"
        above.append(joint)
    yield from ("\t" * depth + "}" for depth in reversed(range(len(above))))


def _is_moved(body: BodyMotion, joint: int) -> bool:
    moved = body.translations
    return joint == 0 or (moved is not None and bool(moved[:, joint].any()))


def _channel_values(body: BodyMotion, ends: set[int]) -> FloatArray:
    columns = []
    for joint in _written_order(body):
        if joint in ends:
            continue
        if _is_moved(body, joint):
            offset = body.skeleton.offsets[joint]
            moved = body.root if joint == 0 else offset + np.asarray(body.translations)[:, joint]
            columns.append(from_z_up(moved * 100, "y"))
        before = np.asarray(body.skeleton.prerotations)[joint]
        turned = before @ from_expmap(body.rotations[:, joint])
        # The file's axes are a cyclic exchange of ours: so are the rows and columns of a rotation
        in_file = from_z_up(from_z_up(turned, "y").swapaxes(1, 2), "y").swapaxes(1, 2)
        columns.append(np.rad2deg(to_rpy(in_file))[:, ::-1])
    return np.concatenate(columns, axis=1)


def _written_order(body: BodyMotion) -> list[int]:
    """Joints as the hierarchy lists them: each before those below it, branch by branch."""
    below: list[list[int]] = [[] for _ in body.skeleton.names]
    for joint, parent in enumerate(body.skeleton.parents[1:], start=1):
        below[parent].append(joint)
    order, waiting = [], [0]
    while waiting:
        order.append(waiting.pop())
        waiting.extend(reversed(below[order[-1]]))
    return order
