"""Predicted motions that need bending: limits, other swivels, obstacles, uneven speed."""

from dataclasses import dataclass
from typing import ClassVar

import msgspec
import numpy as np
import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.arm.shapes import BoxDescription
from armsyn.errors import CollisionError, InputError, UnreachableError
from armsyn.kinematics import SerialChain
from armsyn.planning import planner_for
from armsyn.planning.bending import leaves_range, within_ranges
from armsyn.planning.ending import EASE
from armsyn.planning.generation.batch import Recipe, make_batch
from armsyn.planning.generation.targets import ListedTargets
from armsyn.planning.minimum_jerk import MinimumJerkPredictor
from armsyn.planning.motion_planner import MotionPlanner
from armsyn.planning.posing import HandTask, Pointing
from armsyn.planning.prediction import Predicted
from armsyn.planning.swivel import swivels
from armsyn.safety import check_trajectory
from armsyn.scoring import measure
from tests.kinematics.oracle import Oracle

TARGET = np.array([0.35, -0.10, -0.15])


@pytest.fixture(scope="module")
def arm() -> ArmDescription:
    return load_arm("human7")


@dataclass(frozen=True)
class Told:
    """A predictor that says what it is told."""

    chain: SerialChain
    angles: np.ndarray
    duration: float = 0.8

    name: ClassVar[str] = "told"

    def predict(self, starts: np.ndarray, targets: np.ndarray) -> Predicted:
        assert starts.shape == (1, self.chain.dof)
        miss = np.linalg.norm(self.chain.positions(self.angles[-1:])[:, -1] - targets, axis=1)
        return Predicted(self.angles[None], np.array([self.duration]), np.array([0.03]), miss)


def straight(arm: ArmDescription, end: np.ndarray) -> np.ndarray:
    return np.asarray(arm.rest + EASE[:, None] * (end - arm.rest))


def hand(arm: ArmDescription, q: np.ndarray) -> np.ndarray:
    return np.asarray(Oracle(arm.chain).frames(q)[0][-1])


def an_end(arm: ArmDescription) -> np.ndarray:
    """A posture with the hand at the target, and joints far from their limits."""
    planned = planner_for(arm, "minjerk").plan(arm.rest, TARGET)
    return np.asarray(planned.angles[-1])


def test_what_is_predicted_is_what_is_planned(arm: ArmDescription) -> None:
    angles = straight(arm, an_end(arm))
    planned = MotionPlanner(arm, Told(arm.chain, angles)).plan(arm.rest, TARGET)
    assert (planned.plan, planned.duration_s, planned.outside_m) == ("told", 0.8, 0.03)
    assert (planned.swivel_m, planned.evened, planned.refused) == (None, 0.0, "")
    # along the very same path: where a joint is, the others are as predicted
    share = (planned.angles[:, 3] - arm.rest[3]) / (angles[-1, 3] - arm.rest[3])
    wanted = arm.rest + share[:, None] * (angles[-1] - arm.rest)
    np.testing.assert_allclose(planned.angles, wanted, atol=1e-6)
    np.testing.assert_array_equal(planned.angles[0], arm.rest)


@pytest.mark.parametrize("duration", [0.0, 1e-6])
def test_a_reach_that_a_person_would_do_in_no_time_takes_the_arm_its_own(
    arm: ArmDescription, duration: float
) -> None:
    angles = straight(arm, an_end(arm))
    planned, usual = (
        MotionPlanner(arm, Told(arm.chain, angles, time)).plan(arm.rest, TARGET)
        for time in (duration, 0.1)
    )
    check_trajectory(planned.trajectory, arm, arm.rest)
    assert planned.trajectory.duration == pytest.approx(usual.trajectory.duration, rel=0.03)


@pytest.mark.parametrize(("angle", "duration"), [(np.nan, 0.8), (np.inf, 0.8), (0.0, np.nan)])
def test_a_prediction_that_is_no_number_is_none(
    arm: ArmDescription, angle: float, duration: float
) -> None:
    """Alone and among others in the same words."""
    angles = straight(arm, an_end(arm))
    angles[50, 2] += angle
    predictor = Told(arm.chain, angles, duration)
    with pytest.raises(UnreachableError, match=r"^the prediction is not finite$"):
        MotionPlanner(arm, predictor).plan(arm.rest, TARGET)
    targets = ListedTargets(np.array([TARGET]))
    batch = make_batch(Recipe(arm, predictor, targets, arm.rest, 200.0), 0, 1)
    assert [refusal.reason for refusal in batch.refused] == ["the prediction is not finite"]


def test_an_end_that_misses_is_led_to_the_target(arm: ArmDescription) -> None:
    angles = straight(arm, an_end(arm) + 0.05)
    planned = MotionPlanner(arm, Told(arm.chain, angles)).plan(arm.rest, TARGET)
    assert np.linalg.norm(hand(arm, planned.angles[-1]) - TARGET) <= 1e-3
    assert np.abs(planned.angles[-1] - angles[-1]).max() < 0.2
    check_trajectory(planned.trajectory, arm, arm.rest)


@pytest.mark.parametrize(("joint", "excess"), [(2, 0.3), (4, 0.2), (5, -0.2), (3, -0.2)])
def test_a_joint_that_leaves_its_range_is_bent_back(
    arm: ArmDescription, joint: int, excess: float
) -> None:
    angles = straight(arm, an_end(arm))
    limit = arm.chain.upper[joint] if excess > 0 else arm.chain.lower[joint]
    phase = np.linspace(0.0, 1.0, 101)
    bump = np.sin(np.pi * phase) ** 4
    angles[:, joint] += bump * (limit + excess - angles[50, joint])
    assert leaves_range(arm.chain, angles)
    bent = within_ranges(arm.chain, angles)
    assert (bent >= arm.chain.lower).all()
    assert (bent <= arm.chain.upper).all()
    np.testing.assert_allclose(bent[[0, -1]], angles[[0, -1]], atol=1e-12)
    # without corners: no second difference greater than a few of those that there were
    assert np.abs(np.diff(bent, 2, axis=0)).max() < 4 * np.abs(np.diff(angles, 2, axis=0)).max()


def test_the_others_keep_the_hand_on_its_path(arm: ArmDescription) -> None:
    """Where they can: the forearm may turn no further, the upper arm and the wrist may."""
    angles = straight(arm, an_end(arm))
    angles[:, 4] += np.sin(np.pi * np.linspace(0, 1, 101)) ** 4 * (1.7 - angles[50, 4])
    bent = within_ranges(arm.chain, angles)
    assert bent[:, 4].max() <= arm.chain.upper[4]
    away = np.linalg.norm(
        arm.chain.positions(bent)[:, -1] - arm.chain.positions(angles)[:, -1], axis=1
    )
    assert away.max() < 5e-4


def test_a_hand_that_would_speed_up_twice_is_evened_and_said_so(arm: ArmDescription) -> None:
    end, phase = an_end(arm), np.linspace(0.0, 1.0, 101)
    angles = straight(arm, end)
    angles[:, 3] += 0.5 * np.sin(2 * np.pi * phase) * np.sin(np.pi * phase) ** 2
    angles[:, 0] += 0.5 * np.sin(3 * np.pi * phase) ** 2 * np.sin(np.pi * phase)
    planned = MotionPlanner(arm, Told(arm.chain, angles)).plan(arm.rest, TARGET)
    assert 0.0 < planned.evened <= 1.0
    assert "speed up" in planned.refused
    assert measure(planned.trajectory).speed_peaks == 1


@pytest.mark.parametrize("name", ["human7", "openmanipulator_x", "koch", "widowx_250s"])
def test_swivels_move_the_arm_and_not_its_hand(name: str) -> None:
    arm = load_arm(name)
    oracle = Oracle(arm.chain)
    middle = 0.5 * (arm.rest + 0.5 * (arm.chain.lower + arm.chain.upper))
    frames, _ = oracle.frames(middle)
    moved = []
    for swivel in swivels(arm.chain, HandTask(frames[-1]), middle):
        places, _ = oracle.frames(swivel.posture)
        assert np.linalg.norm(places[-1] - frames[-1]) < 1e-3
        assert (swivel.posture >= arm.chain.lower).all()
        assert (swivel.posture <= arm.chain.upper).all()
        assert np.linalg.norm(places - frames, axis=1).max() == pytest.approx(swivel.moved_m)
        moved.append(swivel.moved_m)
    assert len(moved) >= 2
    assert moved[0] < moved[-1]


def test_an_arm_without_a_joint_to_spare_has_no_swivel(arm: ArmDescription) -> None:
    turned = arm.chain.forward(an_end(arm)).orientations[-1]
    two = SerialChain(arm.chain.joints[:3], (0.0, 0.0, -0.5))
    posture = np.array([0.3, 0.4, 0.2])
    assert not list(swivels(two, HandTask(two.forward(posture).tip), posture))
    one_left = HandTask(TARGET, Pointing(turned @ [0.0, 0.0, -1.0]))
    assert list(swivels(arm.chain, one_left, an_end(arm)))


def walled(arm: ArmDescription, centre: np.ndarray, size: tuple[float, ...]) -> ArmDescription:
    x, y, z = (float(value) for value in centre)
    box = BoxDescription(name="post", centre=(x, y, z), size=(size[0], size[1], size[2]))
    return msgspec.structs.replace(arm, box=(box,))


@pytest.mark.parametrize("plan", ["minjerk", "synergy"])
def test_a_box_at_the_elbow_is_gone_around_by_another_swivel(
    arm: ArmDescription, plan: str
) -> None:
    free = planner_for(arm, plan).plan(arm.rest, TARGET)
    elbow = arm.chain.positions(free.angles[-1:])[0, 3]
    boxed = walled(arm, elbow - np.array([0.0, 0.05, 0.02]), (0.04, 0.04, 0.04))
    with pytest.raises(CollisionError, match="post"):
        check_trajectory(free.trajectory, boxed)
    around = planner_for(boxed, plan).plan(boxed.rest, TARGET)
    assert around.swivel_m is not None
    assert around.swivel_m > 0.03
    assert "post" in around.refused
    check_trajectory(around.trajectory, boxed, boxed.rest)
    assert np.linalg.norm(hand(arm, around.angles[-1]) - TARGET) <= 1e-3
    assert measure(around.trajectory).speed_peaks == 1
    # nothing of the arm is in the box, told by points along its segments
    places = arm.chain.positions(around.angles)[:, [2, 3, 5, 7]]
    share = np.linspace(0.0, 1.0, 21)[:, None]
    points = places[:, :-1, None] * (1 - share) + places[:, 1:, None] * share
    local = np.abs(points - boxed.box[0].centre) - 0.5 * np.array(boxed.box[0].size)
    assert local.max(axis=-1).min() > 0.02  # the arm has an extent


def test_a_target_that_no_swivel_helps_is_refused_by_the_boxs_name(arm: ArmDescription) -> None:
    boxed = walled(arm, TARGET, (0.05, 0.05, 0.05))
    with pytest.raises(
        CollisionError, match=r"post.*other swivels of the arm, were tried"
    ) as caught:
        planner_for(boxed, "minjerk").plan(boxed.rest, TARGET)
    assert "post" in (caught.value.first, caught.value.second)


def test_a_target_out_of_reach_is_refused_by_every_plan(arm: ArmDescription) -> None:
    with pytest.raises(UnreachableError, match=r"the arm is 0\.66 m long"):
        planner_for(arm, "minjerk").plan(arm.rest, [0.9, 0.0, 0.0])


def test_a_predictor_of_another_arm_is_refused(arm: ArmDescription) -> None:
    with pytest.raises(InputError, match=r"human7 has shoulder_flexion.*learn --atlas"):
        MotionPlanner(arm, MinimumJerkPredictor(load_arm("koch").chain))
