"""One rigid transform a session between the frames of two bases, from calibration poses.

Never fitted to the motions that are scored: a fit per trial lets a reach to the wrong target be
turned onto the right one.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from armsyn.errors import CaptureError, FormatError, InputError
from armsyn.motion.motion import FloatArray, Motion

FLATTEST = 0.02
"""m; root mean square spread of the poses' landmarks in their second direction. On one line they
leave a turn about it free."""
SAME_PLACE = 1e-5
"""m; landmarks that differ by no more are the same ones, written in another format."""


@dataclass(frozen=True, eq=False)
class BaseTransform:
    """A rotation and a translation: point in the one base = rotation @ point in the other + this.

    Parameters
    ----------
    rotation : array, shape (3, 3)
    translation : array, shape (3,)
        m.
    residual : float
        m, root mean square, of the landmarks it was fitted to.
    poses : int
        How many.
    source : str
        Of the poses, for people.
    """

    rotation: FloatArray
    translation: FloatArray
    residual: float
    poses: int
    source: str = ""

    def apply(self, motion: Motion) -> Motion:
        """Return the motion with its landmarks in the one base.

        Raises
        ------
        FormatError
            When it has angles only.
        """
        if motion.landmarks is None:
            raise FormatError(f"{motion.source or 'motion'}: no landmark positions to transform")
        landmarks = motion.landmarks @ self.rotation.T + self.translation
        return dataclasses.replace(motion, landmarks=landmarks)


def fit_base_transform(poses: Motion, other_poses: Motion) -> BaseTransform:
    """Fit the transform that takes the other base's poses to the one base's, by least squares.

    Parameters
    ----------
    poses, other_poses : Motion
        The same postures in the same order, one a frame, with the same landmarks; those that only
        one of them has are left out.

    Returns
    -------
    BaseTransform
        A proper rotation, never a mirror image.

    Raises
    ------
    FormatError
        When one has angles only.
    CaptureError
        When they have no landmark in common, frames differ in number, there are gaps, or
        the landmarks lie on one line.

    References
    ----------
    Umeyama, IEEE PAMI 13:376 (1991), eq. 40-42, without scale.
    """
    common = [name for name in poses.landmark_names if name in other_poses.landmark_names]
    for motion in (poses, other_poses):
        if motion.landmarks is None:
            raise FormatError(f"{motion.source or 'calibration poses'}: no landmark positions")
    if not common:
        raise CaptureError(
            f"calibration poses: no landmark of {poses.source} ({', '.join(poses.landmark_names)})"
            f" is one of {other_poses.source} ({', '.join(other_poses.landmark_names)})"
        )
    here, there = _points(poses, common), _points(other_poses, common)
    if here.shape != there.shape:
        raise CaptureError(
            f"calibration poses: {poses.source} has {poses.frames} frames,"
            f" {other_poses.source} {other_poses.frames}: the same postures are needed in both"
        )
    here, there = here.reshape(-1, 3), there.reshape(-1, 3)
    if not (np.isfinite(here).all() and np.isfinite(there).all()):
        raise CaptureError("calibration poses have gaps: leave those frames out of both")
    for points, motion in ((here, poses), (there, other_poses)):
        spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        if points.shape[0] < 3 or spread[1] / np.sqrt(len(points)) < FLATTEST:
            raise CaptureError(f"{motion.source}: calibration poses on one line fix no transform")
    rotation = _rotation(here - here.mean(axis=0), there - there.mean(axis=0))
    translation = here.mean(axis=0) - rotation @ there.mean(axis=0)
    left = np.linalg.norm(here - there @ rotation.T - translation, axis=1)
    residual = float(np.sqrt((left**2).mean()))
    source = f"{other_poses.source} onto {poses.source}"
    return BaseTransform(rotation, translation, residual, poses.frames, source)


def check_poses(poses: tuple[Motion, Motion], trials: tuple[Motion, ...]) -> None:
    """Refuse calibration poses that are a trial's own, under whatever name they were read.

    Parameters
    ----------
    poses : (Motion, Motion)
        Of the one base and the other.
    trials : tuple of Motion
        What the transform is meant for.

    Raises
    ------
    InputError
        When the landmarks, or without any the joint angles, of one of both are those of a trial.
    """
    for one in poses:
        if any(_same(one, trial) for trial in trials):
            raise InputError(
                "--align: calibration poses must be others than the motion, and those of"
                f" {one.source or 'one file'} are its own: a transform fitted to a trial hides"
                " where it went"
            )


def _same(one: Motion, other: Motion) -> bool:
    pairs = ((one.landmarks, other.landmarks), (one.angles, other.angles))
    first, second = next((p for p in pairs if p[0] is not None and p[1] is not None), pairs[0])
    if first is None or second is None or first.shape != second.shape:
        return False
    return np.allclose(first, second, rtol=0, atol=SAME_PLACE, equal_nan=True)


def _points(motion: Motion, names: list[str]) -> FloatArray:
    assert motion.landmarks is not None  # noqa: S101 - the caller looked
    return motion.landmarks[:, [motion.landmark_names.index(name) for name in names]]


def _rotation(here: FloatArray, there: FloatArray) -> FloatArray:
    left, _, right = np.linalg.svd(here.T @ there)
    turn = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    return np.asarray(left @ turn @ right)
