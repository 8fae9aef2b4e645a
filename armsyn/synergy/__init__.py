"""Synergy inverse kinematics: models, controller, learning (Aubry, Julliard, Gibet 2009)."""

from armsyn.synergy.controller import Controller, RollOut
from armsyn.synergy.library import LearnedReach, SynergyLibrary, SynergySet, load_library
from armsyn.synergy.models import MODELS, parameter_names, synergies

__all__ = [
    "MODELS",
    "Controller",
    "LearnedReach",
    "RollOut",
    "SynergyLibrary",
    "SynergySet",
    "load_library",
    "parameter_names",
    "synergies",
]
