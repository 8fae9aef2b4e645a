"""Motions: the container, its formats, resampling and segmentation."""

from armsyn.motion.motion import FloatArray, Motion

__all__ = ["FloatArray", "Motion"]
