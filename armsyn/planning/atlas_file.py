"""Read and write ``<arm>.atlas.json``."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Literal

import msgspec
import numpy as np

from armsyn.arm import ArmDescription
from armsyn.errors import DescriptionError, InputError
from armsyn.motion.formats.files import replacing
from armsyn.planning.atlas import Atlas, AtlasFacts, chain_hash
from armsyn.planning.atlas_codec import decoded, encoded
from armsyn.planning.examples import PHASES
from armsyn.planning.generation.variability import Variability
from armsyn.planning.prediction import Predictor

MAXIMUM_BYTES = 10_000_000
_NUMBERS = re.compile(r"\[[-+.,eE0-9\s]+\]")


class AtlasDocument(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The content of the file.

    Attributes
    ----------
    schema : str
    facts : AtlasFacts
    predictors : dict of str to dict
        As `armsyn.planning.atlas_codec` writes them.
    variability : dict or None
    """

    schema: Literal["armsyn-atlas-1"]
    facts: AtlasFacts
    predictors: dict[str, dict[str, Any]]
    variability: dict[str, Any] | None = None


def load_atlas(path: Path, arm: ArmDescription) -> Atlas:
    """Read an atlas.

    Parameters
    ----------
    path : Path
    arm : ArmDescription
        That it was learned for.

    Returns
    -------
    Atlas

    Raises
    ------
    DescriptionError
        Unreadable, half-written, wrong in a field, or of another arm; the message names file and
        field.
    """
    try:
        if path.stat().st_size > MAXIMUM_BYTES:
            raise DescriptionError(f"{path}: larger than {MAXIMUM_BYTES} bytes")
        document = msgspec.json.decode(path.read_bytes(), type=AtlasDocument)
        _check_arm(document.facts, arm)
        predictors = {
            kind: _predictor(part, arm, kind) for kind, part in document.predictors.items()
        }
        variability = _variability(document.variability, arm)
    except (OSError, UnicodeDecodeError, msgspec.DecodeError, InputError) as error:
        raise DescriptionError(
            f"{path}: {error}; learn it again with armsyn learn --atlas --arm {arm.name}"
        ) from error
    return Atlas(document.facts, predictors, variability)


def save_atlas(path: Path, atlas: Atlas) -> None:
    """Write an atlas: to a temporary file beside it, then renamed over it.

    Raises
    ------
    InputError
        When the place cannot be written.
    """
    document = AtlasDocument(
        "armsyn-atlas-1",
        atlas.facts,
        {kind: encoded(predictor) for kind, predictor in atlas.predictors.items()},
        None if atlas.variability is None else encoded(atlas.variability),
    )
    text = msgspec.json.format(msgspec.json.encode(document), indent=1).decode()
    # One line an array, so that what changed can be seen
    text = _NUMBERS.sub(lambda found: "".join(found[0].split()), text)
    with replacing(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")


def _check_arm(facts: AtlasFacts, arm: ArmDescription) -> None:
    if facts.arm != arm.name or facts.joint_names != arm.joint_names:
        raise InputError(
            f"of {facts.arm} ({', '.join(facts.joint_names)}), not of {arm.name}"
            f" ({', '.join(arm.joint_names)})"
        )
    if facts.chain_sha256 != chain_hash(arm.chain):
        raise InputError(f"the links of {arm.name} are no longer those it was learned on")


def _predictor(part: dict[str, Any], arm: ArmDescription, kind: str) -> Predictor:
    """Decode a predictor and let it predict once: arrays that do not fit each other are found."""
    predictor: Predictor = decoded(part, arm.chain, f"predictors.{kind}")
    start = np.clip(arm.rest, arm.chain.lower, arm.chain.upper)
    goal = arm.chain.forward(start).tip
    try:
        found = predictor.predict(start[None], goal[None])
        usable = np.isfinite(found.angles).all() and np.isfinite(found.durations).all()
    except (AttributeError, ValueError, IndexError, np.linalg.LinAlgError) as error:
        raise InputError(f"predictors.{kind}: arrays do not fit each other ({error})") from error
    if not usable or found.angles.shape[2] != arm.chain.dof or not (found.durations > 0).all():
        raise InputError(f"predictors.{kind}: predicts no motion of {arm.name}")
    return predictor


def _variability(document: dict[str, Any] | None, arm: ArmDescription) -> Variability | None:
    if document is None:
        return None
    found = decoded(document, arm.chain, "variability")
    if not isinstance(found, Variability):
        raise InputError(f"variability: expected Variability, got {type(found).__name__}")
    if found.modes.shape != (*found.times.shape, PHASES, arm.chain.dof):
        raise InputError(
            f"variability: modes of shape {found.modes.shape} are none of {arm.name}'s"
            f" {arm.chain.dof} joints"
        )
    return found
