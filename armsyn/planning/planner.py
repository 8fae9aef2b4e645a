"""One call behind every plan: ``planner_for(arm, plan)`` gives what plans the arm's reaches."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from numpy.typing import ArrayLike

from armsyn.arm import ArmDescription, find_file
from armsyn.errors import DescriptionError, InputError, meant
from armsyn.planning.checking import PLANNING_RATE_HZ
from armsyn.planning.minimum_jerk import MinimumJerkPredictor
from armsyn.planning.motion_planner import MotionPlanner
from armsyn.planning.nearest import NearestReaches
from armsyn.planning.planned import PlannedReach
from armsyn.planning.posing import HandOrientation
from armsyn.planning.prediction import Predictor
from armsyn.planning.raw_library import raw_library
from armsyn.planning.synergy_planner import SynergyPlanner
from armsyn.synergy import load_library

SYNERGY = "synergy"
MINIMUM_JERK = "minjerk"
PLANS = (SYNERGY, "latent", "linear", MINIMUM_JERK)
"""``synergy`` rolls the controller out with a learned synergy: that of the place, by the atlas; or,
without an atlas, or with an optimiser or model given, the nearest that was learned. ``latent`` and
``linear`` predict whole motions learned from people, ``minjerk`` is a rule without captures."""

DEFAULT_PLAN = "latent"
"""What comes nearest to people (`armsyn experiment anytarget`); of arms that have an atlas."""

SYNERGIES = ".synergies.json"
ATLAS = ".atlas.json"


class Planner(Protocol):
    """Plans reaches of one arm."""

    @property
    def arm(self) -> ArmDescription:
        """Whose reaches."""

    @property
    def name(self) -> str:
        """Of `PLANS`."""

    def plan(
        self,
        posture: ArrayLike,
        target: ArrayLike,
        rate_hz: float = PLANNING_RATE_HZ,
        *,
        orientation: HandOrientation | None = None,
    ) -> PlannedReach:
        """Plan a reach from a posture to a target.

        Parameters
        ----------
        posture : array_like, shape (n,)
            Where the arm is, rad or m.
        target : array_like, shape (3,)
            Position of the hand, base frame, m.
        rate_hz : float
            Of the trajectory; limits hold at `armsyn.planning.pacing.LEAST_HZ` or more.
        orientation : HandOrientation, optional
            How the hand is to be turned at the end.

        Returns
        -------
        PlannedReach
            It ends within 1 mm of the target, keeps every limit and touches nothing.

        Raises
        ------
        InputError
            Wrong counts, not finite, or a rate that is not positive.
        UnreachableError
            The hand cannot get there, or cannot be turned so there.
        LimitError
            The posture is outside the joints' ranges, or no way to the target keeps the limits.
        CollisionError
            Every way that was tried touches the arm itself or what is around it.
        """


def planner_for(
    arm: ArmDescription,
    plan: str | None = None,
    directory: Path | None = None,
    *,
    ik: str | None = None,
    model: str | None = None,
) -> Planner:
    """Return a planner, with what it needs of the arm's files.

    Parameters
    ----------
    arm : ArmDescription
    plan : str, optional
        Of `PLANS`; `default_plan` when it is not given.
    directory : Path, optional
        Search only here, as `armsyn.arm.find_file`.
    ik, model : str, optional
        Of ``synergy``: the optimiser and the synergy model, svd and C unless given.

    Returns
    -------
    Planner

    Raises
    ------
    InputError
        No such plan; an optimiser or model for another plan than ``synergy``.
    DescriptionError
        Its file is missing or unusable.
    """
    if plan is None:
        plan = SYNERGY if ik or model else default_plan(arm.name, directory)
    if plan not in PLANS:
        raise InputError(f"no plan {plan!r}, but {', '.join(PLANS)}{meant(plan, PLANS)}")
    if plan == SYNERGY and (ik or model or not _has(arm.name, ATLAS, directory)):
        return _synergy_planner(arm, directory, ik or "svd", model or "C")
    if ik or model:
        raise InputError(f"optimisers and synergy models are of --plan {SYNERGY}, not of {plan}")
    predictor = (
        by_minimum_jerk(arm, directory) if plan == MINIMUM_JERK else _of_atlas(arm, plan, directory)
    )
    return MotionPlanner(arm, predictor, _captured(arm, directory))


def default_plan(name: str, directory: Path | None = None) -> str:
    """Return the plan of an arm when none is asked for: `DEFAULT_PLAN` if it has an atlas."""
    return DEFAULT_PLAN if _has(name, ATLAS, directory) else SYNERGY


def by_minimum_jerk(arm: ArmDescription, directory: Path | None = None) -> MinimumJerkPredictor:
    """Return minimum jerk of an arm, with the captured workspace where an atlas knows it.

    Parameters
    ----------
    arm : ArmDescription
    directory : Path, optional
        Search only here, as `armsyn.arm.find_file`.

    Returns
    -------
    MinimumJerkPredictor
    """
    hull = None
    if _has(arm.name, ATLAS, directory):
        try:
            hull = getattr(_of_atlas(arm, DEFAULT_PLAN, directory), "hull", None)
        except InputError:  # damaged, or of another arm: not needed to plan
            hull = None
    return MinimumJerkPredictor(arm.chain, hull=hull)


def _of_atlas(arm: ArmDescription, plan: str, directory: Path | None) -> Predictor:
    from armsyn.planning.atlas_file import load_atlas  # noqa: PLC0415  the others need none

    return load_atlas(_found(arm.name, ATLAS, directory), arm).predictor(plan)


def _captured(arm: ArmDescription, directory: Path | None) -> NearestReaches | None:
    """What there is to compare a plan with."""
    if not _has(arm.name, SYNERGIES, directory):
        return None
    try:
        return SynergyPlanner(arm, load_library(find_file(arm.name, SYNERGIES, directory))).captured
    except InputError:  # of another arm, damaged, or nothing that fits: not needed to plan
        return None


def _synergy_planner(
    arm: ArmDescription, directory: Path | None, ik: str, model: str
) -> SynergyPlanner:
    try:
        library = load_library(_found(arm.name, SYNERGIES, directory))
    except DescriptionError:
        if model != "A":  # which needs nothing learned but its pace
            raise
        library = raw_library(arm, ik)
    return SynergyPlanner(arm, library, ik, model)


def _has(name: str, suffix: str, directory: Path | None) -> bool:
    try:
        find_file(name, suffix, directory)
    except DescriptionError:
        return False
    return True


def _found(name: str, suffix: str, directory: Path | None) -> Path:
    try:
        return find_file(name, suffix, directory)
    except DescriptionError as error:
        if suffix == ATLAS:
            raise DescriptionError(
                f"no {name}{ATLAS} was found: learn it by armsyn learn --arm {name} --atlas, or"
                f" use --plan {SYNERGY} or {MINIMUM_JERK}"
            ) from error
        error.add(f"or --plan {MINIMUM_JERK}, which needs no captures")
        raise
