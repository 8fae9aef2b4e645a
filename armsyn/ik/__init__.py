"""Iterative inverse kinematics: the paper's function O in four forms, and a solver around it."""

from armsyn.ik.landmarks import PostureFit, fit_posture
from armsyn.ik.optimisers import OPTIMISERS, optimiser_settings
from armsyn.ik.solve import IkResult, solve_ik

__all__ = [
    "OPTIMISERS",
    "IkResult",
    "PostureFit",
    "fit_posture",
    "optimiser_settings",
    "solve_ik",
]
