"""Talking to an arm: bus, checks before torque, streaming, recording."""

from armsyn.driver.recording import Ending, Recording
from armsyn.driver.session import ArmSession, clear_watchdogs

__all__ = ["ArmSession", "Ending", "Recording", "clear_watchdogs"]
