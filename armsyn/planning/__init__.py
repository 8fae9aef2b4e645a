"""Planners: from a posture and a target to a trajectory that an arm can follow."""

from armsyn.planning.planned import PlannedReach, concatenated
from armsyn.planning.planner import DEFAULT_PLAN, PLANS, Planner, default_plan, planner_for
from armsyn.planning.posing import HandOrientation, Pointing, Turned
from armsyn.planning.synergy_planner import SynergyPlanner

__all__ = [
    "DEFAULT_PLAN",
    "PLANS",
    "HandOrientation",
    "PlannedReach",
    "Planner",
    "Pointing",
    "SynergyPlanner",
    "Turned",
    "concatenated",
    "default_plan",
    "planner_for",
]
