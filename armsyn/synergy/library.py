"""The learned synergies of an arm: ``<arm>.synergies.json`` and what is looked up in it."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from armsyn.errors import DescriptionError, InputError
from armsyn.kernels.rollout import Synergies
from armsyn.motion.formats.files import replacing
from armsyn.synergy.models import parameter_names, synergies

FloatArray = NDArray[np.float64]

MAXIMUM_BYTES = 50_000_000
PROFILE_SAMPLES = 101


class SynergySet(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Parameters learned for one reach with one optimiser and model, and how well they fit.

    Attributes
    ----------
    ik, model : str
        Optimiser and synergy model.
    parameters : tuple of float
        In the order of `armsyn.synergy.models.parameter_names`.
    distance_m : float
        The paper's distance to the capture: a training error, for it was minimised.
    speed_r : float
        Correlation of the hand's normalised speed with the captured one.
    misfit : str
        Why this set is not used to plan reaches; empty when it is.
    """

    ik: str
    model: str
    parameters: tuple[float, ...]
    distance_m: float
    speed_r: float
    misfit: str = ""


class LearnedReach(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One captured reach with the sets that were learned from it.

    Attributes
    ----------
    name : str
        The capture, such as ``garza:ForwardHigh``.
    kind : {"reach", "return"}
    source : str
        Set, file and frames of the capture.
    start_m, target_m : 3-tuple of float
        Hand at the start and at the end, arm base frame, m.
    duration_s : float
        Of the capture.
    start_residual_m : float
        Mean distance of the fitted first posture's landmarks to the captured ones.
    speed_profile : tuple of 101 float
        Captured hand speed from onset to offset over normalised time, as a share of its peak.
    sets : tuple of SynergySet
    """

    name: str
    kind: Literal["reach", "return"]
    source: str
    start_m: tuple[float, float, float]
    target_m: tuple[float, float, float]
    duration_s: float
    start_residual_m: float
    speed_profile: tuple[float, ...]
    sets: tuple[SynergySet, ...]

    def set_for(self, ik: str, model: str) -> SynergySet | None:
        """Return the set of an optimiser and model, or None."""
        return next((s for s in self.sets if (s.ik, s.model) == (ik, model)), None)


class SynergyLibrary(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The content of ``<arm>.synergies.json``.

    Attributes
    ----------
    schema : str
    arm : str
    joint_names : tuple of str
        Of the arm when it was learned; gains belong to them.
    captures : str
        The selection learned from.
    inputs_sha256 : str
        Of the arm, the captures as they were prepared for it, bounds, rate and schedule; what
        else the result depends on (seed, lambdas, optimisers, models) stands in the file.
    seed : int
    rate_hz : float
        Frame rate of learning.
    lambdas : dict of str to float
        lambda of each optimiser, 1/s.
    stable_gains : bool
        Whether gains were bounded below, so that the loop provably converges.
    complete : bool
        False when learning was interrupted: the best so far.
    reaches : tuple of LearnedReach
    left_out : dict of str to str
        Captures that could not be learned from, and why.
    """

    schema: Literal["armsyn-synergies-1"]
    arm: str
    joint_names: tuple[str, ...]
    captures: str
    inputs_sha256: str
    seed: int
    rate_hz: float
    lambdas: dict[str, float]
    stable_gains: bool
    complete: bool
    reaches: tuple[LearnedReach, ...]
    left_out: dict[str, str] = {}

    def synergy(self, chosen: SynergySet) -> Synergies:
        """Return a set's gains and sigmoids as the controller takes them."""
        return synergies(chosen.model, len(self.joint_names), [chosen.parameters])

    def nearest(
        self, start: FloatArray, target: FloatArray, ik: str, model: str
    ) -> list[tuple[LearnedReach, SynergySet]]:
        """Learned reaches that may serve a new one, the nearest first.

        Near is what moves from about there to about here: the distance of the targets and that
        of the starts, added in squares.

        Parameters
        ----------
        start, target : array, shape (3,)
            Hand positions, arm base frame, m.
        ik : str
            Optimiser.
        model : str
            Synergy model.

        Returns
        -------
        list of (LearnedReach, SynergySet)
            Only sets that fit; sets of S_A and S_B go by their reach's S_C where there is one,
            for they never follow the captured speed.

        Raises
        ------
        InputError
            When the library has nothing learned with them.
        """
        usable = []
        for reach in self.reaches:
            found = reach.set_for(ik, model)
            judge = (reach.set_for(ik, "C") if model in ("A", "B") else None) or found
            if found is not None and judge is not None and not judge.misfit:
                gap = np.concatenate([reach.start_m - start, reach.target_m - target])
                usable.append((float(np.linalg.norm(gap)), reach, found))
        if not usable:
            raise InputError(self._why_none(ik, model))
        return [(reach, found) for _, reach, found in sorted(usable, key=lambda item: item[0])]

    def _why_none(self, ik: str, model: str) -> str:
        known = sorted({(s.ik, s.model) for reach in self.reaches for s in reach.sets})
        if (ik, model) in known:
            return (
                f"none of the {len(self.reaches)} reaches that {self.arm} learned with {ik}/{model}"
                " moves its hand as captured (armsyn learn says why): choose another --ik or"
                " --model"
            )
        listed = ", ".join(f"{i}/{m}" for i, m in known)
        return (
            f"{self.arm} has learned nothing with --ik {ik} --model {model}"
            f"{f', only {listed}' if listed else ''}: run armsyn learn"
        )


def load_library(path: Path) -> SynergyLibrary:
    """Read a synergies file.

    Parameters
    ----------
    path : Path

    Returns
    -------
    SynergyLibrary

    Raises
    ------
    DescriptionError
        Unreadable, half-written or wrong in a field; the message names file and field.
    """
    try:
        if path.stat().st_size > MAXIMUM_BYTES:
            raise DescriptionError(f"{path}: larger than {MAXIMUM_BYTES} bytes")
        library = msgspec.json.decode(path.read_bytes(), type=SynergyLibrary)
        _check(library)
    except (OSError, UnicodeDecodeError, msgspec.DecodeError, InputError) as error:
        raise DescriptionError(f"{path}: {error}; learn it again with armsyn learn") from error
    return library


def save_library(path: Path, library: SynergyLibrary) -> None:
    """Write a synergies file: to a temporary file beside it, then renamed over it.

    Raises
    ------
    InputError
        When the place cannot be written.
    """
    # One line a reach: a file that is kept under version control should show what changed
    frame = msgspec.json.format(msgspec.json.encode(msgspec.structs.replace(library, reaches=())))
    reaches = b",\n    ".join(msgspec.json.encode(reach) for reach in library.reaches)
    text = frame.replace(b'"reaches": []', b'"reaches": [\n    ' + reaches + b"\n  ]")
    with replacing(path) as temporary:
        temporary.write_bytes(text + b"\n")


def _check(library: SynergyLibrary) -> None:
    for reach in library.reaches:
        numbers = [*reach.start_m, *reach.target_m, *reach.speed_profile]
        if len(reach.speed_profile) != PROFILE_SAMPLES or not np.isfinite(numbers).all():
            raise InputError(f"{reach.name}: speed_profile must be {PROFILE_SAMPLES} numbers")
        for learned in reach.sets:
            expected = len(parameter_names(learned.model, library.joint_names))
            if len(learned.parameters) != expected:
                raise InputError(
                    f"{reach.name}: {learned.ik}/{learned.model} has {len(learned.parameters)}"
                    f" parameters, expected {expected}"
                )
            if not library.lambdas.get(learned.ik, 0.0) > 0:
                raise InputError(f"{reach.name}: lambdas has no positive rate for {learned.ik}")
