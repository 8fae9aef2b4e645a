"""Synergies in the experiment `anytarget`: by fields over the workspace, and the bound, fitted to
the very reaches that it plays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from armsyn.experiments.anytarget_baselines import predicted
from armsyn.motion import FloatArray
from armsyn.planning.ending import ended_at
from armsyn.planning.examples import PHASES, Examples
from armsyn.planning.hull import Hull
from armsyn.planning.movement_time import learn_movement_time
from armsyn.planning.prediction import Predicted
from armsyn.planning.synergy_atlas import SynergyPredictor
from armsyn.planning.synergy_fitting import SynergyFits
from armsyn.synergy.phased import PhasedSynergies

MODEL = "D"
RIDGE_M = 0.1
"""Pull of every set towards the common one, not chosen anew for each fold."""


def synergy_fits(examples: Examples) -> SynergyFits:
    """Prepare fits of S_D, which all fields share: their common set is fitted once."""
    family = PhasedSynergies(examples.chain, MODEL, float(examples.durations.mean()))
    return SynergyFits.of(examples, family)


def synergies_by(fits: SynergyFits, field: str) -> SynergyPredictor:
    """Lay parameters over the workspace.

    Parameters
    ----------
    fits : SynergyFits
    field : str
        Of `armsyn.planning.synergy_fitting.FIELDS`.

    Returns
    -------
    SynergyPredictor
        As `armsyn.planning.synergy_atlas.learn_synergies` learns it with that ridge.
    """
    return SynergyPredictor(
        field,
        fits.family,
        fits.field(field, RIDGE_M),
        fits.places.min(axis=0),
        fits.places.max(axis=0),
        learn_movement_time(fits.examples),
        Hull.of(fits.examples.targets),
    )


@dataclass(frozen=True, eq=False)
class OwnSynergy:
    """One set of parameters for every reach, in the mean time of those it was fitted to.

    Parameters
    ----------
    family : PhasedSynergies
    coordinates : array, shape (P,)
    duration : float
        s.
    """

    family: PhasedSynergies
    coordinates: FloatArray
    duration: float

    def predict(self, starts: FloatArray, targets: FloatArray) -> Predicted:
        """Predict reaches; see `armsyn.planning.prediction.Predictor`."""
        chain, count = self.family.chain, len(targets)
        coordinates = self.coordinates[None].repeat(count, axis=0)
        paths = self.family.play(coordinates, starts, targets, PHASES)
        angles, _ = ended_at(chain, paths, targets)
        return predicted(chain, angles, np.full(count, self.duration), targets)


def own_synergy(examples: Examples) -> OwnSynergy:
    """Fit one set of S_D to all examples, however few or close together.

    Parameters
    ----------
    examples : Examples

    Returns
    -------
    OwnSynergy
    """
    fits = synergy_fits(examples)
    return OwnSynergy(fits.family, fits.common, fits.family.duration)
