"""Independent kinematics: Pinocchio models of chains, and finite differences."""

from collections.abc import Callable
from functools import cached_property

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from armsyn.kinematics import SerialChain

Array = NDArray[np.float64]


class Oracle:
    """A chain as Pinocchio builds it from the same joints."""

    def __init__(self, chain: SerialChain) -> None:
        self.model = pin.Model()
        parent = 0
        for joint in chain.joints:
            moving = {
                "revolute": pin.JointModelRevoluteUnaligned,
                "prismatic": pin.JointModelPrismaticUnaligned,
            }[joint.kind](np.array(joint.axis) / np.linalg.norm(joint.axis))
            place = pin.SE3(pin.rpy.rpyToMatrix(*joint.rpy), np.array(joint.xyz))
            parent = self.model.addJoint(parent, moving, place, joint.name)
        tip = pin.SE3(pin.rpy.rpyToMatrix(*chain.tip_rpy), np.array(chain.tip_xyz))
        self.tip = self.model.addFrame(pin.Frame("tip", parent, 0, tip, pin.FrameType.OP_FRAME))

    @cached_property
    def data(self) -> pin.Data:
        return self.model.createData()

    def frames(self, q: Array) -> tuple[Array, Array]:
        """Positions (n + 1, 3) and orientations (n + 1, 3, 3) of joints and tip."""
        pin.framesForwardKinematics(self.model, self.data, q)
        frames = [*list(self.data.oMi)[1:], self.data.oMf[self.tip]]
        return np.array([f.translation for f in frames]), np.array([f.rotation for f in frames])

    def jacobian(self, q: Array) -> Array:
        """Geometric Jacobian of the tip, base axes, shape (6, n)."""
        reference = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        J = pin.computeFrameJacobian(self.model, self.data, q, self.tip, reference)
        return np.array(J).reshape(6, -1)  # a single column comes as a vector


def differences(function: Callable[[Array], Array], at: Array, step: float = 1e-6) -> Array:
    """Central differences of a vector function: shape (values, n)."""
    steps = step * np.eye(at.size)
    columns = [(function(at + h) - function(at - h)) / (2.0 * step) for h in steps]
    return np.stack(columns, axis=-1)


def angular_differences(rotation: Callable[[Array], Array], at: Array, step: float = 1e-6) -> Array:
    """Angular velocity per unit of each variable, base axes, by central differences: (3, n)."""
    columns = []
    for h in step * np.eye(at.size):
        W = (rotation(at + h) - rotation(at - h)) / (2.0 * step) @ rotation(at).T
        columns.append([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]])
    return 0.5 * np.array(columns).T


def random_posture(chain: SerialChain, rng: np.random.Generator) -> Array:
    """Return a posture anywhere within the limits."""
    return rng.uniform(chain.lower, chain.upper)
