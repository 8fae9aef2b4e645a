"""What a solver answers at the edges: unreachable, already there, bad input, no chance."""

import numpy as np
import pytest

from armsyn.errors import InputError
from armsyn.ik import OPTIMISERS, optimiser_settings, solve_ik
from armsyn.kinematics import Joint, SerialChain
from tests.kinematics.oracle import Oracle

START = np.array([0.4, 0.3, 0.2, 0.9, 0.1, 0.1, -0.1])
LENGTH = 0.66
PLANAR = SerialChain(
    (
        Joint("shoulder", lower=-3.0, upper=3.0),
        Joint("elbow", xyz=(0.3, 0.0, 0.0), lower=-3.0, upper=3.0),
    ),
    tip_xyz=(0.2, 0.0, 0.0),
)


@pytest.mark.parametrize("optimiser", OPTIMISERS)
@pytest.mark.parametrize(
    "direction", [(1.0, 0.0, 0.0), (0.6, -0.8, 0.0), (0.0, -0.6, -0.8), (0.48, -0.6, -0.64)]
)
@pytest.mark.parametrize("distance", [0.67, 0.9, 3.0])
def test_an_unreachable_target_is_missed_by_what_is_too_far(
    human7: SerialChain, oracle: Oracle, optimiser: str, direction: tuple, distance: float
) -> None:
    target = distance * np.array(direction)
    result = solve_ik(human7, target, START, optimiser=optimiser, restarts=3)
    assert not result.success
    # the inverses swing about the stretched arm, where they are nearly singular
    near = 1.5e-3 if optimiser in ("jt", "njt") else 0.02
    too_far = distance - LENGTH
    assert too_far - 1e-12 <= result.position_error <= too_far + near
    hand = oracle.frames(result.posture)[0][-1]
    assert np.linalg.norm(hand - target) == pytest.approx(result.position_error, abs=1e-9)


@pytest.mark.parametrize("optimiser", OPTIMISERS)
def test_a_target_inside_the_hole_of_a_planar_arm(optimiser: str) -> None:
    # the elbow bends to 3 rad at most, so the hand stays clear of the shoulder
    nearest = np.sqrt(0.3**2 + 0.2**2 + 2 * 0.3 * 0.2 * np.cos(3.0))
    result = solve_ik(PLANAR, [0.02, 0.0, 0.0], [0.5, 1.0], optimiser=optimiser, restarts=5)
    assert not result.success
    assert result.position_error == pytest.approx(nearest - 0.02, abs=1e-3)


@pytest.mark.parametrize("optimiser", OPTIMISERS)
def test_the_two_postures_of_a_planar_arm(optimiser: str) -> None:
    # cosine rule: elbow of a 0.3, 0.2 arm whose hand is 0.4 away
    elbow = np.pi - np.arccos((0.3**2 + 0.2**2 - 0.4**2) / (2 * 0.3 * 0.2))
    for side in (1.0, -1.0):
        start = [0.1, side]
        result = solve_ik(PLANAR, [0.4, 0.0, 0.0], start, optimiser=optimiser, tolerance=1e-9)
        assert result.success
        assert result.posture[1] == pytest.approx(side * elbow, abs=1e-7)


def test_a_prismatic_joint_is_solved_in_metres() -> None:
    chain = SerialChain(
        (Joint("turn"), Joint("slide", "prismatic", axis=(1.0, 0.0, 0.0), lower=0.1, upper=0.6))
    )
    result = solve_ik(chain, [0.3, 0.4, 0.0], [0.0, 0.2])
    assert result.success
    np.testing.assert_allclose(result.posture, [np.arctan2(0.4, 0.3), 0.5], atol=1e-3)
    short = solve_ik(chain, [0.7, 0.0, 0.0], [0.5, 0.2])
    assert not short.success
    assert short.position_error == pytest.approx(0.1, abs=1e-6)
    assert short.posture[1] == 0.6


@pytest.mark.parametrize("optimiser", OPTIMISERS)
@pytest.mark.parametrize("pose", [False, True])
def test_where_the_hand_is_already(human7: SerialChain, optimiser: str, pose: bool) -> None:
    at = human7.forward(START)
    result = solve_ik(
        human7,
        at.tip,
        START,
        orientation=at.orientations[-1] if pose else None,
        optimiser=optimiser,
    )
    assert result.success
    assert result.steps == 0
    np.testing.assert_array_equal(result.posture, START)


def test_an_orientation_that_the_limits_forbid_is_said_so(human7: SerialChain) -> None:
    at = human7.forward(np.zeros(7))
    upside_down = at.orientations[-1] @ np.diag([1.0, -1.0, -1.0])
    result = solve_ik(human7, at.tip, START, orientation=upside_down, restarts=5)
    assert not result.success
    assert result.position_error + result.orientation_error > 0.1


def test_a_start_outside_the_limits_is_brought_inside(human7: SerialChain) -> None:
    result = solve_ik(human7, human7.forward(START).tip, np.full(7, 9.0), restarts=20)
    assert result.success
    assert (human7.lower <= result.posture).all()
    assert (result.posture <= human7.upper).all()


def test_the_same_seed_gives_the_same_posture(human7: SerialChain) -> None:
    far = np.array([0.5, 0.1, -0.35])
    solve = [solve_ik(human7, far, START, restarts=5, seed=seed) for seed in (3, 3)]
    np.testing.assert_array_equal(solve[0].posture, solve[1].posture)
    assert solve[0][1:] == solve[1][1:]


def test_steps_are_bounded_and_what_is_given_stays(human7: SerialChain) -> None:
    start, target = START.copy(), np.array([0.3, -0.2, 0.3])
    result = solve_ik(human7, target, start, optimiser="jt", max_steps=7, restarts=2)
    assert result.steps <= 21
    np.testing.assert_array_equal(start, START)
    np.testing.assert_array_equal(target, [0.3, -0.2, 0.3])


TARGET = (0.3, -0.2, -0.2)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"target": (0.3, -0.2)}, "3 finite numbers of metres"),
        ({"target": (0.3, np.nan, 0.0)}, "3 finite numbers of metres"),
        ({"target": (0.3, np.inf, 0.0)}, "3 finite numbers of metres"),
        ({"start": np.zeros(6)}, "7 finite numbers"),
        ({"start": np.full(7, np.nan)}, "7 finite numbers"),
        ({"orientation": np.eye(2)}, "3 x 3 rotation matrix"),
        ({"orientation": 2 * np.eye(3)}, "3 x 3 rotation matrix"),
        ({"orientation": np.full((3, 3), np.nan)}, "3 x 3 rotation matrix"),
        ({"orientation": np.diag([1.0, 1.0, -1.0])}, "must not mirror"),
        ({"optimiser": "lm"}, "no optimiser 'lm'; known: svd, jt, njt, dls"),
        ({"tolerance": 0.0}, "tolerance must be above 0"),
        ({"tolerance": np.nan}, "tolerance must be above 0"),
        ({"max_steps": 0}, "max_steps at least 1"),
        ({"restarts": -1}, "restarts at least 0"),
    ],
)
def test_bad_input(human7: SerialChain, changes: dict, says: str) -> None:
    given = {"target": TARGET, "start": START, **changes}
    with pytest.raises(InputError, match=says):
        solve_ik(human7, **given)


@pytest.mark.parametrize(
    ("constants", "says"),
    [
        ({"cut_off": -0.1}, "cut_off must be in"),
        ({"cut_off": 1.0}, "cut_off must be in"),
        ({"damping": 0.0}, "damping above 0"),
        ({"damping": np.nan}, "damping above 0"),
        ({"slowing": 0.0}, "slowing and radius must be above 0"),
        ({"radius": np.inf}, "slowing and radius must be above 0"),
    ],
)
def test_bad_constants(constants: dict, says: str) -> None:
    with pytest.raises(InputError, match=says):
        optimiser_settings("svd", **constants)
