"""The second paper's higher jump: the root raised at the apex."""

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
    SolverOptions,
    learn_model,
)
from armsyn.editing.pictures import SIDE
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
from armsyn.experiments.tables import Column, Report, Table, Value, centimetres
from armsyn.motion.body import BodyMotion

FRAMES, APEX, VARIANCE = 26, 15, 0.95
ROOT = Effector("JtRoot")
BY = (0.0, 0.0, 0.10)
"""Of the root at the apex, m."""
PAPER_XI = 10.0
SHOWN = "jump:JumpForwardLowMid"
_TOES = ("JtToeRt", "JtToeLf")
_STANDS_M = 0.03
_STILL_M_S = 0.3
"""A toe no higher than this above its lowest place, and no faster, stands on the ground."""
_JUMP_COLUMNS = (
    Column("method", "method"),
    centimetres("crouch", "crouch"),
    centimetres("lifted", "lifted"),
    centimetres("below", "below ground"),
    centimetres("end", "end moved"),
)


def run(settings: Settings, folder: Path, on_progress: Progress) -> Report:
    """Raise captured jumps by each method.

    Parameters
    ----------
    settings : Settings
        A small budget edits two jumps, a full one all.
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
    clips, shown, repeats = begin("jump", SHOWN, settings)
    model = _learned(clips, shown)
    found = _edited(shown, model, repeats)
    as_paper = _edited(shown, model, repeats, as_in_paper(PAPER_XI))
    edited = clips[:2] if settings.budget == "small" else clips
    everywhere = edit_each(
        "jumps", edited, lambda clip: _edited(clip, _learned(clips, clip), 1), on_progress
    )
    return Report(
        "jump",
        "A higher jump (the second paper's third case)",
        made_with(settings, [model], FRAMES, VARIANCE, by_m=list(BY), xi=PAPER_XI),
        [
            pattern_table([model], _PAPER),
            *method_tables(SHOWN, found, repeats),
            *method_tables(f"{SHOWN}, the paper's xi", as_paper, repeats),
            Table(f"{SHOWN}: the jump", _JUMP_COLUMNS, jump_rows(found), [_JUMP_NOTE]),
            mean_table("Every jump, from the others", everywhere, [slide_verdict(everywhere)]),
        ],
        [draw(found, SIDE, folder, "jump.png", 3.5)],
        [_WHAT, _LIMITS],
    )


_WHAT = (
    f"The root is raised by {100 * BY[2]:.0f} cm at the apex, frame {APEX} of {FRAMES} from 0. The"
    " edited jump is never among the examples. By a key-frame, one change of the coefficients"
    " holds for the whole motion; by a key-trajectory the height is eased in from the first frame"
    " and out to the last, and every frame is solved."
)
_LIMITS = (
    "One person's 24 standing jumps, in five directions and three heights; the paper's are 89"
    " walking jumps of six people, which are not public."
)
_PAPER = "The paper: 89 walking jumps of 26 frames, 95 %, 30 components."
_JUMP_NOTE = (
    "crouch: how far the root goes down before the jump; lifted: the most that a toe is raised"
    " above where it was, of the frames in which it stood before the edit; below ground: the"
    " most that a toe goes below its lowest place before the edit; end moved: of the root, at the"
    " last frame."
)


def _learned(clips: Sequence[BodyMotion], without: BodyMotion) -> MotionModel:
    others = [clip for clip in clips if clip is not without]
    return learn_model(others, frames=FRAMES, variance=VARIANCE)


def _edited(
    clip: BodyMotion, model: MotionModel, repeats: int, options: SolverOptions = OPTIONS
) -> list[Method]:
    assert isinstance(model.figure, SkeletonFigure)  # noqa: S101 - learned from bodies
    keys: list[Constraint] = [KeyFrame(ROOT, APEX, by=BY)]
    after = FRAMES - 1 - APEX
    paths: list[Constraint] = [
        KeyTrajectory(ROOT, (Key(APEX, BY),), True, ease_in=APEX, ease_out=after)
    ]
    jump = at_frames(clip, model.figure, FRAMES)
    return compare(jump, model, keys, paths, repeats, options)


def jump_rows(methods: Sequence[Method]) -> list[tuple[Value, ...]]:
    """Return crouch and ground contact before and after each method's edit, m.

    Parameters
    ----------
    methods : sequence of Method
        Of one jump.

    Returns
    -------
    list of tuple
        The first row is the jump before the edit.
    """
    bodies = methods[0].result.figure.tree.bodies
    toes = [bodies.index(name) for name in _TOES]
    before = methods[0].result.positions[0]
    ground = before[:, toes, 2].min(axis=0)
    time = methods[0].result.original.time
    speed = np.linalg.norm(np.gradient(before[:, toes], time, axis=0), axis=-1)
    stands = (before[:, toes, 2] < ground + _STANDS_M) & (speed < _STILL_M_S)
    rows: list[tuple[Value, ...]] = [("before the edit", _crouch(before[:, 0, 2]), 0.0, 0.0, 0.0)]
    for method in methods:
        after = method.result.positions[1]
        raised = np.where(stands, after[:, toes, 2] - before[:, toes, 2], -np.inf)
        rows.append(
            (
                method.name,
                _crouch(after[:, 0, 2]),
                max(0.0, float(raised.max())),
                max(0.0, float((ground - after[:, toes, 2]).max())),
                float(np.linalg.norm(after[-1, 0] - before[-1, 0])),
            )
        )
    return rows


def _crouch(height: np.ndarray) -> float:
    return float(height[0] - height[: APEX + 1].min())
