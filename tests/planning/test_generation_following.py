"""Every reach that is generated is one that may be driven, and the one that a planner plans."""

from __future__ import annotations

import numpy as np
import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.errors import RefusedMotionError
from armsyn.kinematics.rotation import from_expmap, from_rpy, to_rpy
from armsyn.motion import Motion
from armsyn.planning.atlas import Atlas, atlas_of
from armsyn.planning.evenness import uneven_speed
from armsyn.planning.generation.batch import KINDS, Batch, Recipe, make_batch
from armsyn.planning.generation.targets import ListedTargets, random_within
from armsyn.planning.minimum_jerk import MinimumJerkPredictor
from armsyn.planning.motion_planner import MotionPlanner
from armsyn.planning.posing import HandOrientation, Pointing, Turned, pointing_axis
from armsyn.planning.prediction import Predictor
from armsyn.safety import check_trajectory

ASKED = 40
CASES = [
    ("human7", "latent"),
    ("human7", "linear"),
    ("human7", "synergy"),
    ("widowx_250s", "latent"),
    ("widowx_250s", "synergy"),
    ("openmanipulator_x", "minjerk"),
]


def learned(arm: ArmDescription, plan: str) -> tuple[Predictor, Atlas]:
    atlas = atlas_of(arm)
    return MinimumJerkPredictor(arm.chain) if plan == "minjerk" else atlas.predictor(plan), atlas


def wild(arm: ArmDescription, predictor: Predictor, seed: int) -> ListedTargets:
    """Targets within and far beyond what was captured, from rest and from anywhere."""
    rng, chain = np.random.default_rng(seed), arm.chain
    goals = chain.positions(rng.uniform(chain.lower, chain.upper, (ASKED, chain.dof)))[:, -1]
    starts = np.tile(arm.rest, (ASKED, 1))
    starts[ASKED // 2 :] = rng.uniform(chain.lower, chain.upper, (ASKED - ASKED // 2, chain.dof))
    if (hull := getattr(predictor, "hull", None)) is not None:
        goals[::2] = random_within(ASKED, seed, hull).some(0, ASKED)[0][::2]
    goals[3], goals[5] = arm.chain.forward(starts[3]).tip, 9.0
    starts[7, 0] = chain.upper[0] + 0.5
    return ListedTargets(goals, starts)


def check_each(recipe: Recipe, batch: Batch) -> None:
    """What is asked of every reach, by what is asked of any trajectory."""
    arm = recipe.arm
    goals, starts, _ = recipe.targets.some(0, recipe.targets.size)
    for row, index in enumerate(batch.index.tolist()):
        path, of = batch.paced.path(row), index // recipe.repeats
        start = recipe.start if starts is None else starts[of]
        motion = Motion(np.arange(len(path)) / recipe.rate_hz, arm.joint_names, path)
        check_trajectory(motion, arm, start, start_tolerance=1e-9)
        hand = arm.chain.positions(path)[:, -1]
        assert np.linalg.norm(hand[-1] - goals[of]) <= 1e-3
        np.testing.assert_allclose(hand[-1], batch.hands[row], rtol=0.0, atol=1e-12)
        assert uneven_speed(hand, recipe.rate_hz, batch.paced.scales[row]) is None
    made = {*batch.index.tolist(), *(refusal.index for refusal in batch.refused)}
    assert made == set(range(recipe.size))


@pytest.mark.parametrize(("name", "plan"), CASES)
def test_what_is_generated_is_what_is_planned(name: str, plan: str) -> None:
    arm = load_arm(name, calibrated=False)
    predictor, _ = learned(arm, plan)
    asked = wild(arm, predictor, 2)
    recipe = Recipe(arm, predictor, asked, arm.rest, 200.0)
    batch = make_batch(recipe, 0, ASKED)
    check_each(recipe, batch)
    assert 10 < len(batch.index) < ASKED
    rows = {index: row for row, index in enumerate(batch.index.tolist())}
    changed = {change.index: change for change in batch.changed}
    refused = {refusal.index: refusal for refusal in batch.refused}
    planner = MotionPlanner(arm, predictor)
    goals, starts = asked.targets, asked.starts
    assert starts is not None
    refusals = []
    for index in range(ASKED):
        try:
            planned = planner.plan(starts[index], goals[index], 200.0)
        except RefusedMotionError as error:
            kinds = [kind for of, kind in KINDS if isinstance(error, of)]
            refusals.append((refused[index].kind, kinds[0]))
            continue
        path = batch.paced.path(rows[index])
        wanted = planned.angles[: len(path)]  # what predicts rounds otherwise, alone
        np.testing.assert_allclose(path, wanted, rtol=0.0, atol=2e-4)
        assert (planned.angles[len(path) :] == planned.angles[-1]).all()
        assert batch.evened[rows[index]] == pytest.approx(planned.evened, abs=1e-4)
        # found in a walk of many steps, which amplifies what predicts rounds otherwise
        assert batch.swivels[rows[index]] == pytest.approx(planned.swivel_m or 0.0, abs=1e-5)
        assert bool(planned.refused) == (index in changed)
    assert len(refusals) == len(refused)
    assert all(kind == planned for kind, planned in refusals)


def turned_by(rpy: np.ndarray) -> HandOrientation:
    return Turned(from_rpy(rpy))


def turns_near(arm: ArmDescription, ends: np.ndarray, *, whole: bool) -> np.ndarray:
    """Directions or orientations near those of some hands, most of which can be had."""
    rng, axis = np.random.default_rng(4), pointing_axis(arm.chain)
    away = 0.5 * rng.normal(size=(len(ends), 3))
    hands = [arm.chain.forward(end).orientations[-1] for end in ends]
    if whole:
        return np.array(
            [to_rpy(from_expmap(a) @ hand) for a, hand in zip(away, hands, strict=True)]
        )
    return np.array([hand @ axis for hand in hands]) + away


def angle_off(arm: ArmDescription, wanted: HandOrientation, hand: np.ndarray) -> float:
    if isinstance(wanted, Pointing):
        cosine = hand @ pointing_axis(arm.chain) @ np.asarray(wanted.direction)
    else:
        cosine = 0.5 * (np.trace(hand.T @ wanted.wanted) - 1.0)
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))


@pytest.mark.parametrize("whole", [False, True])
@pytest.mark.parametrize("name", ["human7", "widowx_250s"])
def test_a_hand_that_is_turned_is_as_planned(name: str, whole: bool) -> None:
    arm = load_arm(name, calibrated=False)
    predictor, _ = learned(arm, "latent")
    hull = predictor.hull  # type: ignore[attr-defined]
    goals = random_within(12, 4, hull).some(0, 12).targets
    ends = predictor.predict(np.tile(arm.rest, (12, 1)), goals).angles[:, -1]
    turns = turns_near(arm, ends, whole=whole)
    asked = ListedTargets(goals, None, turns, turned_by if whole else Pointing)
    batch = make_batch(Recipe(arm, predictor, asked, arm.rest, 200.0), 0, 12)
    rows = {index: row for row, index in enumerate(batch.index.tolist())}
    refused, reasons = {refusal.index: refusal.reason for refusal in batch.refused}, {}
    assert rows
    planner = MotionPlanner(arm, predictor)
    for index, orientation in enumerate(asked.some(0, 12).orientations or ()):
        try:
            planned = planner.plan(arm.rest, goals[index], 200.0, orientation=orientation)
        except RefusedMotionError as error:
            reasons[index] = str(error)
            continue
        path = batch.paced.path(rows[index])
        np.testing.assert_allclose(path, planned.angles[: len(path)], rtol=0.0, atol=2e-4)
        last = arm.chain.forward(path[-1])
        off = angle_off(arm, orientation, last.orientations[-1])
        assert off <= orientation.tolerance
        assert batch.turned[rows[index]] == pytest.approx(off, abs=1e-7)
        assert np.linalg.norm(last.tip - goals[index]) <= 1e-3
    assert refused == reasons


@pytest.mark.parametrize("plan", ["latent", "synergy"])
def test_repeats_that_differ_may_be_driven_and_go_in_one_bell(plan: str) -> None:
    arm = load_arm("human7", calibrated=False)
    predictor, atlas = learned(arm, plan)
    targets = random_within(40, 6, predictor.hull)  # type: ignore[attr-defined]
    recipe = Recipe(arm, predictor, targets, arm.rest, 200.0, 5, 1, atlas.variability)
    batch = make_batch(recipe, 0, recipe.size)
    check_each(recipe, batch)
    assert len(batch.index) > 0.9 * recipe.size
    assert batch.changed
    ends = np.array([batch.paced.path(row)[-1] for row in range(5)])
    assert np.ptp(ends, axis=0).max() > 1e-3
