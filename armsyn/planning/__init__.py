"""Planners: from a posture and a target to a trajectory that an arm can follow."""

from armsyn.planning.reach import PlannedReach, ReachPlanner

__all__ = ["PlannedReach", "ReachPlanner"]
