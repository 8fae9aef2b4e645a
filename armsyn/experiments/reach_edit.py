"""The second paper's reach to a new place: in the latent space and in the joint space."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
    SolverOptions,
    learn_model,
)
from armsyn.editing.pictures import FRONT
from armsyn.editing.sampling import at_frames
from armsyn.experiments.edit_tables import (
    draw,
    mean_table,
    method_tables,
    pattern_table,
    slide_verdict,
)
from armsyn.experiments.edits import (
    OPTIONS,
    Method,
    as_in_paper,
    begin,
    compare,
    edit_each,
    made_with,
)
from armsyn.experiments.learned import Progress
from armsyn.experiments.settings import Settings
from armsyn.experiments.tables import Report
from armsyn.motion import FloatArray
from armsyn.motion.body import BodyMotion

FRAMES, VARIANCE = 50, 0.98
HAND = Effector("JtWristRt")
BY = (0.0, 0.10, 0.0)
"""Of the hand at the last frame, m: to the person's left."""
SHOWN = "garza:ForwardMediumMid"
FEW = 16
PAPER_XI = 10.0


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
    found = {count: _edited(clips, shown, count, repeats) for count in _counts(clips)}
    models = [learned(clips, shown, count) for count in found]
    as_paper = _edited(clips, shown, FEW, repeats, as_in_paper(PAPER_XI))
    tables = [pattern_table(models, _PAPER)]
    for count, methods in found.items():
        tables += method_tables(f"{SHOWN}, {count} examples", methods, repeats)
    tables += method_tables(f"{SHOWN}, {FEW} examples, the paper's xi", as_paper, repeats)
    edited = clips[:2] if settings.budget == "small" else clips
    for count in found:
        everywhere = edit_each(
            f"reaches, {count} examples", edited, _each(clips, count), on_progress
        )
        title = f"Every reach, from {count} others"
        tables.append(mean_table(title, everywhere, [slide_verdict(everywhere)]))
    return Report(
        "reach-edit",
        "A reach to a new place (the second paper's second case)",
        made_with(settings, models, FRAMES, VARIANCE, by_m=list(BY), xi=PAPER_XI),
        tables,
        [draw(found[FEW], FRONT, folder, "reach-edit.png")],
        [_WHAT, _WHY, _LIMITS],
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
_WHY = (
    "Why feet slide more from all others than from 16 near ones: exponential maps of legs that"
    " stand are mixed linearly, and reaches to all sides, high and to the floor, are far from each"
    " other, so that even their mean slides its feet."
)
_PAPER = "The paper: 16 reaches of 50 frames, 98 %, 15 components: as many as 16 reaches have."


def _counts(clips: Sequence[BodyMotion]) -> tuple[int, int]:
    return FEW, len(clips) - 1


def _each(clips: Sequence[BodyMotion], count: int) -> Callable[[BodyMotion], list[Method]]:
    return lambda clip: _edited(clips, clip, count, 1)


def learned(clips: Sequence[BodyMotion], edited: BodyMotion, count: int) -> MotionModel:
    """Learn from so many of the clips, not the edited one, whose hands end nearest to its goal."""
    goal = hand_end(edited) + BY
    others = [clip for clip in clips if clip is not edited]
    nearest = sorted(others, key=lambda clip: float(np.linalg.norm(hand_end(clip) - goal)))
    return learn_model(nearest[:count], frames=FRAMES, variance=VARIANCE)


def hand_end(clip: BodyMotion) -> FloatArray:
    """Return where the hand ends, shape (3,), m."""
    body = clip.skeleton.index(HAND.body)
    return np.asarray(clip.positions()[-1, body])


def _edited(
    clips: Sequence[BodyMotion],
    clip: BodyMotion,
    count: int,
    repeats: int,
    options: SolverOptions = OPTIONS,
) -> list[Method]:
    model, last = learned(clips, clip, count), FRAMES - 1
    assert isinstance(model.figure, SkeletonFigure)  # noqa: S101 - learned from bodies
    keys: list[Constraint] = [KeyFrame(HAND, last, by=BY)]
    paths: list[Constraint] = [KeyTrajectory(HAND, (Key(last, BY),), True, ease_in=last)]
    reach = at_frames(clip, model.figure, FRAMES)
    return compare(reach, model, keys, paths, repeats, options)
