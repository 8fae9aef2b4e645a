"""Arm descriptions and calibration: what an arm is, where its files are, rad <-> ticks."""

from armsyn.arm.calibration import Calibration
from armsyn.arm.description import ArmDescription, load_arm
from armsyn.arm.gravity import gravity_torque
from armsyn.arm.joints import JointDescription
from armsyn.arm.search import arm_names, find_file
from armsyn.arm.servos import GripperDescription, ServoDescription, calibration_of

__all__ = [
    "ArmDescription",
    "Calibration",
    "GripperDescription",
    "JointDescription",
    "ServoDescription",
    "arm_names",
    "calibration_of",
    "find_file",
    "gravity_torque",
    "load_arm",
]
