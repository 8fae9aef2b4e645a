"""What the second paper's cases share: one edit by LPIK and by joint-space PIK."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from armsyn.editing import (
    Constraint,
    Editor,
    EditResult,
    MotionModel,
    SolverOptions,
    edit_in_joint_space,
    load_clips,
)
from armsyn.experiments.learned import Progress
from armsyn.experiments.settings import Settings
from armsyn.motion.body import BodyMotion

KEY_FRAME, LATENT_PATH, JOINT_PATH = "LPIK key-frame", "LPIK key-trajectory", "PIK key-trajectory"
OPTIONS = SolverOptions(tolerance=1e-5)
"""Of every method: the same tolerance, m, and at most 100 iterations a frame, as in the paper."""


def as_in_paper(xi: float) -> SolverOptions:
    """Return the paper's settings: its damping, centimetres, components that are not whitened."""
    return dataclasses.replace(SolverOptions.paper(xi), tolerance=OPTIONS.tolerance)


class Likeness(NamedTuple):
    """How a whole clip looks to a pattern.

    Attributes
    ----------
    largest : float
        Largest whitened coefficient: of any frame, or of its projection in the joint space.
    nearest : (str, float)
        The example nearest to it, and how far it is, sigma.
    outside_m : float
        Mean distance of its bodies from what the pattern can say of it, m.
    """

    largest: float
    nearest: tuple[str, float]
    outside_m: float


class Method(NamedTuple):
    """One way of making an edit.

    Attributes
    ----------
    name : str
    result : EditResult
    seconds : float
    before, after : Likeness
        Of the clip and of the edited one.
    """

    name: str
    result: EditResult
    seconds: float
    before: Likeness
    after: Likeness


def made_with(
    settings: Settings, models: Sequence[MotionModel], frames: int, variance: float, **more: object
) -> dict[str, object]:
    """All that the figures of a case depend on, for its JSON; `more` is the case's own."""
    return {
        "seed": settings.seed,
        "frames": frames,
        "variance": variance,
        "radians_per_metre": models[0].radians_per_metre,
        **more,
        "inputs_sha256": {str(len(model.names)): model.inputs_sha256 for model in models},
    }


def begin(case: str, shown: str, settings: Settings) -> tuple[list[BodyMotion], BodyMotion, int]:
    """Clips of a case, the one of the pictures, and how often an edit is timed."""
    clips = load_clips(case)
    repeats = 1 if settings.budget == "small" else 5
    return clips, next(clip for clip in clips if clip.source == shown), repeats


def compare(
    clip: BodyMotion,
    model: MotionModel,
    keys: Sequence[Constraint],
    paths: Sequence[Constraint],
    repeats: int,
    options: SolverOptions = OPTIONS,
) -> list[Method]:
    """Make one edit by LPIK with a key-frame and with a path, and by joint-space PIK with the path.

    Parameters
    ----------
    clip : BodyMotion
    model : MotionModel
    keys, paths : sequence of Constraint
        The same goal as key-frames and as key-trajectories.
    repeats : int
        Runs that are timed.
    options : SolverOptions
        Of every method.

    Returns
    -------
    list of Method
    """
    ways: dict[str, Callable[[], EditResult]] = {
        KEY_FRAME: lambda: Editor(clip, model, options).edit(keys, force=True),
        LATENT_PATH: lambda: Editor(clip, model, options).edit(paths, force=True),
        JOINT_PATH: lambda: edit_in_joint_space(clip, model.figure, paths, options),
    }
    before, found = likeness(clip, model), []
    for name, way in ways.items():
        result, seconds = way(), _median_time(way, repeats)
        edited = result.clip
        assert isinstance(edited, BodyMotion)  # noqa: S101 - as the clip is
        after = likeness(edited, model)
        if result.largest_coefficient is not None:  # of any frame, where the projection is of all
            after = after._replace(largest=result.largest_coefficient)
        found.append(Method(name, result, seconds, before, after))
    return found


def edit_each(
    stage: str,
    clips: Sequence[BodyMotion],
    edit: Callable[[BodyMotion], list[Method]],
    on_progress: Progress,
) -> list[list[Method]]:
    """Edit one clip after the other.

    Parameters
    ----------
    stage : str
        For the progress.
    clips : sequence of BodyMotion
    edit : callable
        From a clip to its edits by each method.
    on_progress : callable

    Returns
    -------
    list of list of Method
    """
    found = []
    for number, clip in enumerate(clips):
        on_progress(stage, number, len(clips), clip.source)
        found.append(edit(clip))
    on_progress(stage, len(clips), len(clips), "")
    return found


def likeness(clip: BodyMotion, model: MotionModel) -> Likeness:
    """Set a clip of the pattern's number of frames beside its projection on the pattern."""
    coefficients = model.coefficients(clip)
    tree = model.figure.tree
    away = tree.positions(model.figure.poses(clip)) - tree.positions(model.poses(coefficients))
    return Likeness(
        float(np.abs(coefficients).max()),
        model.nearest_example(coefficients),
        float(np.linalg.norm(away, axis=-1).mean()),
    )


def _median_time(way: Callable[[], Any], repeats: int) -> float:
    taken = []
    for _ in range(repeats):
        began = time.perf_counter()
        way()
        taken.append(time.perf_counter() - began)
    return float(np.median(taken))
