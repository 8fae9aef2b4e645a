"""What servos remember without power, kept in a file from one run to the next.

::

    {
      "schema": "firmware-sim-state-1",
      "servos": [
        {"place": "xm430-w350:1", "model": "xm430-w350", "eeprom": {"ID": 1, ...},
         "backup": null, "angle": 0.0}
      ]
    }

``place`` is what the command line or the rig file says of the servo, so that one whose ID was
changed is still known; the rest is `Servo.snapshot`. The file is replaced as a whole: whoever
reads it finds the old one or the new one.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from firmware_sim.errors import OutputError, StateFileError
from firmware_sim.servo import Servo

SCHEMA = "firmware-sim-state-1"

_FILE_SIZE_CAP = 10_000_000  # bytes; a servo takes about 2,000
_NAMES_SHOWN = 300  # characters of a list of servos in an error
_PERIOD = 0.05  # s between looks at one servo's memory

_Snapshot = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class SavedState:
    """What a state file says.

    Parameters
    ----------
    file : str
        Its path.
    names : tuple of str
        ``MODEL:ID`` of each servo, as it was asked for when the file was made.
    snapshots : tuple of mapping
        What `Servo.snapshot` returned for each; not checked.
    """

    file: str
    names: tuple[str, ...]
    snapshots: tuple[_Snapshot, ...]

    def restore(self, servos: Sequence[Servo]) -> None:
        """Put servos into this state.

        Raises
        ------
        StateFileError
            If a snapshot is not one of its servo.
        """
        for name, snapshot, servo in zip(self.names, self.snapshots, servos, strict=True):
            try:
                servo.restore_snapshot(snapshot)
            except ValueError as error:
                raise StateFileError(f"{self.file}: {name}: {error}", self.file) from None


def read_state(path: Path, names: Sequence[str]) -> SavedState | None:
    """Return what a state file says.

    Parameters
    ----------
    path : Path
        The file.
    names : sequence of str
        ``MODEL:ID`` of each servo that it must be of, in its order.

    Returns
    -------
    SavedState or None
        None when there is no file yet.

    Raises
    ------
    StateFileError
        If it cannot be read, is malformed, or belongs to other servos.
    """
    file = str(path)
    try:
        if path.stat().st_size > _FILE_SIZE_CAP:
            raise StateFileError(f"{file} is larger than {_FILE_SIZE_CAP} bytes", file)
        document = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    except OSError as error:
        raise StateFileError(f"{file} cannot be read: {error.strerror}", file) from error
    except (ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise StateFileError(f"{file} is no state file: {reason}", file) from error
    if not isinstance(document, dict) or document.get("schema") != SCHEMA:
        raise StateFileError(f'{file} is no state file: "schema" is not "{SCHEMA}"', file)
    servos = document.get("servos")
    if not isinstance(servos, list) or not all(isinstance(servo, dict) for servo in servos):
        raise StateFileError(f'{file}: "servos" is not a list of objects', file)
    _check_names([str(servo.pop("place", None)) for servo in servos], names, file)
    return SavedState(file, tuple(names), tuple(servos))


def _check_names(found: Sequence[str], expected: Sequence[str], file: str) -> None:
    if list(found) == list(expected):
        return
    shown = [", ".join(names)[:_NAMES_SHOWN] or "none" for names in (found, expected)]
    raise StateFileError(
        f"{file} is the state of {shown[0]}, not of {shown[1]}:"
        " give the servos it was made with, or another --state",
        file,
    )


def write_state(path: Path, names: Sequence[str], snapshots: Sequence[_Snapshot]) -> None:
    """Replace a state file.

    Parameters
    ----------
    path : Path
        The file.
    names : sequence of str
        ``MODEL:ID`` of each servo, as it was asked for.
    snapshots : sequence of mapping
        What `Servo.snapshot` returned for each.

    Raises
    ------
    OutputError
        If it cannot be written; the old one is left as it was.
    """
    servos = [{"place": name, **held} for name, held in zip(names, snapshots, strict=True)]
    text = json.dumps({"schema": SCHEMA, "servos": servos}, indent=1) + "\n"
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        draft.write_text(text, encoding="utf-8")
        draft.replace(path)
    except OSError as error:
        with suppress(OSError):
            draft.unlink()
        raise OutputError(f"{path} cannot be written: {error.strerror}", str(path)) from error


class StateKeeper:
    """Keeps a state file true while a simulation runs: a `server.Chore`.

    Parameters
    ----------
    path : Path
        The file, which is written at once.
    servos : sequence of Servo
        All of them.
    names : sequence of str
        ``MODEL:ID`` of each, as it was asked for.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """

    def __init__(self, path: Path, servos: Sequence[Servo], names: Sequence[str]) -> None:
        self._path = path
        self._servos = tuple(servos)
        self._names = tuple(names)
        self._snapshots: list[_Snapshot] = [servo.snapshot() for servo in servos]
        self.problem = ""
        """Why the file could not be written the last time; empty when it was."""
        self.next_due = 0.0
        self._changed = False
        self._places: Iterator[int] = iter(())
        write_state(path, self._names, self._snapshots)

    def work(self, now: float) -> None:
        """Look at one servo; after the last, write the file if any has changed."""
        place = next(self._places, None)
        if place is not None:
            self._look_at(place)
        else:
            if self._changed:
                self._save()
            self._places = iter(range(len(self._servos)))
        self.next_due = now + _PERIOD

    def close(self) -> None:
        """Write all as it is now, angles too.

        Raises
        ------
        OutputError
            If it cannot be written.
        """
        self._snapshots = [servo.snapshot() for servo in self._servos]
        write_state(self._path, self._names, self._snapshots)

    def _look_at(self, place: int) -> None:
        held, snapshot = self._snapshots[place], self._servos[place].snapshot()
        self._changed |= any(held[key] != snapshot[key] for key in ("eeprom", "backup"))
        self._snapshots[place] = snapshot

    def _save(self) -> None:
        try:
            write_state(self._path, self._names, self._snapshots)
        except OutputError as error:
            self.problem = str(error)
        else:
            self.problem = ""
            self._changed = False
