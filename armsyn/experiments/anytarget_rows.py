"""The rows of the experiment `anytarget`: what each predicts with, and what it may learn from."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, Literal, NamedTuple, Protocol

from armsyn.experiments.anytarget_baselines import MeanReach, nearest_reach, raw_ik
from armsyn.experiments.anytarget_bells import learn_chosen
from armsyn.experiments.anytarget_primitives import dmp, promp, why_missing
from armsyn.experiments.anytarget_synergies import RIDGE_M, own_synergy, synergies_by, synergy_fits
from armsyn.motion import FloatArray
from armsyn.planning.examples import Examples
from armsyn.planning.latent import DAMPING
from armsyn.planning.prediction import Predicted
from armsyn.planning.predictor import learn_predictor

Kind = Literal["reference", "baseline", "synergy", "latent", "joined", "bound"]
Lessons = Literal["fold", "repeats", "others", "own"]
"""What a row learns from: the fold; the person's other repeats of the target; other persons'
reaches to it; all of the person's reaches to it, the predicted one among them."""


class Predicts(Protocol):
    """What a row needs of a predictor."""

    def predict(self, starts: FloatArray, targets: FloatArray) -> Predicted:
        """Predict reaches, as `armsyn.planning.prediction.Predictor` does."""


class Row(NamedTuple):
    """One way of predicting reaches."""

    key: str
    title: str
    kind: Kind
    what: str
    learn: Callable[[Any], Predicts]
    """From examples, or from what `shared` makes of them."""
    lessons: Lessons = "fold"
    shared: Callable[[Examples], Any] | None = None
    """What several rows learn from, made once for all of them."""
    tuned: str = ""
    """Which of its constants were set with the judged reaches in view; such a row is shown, but the
    best row and the verdict are taken among the others."""
    missing: Callable[[], str | None] = lambda: None
    """Says why the row cannot be had on this machine; None when it can."""

    @property
    def competes(self) -> bool:
        """Whether it predicts a target that nobody showed it: only such rows are compared."""
        return self.kind not in ("reference", "bound")


_MEAN = "mean of {}, moved to start and end, in their mean time"


_RIDGE = f"ridge {RIDGE_M:g} m, fixed over all folds"
_KERNELS = "kernels fixed where there are fewer than 12 targets"


def _learned(key: str, title: str, kind: Kind, what: str, predictor: str, tuned: str = "") -> Row:
    """Return a row of `armsyn.planning.predictor`."""
    return Row(key, title, kind, what, partial(learn_predictor, predictor), tuned=tuned)


ROWS = (
    Row(
        "floor",
        "human floor",
        "reference",
        _MEAN.format("the person's other repeats of the target"),
        MeanReach,
        "repeats",
    ),
    Row(
        "other",
        "other humans",
        "reference",
        _MEAN.format("other persons' reaches to the target"),
        MeanReach,
        "others",
    ),
    _learned(
        "linear",
        "linear",
        "baseline",
        "linear regression of the normalised motion on the target, start and end corrected",
        "linear",
    ),
    *(
        Row(
            f"raw_{ik}",
            f"raw IK, {name}",
            "baseline",
            "S_A: one gain, the best of seven on a few reaches; cut at 5 %, end corrected",
            partial(raw_ik, optimiser=ik),
        )
        for ik, name in (("jt", "J^T"), ("svd", "SVD"), ("njt", "NJ^T"))
    ),
    _learned(
        "straight",
        "straight hand + IK",
        "baseline",
        "the hand goes straight by minimum jerk, the joints by pseudo-inverse; time regressed",
        "minjerk_hand",
    ),
    _learned(
        "minjerk",
        "joint minimum jerk",
        "baseline",
        "every joint by minimum jerk to the posture of IK; time regressed",
        "minjerk",
    ),
    Row(
        "dmp",
        "DMP",
        "baseline",
        "primitive of the nearest target's mean reach, goal by IK; time of linear",
        dmp,
        missing=why_missing,
    ),
    Row(
        "promp",
        "ProMP",
        "baseline",
        "conditioned on the start, then on the end by IK; time of linear",
        promp,
        missing=why_missing,
    ),
    Row(
        "nearest_reach",
        "nearest reach",
        "baseline",
        "the nearest target's mean reach, start and end corrected; time of linear",
        nearest_reach,
    ),
    *(
        Row(
            f"synergy_{field}",
            title,
            "synergy",
            f"S_D with parameters over the workspace: {how}",
            partial(synergies_by, field=field),
            shared=synergy_fits,
            tuned=_RIDGE,
        )
        for field, title, how in (
            ("common", "synergy, common", "one set everywhere"),
            ("nearest", "synergy, nearest", "the nearest target's set"),
            ("idw", "synergy, distance", "weighted by inverse distance"),
            ("rbf", "synergy, RBF", "by thin-plate splines"),
            ("gp", "synergy, GP", "by a Gaussian process"),
            ("map", "synergy, map", "linear in the target, fitted to all reaches as one"),
        )
    ),
    _learned(
        "latent",
        "latent",
        "latent",
        "whole motions by Gaussian process, then the likeliest deviation to start and target",
        "latent",
        _KERNELS,
    ),
    Row(
        "latent_chosen",
        "latent, chosen",
        "latent",
        "latent, its kernels chosen in every fold by leaving out each of the fold's own targets;"
        f" damping {DAMPING:g} is fixed; evened into one bell where the hand would hesitate, as by"
        " the planner",
        learn_chosen,
    ),
    Row(
        "joined",
        "joined",
        "joined",
        "synergy map, and what it leaves of people's reaches added in latent space",
        partial(learn_predictor, "joined", ridge=RIDGE_M),
        tuned=f"{_RIDGE}; {_KERNELS}",
    ),
    Row(
        "own",
        "bound: own synergy",
        "bound",
        "one S_D set fitted to all of the person's reaches to the target, this one too",
        own_synergy,
        "own",
    ),
)
