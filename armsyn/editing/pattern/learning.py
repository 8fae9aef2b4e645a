"""Learn a motion pattern from examples: time normalisation, one branch, PCA, leave-one-out."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from armsyn.editing.figure import Clip, Figure, SkeletonFigure, figure_of
from armsyn.editing.pattern.branches import unwrapped_poses
from armsyn.editing.pattern.model import MotionModel
from armsyn.editing.pattern.timing import normalised_poses
from armsyn.editing.sharing import moving_joints, retargeted, translations_on
from armsyn.errors import PatternError, SkeletonMismatchError
from armsyn.motion.body import BodyMotion

FloatArray = NDArray[np.float64]
RADIANS_PER_METRE = 2.0
"""Default weight: a metre of the root counts as the two radians by which a limb of half a metre
moves its end that far."""
FEWEST = 3
MOST_FRAMES = 10_000
_RANK = 1e-9
"""Of the largest standard deviation: what less than this is noise."""


def learn_model(
    clips: Sequence[Clip],
    *,
    figure: Figure | None = None,
    frames: int | None = None,
    variance: float = 0.98,
    components: int | None = None,
    radians_per_metre: float = RADIANS_PER_METRE,
    retarget: bool = False,
    seed: int = 0,
) -> MotionModel:
    """Learn a motion pattern.

    Parameters
    ----------
    clips : sequence of BodyMotion or Motion
        The examples, each a whole movement, at least three.
    figure : Figure, optional
        Needed for an arm's motions; the first clip's skeleton by default.
    frames : int, optional
        N of the normalised motion; the median of the clips' by default.
    variance : float
        Share of the variance to keep, in (0, 1].
    components : int, optional
        How many to keep, instead.
    radians_per_metre : float
        What a metre counts against a radian.
    retarget : bool
        Whether motions of other skeletons are first brought onto the figure's, joint by joint.
    seed : int
        Kept in the model; learning draws nothing.

    Returns
    -------
    MotionModel

    Raises
    ------
    PatternError
        Too few motions, or all the same, or more components than they have.
    SkeletonMismatchError
        Motions of different skeletons, by name.
    """
    if len(clips) < FEWEST:
        raise PatternError(f"{len(clips)} motions: a pattern needs at least {FEWEST}")
    if retarget:
        clips = _on_one_skeleton(clips, figure)
    figure = figure or figure_of([_body(clip) for clip in clips])
    count = int(np.median([clip.frames for clip in clips])) if frames is None else frames
    _check_options(count, variance, radians_per_metre)
    motions = example_poses(clips, figure, count)
    weights = np.where(figure.metres, radians_per_metre, 1.0)
    X = (motions * weights).reshape(len(clips), -1)
    sigma, E = _principal(X - X.mean(axis=0))
    shares = sigma**2 / np.sum(sigma**2)
    m = _kept(shares, variance, components)
    mean = motions.mean(axis=0)
    return MotionModel(
        figure=figure,
        mean=mean,
        components=E[:m].reshape(m, *mean.shape),
        sigma=sigma[:m],
        radians_per_metre=radians_per_metre,
        duration=float(np.mean([clip.time[-1] - clip.time[0] for clip in clips])),
        names=_names(clips),
        examples=(X - X.mean(axis=0)) @ E[:m].T / sigma[:m],
        shares=shares,
        left_out_m=_left_out(X, motions, weights, figure, m),
        inputs_sha256=_hash(motions, weights, m),
        seed=seed,
    )


def _body(clip: Clip) -> BodyMotion:
    if not isinstance(clip, BodyMotion):
        raise PatternError(f"{clip.source or 'motion'}: has no skeleton: say of which arm it is")
    return clip


def _on_one_skeleton(clips: Sequence[Clip], figure: Figure | None) -> list[Clip]:
    """Retarget the clips that do not share the skeleton, and only those."""
    bodies = [_body(clip) for clip in clips]
    skeleton = figure.skeleton if isinstance(figure, SkeletonFigure) else bodies[0].skeleton
    found: list[Clip] = []
    for body in bodies:
        try:
            translations_on(body, skeleton, moving_joints([body], skeleton))
            found.append(body)
        except SkeletonMismatchError:
            found.append(retargeted(body, skeleton))
    return found


def _check_options(frames: int, variance: float, radians_per_metre: float) -> None:
    if not 2 <= frames <= MOST_FRAMES:
        raise PatternError(f"{frames} frames: a pattern has 2 to {MOST_FRAMES}")
    if not 0.0 < variance <= 1.0:
        raise PatternError(f"variance {variance:g}: give a share in (0, 1], such as 0.98")
    if not (np.isfinite(radians_per_metre) and radians_per_metre > 0.0):
        raise PatternError(f"{radians_per_metre:g} radians a metre: give a positive weight")


def _names(clips: Sequence[Clip]) -> tuple[str, ...]:
    return tuple(clip.source or f"motion {place + 1}" for place, clip in enumerate(clips))


def example_poses(clips: Sequence[Clip], figure: Figure, frames: int) -> FloatArray:
    """Return the examples' poses, normalised in time and on one branch.

    Parameters
    ----------
    clips : sequence of BodyMotion or Motion
    figure : Figure
    frames : int

    Returns
    -------
    array, shape (examples, frames, n)
        rad and m; unwrapped along time, the first frames all on the branches of the first clip's.
    """
    time_normalised = [
        normalised_poses(clip.time, figure.poses(clip), figure.turns, frames) for clip in clips
    ]
    over_time = np.stack(time_normalised, axis=1)
    return np.ascontiguousarray(
        unwrapped_poses(over_time, figure.turns, over_time[0, 0]).swapaxes(0, 1)
    )


def _principal(X: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return standard deviations and orthonormal rows of a centred X, the largest first."""
    _, singular, E = np.linalg.svd(X, full_matrices=False)
    largest = singular[0] if singular.size else 0.0
    if not largest > _RANK * max(1.0, float(np.abs(X).max())):
        raise PatternError("the motions are all the same: there is no pattern in them")
    rank = int(np.sum(singular > _RANK * largest))
    # A sign that does not depend on the library: the largest entry is positive
    peaks = np.take_along_axis(E[:rank], np.abs(E[:rank]).argmax(axis=1)[:, None], axis=1)
    return singular[:rank] / np.sqrt(len(X) - 1), E[:rank] * np.sign(peaks)


def _kept(shares: FloatArray, variance: float, components: int | None) -> int:
    if components is None:
        return min(int(np.searchsorted(np.cumsum(shares), variance - 1e-12)) + 1, shares.size)
    if not 1 <= components <= shares.size:
        raise PatternError(
            f"{components} components: these motions have {shares.size} independent ones"
        )
    return components


def _left_out(
    X: FloatArray, motions: FloatArray, weights: FloatArray, figure: Figure, m: int
) -> FloatArray:
    """Mean distance of each example's bodies from what the others' model makes of it, m.

    All of it goes through the examples' Gram matrix: a reconstruction is a mixture of examples.
    """
    count = len(X)
    K = X @ X.T
    mixtures = np.zeros((count, count))
    for out in range(count):
        others = np.delete(np.arange(count), out)
        mixtures[out, others] = _mixture(K[np.ix_(others, others)], K[others, out], m)
    rebuilt = (mixtures @ X).reshape(motions.shape) / weights
    errors = np.empty(count)
    for out in range(count):
        apart = figure.tree.positions(rebuilt[out]) - figure.tree.positions(motions[out])
        errors[out] = np.linalg.norm(apart, axis=-1).mean()
    return errors


def _mixture(K: FloatArray, k: FloatArray, m: int) -> FloatArray:
    """Weights of the examples in the projection of another on their first m components."""
    count = len(K)
    C = np.eye(count) - 1.0 / count
    values, vectors = np.linalg.eigh(C @ K @ C)
    kept = values > _RANK**2 * values[-1]
    kept[: max(0, count - m)] = False
    U = vectors[:, kept]
    along = U.T @ (C @ (k - K.mean(axis=1)))
    return np.asarray(C @ (U @ (along / values[kept])) + 1.0 / count)


def _hash(motions: FloatArray, weights: FloatArray, m: int) -> str:
    digest = hashlib.sha256(np.ascontiguousarray(motions).tobytes())
    digest.update(weights.tobytes())
    digest.update(str(m).encode())
    return digest.hexdigest()
