"""SerialChain against Pinocchio, finite differences and published facts."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armsyn.arm import arm_names, load_arm
from armsyn.errors import InputError
from armsyn.kinematics import Joint, SerialChain
from tests.kinematics.oracle import Oracle, angular_differences, differences, random_posture

POSTURES = 50
PLANAR = SerialChain(
    (Joint("a"), Joint("b", xyz=(0.3, 0.0, 0.0))),
    tip_xyz=(0.2, 0.0, 0.0),
)


def assert_agrees_with_pin(chain: SerialChain, q: np.ndarray) -> None:
    oracle = Oracle(chain)
    frames = chain.forward(q)
    positions, orientations = oracle.frames(q)
    tight = {"rtol": 0, "atol": 1e-9}
    np.testing.assert_allclose(frames.positions, positions, **tight)
    np.testing.assert_allclose(frames.orientations, orientations, **tight)
    np.testing.assert_allclose(frames.tip, positions[-1], **tight)
    np.testing.assert_allclose(chain.positions(q[None])[0], positions, **tight)
    J = oracle.jacobian(q)
    np.testing.assert_allclose(chain.jacobian(q), J[:3], **tight)
    np.testing.assert_allclose(chain.jacobian(q, pose=True), J, **tight)


@pytest.mark.parametrize("name", arm_names())
def test_every_described_arm_agrees_with_pinocchio(name: str) -> None:
    chain = load_arm(name).chain
    rng = np.random.default_rng(11)
    for _ in range(POSTURES):
        assert_agrees_with_pin(chain, random_posture(chain, rng))


@pytest.mark.parametrize("name", arm_names())
def test_jacobians_are_the_derivatives(name: str) -> None:
    chain = load_arm(name).chain
    rng = np.random.default_rng(12)
    for _ in range(10):
        q = random_posture(chain, rng)
        moved = differences(lambda at: chain.forward(at).tip, q)
        turned = angular_differences(lambda at: chain.forward(at).orientations[-1], q)
        expected = np.concatenate([moved, turned])
        np.testing.assert_allclose(chain.jacobian(q, pose=True), expected, rtol=0, atol=1e-8)


def test_path_is_posture_by_posture() -> None:
    chain = load_arm("human7").chain
    rng = np.random.default_rng(13)
    path = np.array([random_posture(chain, rng) for _ in range(20)])
    expected = [Oracle(chain).frames(q)[0] for q in path]
    np.testing.assert_allclose(chain.positions(path), expected, rtol=0, atol=1e-9)


numbers = st.floats(-2.0, 2.0)
angles = st.floats(-np.pi, np.pi) | st.sampled_from([0.0, np.pi / 2, -np.pi / 2, np.pi])
triples = st.tuples(numbers, numbers, numbers)
directions = triples.filter(lambda axis: np.linalg.norm(axis) > 1e-3) | st.sampled_from(
    [(0.0, 0.0, -1.0), (1e-7, 0.0, -1.0), (0.0, -3.0, 0.0), (1e-9, 1e-9, 1.0)]
)
joints = st.builds(
    Joint,
    name=st.just("joint"),
    kind=st.sampled_from(["revolute", "prismatic"]),
    xyz=triples,
    rpy=st.tuples(angles, angles, angles),
    axis=directions,
)


@st.composite
def chains(draw: st.DrawFn) -> SerialChain:
    drawn = draw(st.lists(joints, min_size=1, max_size=8))
    named = tuple(dataclasses.replace(j, name=f"j{i}") for i, j in enumerate(drawn))
    return SerialChain(named, draw(triples), draw(st.tuples(angles, angles, angles)))


@settings(max_examples=150, deadline=None)
@given(chain=chains(), seed=st.integers(0, 2**32 - 1))
def test_any_chain_agrees_with_pinocchio(chain: SerialChain, seed: int) -> None:
    q = np.random.default_rng(seed).uniform(-4.0, 4.0, chain.dof)
    assert_agrees_with_pin(chain, q)


@settings(max_examples=50, deadline=None)
@given(chain=chains(), seed=st.integers(0, 2**32 - 1))
def test_no_posture_is_beyond_reach(chain: SerialChain, seed: int) -> None:
    q = random_posture(chain, np.random.default_rng(seed))
    base = np.array(chain.joints[0].xyz)
    tip = Oracle(chain).frames(q)[0][-1]
    assert np.linalg.norm(tip - base) <= chain.reach + 1e-9


# (sums of the offsets that the arms' makers publish: reference frames as in their URDFs)
ZERO_TIPS = {
    "human7": (0.0, 0.0, -0.66),
    "openmanipulator_x": (0.286, 0.0, 0.1875),
    "koch": (-0.14828 - 0.08, -0.0013, 0.1673),
}


@pytest.mark.parametrize(("name", "tip"), ZERO_TIPS.items())
def test_published_zero_pose(name: str, tip: tuple[float, float, float]) -> None:
    chain = load_arm(name).chain
    np.testing.assert_allclose(chain.forward(np.zeros(chain.dof)).tip, tip, rtol=0, atol=1e-9)


def test_openmanipulator_bends_forward_and_pans_left() -> None:
    chain = load_arm("openmanipulator_x").chain
    upper_arm = np.hypot(0.024, 0.128)
    lean = np.arctan2(0.024, 0.128)
    q = np.array([np.pi / 2, 0.5, -0.5, 0.0])
    ahead = 0.012, upper_arm * np.sin(lean + 0.5) + 0.124 + 0.126
    expected = [ahead[0], ahead[1], 0.0595 + upper_arm * np.cos(lean + 0.5)]
    np.testing.assert_allclose(chain.forward(q).tip, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("joint", "tip"),
    [
        ("shoulder_flexion", (0.66, 0.0, 0.0)),
        ("shoulder_abduction", (0.0, -0.66, 0.0)),
        ("elbow_flexion", (0.36, 0.0, -0.30)),
        ("wrist_deviation", (0.10, 0.0, -0.56)),
    ],
)
def test_human7_right_angles_go_where_anatomy_says(
    joint: str, tip: tuple[float, float, float]
) -> None:
    chain = load_arm("human7").chain
    q = np.where(np.array(chain.names) == joint, np.pi / 2, 0.0)
    np.testing.assert_allclose(chain.forward(q).tip, tip, rtol=0, atol=1e-12)


def test_planar_arm_in_closed_form() -> None:
    frames = PLANAR.forward([np.pi / 2, np.pi / 2])
    expected = [[0, 0, 0], [0, 0.3, 0], [-0.2, 0.3, 0]]
    np.testing.assert_allclose(frames.positions, expected, rtol=0, atol=1e-15)
    np.testing.assert_allclose(
        PLANAR.jacobian([np.pi / 2, np.pi / 2]), [[-0.3, 0], [-0.2, -0.2], [0, 0]], atol=1e-15
    )
    assert PLANAR.reach == pytest.approx(0.5)
    assert PLANAR.dof == 2
    assert PLANAR.names == ("a", "b")


def test_limits_are_the_joints() -> None:
    chain = SerialChain((Joint("a", lower=-0.5, upper=1.0), Joint("b", "prismatic", upper=0.2)))
    np.testing.assert_array_equal(chain.lower, [-0.5, -np.pi])
    np.testing.assert_array_equal(chain.upper, [1.0, 0.2])


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"kind": "planar"}, "not revolute or prismatic"),
        ({"axis": (0.0, 0.0, 0.0)}, "no length"),
        ({"xyz": (np.nan, 0.0, 0.0)}, "finite"),
        ({"upper": np.inf}, "finite"),
        ({"lower": 1.0, "upper": 1.0}, "not below"),
    ],
)
def test_refused_joints_are_named(fields: dict, says: str) -> None:
    with pytest.raises(InputError, match=f"joint odd.*{says}"):
        Joint("odd", **fields)


def test_refused_chains() -> None:
    with pytest.raises(InputError, match="at least one"):
        SerialChain(())
    with pytest.raises(InputError, match="share a name"):
        SerialChain((Joint("a"), Joint("a")))


@pytest.mark.parametrize(
    "bad", [[0.0], [0.0, 0.0, 0.0], [0.0, np.nan], [np.inf, 0.0], [[0.0, 0.0]]]
)
def test_refused_postures(bad: list) -> None:
    for method in (PLANAR.forward, PLANAR.jacobian, PLANAR.checked_posture):
        with pytest.raises(InputError, match="2 finite numbers"):
            method(bad)


@pytest.mark.parametrize("bad", [[0.0, 0.0], [[0.0]], [[0.0, np.nan]]])
def test_refused_paths(bad: list) -> None:
    with pytest.raises(InputError, match="2 finite columns"):
        PLANAR.positions(bad)


def test_what_is_given_stays_as_it_is() -> None:
    q = np.array([0.1, 0.2])
    PLANAR.forward(q)
    PLANAR.jacobian(q)
    PLANAR.checked_posture(q)[0] = 9.0
    np.testing.assert_array_equal(q, [0.1, 0.2])
