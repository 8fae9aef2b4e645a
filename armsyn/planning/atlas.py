"""The atlas of an arm: all that was learned from people about reaches to any target."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription, find_file
from armsyn.errors import InputError, meant
from armsyn.kinematics import SerialChain
from armsyn.planning.generation.variability import Variability
from armsyn.planning.prediction import Predictor

FloatArray = NDArray[np.float64]

SUFFIX = ".atlas.json"


class Likeness(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How well an arm can take the captured postures.

    Attributes
    ----------
    landmarks : tuple of str
        That were followed, put on the arm's own links.
    residual_m, worst_m : float
        Mean and greatest distance of the arm's landmarks to them.
    upper_arm_deg, forearm_deg : float or None
        Mean angle between the arm's segment and the person's; None where the arm names none.
    """

    landmarks: tuple[str, ...]
    residual_m: float
    worst_m: float
    upper_arm_deg: float | None
    forearm_deg: float | None


class AtlasFacts(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where an atlas comes from.

    Attributes
    ----------
    arm : str
    joint_names : tuple of str
    captures : str
        The selection learned from.
    sources : tuple of str
        The files that the captures are in.
    subjects : tuple of str
    reaches, places : int
        How many reaches, to and from how many places.
    left_out : dict of str to str
        Captures that could not be learned from, and why.
    repeats : str
        The selection that the spread between repeats was learned from; empty for none.
    inputs_sha256 : str
        Of the captures as they were put on the arm.
    chain_sha256 : str
        Of the arm's links.
    seed : int
    likeness : Likeness
    """

    arm: str
    joint_names: tuple[str, ...]
    captures: str
    sources: tuple[str, ...]
    subjects: tuple[str, ...]
    reaches: int
    places: int
    left_out: dict[str, str]
    repeats: str
    inputs_sha256: str
    chain_sha256: str
    seed: int
    likeness: Likeness


@dataclass(frozen=True)
class Atlas:
    """Learned models of one arm.

    Parameters
    ----------
    facts : AtlasFacts
    predictors : mapping of str to Predictor
        By kind: ``linear``, ``latent``, ``synergy``.
    variability : Variability or None
        How repeats of a reach differ; None where no captures had repeats.
    """

    facts: AtlasFacts
    predictors: Mapping[str, Predictor]
    variability: Variability | None = None

    @property
    def kinds(self) -> tuple[str, ...]:
        """What `predictor` knows."""
        return tuple(self.predictors)

    def predictor(self, kind: str) -> Predictor:
        """Return a predictor.

        Raises
        ------
        InputError
            The atlas has none of that kind.
        """
        if kind not in self.predictors:
            raise InputError(
                f"the atlas of {self.facts.arm} has no {kind!r}, but {', '.join(self.kinds)}"
                f"{meant(kind, self.kinds)}"
            )
        return self.predictors[kind]


def atlas_of(arm: ArmDescription, directory: Path | None = None) -> Atlas:
    """Find and read the atlas of an arm.

    Parameters
    ----------
    arm : ArmDescription
    directory : Path, optional
        Search only here, as `armsyn.arm.find_file`.

    Returns
    -------
    Atlas

    Raises
    ------
    DescriptionError
        None is found, or it is not of this arm.
    """
    from armsyn.planning.atlas_file import load_atlas  # noqa: PLC0415  it imports this module

    return load_atlas(find_file(arm.name, SUFFIX, directory), arm)


def chain_hash(chain: SerialChain) -> str:
    """Hash of a chain's joints and links, which learned angles belong to.

    Not of its limits: a calibration narrows them to what an arm really has, and a plan is bent into
    them.
    """
    digest = hashlib.sha256(repr(chain.names).encode())
    arrays = chain.arrays
    for part in (arrays.rotation, arrays.translation, arrays.prismatic):
        digest.update(np.round(np.asarray(part, dtype=np.float64), 9).tobytes())
    return digest.hexdigest()
