"""The motion of an arm as that of a skeleton, for BVH.

The root, ``base``, stands still in the arm's base frame; every joint of the chain is a joint with
its name, its fixed orientation a pre-rotation, and turns about its own axis (a prismatic joint is
moved along it); ``tip`` is the last. So the skeleton's positions are those of forward kinematics.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from armsyn.errors import FormatError
from armsyn.kinematics import SerialChain
from armsyn.kinematics.rotation import from_rpy
from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion.body import BodyMotion
from armsyn.motion.formats import bvh_write
from armsyn.motion.motion import Motion

BASE, TIP = "base", "tip"


def body_of(motion: Motion, chain: SerialChain) -> BodyMotion:
    """Return the motion of an arm as that of a skeleton.

    Parameters
    ----------
    motion : Motion
        With angles of all of the chain's joints, rad or m; in any order, others are left out.
    chain : SerialChain

    Returns
    -------
    BodyMotion
        Joints ``base``, the chain's, ``tip`` and its end; positions in the base frame, m.

    Raises
    ------
    FormatError
        When joints of the chain have no angles in the motion, or one has a name of ours.
    """
    missing = [name for name in chain.names if name not in motion.joint_names]
    if motion.angles is None or missing:
        raise FormatError(
            f"{motion.source or 'motion'}: no angles of"
            f" {', '.join(missing or chain.names)}: not a motion of this arm"
        )
    if {BASE, TIP, f"{TIP}_end"} & set(chain.names):
        raise FormatError(f"a joint named {BASE} or {TIP} cannot be written as BVH: rename it")
    angles = motion.angles[:, [motion.joint_names.index(name) for name in chain.names]]
    skeleton = _skeleton(chain)
    shape = (motion.frames, skeleton.joints, 3)
    rotations, moved = np.zeros(shape), np.zeros(shape)
    for joint, (described, values) in enumerate(zip(chain.joints, angles.T, strict=True), start=1):
        axis = np.asarray(described.axis) / np.linalg.norm(described.axis)
        if described.kind == "prismatic":
            moved[:, joint] = values[:, None] * (from_rpy(described.rpy) @ axis)
        else:
            rotations[:, joint] = values[:, None] * axis
    root = np.zeros((motion.frames, 3))
    translations = moved if moved.any() else None
    return BodyMotion(motion.time, skeleton, rotations, root, translations, motion.source)


def _skeleton(chain: SerialChain) -> Skeleton:
    names = (BASE, *chain.names, TIP, f"{TIP}_end")
    places = [joint.xyz for joint in chain.joints]
    turns = [from_rpy(joint.rpy) for joint in chain.joints]
    offsets = np.array([(0.0, 0.0, 0.0), *places, chain.tip_xyz, (0.0, 0.0, 0.0)])
    before = np.array([np.eye(3), *turns, from_rpy(chain.tip_rpy), np.eye(3)])
    return Skeleton(names, tuple(range(-1, len(names) - 1)), offsets, before)


def write(path: Path, motion: Motion, chain: SerialChain) -> None:
    """Write the motion of an arm as BVH: centimetres, y up, ZYX rotations in degrees.

    Parameters
    ----------
    path : Path
        The file appears whole or not at all.
    motion : Motion
        Evenly sampled, with angles of all of the chain's joints.
    chain : SerialChain

    Raises
    ------
    FormatError
        As `body_of` and `armsyn.motion.formats.bvh_write.write`.
    InputError
        When the file cannot be written.
    """
    bvh_write.write(path, body_of(motion, chain))
