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


def on_same_rests(clip: BodyMotion, skeleton: Skeleton) -> BodyMotion:
    """Return a motion with its joints in a skeleton's order and turned from the skeleton's rests.

    The same movement in other numbers: bodies keep their global places and orientations. BVH, for
    one, keeps pre-rotations as part of the rotations, and lists joints branch by branch.

    Parameters
    ----------
    clip : BodyMotion
    skeleton : Skeleton

    Returns
    -------
    BodyMotion
        On a skeleton of the clip's own offsets; the clip itself where nothing differs.

    Raises
    ------
    SkeletonMismatchError
        Other joints, or joints that hang elsewhere.
    """
    own = clip.skeleton
    if own is skeleton:
        return clip
    order = _order(clip, skeleton)
    before, wanted = np.asarray(own.prerotations)[order], np.asarray(skeleton.prerotations)
    if order == sorted(order) and np.abs(before - wanted).max() <= _SAME_TURN:
        return clip
    moved = clip.translations
    return dataclasses.replace(
        clip,
        skeleton=dataclasses.replace(skeleton, offsets=np.asarray(own.offsets)[order]),
        rotations=_rested(clip.rotations[:, order], before, wanted),
        translations=None if moved is None else np.asarray(moved)[:, order],
    )


def _rested(rotations: FloatArray, before: FloatArray, wanted: FloatArray) -> FloatArray:
    """Exponential maps from other rests, such that bodies are turned alike."""
    local = wanted.swapaxes(-1, -2) @ before @ from_expmap(rotations)
    return quaternion.to_expmap(quaternion.from_matrix(local))


def _order(clip: BodyMotion, skeleton: Skeleton, *, more: bool = False) -> list[int]:
    """Where a clip has each joint of a skeleton; it may have `more`.

    Raises
    ------
    SkeletonMismatchError
        When the joints are not the same ones, or hang elsewhere; by the first.
    """
    own, who = clip.skeleton, clip.source or "a motion"
    lacking = [name for name in skeleton.names if name not in own.names]
    beyond = [name for name in own.names if name not in skeleton.names]
    if lacking or (beyond and not more):
        has = f"has '{beyond[0]}'" if beyond else f"has {own.joints} joints"
        other = f"'{lacking[0]}'" if lacking else f"only {skeleton.joints} joints"
        raise SkeletonMismatchError(
            f"{who}: {has} where the pattern has {other} ({len(lacking) + len(beyond)} names are"
            " not shared): motions of one pattern share their joints' names, retargeted ones, too",
            who,
            (lacking + beyond)[0],
        )
    for name, parent in zip(skeleton.names, skeleton.parents, strict=True):
        above = own.parents[own.names.index(name)]
        found = "nothing" if above < 0 else f"'{own.names[above]}'"
        wanted = "nothing" if parent < 0 else f"'{skeleton.names[parent]}'"
        if found != wanted:
            raise SkeletonMismatchError(
                f"{who}: joint '{name}' hangs on {found}, in the pattern on {wanted}: motions of"
                " one pattern share their hierarchy, retargeted ones, too",
                who,
                name,
            )
    return [own.names.index(name) for name in skeleton.names]


def _refuse(who: str, own: Skeleton, gaps: FloatArray, allowed: float, how: str) -> None:
    if gaps.max() > allowed:
        name = own.names[int(np.argmax(gaps))]
        raise SkeletonMismatchError(
            f"{who}: joint '{name}' {how} in the pattern (by {100 * gaps.max():.2g} cm):"
            " retarget it first (--retarget)",
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
    for given in clips:
        clip = on_same_rests(given, skeleton)
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
    clip = on_same_rests(clip, skeleton)
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
    own, order = clip.skeleton, _order(clip, skeleton, more=True)
    before, wanted = np.asarray(own.prerotations)[order], np.asarray(skeleton.prerotations)
    lengths = [float(np.linalg.norm(s.offsets[1:], axis=1).sum()) for s in (skeleton, own)]
    return dataclasses.replace(
        clip,
        skeleton=skeleton,
        rotations=_rested(clip.rotations[:, order], before, wanted),
        root=clip.root * (lengths[0] / lengths[1]),
        translations=None,
    )
