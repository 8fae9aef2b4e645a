"""An edit's figures: a JSON document, rows for people, and the score of after against before."""

from __future__ import annotations

import dataclasses
from typing import Any, NamedTuple

import numpy as np

from armsyn.editing.pattern.model import MotionModel
from armsyn.editing.result import EditResult
from armsyn.errors import InputError
from armsyn.motion import FloatArray, Motion
from armsyn.scoring.comparison import refusal_of_paper_distance
from armsyn.scoring.score import Score, Settings, score_as_dict, score_motions

SCHEMA = "armsyn-edit-1"
LATENT_SCHEMA = "armsyn-latent-1"


class Scored(NamedTuple):
    """The score of the edited clip against the original.

    Attributes
    ----------
    score : Score or None
        The original is its "captured" one.
    refusal : str
        Why there is none; empty otherwise.
    """

    score: Score | None
    refusal: str


def as_landmarks(result: EditResult) -> tuple[Motion, Motion]:
    """Return the original and the edited clip as landmarks, the constrained body last.

    Parameters
    ----------
    result : EditResult

    Returns
    -------
    (Motion, Motion)
        All bodies; the hand is the first body that a constraint of the first level names, or the
        last body where nothing is asked for.
    """
    bodies = result.figure.tree.bodies
    hand = bodies.index(result.constrained[0]) if result.constrained else len(bodies) - 1
    order = [*(place for place in range(len(bodies)) if place != hand), hand]
    names, time = tuple(bodies[place] for place in order), result.original.time
    source = result.original.source or "clip"

    def landmarks(positions: FloatArray, what: str) -> Motion:
        return Motion(
            time=time - time[0],
            landmark_names=names,
            landmarks=positions[:, order],
            source=f"{source}, {what}",
        )

    before, after = result.positions
    return landmarks(before, "original"), landmarks(after, "edited")


def score_edit(result: EditResult) -> Scored:
    """Score the edited clip against the original by the constrained body's movement.

    Parameters
    ----------
    result : EditResult

    Returns
    -------
    Scored
        Without a score where that body does not move, such as a foot that stands.
    """
    before, after = as_landmarks(result)
    try:
        settings = Settings(rebuild=False)
        return Scored(
            _without_verdict(score_motions(("original", before), ("edited", after), settings)), ""
        )
    except InputError as error:
        return Scored(None, str(error))


def _without_verdict(score: Score) -> Score:
    """Leave out that the captured target is missed: an edit goes where it is asked to."""
    missed = refusal_of_paper_distance(1.0, score.comparison.endpoint_error)
    if missed is None or score.comparison.refusal != missed:
        return score
    return dataclasses.replace(
        score, comparison=dataclasses.replace(score.comparison, refusal=None)
    )


def edit_as_dict(result: EditResult, scored: Scored) -> dict[str, Any]:
    """Return an edit as a JSON document, SI units.

    Parameters
    ----------
    result : EditResult
    scored : Scored

    Returns
    -------
    dict
    """
    slides = result.foot_slide_m or {}
    return {
        "schema": SCHEMA,
        "clip": result.original.source,
        "frames": result.original.frames,
        "success": result.success,
        "iterations": result.iterations,
        "constraints": [
            {"label": r.label, "level": r.level, "worst": r.worst, "frame": r.frame, "unit": r.unit}
            for r in result.residuals
        ],
        "largest_coefficient": result.largest_coefficient,
        "largest_own_coefficient": _largest_own(result),
        "nearest_example": None if result.nearest is None else result.nearest[0],
        "distance_to_nearest": None if result.nearest is None else result.nearest[1],
        "start_drift_m": result.start_drift_m,
        "largest_change_m": _largest_change(result),
        "foot_slide_m": {
            name: {"before": before, "after": after} for name, (before, after) in slides.items()
        },
        "foot_lift_m": {name: foot.lift for name, foot in result.feet.items()},
        "score": None if scored.score is None else score_as_dict(scored.score),
        "score_refusal": scored.refusal or None,
    }


def latent_as_dict(result: EditResult, model: MotionModel) -> dict[str, Any]:
    """Return an edit as latent variables: whitened coefficients of the model that they are of.

    Parameters
    ----------
    result : EditResult
        Of the latent space.
    model : MotionModel

    Returns
    -------
    dict
        ``edited`` has a row a frame, or one row for all where they are equal.
    """
    assert result.coefficients is not None  # noqa: S101 - of the latent space
    assert result.own_coefficients is not None  # noqa: S101
    rows = result.coefficients
    alike = bool((rows == rows[0]).all())
    return {
        "schema": LATENT_SCHEMA,
        "clip": result.original.source,
        "model_inputs_sha256": model.inputs_sha256,
        "own": result.own_coefficients.tolist(),
        "edited": (rows[:1] if alike else rows).tolist(),
    }


def figure_rows(result: EditResult) -> list[tuple[str, str]]:
    """Write out an edit's figures for people: what, and how much."""
    rows = [(f"level {r.level}: {r.label}", f"misses {r.amount}") for r in result.residuals]
    rows.append(("iterations", str(result.iterations)))
    if result.largest_coefficient is not None:
        said = f"{result.largest_coefficient:.2f} sigma (the clip's own {_largest_own(result):.2f})"
        rows.append(("largest coefficient", said))
    if result.nearest is not None:
        rows.append(("nearest example", f"{result.nearest[0]}, {result.nearest[1]:.2f} sigma away"))
    rows.append(("largest change", f"{100 * _largest_change(result):.2f} cm"))
    rows.append(("start drift", f"{100 * result.start_drift_m:.2f} cm"))
    for name, foot in result.feet.items():
        slides = f"{100 * foot.slide_before:.2f} -> {100 * foot.slide_after:.2f} cm"
        rows.append((f"slide of {name}", f"{slides}, lifted or sunk by {100 * foot.lift:.2f} cm"))
    return rows


def _largest_own(result: EditResult) -> float | None:
    own = result.own_coefficients
    return None if own is None else float(np.abs(own).max())


def _largest_change(result: EditResult) -> float:
    before, after = result.positions
    return float(np.linalg.norm(after - before, axis=-1).max())
