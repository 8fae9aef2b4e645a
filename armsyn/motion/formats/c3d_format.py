"""C3D (c3d.org), binary marker data, read through the package ``c3d`` (extra ``formats``).

Points whose residual is negative are gaps. Length unit, rate and labels are the file's own
(``POINT:UNITS``, ``RATE``, ``LABELS``, ``LABELS2``); without a unit none is guessed. The axis up
is that of ``POINT:Y_SCREEN``, the vertical of the screen, else z is assumed and said. Points with
another ``POINT:TYPE_GROUPS`` than positions (angles, forces, moments, powers) are left out, and
named. Analog channels are not read.
"""

from __future__ import annotations

import struct
import warnings
from pathlib import Path
from typing import IO, Any

import numpy as np

from armsyn.errors import FormatError
from armsyn.motion.formats.files import check_size
from armsyn.motion.formats.options import METRES, Reading, ReadOptions, fact, metres, z_up
from armsyn.motion.motion import FloatArray, Motion

LARGEST_FILE = 256 * 2**20
MOST_POSITIONS = 10_000_000
"""Frames times points."""
_BLOCK = 512
_KEY = 0x50
_NOT_POSITIONS = ("ANGLES", "FORCES", "MOMENTS", "POWERS")
_DAMAGE = (
    *(ValueError, TypeError, LookupError, AttributeError, AssertionError, OverflowError),
    *(struct.error, EOFError, OSError, MemoryError, ArithmeticError, RuntimeError, NameError),
)
"""What the package raises on damaged files."""


def read(path: Path, options: ReadOptions) -> Reading:
    """Read the points of a C3D file.

    Parameters
    ----------
    path : Path
    options : ReadOptions
        `unit`, `up` and `rate` are heard.

    Returns
    -------
    Reading

    Raises
    ------
    FormatError
        When the package is missing; else one line with the file and the byte or parameter that is
        wrong.
    """
    try:
        import c3d  # noqa: PLC0415  an extra
    except ImportError:
        raise FormatError(
            f"{path}: C3D needs the package c3d: install it with pip install 'armsyn[formats]'"
        ) from None
    size = check_size(path, LARGEST_FILE)
    try:
        with path.open("rb") as file, warnings.catch_warnings():
            warnings.simplefilter("ignore")  # analog data that is not there, and the like
            _check_header(file, size, path)
            reader = c3d.Reader(file)
            _check_counts(reader, size, path)
            frames = reader.read_frames(copy=True)
            points = np.array([frame[1][:, :4] for frame in frames], dtype=np.float64)
            facts = _Facts(reader, path)
            return _assemble(facts, points, path, options)
    except FormatError:
        raise
    except _DAMAGE as error:
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise FormatError(f"{path}: not a C3D file, or damaged: {reason}") from error


def _check_header(file: IO[bytes], size: int, path: Path) -> None:
    """Look at the two bytes that every C3D file begins with, and where its parameters are."""
    start = file.read(2)
    file.seek(0)
    if len(start) < 2 or start[1] != _KEY or size < 2 * _BLOCK:
        raise FormatError(f"{path}: byte 1 is not 0x50, or it is too short: not a C3D file")
    if (start[0] - 1) * _BLOCK + 4 > size:
        raise FormatError(f"{path}: byte 0: the parameters begin after the end: the file was cut")


def _check_counts(reader: Any, size: int, path: Path) -> None:
    """Compare what the header claims with what the file holds, before memory is given to it."""
    frames, points = int(reader.last_frame - reader.first_frame + 1), int(reader.point_used)
    if frames < 2 or points < 1 or frames * points > MOST_POSITIONS:
        raise FormatError(
            f"{path}: {frames} frames of {points} points: at least two of one, together no more"
            f" than {MOST_POSITIONS}"
        )
    word = 4 if reader.point_scale < 0 else 2
    analog = int(reader.analog_used) * int(reader.header.analog_per_frame)
    start = (int(reader.header.data_block) - 1) * _BLOCK
    end = start + frames * word * (4 * points + analog)
    if start < _BLOCK or end > size:
        raise FormatError(
            f"{path}: the frames end at byte {end}, the file at {size}: it was cut, or its header"
            " is damaged"
        )


class _Facts:
    """What the parameters say."""

    def __init__(self, reader: Any, path: Path) -> None:
        self._reader = reader
        count = int(reader.point_used)
        labels = [*self.texts("LABELS"), *self.texts("LABELS2")][:count]
        self.labels = labels + [f"point{index + 1}" for index in range(len(labels), count)]
        self.rate = float(reader.point_rate)
        self.unit = next(iter(self.texts("UNITS")), "")
        self.up = next(iter(self.texts("Y_SCREEN")), "")[-1:].lower()
        self.not_positions = {
            label for kind in _NOT_POSITIONS for label in self.texts(kind) if label in self.labels
        }
        if len(set(self.labels)) != count:
            raise FormatError(f"{path}: POINT:LABELS are not unique")

    def texts(self, name: str) -> list[str]:
        parameter = self._reader.get(f"POINT:{name}")
        if parameter is None:
            return []
        if not parameter.dimensions:
            return []
        if len(parameter.dimensions) == 1:
            return [str(parameter.string_value).strip("\0 ")]
        return [str(text).strip("\0 ") for text in np.ravel(parameter.string_array)]


def _assemble(facts: _Facts, points: FloatArray, path: Path, options: ReadOptions) -> Reading:
    unit = options.unit or facts.unit
    if options.unit is None and unit not in METRES:
        raise FormatError(
            f"{path}: POINT:UNITS is '{unit[:40]}', not one of {', '.join(METRES)}: say the unit"
        )
    up = options.up or (facts.up if facts.up in ("x", "y", "z") else "z")
    rate = options.rate or facts.rate
    if not 0 < rate < 1e6:
        raise FormatError(f"{path}: a rate of {rate:g} Hz: say it")
    kept = [row for row, name in enumerate(facts.labels) if name not in facts.not_positions]
    positions = points[:, kept, :3] * metres(unit)
    positions[points[:, kept, 3] < 0] = np.nan
    try:
        motion = Motion(
            time=np.arange(len(points)) / rate,
            landmark_names=tuple(facts.labels[row] for row in kept),
            landmarks=z_up(positions, up),
            source=path.name,
        )
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from error
    said = {
        "unit": unit,
        "up": fact(up, options.up or facts.up == up),
        "rate": f"{rate:g} Hz",
    }
    if facts.not_positions:
        said["left out"] = "no positions: " + ", ".join(
            label for label in facts.labels if label in facts.not_positions
        )
    return Reading(motion, said)
