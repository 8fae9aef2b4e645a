"""What an arm may do: pure functions that allow a motion or a command, or say why not."""

from armsyn.safety.command import CommandLimits, check_command, check_following
from armsyn.safety.trajectory import START_TOLERANCE, check_trajectory

__all__ = [
    "START_TOLERANCE",
    "CommandLimits",
    "check_command",
    "check_following",
    "check_trajectory",
]
