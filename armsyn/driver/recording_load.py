"""Recordings read back from npz files, old ones included; of CSV, what was commanded."""

from __future__ import annotations

import csv
import math
import zipfile
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from armsyn.driver.log import Event, Level
from armsyn.driver.recording import Ending, Recording
from armsyn.errors import FormatError
from armsyn.motion.formats import npz_format

_DAMAGE = (zipfile.BadZipFile, OSError, EOFError, ValueError, TypeError, KeyError, SyntaxError)
_LEVELS = ("info", "warning", "fault")


def load_recording(path: Path | str) -> Recording:
    """Read a recording; files of older versions too, whose missing parts take their defaults.

    Parameters
    ----------
    path : Path or str
        An ``.npz`` file of `save_recording`.

    Returns
    -------
    Recording

    Raises
    ------
    FormatError
        Not a recording in npz, or a damaged one; one line with the file and the key.
    """
    path = Path(path)
    if path.suffix.lower() != ".npz":
        raise FormatError(f"{path}: only .npz holds a whole recording: read other files as motions")
    motion = npz_format.read(path)  # which bounds the file's size and all that is in a motion
    assert motion.angles is not None or motion.landmarks is not None  # noqa: S101 - a Motion
    with zipfile.ZipFile(path) as archive:
        reader = _Reader(path, archive, (motion.frames, len(motion.joint_names)))
        if motion.angles is None or not reader.has("commanded_rad"):
            raise FormatError(f"{path}: a motion, but not a recording of an arm")
        arrays = {
            name: reader.array(name)
            for name in ("velocity_rad_s", "current_a", "commanded_rad", "stale", "hardware_error")
        }
        newer = ("measured_rad", "sent_rad", "temperature_c", "voltage_v")
        arrays |= {name: reader.array(name) for name in newer if reader.has(name)}
        arrays.setdefault("measured_rad", motion.angles)
        facts = {name: reader.fact(name, kind) for name, kind in _FACTS.items()}
        later = ("description_sha256", "driver_version")
        facts |= {name: reader.fact(name, "U") if reader.has(name) else "" for name in later}
        return Recording(
            **arrays,
            **facts,
            time_s=motion.time.copy(),
            joint_names=motion.joint_names,
            target_m=reader.target(),
            events=reader.events(),
            ending=reader.ending(),
        )


_FACTS = {
    **{"arm": "U", "port": "U", "simulated": "b", "rate_hz": "f"},
    **{"ticks": "i", "missed_ticks": "i", "dropped_rows": "i", "command_success_rate": "f"},
}


class _Reader:
    """Reads members after their headers have been compared with what they must be."""

    def __init__(self, path: Path, archive: zipfile.ZipFile, shape: tuple[int, int]) -> None:
        self._path = path
        self._archive = archive
        self._shape = shape
        self._names = set(archive.namelist())

    def has(self, key: str) -> bool:
        return f"{key}.npy" in self._names

    def array(self, key: str) -> Any:
        found = self._member(key)
        if found.shape != self._shape or found.dtype.kind not in "fiub":
            raise FormatError(
                f"{self._path}: '{key}' is {found.dtype} of shape {found.shape}, expected numbers"
                f" of shape {self._shape}"
            )
        return found

    def fact(self, key: str, kind: str) -> Any:
        found = self._member(key)
        if found.shape != () or found.dtype.kind != kind:
            raise FormatError(f"{self._path}: '{key}' is not a single value of its kind")
        return found.item()

    def ending(self) -> Ending:
        name = self.fact("ending", "U")
        try:
            return Ending[name]
        except KeyError:
            raise FormatError(f"{self._path}: unknown ending {name[:40]!r}") from None

    def target(self) -> tuple[float, float, float] | None:
        if not self.has("target_m"):
            return None
        row = self._row("target_m", "f")
        if len(row) != 3 or not all(map(math.isfinite, row)):
            raise FormatError(f"{self._path}: 'target_m' is not three finite numbers")
        return row[0], row[1], row[2]

    def events(self) -> tuple[Event, ...]:
        times, texts = self._row("event_time_s", "f"), self._row("event_text", "U")
        levels = ["info"] * len(times)
        if self.has("event_level"):
            levels = self._row("event_level", "U")
        if not len(times) == len(texts) == len(levels) or not set(levels) <= set(_LEVELS):
            raise FormatError(f"{self._path}: the events do not fit each other")
        return tuple(
            Event(time, text, cast("Level", level))
            for time, text, level in zip(times, texts, levels, strict=True)
        )

    def _row(self, key: str, kind: str) -> list[Any]:
        found = self._member(key)
        if found.ndim != 1 or (found.dtype.kind != kind and found.size):
            raise FormatError(f"{self._path}: '{key}' is not a row of its kind")
        row: list[Any] = found.tolist()
        return row

    def _member(self, key: str) -> NDArray[Any]:
        try:
            member = self._archive.getinfo(f"{key}.npy")
            with self._archive.open(member) as stream:
                version = npy.read_magic(stream)
                read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
                shape, _, dtype = read(stream)
                claimed = stream.tell() + math.prod(shape) * dtype.itemsize
            if dtype.hasobject or claimed != member.file_size:
                raise ValueError(f"{dtype} of shape {shape} in {member.file_size} bytes")
            if member.file_size > npz_format.LARGEST_ARRAY:
                raise ValueError(f"{member.file_size} bytes")
            with self._archive.open(member) as stream:
                array: NDArray[Any] = npy.read_array(stream, allow_pickle=False)
                return np.array(array)
        except _DAMAGE as error:
            raise FormatError(
                f"{self._path}: '{key}' is missing or damaged: {str(error)[:80]}"
            ) from error


def read_commanded(path: Path, joint_names: tuple[str, ...]) -> NDArray[np.float64] | None:
    """Read what was commanded from a recording in CSV.

    Parameters
    ----------
    path : Path
        Which `armsyn.motion.formats.read_motion` has read already.
    joint_names : tuple of str
        Joints, in the order that is wanted.

    Returns
    -------
    array, shape (frames, n), or None
        rad; None where the file has no such columns.

    Raises
    ------
    FormatError
        A cell that is no number.
    """
    with path.open(encoding="utf-8-sig", newline="") as file:
        rows = csv.reader(line for line in file if not line.startswith("#"))
        header = next(rows)
        names = [f"{name}:commanded_rad" for name in joint_names]
        if not set(names) <= set(header):
            return None
        places = [header.index(name) for name in names]
        try:
            found = [[float(row[place] or "nan") for place in places] for row in rows if row]
        except (ValueError, IndexError) as error:
            raise FormatError(f"{path}: what was commanded is damaged: {error}") from error
    return np.array(found, dtype=np.float64)
