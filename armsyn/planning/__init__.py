"""Planners: from a posture and a target to a trajectory that an arm can follow."""

from armsyn.planning.reach import PlannedReach, ReachPlanner, joined

__all__ = ["PlannedReach", "ReachPlanner", "joined"]
