"""Trees with one pose vector: places against the skeleton's and chain's own, Jacobians against
central differences.
"""

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.errors import InputError
from armsyn.kernels.editing_tree import exponential, left_jacobian
from armsyn.kinematics import quaternion
from armsyn.kinematics.pose_tree import PoseTree, chain_tree, skeleton_tree
from armsyn.kinematics.rotation import from_expmap
from armsyn.kinematics.skeleton import Skeleton

STEP = 1e-6
ANGLES = [0.0, 1e-9, 1e-5, 0.0099, 0.0101, 1.0, np.pi - 1e-4, np.pi, np.pi + 1e-4, 4.5]


def a_skeleton(rng: np.random.Generator) -> Skeleton:
    return Skeleton(
        ("root", "spine", "head", "arm", "hand"),
        (-1, 0, 1, 1, 3),
        rng.normal(scale=0.3, size=(5, 3)),
        from_expmap(rng.normal(size=(5, 3))),
    )


def assert_jacobian_is_the_derivative(tree: PoseTree, pose: np.ndarray, tolerance: float) -> None:
    bodies = np.arange(len(tree.bodies))
    points = np.random.default_rng(1).normal(scale=0.2, size=(len(bodies), 3))
    found = tree.points(pose, bodies, points)
    for column in range(tree.size):
        nudge = np.zeros(tree.size)
        nudge[column] = STEP
        more, less = (tree.points(pose + s * nudge, bodies, points) for s in (1, -1))
        turned = more.orientations @ less.orientations.swapaxes(-1, -2)
        linear = (more.positions - less.positions) / (2 * STEP)
        angular = quaternion.to_expmap(quaternion.from_matrix(turned)) / (2 * STEP)
        np.testing.assert_allclose(found.jacobians[:, :3, column], linear, atol=tolerance)
        np.testing.assert_allclose(found.jacobians[:, 3:, column], angular, atol=tolerance)


@pytest.mark.parametrize("angle", ANGLES)
def test_a_skeletons_jacobian_at_any_angle(angle: float) -> None:
    rng = np.random.default_rng(7)
    tree = skeleton_tree(a_skeleton(rng), [1, 3])
    axes = rng.normal(size=(5, 3))
    axes *= angle / np.linalg.norm(axes, axis=1, keepdims=True)
    pose = np.concatenate([rng.normal(size=3), axes.ravel(), rng.normal(scale=0.1, size=6)])
    assert_jacobian_is_the_derivative(tree, pose, 1e-6)


@pytest.mark.parametrize("name", ["human7", "koch"])
def test_a_chains_tree_is_the_chain(name: str) -> None:
    chain = load_arm(name).chain
    q = np.random.default_rng(3).uniform(chain.lower, chain.upper)
    tree = chain_tree(chain)
    np.testing.assert_allclose(tree.positions(q[None])[0], chain.forward(q).positions, atol=1e-12)
    at_tip = tree.points(q, np.array([chain.dof]), np.zeros((1, 3)))
    np.testing.assert_allclose(at_tip.jacobians[0], chain.jacobian(q, pose=True), atol=1e-12)
    np.testing.assert_allclose(
        at_tip.orientations[0], chain.forward(q).orientations[-1], atol=1e-12
    )
    assert_jacobian_is_the_derivative(tree, q, 1e-6)


def test_a_skeletons_tree_is_the_skeleton() -> None:
    rng = np.random.default_rng(5)
    skeleton = a_skeleton(rng)
    root, turns = rng.normal(size=(4, 3)), rng.normal(size=(4, 5, 3))
    moved = np.zeros((4, 5, 3))
    moved[:, 3] = rng.normal(size=(4, 3))
    poses = np.concatenate([root, turns.reshape(4, -1), moved[:, 3]], axis=1)
    wanted = skeleton.positions(root, turns, moved)
    np.testing.assert_allclose(skeleton_tree(skeleton, [3]).positions(poses), wanted, atol=1e-12)


@pytest.mark.parametrize("angle", ANGLES)
def test_the_left_jacobian_is_that_of_the_exponential(angle: float) -> None:
    w = np.array([0.36, -0.48, 0.8]) * angle
    L, R, more, less = (np.empty((3, 3)) for _ in range(4))
    left_jacobian(w, L)
    exponential(w, R)
    np.testing.assert_allclose(R, from_expmap(w), atol=1e-14)
    for column in range(3):
        nudge = np.eye(3)[column] * STEP
        exponential(w + nudge, more)
        exponential(w - nudge, less)
        turned = quaternion.to_expmap(quaternion.from_matrix(more @ less.T)) / (2 * STEP)
        np.testing.assert_allclose(L[:, column], turned, atol=1e-8)


def test_an_unknown_body_is_named() -> None:
    tree = skeleton_tree(a_skeleton(np.random.default_rng(0)))
    with pytest.raises(InputError, match="no body 'tail' here; there are root, spine"):
        tree.body("tail")
