"""Quaternions and skeletons against scipy's rotations and against a joint-by-joint recursion."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from armsyn.errors import InputError
from armsyn.kinematics import quaternion
from armsyn.kinematics.rotation import from_rpy, to_rpy
from armsyn.kinematics.skeleton import Skeleton

angles = st.floats(-7, 7)
orders = ["", "x", "zyx", "zxy", "xyz", "yzx", "yxz", "xzy", "zx"]


@pytest.mark.parametrize("order", orders)
@given(st.data())
def test_euler_angles_are_those_of_scipy(order: str, data: st.DataObject) -> None:
    values = data.draw(arrays(np.float64, (3, len(order)), elements=angles))
    found = quaternion.from_euler(order, values)
    there = np.eye(3)[None].repeat(3, axis=0)
    for place, axis in enumerate(order):
        there = there @ Rotation.from_euler(axis, values[:, [place]]).as_matrix()
    np.testing.assert_allclose(Rotation.from_quat(found).as_matrix(), there, atol=1e-12)


@given(arrays(np.float64, 3, elements=st.floats(-3, 3)))
def test_exponential_maps_are_those_of_scipy(rotation_vector: np.ndarray) -> None:
    turn = Rotation.from_rotvec(rotation_vector)
    for q in (turn.as_quat(), -turn.as_quat()):
        found = quaternion.to_expmap(q)
        assert np.linalg.norm(found) <= np.pi + 1e-12
        again = Rotation.from_rotvec(found)
        assert (again.inv() * turn).magnitude() < 1e-7


@given(arrays(np.float64, 3, elements=st.sampled_from([0, 1e-9, 0.5, np.pi / 2, np.pi, -3])))
def test_quaternions_of_matrices_lose_no_digits(rotation_vector: np.ndarray) -> None:
    R = Rotation.from_rotvec(rotation_vector).as_matrix()
    q = quaternion.from_matrix(R)
    assert np.linalg.norm(q) == pytest.approx(1)
    np.testing.assert_allclose(Rotation.from_quat(q).as_matrix(), R, atol=1e-14)


def test_roll_pitch_and_yaw_of_many_matrices_at_once() -> None:
    many = np.random.default_rng(0).uniform(-1.5, 1.5, (4, 5, 3))
    R = np.array([[from_rpy(rpy) for rpy in row] for row in many])
    np.testing.assert_allclose(to_rpy(R), many, atol=1e-12)


@st.composite
def skeletons(draw: st.DrawFn) -> Skeleton:
    count = draw(st.integers(1, 6))
    parents = (-1, *(draw(st.integers(0, joint - 1)) for joint in range(1, count)))
    numbers = arrays(np.float64, (2, count, 3), elements=st.floats(-2, 2))
    offsets, turns = draw(numbers)
    before = Rotation.from_rotvec(turns).as_matrix()
    return Skeleton(tuple(f"j{joint}" for joint in range(count)), parents, offsets, before)


@given(skeletons(), st.integers(0, 2**32 - 1), st.booleans())
def test_frames_are_the_recursion_joint_by_joint(
    skeleton: Skeleton, seed: int, moving: bool
) -> None:
    random = np.random.default_rng(seed)
    turns, moved = random.normal(size=(2, 3, skeleton.joints, 3))
    root = random.normal(size=(3, 3))
    found = skeleton.frames(root, turns, moved if moving else None)
    for frame in range(3):
        there: list[tuple[np.ndarray, Rotation]] = []
        for joint, parent in enumerate(skeleton.parents):
            before = Rotation.from_matrix(np.asarray(skeleton.prerotations)[joint])
            local = before * Rotation.from_rotvec(turns[frame, joint])
            if parent < 0:
                there.append((root[frame], local))
                continue
            place, above = there[parent]
            offset = skeleton.offsets[joint] + (moved[frame, joint] if moving else 0)
            there.append((place + above.apply(offset), above * local))
        places, orientations = zip(*there, strict=True)
        np.testing.assert_allclose(found.positions[frame], places, atol=1e-12)
        matrices = [turn.as_matrix() for turn in orientations]
        np.testing.assert_allclose(found.orientations[frame], matrices, atol=1e-12)


def test_positions_of_many_frames_are_those_of_the_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    skeleton = Skeleton(("a", "b"), (-1, 0), np.ones((2, 3)))
    turns = np.random.default_rng(1).normal(size=(7, 2, 3))
    whole = skeleton.positions(turns[:, 0], turns)
    monkeypatch.setattr("armsyn.kinematics.skeleton._FRAMES_AT_ONCE", 3)
    np.testing.assert_array_equal(skeleton.positions(turns[:, 0], turns), whole)


def test_paths_and_names() -> None:
    skeleton = Skeleton(("hips", "chest", "arm", "leg"), (-1, 0, 1, 0), np.zeros((4, 3)))
    assert skeleton.path_to(2) == [0, 1, 2]
    assert skeleton.index("leg") == 3
    with pytest.raises(InputError, match="no joint 'tail'; it has hips, chest, arm, leg"):
        skeleton.index("tail")


@pytest.mark.parametrize(
    ("names", "parents", "offsets", "match"),
    [
        ((), (), np.zeros((0, 3)), "unique names"),
        (("a", "a"), (-1, 0), np.zeros((2, 3)), "unique names"),
        (("a", "b"), (-1,), np.zeros((2, 3)), "one parent a joint"),
        (("a", "b"), (0, 0), np.zeros((2, 3)), "the root"),
        (("a", "b"), (-1, 1), np.zeros((2, 3)), "'b' has parent 1"),
        (("a", "b"), (-1, -1), np.zeros((2, 3)), "'b' has parent -1"),
        (("a", "b"), (-1, 0), np.zeros((2, 2)), "offsets"),
        (("a", "b"), (-1, 0), np.full((2, 3), np.nan), "offsets are finite"),
    ],
)
def test_what_is_no_tree_is_refused(
    names: tuple[str, ...], parents: tuple[int, ...], offsets: np.ndarray, match: str
) -> None:
    with pytest.raises(InputError, match=match):
        Skeleton(names, parents, offsets)


def test_channels_that_do_not_fit_are_refused() -> None:
    skeleton = Skeleton(("a", "b"), (-1, 0), np.zeros((2, 3)))
    with pytest.raises(InputError, match="do not fit"):
        skeleton.frames(np.zeros((4, 3)), np.zeros((4, 3, 3)))
    with pytest.raises(InputError, match=r"translations .* do not fit"):
        skeleton.positions(np.zeros((4, 3)), np.zeros((4, 2, 3)), np.zeros((4, 1, 3)))
