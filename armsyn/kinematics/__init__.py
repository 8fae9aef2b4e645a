"""Serial chains, rotations and URDF."""

from armsyn.kinematics.chain import Joint, SerialChain

__all__ = ["Joint", "SerialChain"]
