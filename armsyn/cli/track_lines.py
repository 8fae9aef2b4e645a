"""Targets as lines of JSON from a file descriptor, read without ever waiting long for one."""

from __future__ import annotations

import fcntl
import math
import os
import select
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import msgspec

from armsyn.cli.orientation_options import orientation_of
from armsyn.errors import FormatError, InputError
from armsyn.planning import HandOrientation
from armsyn.planning.checking import FARTHEST

LONGEST_LINE = 10_000
"""Bytes; what is longer is no target."""

_CHUNK = 65536


class TargetLine(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One target.

    Attributes
    ----------
    target : 3-tuple of float
        Where the hand goes, m, arm base frame.
    t : float or None
        When to turn to it, s after tracking began; at once without it.
    id : str, int, float or None
        The sender's own; it is given back.
    pointing : 3-tuple of float or None
        Where the hand points there, base frame.
    orientation : 3-tuple of float or None
        How it is turned there, roll, pitch and yaw in degrees.
    """

    target: tuple[float, float, float]
    t: float | None = None
    id: str | int | float | None = None
    pointing: tuple[float, float, float] | None = None
    orientation: tuple[float, float, float] | None = None


class NumberedTarget(NamedTuple):
    """A target with the number of its line, from 1, and how the hand is to be turned."""

    number: int
    line: TargetLine
    orientation: HandOrientation | None = None


def parse_target(text: bytes, longest: float = math.inf) -> TargetLine:
    """Read one line.

    Parameters
    ----------
    text : bytes
    longest : float
        s after which tracking ends.

    Returns
    -------
    TargetLine

    Raises
    ------
    FormatError
        It is no target; the message says why.
    """
    if len(text) > LONGEST_LINE:
        raise FormatError(f"longer than {LONGEST_LINE} bytes")
    try:
        line = msgspec.json.decode(text, type=TargetLine)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise FormatError(f'{error}; a target is {{"target": [x, y, z]}} in metres') from error
    if not all(map(math.isfinite, (*line.target, line.t or 0.0))):
        raise FormatError("target and t must be finite numbers")
    if any(abs(x) > FARTHEST for x in line.target):
        raise FormatError(f"target must be within {FARTHEST:.0f} m")
    if line.t is not None and line.t >= longest:
        raise FormatError(f"t is {line.t:g} s, tracking ends at {longest:g} s")
    return line


def turned(line: TargetLine, options: Mapping[str, Any]) -> HandOrientation | None:
    """How the hand is to be turned: as a line says, or else as the command's options.

    Parameters
    ----------
    line : TargetLine
    options : mapping
        As `armsyn.cli.orientation_options` gives them.

    Returns
    -------
    HandOrientation or None

    Raises
    ------
    FormatError
        Both are said, or no direction.
    """
    said = {"pointing": line.pointing, "orientation": line.orientation}
    try:
        return orientation_of({**options, **said} if any(said.values()) else dict(options))
    except InputError as error:
        raise FormatError(str(error).replace("--", "")) from error


@dataclass
class LineReader:
    """Lines of a file descriptor, which may be a pipe, a terminal or a file.

    Parameters
    ----------
    descriptor : int

    Attributes
    ----------
    ended : bool
        Whether there is nothing more to come.

    Raises
    ------
    InputError
        Nothing can be read from it.
    """

    descriptor: int
    ended: bool = False
    _rest: bytes = b""
    _number: int = field(default=0)

    def __post_init__(self) -> None:
        try:
            flags = fcntl.fcntl(self.descriptor, fcntl.F_GETFL)
        except OSError as error:
            raise _unreadable(error) from error
        if flags & os.O_ACCMODE == os.O_WRONLY:
            raise InputError("standard input is open for writing only: give targets to read")

    def read(self, patience: float) -> list[tuple[int, bytes]]:
        """Wait up to `patience` s for lines: their numbers, from 1, and text; none that are blank.

        Of a line that is too long, only the beginning is kept; InputError when reading fails.
        """
        if self.ended or not select.select([self.descriptor], [], [], patience)[0]:
            return []
        try:
            chunk = os.read(self.descriptor, _CHUNK)
        except BlockingIOError:  # somebody else has read it
            return []
        except OSError as error:
            raise _unreadable(error) from error
        self.ended = not chunk
        *lines, rest = (self._rest + chunk).split(b"\n")
        self._rest = rest[: LONGEST_LINE + 1]
        if self.ended and self._rest:
            lines, self._rest = [*lines, self._rest], b""
        found = list(enumerate(lines, self._number + 1))
        self._number += len(lines)
        return [(number, text.strip()) for number, text in found if text.strip()]


def _unreadable(error: OSError) -> InputError:
    return InputError(f"standard input cannot be read: {error.strerror}")
