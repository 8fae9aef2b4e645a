"""What an arm may do: pure functions that allow a motion or a command, or say why not."""

from armsyn.safety.collision import MARGIN, Clearances, Closest, check_collision, closest
from armsyn.safety.command import (
    check_command,
    check_commands,
    check_following,
    check_rates,
)
from armsyn.safety.limits import CommandLimits
from armsyn.safety.load import averaged_current, check_load, warm_joints
from armsyn.safety.state import TickState
from armsyn.safety.tick import Verdict, judge_tick
from armsyn.safety.trajectory import START_TOLERANCE, check_start, check_trajectory

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
    "check_commands",
    "check_following",
    "check_load",
    "check_rates",
    "check_start",
    "check_trajectory",
    "closest",
    "judge_tick",
    "warm_joints",
]
