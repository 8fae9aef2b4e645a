"""What an arm may do: pure functions that allow a motion or a command, or say why not."""

from armsyn.safety.collision import MARGIN, Clearances, Closest, check_collision, closest
from armsyn.safety.command import CommandLimits, check_command, check_following
from armsyn.safety.tick import (
    TickState,
    Verdict,
    averaged_current,
    check_load,
    check_rates,
    judge_tick,
    warm_joints,
)
from armsyn.safety.trajectory import START_TOLERANCE, check_trajectory

__all__ = [
    "MARGIN",
    "START_TOLERANCE",
    "Clearances",
    "Closest",
    "CommandLimits",
    "TickState",
    "Verdict",
    "averaged_current",
    "check_collision",
    "check_command",
    "check_following",
    "check_load",
    "check_rates",
    "check_trajectory",
    "closest",
    "judge_tick",
    "warm_joints",
]
