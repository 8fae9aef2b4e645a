"""Descriptions rebuilt in Pinocchio, joint by joint, without our kinematics or our MJCF."""

import numpy as np
import pinocchio as pin

from armsyn.arm import ArmDescription
from armsyn.arm.link import stand_in_inertia


def placement(xyz: tuple[float, ...], rpy: tuple[float, ...]) -> pin.SE3:
    return pin.SE3(pin.rpy.rpyToMatrix(*rpy), np.array(xyz))


def pinocchio_model(arm: ArmDescription) -> pin.Model:
    """The arm as Pinocchio knows it; a link of unknown inertia is a cylinder by its formula."""
    model = pin.Model()
    model.gravity.linear = np.array(arm.gravity)
    parent = 0
    ends = [*(joint.xyz for joint in arm.joint[1:]), arm.tip.xyz]
    for joint, end in zip(arm.joint, ends, strict=True):
        axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
        kinds = {
            "revolute": pin.JointModelRevoluteUnaligned,
            "prismatic": pin.JointModelPrismaticUnaligned,
        }
        place = placement(joint.xyz, joint.rpy)
        parent = model.addJoint(parent, kinds[joint.kind](axis), place, joint.name)
        assert joint.link is not None
        inertia = (
            stand_in_inertia(joint.link.mass, end)
            if joint.link.inertia is None
            else joint.link.inertia.matrix
        )
        body = pin.Inertia(joint.link.mass, np.array(joint.link.centre_of_mass), inertia)
        model.appendBodyToJoint(parent, body, pin.SE3.Identity())
    # MJCF has a ball of 5 mm for the point
    tool = pin.Inertia(arm.tip.mass, np.zeros(3), 0.4 * arm.tip.mass * 0.005**2 * np.eye(3))
    model.appendBodyToJoint(parent, tool, placement(arm.tip.xyz, arm.tip.rpy))
    return model
