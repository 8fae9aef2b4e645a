"""How well an arm can take a person's postures: what it follows, and what it cannot express."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.ik import fit_posture
from armsyn.kinematics.rotation import from_expmap
from armsyn.motion.captures import Capture
from armsyn.motion.retargeting import retarget
from armsyn.planning.atlas import Likeness

FloatArray = NDArray[np.float64]

FRAMES = 3
"""Of each capture: its first, its middle and its last."""
FAR_M = 0.01
"""Residual beyond which another posture to start the fit from is tried."""
_SEGMENTS = (("shoulder", "elbow"), ("elbow", "wrist"))


def likeness_of(
    arm: ArmDescription,
    captures: Sequence[Capture],
    on_progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> Likeness:
    """Fit an arm to captured postures and say how near it comes.

    Parameters
    ----------
    arm : ArmDescription
    captures : sequence of Capture
        With the arm's landmarks; one at least.
    on_progress : callable
        Given how many captures are done, and of how many, after each.

    Returns
    -------
    Likeness
    """
    residuals: list[float] = []
    angles: list[list[float]] = []
    for done, capture in enumerate(captures, 1):
        wanted = retarget(capture.motion, arm, is_return=capture.kind == "return").landmarks
        assert wanted is not None and capture.motion.landmarks is not None  # noqa: S101, PT018
        posture = arm.rest
        for frame in np.linspace(0, len(wanted) - 1, FRAMES).round().astype(int):
            fit = fit_posture(arm.chain, arm.landmark_frames, wanted[frame], posture)
            for near in (arm.rest, 0.5 * (arm.chain.lower + arm.chain.upper)):
                if fit.residual <= FAR_M:
                    break
                again = fit_posture(arm.chain, arm.landmark_frames, wanted[frame], near)
                fit = min(fit, again, key=lambda one: one.residual)
            posture = fit.posture
            residuals.append(fit.residual)
            person = dict(
                zip(capture.motion.landmark_names, capture.motion.landmarks[frame], strict=True)
            )
            angles.append(_directions(arm, posture, person))
        on_progress(done, len(captures))
    upper, fore = (_mean(column) for column in np.array(angles).T)
    return Likeness(
        tuple(arm.landmarks),
        float(f"{np.mean(residuals):.4g}"),
        float(f"{np.max(residuals):.4g}"),
        upper,
        fore,
    )


def _mean(angles: FloatArray) -> float | None:
    return None if np.isnan(angles).any() else float(f"{angles.mean():.4g}")


def _directions(
    arm: ArmDescription, posture: FloatArray, person: dict[str, FloatArray]
) -> list[float]:
    """Angles between the arm's and the person's upper arm and forearm, degrees; NaN for none."""
    rows = {name: row for row, name in enumerate(arm.joint_names)} | {"tip": arm.chain.dof}
    positions = arm.chain.positions(posture[None])[0]
    turn = from_expmap([0.0, 0.0, arm.facing])
    found = []
    for first, last in _SEGMENTS:
        # a capture without a wrist has its hand at the forearm's end
        end = last if last in person and last in arm.anatomy else "hand"
        if not {first, end} <= person.keys() & arm.anatomy.keys():
            found.append(np.nan)
            continue
        own = positions[rows[arm.anatomy[end]]] - positions[rows[arm.anatomy[first]]]
        theirs = turn @ (person[end] - person[first])
        cosine = own @ theirs / (np.linalg.norm(own) * np.linalg.norm(theirs))
        found.append(float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))))
    return found
