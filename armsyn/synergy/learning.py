"""Learning: a synergy for each captured reach, and a judgement of how well it fits."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Callable

import msgspec
import numba
import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import CaptureError, InputError
from armsyn.ik import optimiser_settings
from armsyn.kernels import rollout as kernels
from armsyn.kernels.rollout import Captures, Timing
from armsyn.motion.captures import Capture
from armsyn.scoring import normalised_speed
from armsyn.synergy.annealing import Annealed, anneal
from armsyn.synergy.judging import Judge
from armsyn.synergy.library import LearnedReach, SynergyLibrary
from armsyn.synergy.models import parameter_bounds, synergies
from armsyn.synergy.options import LearningOptions
from armsyn.synergy.training import Training, as_captures, prepare

FloatArray = NDArray[np.float64]
Progress = Callable[[str, int, int, str], None]

_CORES = numba.get_num_threads()


def learn(
    arm: ArmDescription,
    selection: str,
    captures: list[Capture],
    options: LearningOptions,
    on_progress: Progress | None = None,
) -> SynergyLibrary:
    """Learn synergies of an arm from captured reaches.

    Parameters
    ----------
    arm : ArmDescription
    selection : str
        Where the captures come from, for the record.
    captures : list of Capture
    options : LearningOptions
    on_progress : callable, optional
        Called with what is done, how far it is, of how much, and a remark.

    Returns
    -------
    SynergyLibrary
        ``complete`` is False when Ctrl-C ended it: then it holds the best so far. Where there is
        nothing yet to keep, ``KeyboardInterrupt`` is raised again.

    Raises
    ------
    CaptureError
        When no capture can be used.
    InputError
        An option that is not usable.
    """
    trainings, left_out = _usable(arm, captures, options.rate_hz)
    _set_workers(options.workers)
    found: dict[tuple[str, str], Annealed] = {}
    complete = True
    for ik, model in itertools.product(options.iks, options.models):
        try:
            annealed = fit(arm, trainings, ik, model, options, on_progress)
        except KeyboardInterrupt:  # before anything of this pair was scored
            complete = False
        else:
            complete = not annealed.interrupted
            found[ik, model] = annealed
        if not complete:
            break
    if not found:
        raise KeyboardInterrupt
    reaches = []
    for row, training in enumerate(trainings):
        try:
            if on_progress is not None:
                on_progress("judging", row + 1, len(trainings), "")
            reach = _learned_reach(arm, training, row, found, options, quick=not complete)
        except KeyboardInterrupt:
            complete = False
            reach = _learned_reach(arm, training, row, found, options, quick=True)
        reaches.append(reach)
    return SynergyLibrary(
        schema="armsyn-synergies-1",
        arm=arm.name,
        joint_names=arm.joint_names,
        captures=selection,
        inputs_sha256=inputs_hash(arm, trainings, options),
        seed=options.seed,
        rate_hz=options.rate_hz,
        lambdas={ik: options.rate_of(ik) for ik in options.iks},
        stable_gains=options.stable,
        complete=complete,
        reaches=tuple(reaches),
        left_out=left_out,
    )


def fit(
    arm: ArmDescription,
    trainings: list[Training],
    ik: str,
    model: str,
    options: LearningOptions,
    on_progress: Progress | None = None,
) -> Annealed:
    """Anneal one optimiser and model on all reaches side by side.

    Parameters
    ----------
    arm : ArmDescription
    trainings : list of Training
    ik, model : str
    options : LearningOptions
    on_progress : callable, optional
        As in `learn`.

    Returns
    -------
    Annealed
        Scores are the paper's distance, m.
    """
    lower, upper = parameter_bounds(model, arm.chain.dof, stable=options.stable)
    schedule = options.schedule

    def report(generation: int, distance: float) -> None:
        if on_progress is not None:
            said = f"mean best {distance * 100:.2f} cm"
            on_progress(f"S_{model} {ik}", generation, schedule.max_generations, said)

    return anneal(
        _scorer(arm, as_captures(arm, trainings), ik, model, options),
        [training.capture.name for training in trainings],
        lower,
        upper,
        schedule=schedule,
        seed=options.seed,
        on_generation=report,
    )


def _scorer(
    arm: ArmDescription, captures: Captures, ik: str, model: str, options: LearningOptions
) -> Callable[[FloatArray], FloatArray]:
    settings = optimiser_settings(ik)
    timing = Timing(options.rate_of(ik), 1.0 / options.rate_hz, 0.0, np.inf)

    def score(parameters: FloatArray) -> FloatArray:
        motions, population, count = parameters.shape
        lanes = synergies(model, arm.chain.dof, parameters.reshape(-1, count))
        result = np.empty(motions * population)
        which = np.repeat(np.arange(motions), population)
        kernels.distance_lanes(arm.chain.arrays, settings, lanes, timing, captures, which, result)
        return result.reshape(motions, population)

    return score


def _usable(
    arm: ArmDescription, captures: list[Capture], rate_hz: float
) -> tuple[list[Training], dict[str, str]]:
    trainings: list[Training] = []
    left_out: dict[str, str] = {}
    for capture in captures:
        try:
            trainings.append(prepare(arm, capture, rate_hz))
        except CaptureError as error:
            left_out[capture.name] = str(error)
    if not trainings:
        first = next(iter(left_out.values()), "none given")
        raise CaptureError(f"none of {len(captures)} captures can be used: {first}")
    return trainings, left_out


def _set_workers(workers: int | None) -> None:
    most = _CORES
    if workers is not None and not 1 <= workers <= most:
        raise InputError(f"workers must be between 1 and {most} on this machine, got {workers}")
    numba.set_num_threads(workers or most)


def _learned_reach(
    arm: ArmDescription,
    training: Training,
    row: int,
    found: dict[tuple[str, str], Annealed],
    options: LearningOptions,
    *,
    quick: bool,
) -> LearnedReach:
    profile = normalised_speed(training.time, training.landmarks[:, -1])
    sets = tuple(
        Judge(arm, training, profile, ik, model, options).verdict(annealed, row, quick=quick)
        for (ik, model), annealed in found.items()
    )
    return LearnedReach(
        name=training.capture.name,
        kind="reach" if training.capture.kind == "reach" else "return",
        source=training.capture.source,
        start_m=_triple(training.landmarks[0, -1]),
        target_m=_triple(training.target),
        duration_s=float(training.time[-1]),
        start_residual_m=round(training.start_residual, 6),
        speed_profile=tuple(np.round(profile / profile.max(), 4).tolist()),
        sets=sets,
    )


def _triple(values: FloatArray) -> tuple[float, float, float]:
    x, y, z = np.round(values, 6).tolist()
    return x, y, z


def inputs_hash(arm: ArmDescription, trainings: list[Training], options: LearningOptions) -> str:
    """Hash of the reaches, the options and what learning looks at of the arm."""
    digest = hashlib.sha256(_looked_at(arm))
    for training in trainings:
        digest.update(training.capture.name.encode())
        digest.update(np.round(training.landmarks, 9).tobytes())
    digest.update(repr((options.stable, options.rate_hz, options.schedule)).encode())
    return digest.hexdigest()


def _looked_at(arm: ArmDescription) -> bytes:
    """Encode what learning looks at of a description: neither servos nor masses nor shapes."""
    document = msgspec.to_builtins(arm)
    document = {key: document[key] for key in ("name", "joint", "tip", "facing")}
    document["landmarks"] = arm.landmarks
    del document["tip"]["mass"]
    for joint in document["joint"]:
        for unseen in ("link", "shape", "max_jerk"):
            joint.pop(unseen, None)
    return msgspec.json.encode(document)
