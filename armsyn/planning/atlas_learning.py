"""Learn the atlas of an arm from captured reaches."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence

import numpy as np

from armsyn.arm import ArmDescription
from armsyn.errors import CaptureError
from armsyn.motion.captures import Capture
from armsyn.motion.retargeting import retarget
from armsyn.planning.atlas import Atlas, AtlasFacts, chain_hash
from armsyn.planning.examples import Examples, examples_on_arm
from armsyn.planning.likeness import likeness_of
from armsyn.planning.prediction import Predictor
from armsyn.planning.predictor import learn_predictor

Progress = Callable[[str, int, int, str], None]

KINDS = ("linear", "latent", "synergy")
"""What an atlas holds, in the order in which it is learned."""


def learn_atlas(
    arm: ArmDescription,
    selection: str,
    captures: Sequence[Capture],
    *,
    seed: int = 0,
    on_progress: Progress = lambda _stage, _done, _total, _said: None,
) -> Atlas:
    """Learn everything that an atlas holds.

    Parameters
    ----------
    arm : ArmDescription
    selection : str
        Where the captures come from, for the record.
    captures : sequence of Capture
    seed : int
        For the record: what is learned now draws no random numbers.
    on_progress : callable
        Called with what is done, how far it is, of how much, and a remark.

    Returns
    -------
    Atlas

    Raises
    ------
    CaptureError
        Fewer than eight captures can be used, or their targets lie in one plane.
    """
    usable, left_out = _usable(arm, captures)
    examples = examples_on_arm(
        arm, usable, on_progress=lambda done, total: on_progress("put on the arm", done, total, "")
    )
    likeness = likeness_of(
        arm, usable, lambda done, total: on_progress("compared", done, total, "")
    )
    predictors: dict[str, Predictor] = {}
    for done, kind in enumerate(KINDS):
        on_progress("learning", done, len(KINDS), kind)
        predictors[kind] = learn_predictor(kind, examples)
    on_progress("learning", len(KINDS), len(KINDS), "")
    facts = AtlasFacts(
        arm=arm.name,
        joint_names=arm.joint_names,
        captures=selection,
        sources=tuple(sorted({_source(capture) for capture in usable})),
        subjects=tuple(sorted(set(examples.subjects))),
        reaches=examples.size,
        places=len(set(zip(examples.subjects, examples.places, strict=True))),
        left_out=left_out,
        inputs_sha256=_inputs_hash(examples),
        chain_sha256=chain_hash(arm.chain),
        seed=seed,
        likeness=likeness,
    )
    return Atlas(facts, predictors)


def _usable(
    arm: ArmDescription, captures: Sequence[Capture]
) -> tuple[list[Capture], dict[str, str]]:
    usable: list[Capture] = []
    left_out: dict[str, str] = {}
    for capture in captures:
        try:
            retarget(capture.motion, arm, is_return=capture.kind == "return")
            usable.append(capture)
        except CaptureError as error:
            left_out[capture.name] = str(error)
    if not usable:
        first = next(iter(left_out.values()), "none given")
        raise CaptureError(f"none of {len(captures)} captures can be used: {first}")
    return usable, left_out


def _source(capture: Capture) -> str:
    """Set and file of a capture."""
    return f"{capture.name.split(':')[0]}: {capture.source.split()[0]}"


def _inputs_hash(examples: Examples) -> str:
    digest = hashlib.sha256(repr((examples.names, examples.chain.names)).encode())
    for part in (examples.angles, examples.durations):
        digest.update(np.round(part, 6).tobytes())
    return digest.hexdigest()
