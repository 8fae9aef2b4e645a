"""Recordings as files.

They follow ``armsyn-motion-1`` (see `armsyn.motion.formats`), so that reading one as a motion gives
the measured motion with its landmarks. Beside it stand, in npz, keys of the recording's own fields
(``commanded_rad``, ``velocity_rad_s``, ``current_a``, ``stale``, ``hardware_error``, ``arm``,
``port``, ``simulated``, ..., of a reach ``target_m``) and, in CSV, a column ``JOINT:QUANTITY`` for
each of its arrays. `load_recording` reads npz back; keys that an older file lacks take their
defaults.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.driver.recording import Recording
from armsyn.errors import FormatError
from armsyn.motion.formats import csv_format, npz_format

ARRAYS = (
    *("commanded_rad", "sent_rad", "velocity_rad_s", "current_a", "temperature_c", "voltage_v"),
    *("stale", "hardware_error"),
)
"""Fields with one column a joint."""

FACTS = (
    *("arm", "port", "simulated", "rate_hz", "ticks", "missed_ticks", "dropped_rows"),
    *("command_success_rate", "description_sha256", "driver_version"),
)
"""Fields with one value."""


def check_recording_path(path: Path | str) -> None:
    """Refuse a path that no recording can be written to, before anything moves.

    Parameters
    ----------
    path : Path or str

    Raises
    ------
    FormatError
        Another suffix than ``.npz`` or ``.csv``, or a folder that does not exist.
    """
    path = Path(path)
    if path.suffix.lower() not in (".npz", ".csv"):
        raise FormatError(f"{path}: recordings are written as .npz or .csv")
    if not path.parent.is_dir():
        raise FormatError(f"{path}: the folder {path.parent} does not exist: make it first")


def save_recording(path: Path | str, recording: Recording, arm: ArmDescription) -> None:
    """Write a recording; the file appears whole or not at all.

    Parameters
    ----------
    path : Path or str
        ``.npz`` or ``.csv``.
    recording : Recording
    arm : ArmDescription
        The arm that was recorded.

    Raises
    ------
    FormatError
        Another suffix, another arm, or too few ticks to be a motion.
    InputError
        The file cannot be written.
    """
    check_recording_path(path)
    path, motion = Path(path), recording.measured_motion(arm)
    if path.suffix.lower() == ".npz":
        npz_format.write(path, motion, _keys(recording))
    else:
        csv_format.write(path, motion, _columns(recording))


def _keys(recording: Recording) -> dict[str, NDArray[Any]]:
    keys = {name: np.asarray(getattr(recording, name)) for name in (*ARRAYS, *FACTS)}
    keys["ending"] = np.asarray(recording.ending.name)
    keys["measured_rad"] = recording.measured_rad
    if recording.target_m is not None:
        keys["target_m"] = np.array(recording.target_m, dtype=np.float64)
    events = recording.events
    keys["event_time_s"] = np.array([event.time for event in events], dtype=np.float64)
    keys["event_text"] = np.array([event.text for event in events], dtype=np.str_)
    keys["event_level"] = np.array([event.level for event in events], dtype=np.str_)
    return keys


def _columns(recording: Recording) -> dict[str, NDArray[np.float64]]:
    return {
        f"{joint}:{name}": np.asarray(getattr(recording, name)[:, column], dtype=np.float64)
        for name in ARRAYS
        for column, joint in enumerate(recording.joint_names)
    }
