"""Predict reaches to any target by synergies: parameters over the workspace, then a roll-out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import InputError
from armsyn.kinematics import SerialChain
from armsyn.planning.ending import ended_at
from armsyn.planning.examples import PHASES, Examples
from armsyn.planning.hull import Hull
from armsyn.planning.linear import check_enough
from armsyn.planning.movement_time import MovementTime, learn_movement_time
from armsyn.planning.postures import tips
from armsyn.planning.prediction import Predicted, Predictor, checked_reaches
from armsyn.planning.synergy_fitting import FIELDS, SynergyFits
from armsyn.planning.workspace import Field
from armsyn.synergy.phased import PhasedSynergies

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class SynergyPredictor:
    """Predicts by a roll-out with the parameters of the place, its end led to the target.

    Gains are bounded below whatever the field gives, so every roll-out converges by itself, too.

    Parameters
    ----------
    name : str
        ``synergy``, or ``synergy-`` and its field.
    family : PhasedSynergies
    field : Field
        Its coordinates over places.
    lower, upper : array, shape (k,)
        Of the captured places, m: beyond them the parameters are those at the border. k is 3 (where
        the hand ends), or 6 where captures begin at several places (and where it starts).
    time : MovementTime
    hull : Hull
        Of the captured targets.
    """

    name: str
    family: PhasedSynergies
    field: Field
    lower: FloatArray
    upper: FloatArray
    time: MovementTime
    hull: Hull

    @property
    def chain(self) -> SerialChain:
        """What moves."""
        return self.family.chain

    def coordinates(self, starts: FloatArray, targets: FloatArray) -> FloatArray:
        """Return parameters for reaches, in the family's coordinates and within their bounds.

        Parameters
        ----------
        starts : array, shape (M, n)
        targets : array, shape (M, 3)

        Returns
        -------
        array, shape (M, P)
        """
        places = np.concatenate([targets, tips(self.chain, starts)], axis=1)[:, : self.lower.size]
        found = self.field(np.clip(places, self.lower, self.upper))
        return np.clip(found, self.family.lower, self.family.upper)

    def predict(self, starts: FloatArray, targets: FloatArray) -> Predicted:
        """Predict M reaches; see `armsyn.planning.prediction.Predictor`."""
        first, goals = checked_reaches(self.chain, starts, targets)
        free = self.family.play(self.coordinates(first, goals), first, goals, PHASES)
        free[:, 0] = first
        angles, errors = ended_at(self.chain, free, goals)
        durations = self.time(self.chain, first, goals)
        return Predicted(angles, durations, self.hull.outside(goals), errors)


def learn_synergies(
    examples: Examples, *, field: str = "map", model: str = "D", ridge: float | None = None
) -> SynergyPredictor:
    """Learn synergies over the workspace.

    Parameters
    ----------
    examples : Examples
        Eight at least, to targets that are not all in one plane.
    field : str
        Of `armsyn.planning.synergy_fitting.FIELDS`.
    model : {"C", "D"}
    ridge : float or None
        m: what a set pays for lying a whole range away from the common one; when None chosen by
        leaving one place out after the other.

    Returns
    -------
    SynergyPredictor

    Raises
    ------
    CaptureError
        Too few examples, or all in one plane.
    InputError
        Unknown field or model.
    """
    if field not in FIELDS:
        raise InputError(f"no field {field!r}; known: {', '.join(FIELDS)}")
    check_enough(examples)
    hull = Hull.of(examples.targets)
    family = PhasedSynergies(examples.chain, model, float(examples.durations.mean()))
    fits = SynergyFits.of(examples, family)
    return SynergyPredictor(
        "synergy" if field == "map" else f"synergy-{field}",
        family,
        fits.field(field, ridge),
        fits.places.min(axis=0),
        fits.places.max(axis=0),
        learn_movement_time(examples),
        hull,
    )


SYNERGY_PREDICTORS: dict[str, Callable[..., Predictor]] = {
    "synergy" if field == "map" else f"synergy-{field}": partial(learn_synergies, field=field)
    for field in FIELDS
}
"""By the names of `armsyn.planning.predictor.learn_predictor`."""
