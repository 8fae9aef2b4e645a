"""Serial chains, rotations and URDF."""

from armsyn.kinematics.chain import Joint, SerialChain
from armsyn.kinematics.urdf import load_urdf

__all__ = ["Joint", "SerialChain", "load_urdf"]
