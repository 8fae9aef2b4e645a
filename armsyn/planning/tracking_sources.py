"""Where the synergies come from that a target may be reached for with."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription, find_file
from armsyn.errors import DescriptionError, InputError
from armsyn.planning.atlas import atlas_of
from armsyn.planning.nearest import NearestReaches
from armsyn.planning.planner import ATLAS, SYNERGIES, SYNERGY
from armsyn.planning.synergy_atlas import SynergyPredictor
from armsyn.planning.tracking_state import Candidate
from armsyn.synergy import SynergyLibrary, load_library

FloatArray = NDArray[np.float64]


class Source(Protocol):
    """Knows synergies for reaches of an arm."""

    def candidates(
        self, posture: FloatArray, hand: FloatArray, goal: FloatArray
    ) -> Iterator[Candidate]:
        """Yield those that may serve from a posture and hand to a goal, the likeliest first."""


@dataclass(frozen=True)
class LearnedSynergies:
    """The synergies of learned reaches, the nearest first.

    Parameters
    ----------
    arm : ArmDescription
    library : SynergyLibrary
        Learned for that arm.
    ik : {"svd", "jt", "njt", "dls"}
    model : {"A", "B", "C", "D"}

    Raises
    ------
    InputError
        A library of another arm, or with nothing learned so.
    """

    arm: ArmDescription
    library: SynergyLibrary
    ik: str = "svd"
    model: str = "C"

    def __post_init__(self) -> None:
        if self.library.arm != self.arm.name or self.library.joint_names != self.arm.joint_names:
            raise InputError(
                f"the synergies are those of {self.library.arm}, the arm is {self.arm.name}: run"
                f" armsyn learn --arm {self.arm.name}"
            )
        self._nearest.of(np.zeros(3), np.zeros(3))  # refuse what it has not learned

    @cached_property
    def _nearest(self) -> NearestReaches:
        return NearestReaches(self.library, self.ik, self.model)

    def candidates(
        self,
        posture: FloatArray,  # noqa: ARG002 - as those of the place need it
        hand: FloatArray,
        goal: FloatArray,
    ) -> Iterator[Candidate]:
        """As `Source`."""
        outside, rate = self._nearest.outside(goal), self.library.lambdas[self.ik]
        for rank, (learned, chosen) in enumerate(self._nearest.of(hand, goal)):
            synergy = self.library.synergy(chosen)
            lasts = learned.duration_s
            yield Candidate(synergy, rate, goal, outside, lasts, learned=learned.name, rank=rank)


@dataclass(frozen=True)
class PlaceSynergies:
    """The synergy of the place, at the pace of a person's reach to it.

    Parameters
    ----------
    predictor : SynergyPredictor
        Of the arm's atlas.
    """

    predictor: SynergyPredictor

    def candidates(
        self,
        posture: FloatArray,
        hand: FloatArray,  # noqa: ARG002 - as learned ones need it
        goal: FloatArray,
    ) -> Iterator[Candidate]:
        """As `Source`."""
        found = self.predictor
        starts, goals = posture[None], goal[None]
        synergy = found.family.synergies(found.coordinates(starts, goals))
        pace = float(found.time(found.chain, starts, goals)[0]) / found.family.duration
        outside = float(found.hull.outside(goals)[0])
        rate, lasts = found.family.lambda_, found.family.duration
        yield Candidate(synergy, rate, goal, outside, lasts, closes=True, pace=pace, scale=pace)


def sources_of(
    arm: ArmDescription,
    directory: Path | None = None,
    *,
    ik: str | None = None,
    model: str | None = None,
) -> tuple[Source, ...]:
    """Find what there is for an arm: the atlas's synergies of the place, then learned reaches'.

    Parameters
    ----------
    arm : ArmDescription
    directory : Path, optional
        Search only here, as `armsyn.arm.find_file`.
    ik, model : str, optional
        Optimiser and synergy model; with either, of learned reaches alone (svd and C unless given).

    Returns
    -------
    tuple of Source

    Raises
    ------
    DescriptionError
        There is neither, or a file is unusable.
    InputError
        Nothing learned with that optimiser and model.
    """
    atlas = None if ik or model else _found(arm, ATLAS, directory)
    library = _found(arm, SYNERGIES, directory)
    if atlas is None and library is None:
        find_file(arm.name, SYNERGIES, directory)  # says where it was looked for
    found: list[Source] = []
    if atlas is not None:
        predictor = atlas_of(arm, directory).predictor(SYNERGY)
        assert isinstance(predictor, SynergyPredictor)  # noqa: S101 - of that kind
        found.append(PlaceSynergies(predictor))
    if library is not None:
        found.append(LearnedSynergies(arm, load_library(library), ik or "svd", model or "C"))
    return tuple(found)


def _found(arm: ArmDescription, suffix: str, directory: Path | None) -> Path | None:
    try:
        return find_file(arm.name, suffix, directory)
    except DescriptionError:
        return None
