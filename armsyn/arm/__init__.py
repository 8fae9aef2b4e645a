"""Arm descriptions and calibration: what an arm is, where its files are, rad <-> ticks."""

from armsyn.arm.calibration import Calibration
from armsyn.arm.description import ArmDescription, ServoDescription, load_arm
from armsyn.arm.search import arm_names, find_file

__all__ = [
    "ArmDescription",
    "Calibration",
    "ServoDescription",
    "arm_names",
    "find_file",
    "load_arm",
]
