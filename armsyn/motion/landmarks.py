"""An arm's landmarks from what was captured: a skeleton's joints, markers, or a robot's angles.

The trunk's motion is removed, not modelled: landmarks are given relative to the shoulder, in the
frame of the chest (x forward, y left, z up), so that a lean or a turn of the trunk moves nothing,
and neither does a shrug. Without a chest, only the shoulder's translation is removed.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from armsyn.arm import ArmDescription
from armsyn.errors import CaptureError, InputError
from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion.body import BodyMotion
from armsyn.motion.motion import FloatArray, Motion
from armsyn.motion.points import position_of

_ACROSS = 1e-3
"""m; least extent of a chest's four markers from which a frame can be taken."""


class ArmLayout(NamedTuple):
    """Where a kind of capture has an arm's landmarks.

    Attributes
    ----------
    points : dict of str to str
        Landmark to joint, or to markers with + between; the hand last.
    chest : str
        Joint, or the markers IJ+PX+C7+T8 (see `arm_of_markers`).
    """

    points: Mapping[str, str]
    chest: str


LAYOUTS: dict[str, ArmLayout] = {
    "garza, right arm": ArmLayout(
        {
            **{"shoulder": "JtShoulderRt", "elbow": "JtElbowRt"},
            **{"wrist": "JtWristRt", "hand": "JtMiddleARt"},
        },
        "JtSpineC",
    ),
    "ulema, left arm": ArmLayout(
        {"shoulder": "LGH", "elbow": "LEL+LEM", "wrist": "LRS+LUS", "hand": "LMC3"},
        "IJ+PX+C7+T8",
    ),
    "golf, right arm": ArmLayout(
        {"shoulder": "right_shoulder", "elbow": "right_elbow", "hand": "right_wrist"}, "chest"
    ),
}
"""Known ones, by what people call them: glenohumeral centre, middle of the epicondyles, middle of
the styloids, head of the third metacarpal."""


def known_layout(names: tuple[str, ...]) -> str | None:
    """Return the known layout that finds all its points among these names, or None."""
    for kind, layout in LAYOUTS.items():
        needed = "+".join([*layout.points.values(), layout.chest]).split("+")
        if set(needed) <= set(names):
            return kind
    return None


def arm_of_body(body: BodyMotion, joints: Mapping[str, str], chest: str | None) -> Motion:
    """Return an arm's landmarks from a skeleton.

    Parameters
    ----------
    body : BodyMotion
    joints : mapping of str to str
        Landmark to joint, the shoulder first and the hand last.
    chest : str or None
        The joint whose frame the chest's is, turned as it stands in the skeleton's zero pose.

    Returns
    -------
    Motion
        Relative to the first landmark, m.

    Raises
    ------
    InputError
        When there is no such joint.
    """
    skeleton = body.skeleton
    wanted = [skeleton.index(name) for name in (*joints.values(), *([chest] if chest else []))]
    kept = sorted({above for joint in wanted for above in skeleton.path_to(joint)})
    part = _part(skeleton, kept)
    moved = None if body.translations is None else body.translations[:, kept]
    found = part.frames(body.root, body.rotations[:, kept], moved)
    marks = [part.index(name) for name in joints.values()]
    landmarks = found.positions[:, marks] - found.positions[:, marks[:1]]
    if chest:
        upright = part.frames(np.zeros((1, 3)), np.zeros((1, part.joints, 3)))
        to_chest = found.orientations[:, part.index(chest)].transpose(0, 2, 1)
        turn = upright.orientations[0, part.index(chest)] @ to_chest
        landmarks = np.einsum("tij,tkj->tki", turn, landmarks)
    return Motion(
        time=body.time, landmark_names=tuple(joints), landmarks=landmarks, source=body.source
    )


def _part(skeleton: Skeleton, kept: list[int]) -> Skeleton:
    """Return some joints, all above each among them: the other limbs need not be computed."""
    place = {-1: -1, **{joint: row for row, joint in enumerate(kept)}}
    return Skeleton(
        tuple(skeleton.names[joint] for joint in kept),
        tuple(place[skeleton.parents[joint]] for joint in kept),
        skeleton.offsets[kept],
        np.asarray(skeleton.prerotations)[kept],
    )


def arm_of_markers(motion: Motion, points: Mapping[str, str], chest: str | None) -> Motion:
    """Return an arm's landmarks from markers.

    Parameters
    ----------
    motion : Motion
        Markers as landmarks, m.
    points : mapping of str to str
        Landmark to marker, or to markers with + between, the shoulder first and the hand last.
    chest : str or None
        Four markers with + between, in this order: incisura jugularis, processus xiphoideus,
        seventh cervical and eighth thoracic vertebra. Up goes from the middle of the lower two
        to that of the upper two, left is normal to the plane of these and the upper two.

    Returns
    -------
    Motion
        Relative to the first landmark, m; NaN where a marker that it needs was not seen.

    Raises
    ------
    InputError
        When there is no such marker, or a chest has not four.
    CaptureError
        When the chest's markers are on one line.

    References
    ----------
    Wu et al., J Biomech 38:981 (2005), 2.3.1, thorax coordinate system, with the axes named as
    here.
    """
    places = np.stack([position_of(motion, point) for point in points.values()], axis=1)
    landmarks = places - places[:, :1]
    if chest:
        landmarks = np.einsum("tij,tkj->tki", _thorax(motion, chest), landmarks)
    return Motion(
        time=motion.time,
        landmark_names=tuple(points),
        landmarks=landmarks,
        source=motion.source,
        filled=_filled(motion, points),
    )


def _filled(motion: Motion, points: Mapping[str, str]) -> np.ndarray | None:
    if motion.filled is None:
        return None
    columns = [
        [motion.landmark_names.index(name.strip()) for name in point.split("+")]
        for point in points.values()
    ]
    return np.stack([motion.filled[:, part].any(axis=1) for part in columns], axis=1)


def _thorax(motion: Motion, chest: str) -> FloatArray:
    """Return the rotations into the chest's frame, shape (frames, 3, 3)."""
    names = chest.split("+")
    if len(names) != 4:
        raise InputError(
            f"chest '{chest}': give four markers as IJ+PX+C7+T8: the incisura jugularis, the"
            " processus xiphoideus, and the vertebrae C7 and T8"
        )
    front, front_low, back, back_low = (position_of(motion, name) for name in names)
    bottom = (front_low + back_low) / 2
    up = (front + back) / 2 - bottom
    left = np.cross(back - bottom, front - bottom)
    lengths = [np.linalg.norm(vector, axis=1, keepdims=True) for vector in (up, left)]
    if (lengths[0] < _ACROSS).any() or (lengths[1] < _ACROSS**2).any():
        raise CaptureError(f"{motion.source}: the markers of chest {chest} are on one line")
    up, left = up / lengths[0], left / lengths[1]  # left already is at right angles to up
    return np.stack([np.cross(left, up), left, up], axis=1)


def arm_of_angles(motion: Motion, arm: ArmDescription) -> Motion:
    """Return an arm's landmarks from its joint angles, by its chain.

    Parameters
    ----------
    motion : Motion
        With angles; its joints may stand in any order, and there may be others.
    arm : ArmDescription

    Returns
    -------
    Motion
        The same angles, and the arm's landmarks in its base frame, m.

    Raises
    ------
    InputError
        When it has no angles, or lacks a joint of the arm.
    """
    for name in arm.joint_names:
        if name not in motion.joint_names:
            there = ", ".join(motion.joint_names) or "no joints"
            raise InputError(f"{motion.source}: no joint '{name}' of {arm.name}; it has {there}")
    assert motion.angles is not None  # noqa: S101 - it has names
    columns = [motion.joint_names.index(name) for name in arm.joint_names]
    angles = motion.angles[:, columns]
    return dataclasses.replace(
        motion,
        joint_names=arm.joint_names,
        angles=angles,
        landmark_names=tuple(arm.landmarks),
        landmarks=arm.chain.positions(angles)[:, list(arm.landmark_frames)],
        filled=None,
    )
