"""Learn the atlas of an arm from captured reaches."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from armsyn.arm import ArmDescription
from armsyn.errors import CaptureError
from armsyn.motion.captures import Capture, load_captures
from armsyn.motion.retargeting import retarget
from armsyn.planning.atlas import Atlas, AtlasFacts, chain_hash
from armsyn.planning.examples import Examples, examples_on_arm
from armsyn.planning.generation.variability import Variability, learn_variability
from armsyn.planning.likeness import likeness_of
from armsyn.planning.linear import learn_linear
from armsyn.planning.prediction import Predictor
from armsyn.planning.predictor import learn_predictor

Progress = Callable[[str, int, int, str], None]

KINDS = ("linear", "latent", "synergy")
"""What an atlas holds, in the order in which it is learned."""
HAND_ALONE: Mapping[str, Any] = {"model": "C", "ridge": 1.0}
"""Synergies of arms that follow the hand alone: with more freedom joints that no capture tells
apart take moments of their own, and of 150 reaches of WidowX two thirds had a second peak of
speed; so none has."""
FASTEST_STEP = 0.1
"""rad in a hundredth of a reach: 10 rad/s in one of a second; people stay below 8."""
REPEATS = "hug_mp:S01,hug_mp:S02,hug_mp:S03,hug_mp:S04"
"""Two repeats of each of seven targets by four people."""


class Repeats(NamedTuple):
    """What the spread between repeats was learned from (empty for nothing, then why), and it."""

    selection: str
    spread: Variability | None
    why_none: str


def learn_atlas(
    arm: ArmDescription,
    selection: str,
    captures: Sequence[Capture],
    *,
    repeats: str = REPEATS,
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
    repeats : str
        Selection that the spread between repeats is learned from where `captures` have too few.
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
    examples, swinging = _without_swings(_on_arm(arm, usable, "put on the arm", on_progress))
    left_out |= swinging
    usable = [capture for capture in usable if capture.name not in swinging]
    likeness = likeness_of(
        arm, usable, lambda done, total: on_progress("compared", done, total, "")
    )
    predictors: dict[str, Predictor] = {}
    for done, kind in enumerate(KINDS):
        on_progress("learning", done, len(KINDS), kind)
        options = HAND_ALONE if kind == "synergy" and len(arm.landmarks) == 1 else {}
        predictors[kind] = learn_predictor(kind, examples, **options)
    on_progress("learning", len(KINDS), len(KINDS), "")
    found = _spread(arm, selection, examples, repeats, on_progress)
    facts = AtlasFacts(
        arm=arm.name,
        joint_names=arm.joint_names,
        captures=selection,
        sources=tuple(sorted({_source(capture) for capture in usable})),
        subjects=tuple(sorted(set(examples.subjects))),
        reaches=examples.size,
        places=len(set(zip(examples.subjects, examples.places, strict=True))),
        left_out=left_out | ({"repeats": found.why_none} if found.why_none else {}),
        repeats=found.selection,
        inputs_sha256=_inputs_hash(examples),
        chain_sha256=chain_hash(arm.chain),
        seed=seed,
        likeness=likeness,
    )
    return Atlas(facts, predictors, found.spread)


def _on_arm(
    arm: ArmDescription, captures: Sequence[Capture], stage: str, on_progress: Progress
) -> Examples:
    return examples_on_arm(
        arm, captures, on_progress=lambda done, total: on_progress(stage, done, total, "")
    )


def _without_swings(examples: Examples) -> tuple[Examples, dict[str, str]]:
    """Leave out reaches in which a joint turns faster than people turn any of theirs."""
    steps = np.abs(np.diff(examples.angles, axis=1)).max(axis=1)
    fastest = steps.argmax(axis=1)
    kept = steps.max(axis=1) <= FASTEST_STEP
    if not kept.any():
        raise CaptureError("no captured reach can be followed without swinging a joint")
    reasons = {
        examples.names[row]: f"swings {examples.chain.names[fastest[row]]} by"
        f" {steps[row].max():.2f} rad in a hundredth of the reach: it passes near a singularity"
        for row in np.flatnonzero(~kept)
    }
    return examples.only(kept), reasons


def _spread(
    arm: ArmDescription, selection: str, examples: Examples, repeats: str, on_progress: Progress
) -> Repeats:
    """Learn how repeats differ: of the captures themselves, else of those that have repeats."""
    try:
        return Repeats(selection, learn_variability(examples, learn_linear(examples)), "")
    except CaptureError:
        pass  # one reach a place, as of garza
    try:
        captures, _ = _usable(arm, [_with_wrist(arm, one) for one in load_captures(repeats)])
        others, _ = _without_swings(_on_arm(arm, captures, "repeats put on the arm", on_progress))
        return Repeats(repeats, learn_variability(others, learn_linear(others)), "")
    except CaptureError as error:
        return Repeats("", None, f"no spread between repeats: {error}")


def _with_wrist(arm: ArmDescription, capture: Capture) -> Capture:
    """Add the wrist that an exoskeleton with a straight one has, where the arm follows a wrist."""
    motion = capture.motion
    names = motion.landmark_names
    lacks = "wrist" in arm.landmarks and "wrist" not in names
    if not lacks or motion.landmarks is None or names[-2:] != ("elbow", "hand"):
        return capture
    rows = dict(zip(arm.landmarks, arm.landmark_frames, strict=True))
    at_rest = arm.chain.positions(arm.rest[None])[0]
    elbow, wrist, hand = (at_rest[rows[name]] for name in ("elbow", "wrist", "hand"))
    forearm, palm = np.linalg.norm(wrist - elbow), np.linalg.norm(hand - wrist)
    share = forearm / (forearm + palm)
    middle = (1.0 - share) * motion.landmarks[:, -2:-1] + share * motion.landmarks[:, -1:]
    landmarks = np.concatenate([motion.landmarks[:, :-1], middle, motion.landmarks[:, -1:]], axis=1)
    return dataclasses.replace(
        capture,
        motion=dataclasses.replace(
            motion,
            joint_names=(),
            angles=None,
            landmark_names=(*names[:-1], "wrist", "hand"),
            landmarks=landmarks,
        ),
    )


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
