"""Learning: a synergy for each captured reach, and a judgement of how well it fits."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Callable
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import CaptureError, InputError, by_interrupt
from armsyn.ik import OPTIMISERS
from armsyn.motion.captures import Capture
from armsyn.scoring import normalised_speed
from armsyn.synergy.fitting import Fitted, fit_reach
from armsyn.synergy.judging import Judge
from armsyn.synergy.library import LearnedReach, SynergyLibrary, SynergySet
from armsyn.synergy.models import MODELS
from armsyn.synergy.options import LearningOptions
from armsyn.synergy.parallel import checked_workers, each
from armsyn.synergy.training import Training, prepare

FloatArray = NDArray[np.float64]
Progress = Callable[[str, int, int, str], None]
Key = tuple[str, str, str]
"""A reach's name, an optimiser and a model."""

LEARNER_VERSION = 1
"""Raised with every change of learning that finds other parameters: a library of another version is
not resumed."""

_EVALUATION_S = 1e-4
_WORTH_S = 4.0
"""Work that is worth a process of its own, which takes a good second to start."""


@dataclass(frozen=True)
class _Job:
    arm: ArmDescription
    training: Training
    ik: str
    model: str
    options: LearningOptions


@dataclass(frozen=True)
class Fits:
    """One optimiser and model, learned for every reach by itself.

    Parameters
    ----------
    fitted : tuple of Fitted
        In the order of the reaches.
    """

    fitted: tuple[Fitted, ...]

    @property
    def parameters(self) -> FloatArray:
        """The best vectors, shape (reaches, parameters)."""
        return np.array([each_reach.parameters for each_reach in self.fitted])

    @property
    def scores(self) -> FloatArray:
        """Their distances, shape (reaches,), m: training errors."""
        return np.array([each_reach.score for each_reach in self.fitted])

    def best_after(self, evaluations: int) -> FloatArray:
        """Return the best distances after so many roll-outs a reach, shape (reaches,), m."""
        return np.array([each_reach.best_after(evaluations) for each_reach in self.fitted])


def learn(
    arm: ArmDescription,
    selection: str,
    captures: list[Capture],
    options: LearningOptions,
    on_progress: Progress | None = None,
    resumed: SynergyLibrary | None = None,
    on_fitted: Callable[[Key, Fitted], None] | None = None,
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
    resumed : SynergyLibrary, optional
        Of the same arm, captures and options: what it holds is kept, only the rest is learned.
    on_fitted : callable, optional
        Called with the key and what a learner found, for each reach, optimiser and model.

    Returns
    -------
    SynergyLibrary
        ``complete`` is False when Ctrl-C ended it: then it holds what was finished. Where nothing
        was, ``KeyboardInterrupt`` is raised again.

    Raises
    ------
    CaptureError
        When no capture can be used.
    InputError
        An option that is not usable, or `resumed` does not belong to these options.
    """
    trainings, left_out = _usable(arm, captures, options.rate_hz)
    library = SynergyLibrary(
        schema="armsyn-synergies-1",
        arm=arm.name,
        joint_names=arm.joint_names,
        captures=selection,
        inputs_sha256=inputs_hash(arm, trainings, options),
        seed=options.seed,
        rate_hz=options.rate_hz,
        lambdas={ik: options.rate_of(ik) for ik in options.iks},
        stable_gains=options.stable,
        complete=True,
        reaches=(),
        left_out=left_out,
    )
    found = _kept(library, resumed)
    jobs = [
        _Job(arm, training, ik, model, options)
        for ik, model, training in itertools.product(options.iks, options.models, trainings)
        if (training.capture.name, ik, model) not in found
    ]

    def told(done: int, key: Key, learned: SynergySet, fitted: Fitted) -> None:
        found[key] = learned
        if on_fitted is not None:
            on_fitted(key, fitted)
        if on_progress is not None:
            name, ik, model = key
            said = f"S_{model} {ik} {name}: {learned.distance_m * 100:.2f} cm"
            on_progress("learning", done, len(jobs), said)

    complete = _learn_jobs(jobs, _workers(jobs, options), told)
    if not found:
        raise KeyboardInterrupt
    # in an order of its own, whoever finished first and whatever was there before
    kinds = {(ik, model) for _, ik, model in found}
    pairs = [pair for pair in itertools.product(OPTIMISERS, MODELS) if pair in kinds]
    complete &= len(found) == len(trainings) * len(pairs)
    reaches = []
    for training in trainings:
        keys = [(training.capture.name, *pair) for pair in pairs]
        sets = tuple(found[key] for key in keys if key in found)
        if sets:
            reaches.append(_learned_reach(training, sets))
    return msgspec.structs.replace(
        library,
        lambdas={**(resumed.lambdas if resumed else {}), **library.lambdas},
        complete=complete,
        reaches=tuple(reaches),
    )


def fit(
    arm: ArmDescription,
    trainings: list[Training],
    ik: str,
    model: str,
    options: LearningOptions,
    on_progress: Progress | None = None,
) -> Fits:
    """Learn one optimiser and model for every reach by itself.

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
    Fits
    """
    jobs = [_Job(arm, training, ik, model, options) for training in trainings]
    found: dict[int, Fitted] = {}
    for number, fitted in each(_fitted, jobs, _workers(jobs, options)):
        found[number] = fitted
        if on_progress is not None:
            mean = 100 * np.mean([done.score for done in found.values()])
            on_progress(f"S_{model} {ik}", len(found), len(jobs), f"mean {mean:.2f} cm")
    return Fits(tuple(found[number] for number in range(len(jobs))))


def _workers(jobs: list[_Job], options: LearningOptions) -> int:
    worth = int(len(jobs) * options.evaluations * _EVALUATION_S / _WORTH_S)
    return checked_workers(options.workers, worth)


def _fitted(job: _Job) -> Fitted:
    return fit_reach(job.arm, job.training, job.ik, job.model, job.options)


def _judged(job: _Job) -> tuple[SynergySet, Fitted]:
    fitted = _fitted(job)
    judge = Judge(job.arm, job.training, _profile(job.training), job.ik, job.model, job.options)
    return judge.verdict(fitted), fitted


def _profile(training: Training) -> FloatArray:
    return normalised_speed(training.time, training.landmarks[:, -1])


def _learn_jobs(
    jobs: list[_Job], workers: int, told: Callable[[int, Key, SynergySet, Fitted], None]
) -> bool:
    """Tell of every job that is done; return False when Ctrl-C ended it."""
    try:
        for done, (number, (learned, fitted)) in enumerate(each(_judged, jobs, workers), 1):
            job = jobs[number]
            told(done, (job.training.capture.name, job.ik, job.model), learned, fitted)
    except (KeyboardInterrupt, SystemError) as error:
        if not by_interrupt(error):
            raise
        return False
    return True


def _kept(library: SynergyLibrary, resumed: SynergyLibrary | None) -> dict[Key, SynergySet]:
    """Return what a resumed library holds, once it was found to belong to the same learning."""
    if resumed is None:
        return {}
    for name, said in _BELONGING.items():
        if getattr(library, name) != getattr(resumed, name):
            raise InputError(f"cannot be resumed, for it was learned {said}: choose another --out")
    for ik, rate in library.lambdas.items():
        if resumed.lambdas.get(ik, rate) != rate:
            raise InputError(
                f"cannot be resumed, for its lambda of {ik} is {resumed.lambdas[ik]:g}/s, not"
                f" {rate:g}/s: choose another --out"
            )
    return {
        (reach.name, learned.ik, learned.model): learned
        for reach in resumed.reaches
        for learned in reach.sets
    }


_BELONGING = {
    "arm": "for another arm",
    "captures": "from other captures",
    "seed": "with another --seed",
    "rate_hz": "with another --rate",
    "stable_gains": "with other bounds",
    "inputs_sha256": "with another learner, budget, arm's description or version of the captures",
}


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


def _learned_reach(training: Training, sets: tuple[SynergySet, ...]) -> LearnedReach:
    profile = _profile(training)
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
    schedule = options.annealing if options.learner == "annealing" else None
    asked = (
        *(LEARNER_VERSION, options.stable, options.rate_hz),
        *(options.learner, options.evaluations, schedule),
    )
    digest.update(repr(asked).encode())
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
