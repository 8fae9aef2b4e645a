"""The joints whose names head the columns of a robot's log: those of a URDF file or of an arm."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from armsyn.errors import FormatError, InputError
from armsyn.kinematics import SerialChain
from armsyn.kinematics.urdf import load_urdf
from armsyn.motion.motion import FloatArray

TIP = "tip"


class JointLog(NamedTuple):
    """Joints of a robot.

    Attributes
    ----------
    chain : SerialChain
        From the base to the tip.
    """

    chain: SerialChain

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the joints, base to tip."""
        return tuple(joint.name for joint in self.chain.joints)

    @property
    def prismatic(self) -> frozenset[str]:
        """Names of the joints whose values are metres."""
        joints = self.chain.joints
        return frozenset(joint.name for joint in joints if joint.kind == "prismatic")

    def landmarks(
        self, joints: list[str], angles: FloatArray
    ) -> tuple[tuple[str, ...], FloatArray]:
        """Return the names and positions of the joints and the tip.

        Parameters
        ----------
        joints : list of str
            Those of the columns.
        angles : array, shape (frames, len(joints))
            rad or m.

        Returns
        -------
        names : tuple of str
            Empty when joints of the chain are not among the columns.
        positions : array, shape (frames, names, 3)
            In the frame of the base, m.
        """
        if set(joints) != set(self.names):
            return (), np.empty((len(angles), 0, 3))
        order = [joints.index(name) for name in self.names]
        return (*self.names, TIP), self.chain.positions(angles[:, order])


def read_joint_log(robot: Path) -> JointLog:
    """Return the joints of a robot.

    Parameters
    ----------
    robot : Path
        A URDF file, or the name of an arm, such as ``human7``.

    Returns
    -------
    JointLog

    Raises
    ------
    FormatError
        When there is no such robot, or it is no chain with one tip.
    """
    try:
        if robot.suffix.lower() in (".urdf", ".xml"):
            return JointLog(load_urdf(robot))
        from armsyn.arm import load_arm  # noqa: PLC0415  the arms' schema, only when it is asked

        return JointLog(load_arm(str(robot), calibrated=False).chain)
    except InputError as error:
        raise FormatError(str(error)) from error
