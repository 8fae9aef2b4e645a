"""Talking to an arm: bus, checks before torque, streaming, recording."""

from armsyn.driver.clearing import clear_watchdogs
from armsyn.driver.log import Event
from armsyn.driver.monitor import ArmMonitor
from armsyn.driver.path import straight_way
from armsyn.driver.recording import Ending, Recording, fingerprint
from armsyn.driver.recording_files import check_recording_path, save_recording
from armsyn.driver.recording_load import load_recording
from armsyn.driver.session import ArmSession
from armsyn.driver.stillness import still_posture

__all__ = [
    "ArmMonitor",
    "ArmSession",
    "Ending",
    "Event",
    "Recording",
    "check_recording_path",
    "clear_watchdogs",
    "fingerprint",
    "load_recording",
    "save_recording",
    "still_posture",
    "straight_way",
]
