"""Reaches that end with the hand turned as asked, and arms that cannot turn it so."""

import re

import numpy as np
import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.errors import CollisionError, InputError, UnreachableError
from armsyn.kinematics.rotation import from_expmap, from_rpy
from armsyn.planning import Pointing, Turned, planner_for
from armsyn.planning.posing import HandTask, pointing_axis, settled
from armsyn.safety import check_trajectory
from armsyn.scoring import measure
from tests.kinematics.oracle import Oracle

TARGET = np.array([0.35, -0.10, -0.15])


@pytest.fixture(scope="module")
def arm() -> ArmDescription:
    return load_arm("human7")


def angle_between(first: np.ndarray, second: np.ndarray) -> float:
    return float(np.arccos(np.clip(first @ second / np.linalg.norm(second), -1.0, 1.0)))


def points(arm: ArmDescription, q: np.ndarray) -> np.ndarray:
    """Where the hand points, by the oracle's places of the last joint and the tip."""
    places, _ = Oracle(arm.chain).frames(q)
    along = places[-1] - places[-2]
    return np.asarray(along / np.linalg.norm(along))


@pytest.mark.parametrize("plan", ["minjerk", "synergy"])
@pytest.mark.parametrize("direction", [(1, 0, 0), (0, 0, -1), (1, 0.5, 0.2), (5, 0, -5)])
def test_the_hand_points_where_it_is_asked_to(
    arm: ArmDescription, plan: str, direction: tuple[float, float, float]
) -> None:
    wanted = Pointing(direction)
    planned = planner_for(arm, plan).plan(arm.rest, TARGET, orientation=wanted)
    end = planned.angles[-1]
    assert angle_between(points(arm, end), np.array(direction)) <= np.radians(2.0)
    assert np.linalg.norm(Oracle(arm.chain).frames(end)[0][-1] - TARGET) <= 1e-3
    assert planned.orientation is wanted
    assert planned.orientation_error <= wanted.tolerance
    check_trajectory(planned.trajectory, arm, arm.rest)
    assert measure(planned.trajectory).speed_peaks == 1


def test_the_hands_path_stays_nearly_what_it_was(arm: ArmDescription) -> None:
    planner = planner_for(arm, "minjerk")
    free = planner.plan(arm.rest, TARGET)
    end = points(arm, free.angles[-1])
    turned = planner.plan(arm.rest, TARGET, orientation=Pointing(end + np.array([0.0, 0.3, 0.0])))
    gaps = np.linalg.norm(free.trajectory.hand[:, None] - turned.trajectory.hand, axis=2)
    assert gaps.min(axis=0).max() < 0.005


@pytest.mark.parametrize("name", ["human7", "widowx_250s", "viperx_300s", "reachy_right"])
def test_whole_orientations_of_arms_that_have_the_joints(name: str) -> None:
    """Those of postures that the arm has, so that it can."""
    arm, rng, reached = load_arm(name), np.random.default_rng(1), 0
    planner = planner_for(arm, "minjerk")
    for _ in range(4):
        away = arm.rest + 0.4 * rng.uniform(-1.0, 1.0, arm.chain.dof)
        there = np.clip(away, arm.chain.lower + 0.05, arm.chain.upper - 0.05)
        frames = arm.chain.forward(there)
        try:
            wanted = Turned(frames.orientations[-1])
            planned = planner.plan(arm.rest, frames.tip, orientation=wanted)
        except CollisionError:  # that posture is one within a table, say
            continue
        _, tip = Oracle(arm.chain).frames(planned.angles[-1])
        turn = tip[-1] @ np.asarray(wanted.rotation).T
        assert np.arccos(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0)) <= np.radians(2.0)
        reached += 1
    assert reached >= 2


@pytest.mark.parametrize(
    ("name", "target", "wanted", "said"),
    [
        (
            "openmanipulator_x",
            (0.2, 0.08, 0.15),
            Pointing((0, 1, 0)),
            "its 4 joints leave one of 2",
        ),
        ("openmanipulator_x", (0.2, 0.08, 0.15), Turned(np.eye(3)), "its 4 joints leave one of 3"),
        ("koch", (-0.2, 0.08, 0.15), Pointing((0, 1, 0)), "its 5 joints leave one of 2"),
        ("human7", TARGET, Pointing((-1, 0, 0)), "its joints' ranges end before"),
    ],
)
def test_what_an_arm_cannot_express_is_refused_with_how_near_it_comes(
    name: str, target: tuple[float, float, float], wanted: Pointing | Turned, said: str
) -> None:
    arm = load_arm(name)
    with pytest.raises(UnreachableError, match=said) as caught:
        planner_for(arm, "minjerk").plan(arm.rest, target, orientation=wanted)
    assert "comes no nearer than" in str(caught.value)
    assert "--orientation-tolerance" in str(caught.value)


def test_an_arm_of_four_joints_points_within_its_plane() -> None:
    arm = load_arm("openmanipulator_x")
    target = np.array([0.2, 0.08, 0.15])
    away = np.array([*(target[:2] - [0.012, 0.0]), -0.05])  # from the axis of its first joint
    planned = planner_for(arm, "minjerk").plan(arm.rest, target, orientation=Pointing(away))
    assert angle_between(points(arm, planned.angles[-1]), away) <= np.radians(2.0)


def test_a_tolerance_is_used(arm: ArmDescription) -> None:
    with pytest.raises(UnreachableError):
        planner_for(arm, "minjerk").plan(arm.rest, TARGET, orientation=Pointing((-1, 0, 0)))
    wide = Pointing((-1, 0, 0), tolerance=np.pi)
    free = planner_for(arm, "minjerk").plan(arm.rest, TARGET)
    planned = planner_for(arm, "minjerk").plan(arm.rest, TARGET, orientation=wide)
    np.testing.assert_array_equal(planned.angles, free.angles)


@pytest.mark.parametrize("name", ["human7", "reachy_right"])
def test_the_jacobian_of_a_task_is_what_is_left_differentiated(name: str) -> None:
    arm, step = load_arm(name), 1e-6
    chain = arm.chain
    q = arm.rest + 0.1
    near = from_expmap([0.02, -0.01, 0.015]) @ chain.forward(q).orientations[-1]
    for wanted in (Turned(near), Pointing(near @ pointing_axis(chain))):
        task = HandTask(chain.forward(q).tip + 0.01, wanted)
        left, jacobian = task.left(chain, q)
        found = np.array(
            [
                (task.left(chain, q - step * e)[0] - task.left(chain, q + step * e)[0]) / (2 * step)
                for e in np.eye(chain.dof)
            ]
        ).T
        np.testing.assert_allclose(jacobian[:3], found[:3], atol=1e-6)
        np.testing.assert_allclose(jacobian[3:], found[3:], atol=0.03)  # near what is wanted
        assert left.shape == (6,)
        assert task.errors(chain, settled(chain, task, q)) == pytest.approx((0.0, 0.0), abs=1e-3)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Pointing((0, 0, 0)),
        lambda: Pointing((1, 0)),
        lambda: Pointing((1, np.nan, 0)),
        lambda: Pointing((1, 0, 0), tolerance=0.0),
        lambda: Pointing((1, 0, 0), tolerance=4.0),
        lambda: Turned(np.eye(4)),
        lambda: Turned(np.diag([1.0, 1.0, -1.0])),
        lambda: Turned(from_rpy([0.1, 0.2, 0.3]), tolerance=np.nan),
    ],
)
def test_what_is_no_orientation_is_refused(wrong: object) -> None:
    assert callable(wrong)
    with pytest.raises(InputError):
        wrong()


def test_pointing_the_very_other_way_is_a_turn_of_half_a_circle(arm: ArmDescription) -> None:
    hand = arm.chain.forward(arm.rest)
    away = Pointing(-(hand.orientations[-1] @ pointing_axis(arm.chain)))
    left, _ = HandTask(hand.tip, away).left(arm.chain, arm.rest)
    assert np.linalg.norm(left[3:]) == pytest.approx(np.pi)


@pytest.mark.parametrize("length", [1e-200, 1e-320, 1.0, 1e200])
def test_a_direction_has_any_length(length: float) -> None:
    direction = np.asarray(Pointing((3 * length, 4 * length, 0.0)).direction)
    np.testing.assert_allclose(direction, [0.6, 0.8, 0.0], atol=1e-3)


def test_what_is_off_by_less_than_is_allowed_is_not_refused() -> None:
    """Directions 3 degrees beside the plane of an arm of four joints, to be met to 10."""
    arm, target, said = load_arm("openmanipulator_x"), np.array([0.2, 0.08, 0.15]), []
    azimuth = np.arctan2(0.08, 0.188) + np.radians(3.0)  # from the axis of its first joint
    for pitch in np.radians(np.arange(-60.0, 61.0, 10.0)):
        away = from_rpy((0.0, pitch, azimuth))[:, 0]
        wanted = Pointing(away, tolerance=np.radians(10.0))
        try:
            planned = planner_for(arm, "minjerk").plan(arm.rest, target, orientation=wanted)
        except UnreachableError as error:
            said.append(str(error))
        else:
            assert angle_between(points(arm, planned.angles[-1]), away) <= np.radians(10.0)
    nearest = [re.search(r"no nearer than ([0-9.]+) degrees", words) for words in said]
    assert all(found is None or float(found[1]) >= 10.0 for found in nearest)
    assert len(said) <= 6
