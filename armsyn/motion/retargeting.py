"""A person's arm (or another robot's) put on an arm: its segments on the arm's link lengths."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from armsyn.arm import ArmDescription
from armsyn.errors import CaptureError
from armsyn.ik import fit_posture
from armsyn.kinematics.rotation import from_expmap
from armsyn.motion.motion import BoolArray, FloatArray, Motion
from armsyn.motion.rebuilding import rebuild_segments, segment_lengths

MIRROR = np.array([1.0, -1.0, 1.0])
"""Left and right exchanged."""


class PostureTrack(NamedTuple):
    """Postures fitted to landmarks.

    Attributes
    ----------
    motion : Motion
        The arm's joint angles, and its landmarks as they then are, base frame.
    residuals : array, shape (frames,)
        Mean distance of the arm's landmarks to the wanted ones, m.
    """

    motion: Motion
    residuals: FloatArray


def on_arm(arm: ArmDescription, landmarks: FloatArray, *, is_return: bool = False) -> FloatArray:
    """Put captured landmarks on an arm.

    An arm with the capture's landmarks gets them rebuilt on its own link lengths along their
    captured directions, from where its own first landmark is at rest, so that another body's size
    and place are no error of the motion. An arm that names only its hand gets the hand's path,
    turned to where the arm faces, starting (a return: ending) where its own hand rests, scaled by
    half the ratio of reaches: a person's hand rests an arm's length below the shoulder and goes up
    from there, an arm on a table has half of that.

    Parameters
    ----------
    arm : ArmDescription
    landmarks : array, shape (frames, landmarks, 3)
        Relative to the shoulder, x forward, y left, z up, m, finite.
    is_return : bool
        That the way back to rest was captured.

    Returns
    -------
    array, shape (frames, len(arm.landmarks), 3)
        In the arm's base frame, m.

    Raises
    ------
    InputError, CaptureError
        As `armsyn.motion.rebuilding.rebuild_segments`.
    """
    if len(arm.landmarks) == 1:
        return _scaled_hand(arm, landmarks, is_return=is_return)
    at_rest = arm.chain.forward(arm.rest).positions[list(arm.landmark_frames)]
    return np.asarray(rebuild_segments(landmarks, segment_lengths(at_rest[None])) + at_rest[0])


def _scaled_hand(arm: ArmDescription, landmarks: FloatArray, *, is_return: bool) -> FloatArray:
    person = np.linalg.norm(np.diff(landmarks[0], axis=0), axis=1).sum()
    scale = 0.5 * arm.chain.reach / person
    hand = landmarks[:, -1] @ from_expmap([0.0, 0.0, arm.facing]).T * scale
    at_rest = hand[-1] if is_return else hand[0]
    return np.asarray((hand - at_rest + arm.chain.forward(arm.rest).tip)[:, None])


def retarget(motion: Motion, arm: ArmDescription, *, is_return: bool = False) -> Motion:
    """Return a motion with an arm's landmarks on the arm's link lengths.

    Parameters
    ----------
    motion : Motion
        Landmarks of an arm, x forward, y left, z up; the trunk's motion removed.
    arm : ArmDescription
    is_return : bool
        As in `on_arm`.

    Returns
    -------
    Motion
        In the arm's base frame.

    Raises
    ------
    CaptureError
        When it lacks a landmark of the arm, has gaps, or a segment has no length.
    """
    source = motion.source or "motion"
    landmarks = motion.landmarks
    wanted = tuple(arm.landmarks) if len(arm.landmarks) > 1 else motion.landmark_names
    lacking = [name for name in wanted if name not in motion.landmark_names]
    if landmarks is None or lacking or len(wanted) < 2:
        there = ", ".join(motion.landmark_names) or "none"
        needs = ", ".join(arm.landmarks) if lacking else "two at least"
        raise CaptureError(f"{source} has landmarks {there}; {arm.name} needs {needs}")
    columns = [motion.landmark_names.index(name) for name in wanted]
    landmarks = landmarks[:, columns]
    if not np.isfinite(landmarks).all():
        frame = int(np.argmin(np.isfinite(landmarks).all(axis=(1, 2))))
        raise CaptureError(f"{source}: a landmark is missing at frame {frame}: cut or fill it")
    return dataclasses.replace(
        motion,
        joint_names=(),
        angles=None,
        landmark_names=tuple(arm.landmarks),
        landmarks=on_arm(arm, landmarks - landmarks[:, :1], is_return=is_return),
        filled=_filled(motion, columns, arm),
    )


def _filled(motion: Motion, columns: list[int], arm: ArmDescription) -> BoolArray | None:
    """Marks of what was filled: a rebuilt landmark rests on all before it, a lone hand on its own.

    What the hand's path is scaled by rests on the first frame alone and marks nothing.
    """
    if motion.filled is None:
        return None
    filled = motion.filled[:, columns]
    if len(arm.landmarks) == 1:
        return np.asarray(filled[:, :1] | filled[:, -1:])
    return np.asarray(np.logical_or.accumulate(filled, axis=1))


def mirrored(motion: Motion) -> Motion:
    """Return a motion whose left is its right: a left arm's landmarks for a right arm.

    Parameters
    ----------
    motion : Motion
        With landmarks, y left.

    Returns
    -------
    Motion
        Without joint angles, which are another arm's.
    """
    landmarks = None if motion.landmarks is None else motion.landmarks * MIRROR
    return dataclasses.replace(motion, joint_names=(), angles=None, landmarks=landmarks)


def fit_angles(
    arm: ArmDescription, motion: Motion, progress: Callable[[int], None] | None = None
) -> PostureTrack:
    """Fit the arm's posture to its landmarks, frame by frame.

    Parameters
    ----------
    arm : ArmDescription
    motion : Motion
        Of `retarget`.
    progress : callable, optional
        Called with the number of frames done.

    Returns
    -------
    PostureTrack
        Each posture near the one before, the first near the arm's rest.
    """
    assert motion.landmarks is not None  # noqa: S101 - retarget gives them
    posture, angles, residuals = arm.rest, [], []
    for done, wanted in enumerate(motion.landmarks, 1):
        fit = fit_posture(arm.chain, arm.landmark_frames, wanted, posture)
        posture = fit.posture
        angles.append(posture)
        residuals.append(fit.residual)
        if progress is not None:
            progress(done)
    found = np.array(angles)
    fitted = dataclasses.replace(
        motion,
        joint_names=arm.joint_names,
        angles=found,
        landmarks=arm.chain.positions(found)[:, list(arm.landmark_frames)],
    )
    return PostureTrack(fitted, np.array(residuals))
