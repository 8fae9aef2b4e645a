"""Whether motions share a skeleton, and how one is brought onto another's."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import SkeletonMismatchError
from armsyn.kinematics import quaternion
from armsyn.kinematics.rotation import from_expmap
from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion.body import BodyMotion

FloatArray = NDArray[np.float64]
SOFT_M = 1e-3
"""A joint of a soft skeleton that departs from its offset by more than this translates, m."""
SAME_M = 5e-3
"""What rigid offsets of one skeleton may differ by, m: a person's bones, fitted for each take."""
_SAME_TURN = 1e-4


def check_same(clip: BodyMotion, skeleton: Skeleton) -> None:
    """Refuse a motion of another skeleton; offsets of joints that translate may differ.

    Raises
    ------
    SkeletonMismatchError
        Other joints, parents or pre-rotations, or a rigid offset of another length.
    """
    own, who = clip.skeleton, clip.source or "a motion"
    if own is skeleton:
        return
    for place, (name, other) in enumerate(zip(own.names, skeleton.names, strict=False)):
        if name != other or own.parents[place] != skeleton.parents[place]:
            raise SkeletonMismatchError(
                f"{who}: joint {place} is '{name}' where the pattern has '{other}' (or hangs on"
                " another joint): retarget it first",
                who,
                name,
            )
    if own.joints != skeleton.joints:
        raise SkeletonMismatchError(
            f"{who}: has {own.joints} joints, the pattern {skeleton.joints}: retarget it first", who
        )
    turned = np.abs(np.asarray(own.prerotations) - np.asarray(skeleton.prerotations))
    _refuse(who, own, turned.max(axis=(1, 2)), _SAME_TURN, "rests turned another way")


def _refuse(who: str, own: Skeleton, gaps: FloatArray, allowed: float, how: str) -> None:
    if gaps.max() > allowed:
        name = own.names[int(np.argmax(gaps))]
        raise SkeletonMismatchError(
            f"{who}: joint '{name}' {how} in the pattern ({gaps.max():.3g}): retarget it first",
            who,
            name,
        )


def moving_joints(clips: list[BodyMotion], skeleton: Skeleton) -> tuple[int, ...]:
    """Return the joints that translate in one of the clips, the root left out.

    Raises
    ------
    SkeletonMismatchError
        When a clip is of another skeleton.
    """
    moving: set[int] = set()
    for clip in clips:
        check_same(clip, skeleton)
        if clip.translations is not None:
            apart = clip.skeleton.offsets - skeleton.offsets
            moved = np.abs(clip.translations + apart).max(axis=(0, 2)) > SOFT_M
            moving |= set(np.flatnonzero(moved).tolist())
    return tuple(sorted(moving - {0}))


def translations_on(clip: BodyMotion, skeleton: Skeleton, moving: tuple[int, ...]) -> FloatArray:
    """Return what the moving joints of a clip are moved by beyond a skeleton's offsets.

    Two archives of one person may have split a soft joint's place into offset and translation
    at different points, so the offsets' difference is part of it.

    Parameters
    ----------
    clip : BodyMotion
    skeleton : Skeleton
        Whose offsets count.
    moving : tuple of int

    Returns
    -------
    array, shape (frames, moving, 3)
        m.

    Raises
    ------
    SkeletonMismatchError
        When the clip is of another skeleton, or moves a joint that is rigid in the pattern.
    """
    check_same(clip, skeleton)
    who = clip.source or "a motion"
    apart = clip.skeleton.offsets - skeleton.offsets
    whole = np.broadcast_to(apart, (clip.frames, *apart.shape))
    if clip.translations is not None:
        whole = whole + clip.translations
    rigid = np.abs(whole).max(axis=(0, 2))
    rigid[[0, *moving]] = 0.0
    _refuse(who, clip.skeleton, rigid, SAME_M, "lies elsewhere than")
    return np.asarray(whole[:, list(moving)])


def retargeted(clip: BodyMotion, skeleton: Skeleton) -> BodyMotion:
    """Return the motion on another skeleton with the same joints.

    Rotations are kept, turned into the other's pre-rotations; the root's path is scaled by the
    ratio of the bones' total length, so that steps fit the legs. Translations of joints are left
    out: the bones are the other's.

    Parameters
    ----------
    clip : BodyMotion
    skeleton : Skeleton
        Every joint's name and parent must be the clip's.

    Returns
    -------
    BodyMotion

    Raises
    ------
    SkeletonMismatchError
        When a joint is missing or hangs elsewhere.
    """
    own, who = clip.skeleton, clip.source or "a motion"
    order = []
    for name, parent in zip(skeleton.names, skeleton.parents, strict=True):
        above = None if parent < 0 else skeleton.names[parent]
        place = own.names.index(name) if name in own.names else -1
        if place < 0 or above != (
            None if own.parents[place] < 0 else own.names[own.parents[place]]
        ):
            raise SkeletonMismatchError(
                f"{who}: has no joint '{name}' below '{above or 'the world'}', so it cannot be"
                " retargeted by names",
                who,
                name,
            )
        order.append(place)
    before = np.asarray(own.prerotations)[order]
    turned = np.asarray(skeleton.prerotations).swapaxes(-1, -2) @ before
    local = turned @ from_expmap(clip.rotations[:, order])
    lengths = [float(np.linalg.norm(s.offsets[1:], axis=1).sum()) for s in (skeleton, own)]
    return dataclasses.replace(
        clip,
        skeleton=skeleton,
        rotations=quaternion.to_expmap(quaternion.from_matrix(local)),
        root=clip.root * (lengths[0] / lengths[1]),
        translations=None,
    )
