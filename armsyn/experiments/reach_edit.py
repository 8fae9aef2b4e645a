"""The second paper's reach to a new place: in the latent space and in the joint space."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from armsyn.editing import (
    Constraint,
    Effector,
    Key,
    KeyFrame,
    KeyTrajectory,
    MotionModel,
    SkeletonFigure,
    learn_model,
)
from armsyn.editing.pictures import FRONT
from armsyn.experiments.edit_tables import (
    draw,
    mean_table,
    method_tables,
    pattern_table,
    slide_verdict,
)
from armsyn.experiments.edits import Method, at_frames, begin, compare, edit_each, made_with
from armsyn.experiments.learned import Progress
from armsyn.experiments.settings import Settings
from armsyn.experiments.tables import Report
from armsyn.motion.body import BodyMotion

FRAMES, VARIANCE = 50, 0.98
HAND = Effector("JtWristRt")
BY = (0.0, 0.10, 0.0)
"""Of the hand at the last frame, m: to the person's left."""
SHOWN = "garza:ForwardMediumMid"
FEW = 16


def run(settings: Settings, folder: Path, on_progress: Progress) -> Report:
    """Move the end of captured reaches to a new place by each method.

    Parameters
    ----------
    settings : Settings
        A small budget edits two reaches, a full one all.
    folder : Path
        Where the picture goes.
    on_progress : callable

    Returns
    -------
    Report

    Raises
    ------
    CaptureError
        Captures that are not there.
    """
    clips, shown, repeats = begin("garza", SHOWN, settings)
    others = _others(clips, shown)
    models = [_learned(others, count) for count in (FEW, len(others))]
    found = [_edited(shown, model, repeats) for model in models]
    edited = clips[:2] if settings.budget == "small" else clips
    everywhere = edit_each(
        "reaches",
        edited,
        lambda clip: _edited(clip, _learned(_others(clips, clip), len(clips) - 1), 1),
        on_progress,
    )
    tables = [pattern_table(models, _PAPER)]
    for model, methods in zip(models, found, strict=True):
        tables += method_tables(f"{SHOWN}, {len(model.names)} examples", methods, repeats)
    verdict = slide_verdict(everywhere)
    tables.append(mean_table("Every reach, from the others", everywhere, [verdict]))
    return Report(
        "reach-edit",
        "A reach to a new place (the second paper's second case)",
        made_with(settings, models, FRAMES, VARIANCE, by_m=list(BY)),
        tables,
        [draw(found[-1], FRONT, folder, "reach-edit.png")],
        [_WHAT, _LIMITS],
    )


_WHAT = (
    f"The right wrist is moved {100 * np.linalg.norm(BY):.0f} cm to the left at the last of"
    f" {FRAMES} frames. The edited reach is never among the examples. By a key-frame, one change of"
    " the coefficients holds for the whole motion; by a key-trajectory the displacement grows from"
    " nothing at the first frame by 3 u^2 - 2 u^3 and every frame is solved. Feet are not"
    " constrained, as in the paper."
)
_LIMITS = (
    "One person's free reaches from standing rest; the paper's own 16 reaches are not public."
    " Captured toes slide before any edit, as the tables say."
)
_PAPER = "The paper: 16 reaches of 50 frames, 98 %, 15 components: as many as 16 reaches have."


def _others(clips: Sequence[BodyMotion], without: BodyMotion) -> list[BodyMotion]:
    return [clip for clip in clips if clip is not without]


def _learned(clips: Sequence[BodyMotion], count: int) -> MotionModel:
    """Learn from so many of the clips, evenly from the table's order."""
    rows = np.round(np.linspace(0, len(clips) - 1, count)).astype(int)
    return learn_model([clips[row] for row in rows], frames=FRAMES, variance=VARIANCE)


def _edited(clip: BodyMotion, model: MotionModel, repeats: int) -> list[Method]:
    assert isinstance(model.figure, SkeletonFigure)  # noqa: S101 - learned from bodies
    last = FRAMES - 1
    keys: list[Constraint] = [KeyFrame(HAND, last, by=BY)]
    paths: list[Constraint] = [KeyTrajectory(HAND, (Key(last, BY),), True, ease_in=last)]
    return compare(at_frames(clip, model.figure, FRAMES), model, keys, paths, repeats)
