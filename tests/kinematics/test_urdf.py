"""URDF files: the same chain that Pinocchio reads."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armsyn.kinematics import SerialChain, load_urdf
from armsyn.kinematics.urdf import parse_urdf
from tests.kinematics.robots import UrdfOracle, UrdfPart, urdf

FINGERS = (
    UrdfPart("jaw", "fixed", xyz=(0.02, 0.0, 0.0), parent="wrist_rotate_link"),
    UrdfPart("left", "prismatic", axis=(0.0, 1.0, 0.0), limit=(0.015, 0.037), parent="jaw_link"),
    UrdfPart(
        "right",
        "prismatic",
        axis=(0.0, 1.0, 0.0),
        limit=(-0.037, -0.015),
        parent="jaw_link",
        inside='<mimic joint="left" multiplier="-1"/>',
    ),
)


def degrees(low: float, high: float) -> tuple[float, float]:
    return float(np.deg2rad(low)), float(np.deg2rad(high))


X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
# Offsets, axes and limits of Interbotix's wx250s and vx300s (interbotix_ros_manipulators, BSD-3)
WIDOWX = (
    UrdfPart("waist", xyz=(0.0, 0.0, 0.072), axis=Z, limit=degrees(-180, 180)),
    UrdfPart("shoulder", xyz=(0.0, 0.0, 0.03865), axis=Y, limit=degrees(-108, 114)),
    UrdfPart("elbow", xyz=(0.04975, 0.0, 0.25), axis=Y, limit=degrees(-123, 92)),
    UrdfPart("forearm_roll", xyz=(0.175, 0.0, 0.0), axis=X, limit=degrees(-180, 180)),
    UrdfPart("wrist_angle", xyz=(0.075, 0.0, 0.0), axis=Y, limit=degrees(-100, 123)),
    UrdfPart("wrist_rotate", xyz=(0.065, 0.0, 0.0), axis=X, limit=degrees(-180, 180)),
)
VIPERX = (
    UrdfPart("waist", xyz=(0.0, 0.0, 0.079), axis=Z, limit=degrees(-180, 180)),
    UrdfPart("shoulder", xyz=(0.0, 0.0, 0.04805), axis=Y, limit=degrees(-106, 72)),
    UrdfPart("elbow", xyz=(0.05955, 0.0, 0.3), axis=Y, limit=degrees(-101, 92)),
    UrdfPart("forearm_roll", xyz=(0.2, 0.0, 0.0), axis=X, limit=degrees(-180, 180)),
    UrdfPart("wrist_angle", xyz=(0.1, 0.0, 0.0), axis=Y, limit=degrees(-107, 128)),
    UrdfPart("wrist_rotate", xyz=(0.069744, 0.0, 0.0), axis=X, limit=degrees(-180, 180)),
)


def hand(x: float) -> UrdfPart:
    return UrdfPart("hand", "fixed", xyz=(x, 0.0, 0.0), parent="wrist_rotate_link")


def assert_same_robot(chain: SerialChain, text: str, tip: str, seed: int = 1) -> None:
    """Compare with Pinocchio's reading of `text`, which has links named after their joints."""
    oracle = UrdfOracle(text)
    rng = np.random.default_rng(seed)
    for _ in range(10):
        q = rng.uniform(chain.lower, chain.upper)
        values = dict(zip(chain.names, q.tolist(), strict=True))
        expected = oracle.frames(values, [*(f"{name}_link" for name in chain.names), tip])
        found = chain.forward(q)
        for place, (position, orientation) in enumerate(expected):
            np.testing.assert_allclose(found.positions[place], position, rtol=0, atol=1e-9)
            np.testing.assert_allclose(found.orientations[place], orientation, rtol=0, atol=1e-9)
        J = chain.jacobian(q, pose=True)
        np.testing.assert_allclose(J, oracle.jacobian(values, tip), rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("parts", "hand_x", "tip"),
    [(WIDOWX, 0.093575, (0.458325, 0.0, 0.36065)), (VIPERX, 0.1072, (0.536494, 0.0, 0.42705))],
    ids=["wx250s", "vx300s"],
)
def test_published_arms(
    tmp_path: Path, parts: tuple[UrdfPart, ...], hand_x: float, tip: tuple[float, float, float]
) -> None:
    text = urdf(*parts, hand(hand_x), *FINGERS)
    file = tmp_path / "arm.urdf"
    file.write_text(text)
    chain = load_urdf(file, tip="hand_link")
    assert chain.names == tuple(part.name for part in parts)
    np.testing.assert_allclose(chain.forward(np.zeros(6)).tip, tip, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(chain.lower, [part.limit[0] for part in parts if part.limit])
    np.testing.assert_array_equal(chain.upper, [part.limit[1] for part in parts if part.limit])
    assert_same_robot(chain, text, "hand_link")
    by_text = load_urdf(str(file), base="base", tip="hand_link")
    np.testing.assert_array_equal(by_text.arrays.rotation, chain.arrays.rotation)


numbers = st.floats(-1.5, 1.5)
angles = st.floats(-np.pi, np.pi) | st.sampled_from([np.pi / 2, -np.pi / 2, np.pi])
triples = st.tuples(numbers, numbers, numbers)
directions = triples.filter(lambda axis: np.linalg.norm(axis) > 0.01).map(
    lambda axis: tuple((np.array(axis) / np.linalg.norm(axis)).tolist())
)
parts = st.builds(
    UrdfPart,
    name=st.just("part"),
    kind=st.sampled_from(["revolute", "continuous", "prismatic", "fixed", "fixed"]),
    xyz=st.none() | triples,
    rpy=st.none() | st.tuples(angles, angles, angles),
    axis=st.none() | directions,
)


@st.composite
def robots(draw: st.DrawFn) -> list[UrdfPart]:
    kinds = draw(st.lists(parts, min_size=1, max_size=9))
    return [
        UrdfPart(f"j{i}", part.kind, part.xyz, part.rpy, part.axis) for i, part in enumerate(kinds)
    ]


@settings(max_examples=100, deadline=None)
@given(robot=robots().filter(lambda robot: any(part.kind != "fixed" for part in robot)))
def test_any_robot_is_read_as_pinocchio_reads_it(robot: list[UrdfPart]) -> None:
    text = urdf(*robot)
    chain = parse_urdf(text, "robot.urdf")
    assert chain.names == tuple(part.name for part in robot if part.kind != "fixed")
    assert_same_robot(chain, text, f"{robot[-1].name}_link")


def test_base_in_the_middle_is_the_base_frame() -> None:
    text = urdf(*WIDOWX)
    whole = parse_urdf(text, "robot.urdf")
    part = parse_urdf(text, "robot.urdf", base="elbow_link", tip="wrist_angle_link")
    assert part.names == ("forearm_roll", "wrist_angle")
    q = np.array([0.0, 0.0, 0.0, 0.3, -0.7, 0.0])
    elbow, wrist = UrdfOracle(text).frames(
        dict(zip(whole.names, q.tolist(), strict=True)), ["elbow_link", "wrist_angle_link"]
    )
    expected = elbow[1].T @ (wrist[0] - elbow[0])
    np.testing.assert_allclose(part.forward(q[3:5]).tip, expected, rtol=0, atol=1e-12)


def test_what_urdf_leaves_out_has_its_defaults() -> None:
    chain = parse_urdf(urdf(UrdfPart("a", limit=(0.0, 1.0))), "robot.urdf")
    joint = chain.joints[0]
    assert (joint.xyz, joint.rpy, joint.axis) == ((0.0,) * 3, (0.0,) * 3, (1.0, 0.0, 0.0))
    inside = '<limit upper="0.5" effort="1" velocity="1"/>'
    chain = parse_urdf(urdf(UrdfPart("a", limit=None, inside=inside)), "robot.urdf")
    assert (chain.joints[0].lower, chain.joints[0].upper) == (0.0, 0.5)


def test_numbers_without_fixed_joints_stay_as_written() -> None:
    part = UrdfPart("a", xyz=(0.1, 0.2, 0.3), rpy=(2.0, 3.0, -4.0), axis=(0.0, 2.0, 0.0))
    joint = parse_urdf(urdf(part), "robot.urdf").joints[0]
    assert (joint.xyz, joint.rpy, joint.axis) == (part.xyz, part.rpy, part.axis)


def test_a_continuous_joint_has_one_turn_whatever_its_limit_says() -> None:
    inside = '<limit lower="-9" upper="9" effort="1" velocity="1"/>'
    for extra in ("", inside):
        chain = parse_urdf(urdf(UrdfPart("spin", "continuous", inside=extra)), "robot.urdf")
        assert (chain.joints[0].kind, chain.joints[0].lower, chain.joints[0].upper) == (
            "revolute",
            -np.pi,
            np.pi,
        )


def test_everything_beside_the_chain_is_left_alone() -> None:
    text = urdf(
        UrdfPart("a"),
        UrdfPart("floats", "floating", parent="base"),
        UrdfPart("limitless", limit=None, parent="base"),
        UrdfPart("copies", parent="base", inside='<mimic joint="a"/>'),
        extra='<transmission name="t"><joint name="a"/></transmission><gazebo reference="a"/>',
    )
    assert parse_urdf(text, "robot.urdf", tip="a_link").names == ("a",)
