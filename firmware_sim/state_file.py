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
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from firmware_sim.control_table import Area
from firmware_sim.errors import OutputError, StateFileError
from firmware_sim.model import ServoModel
from firmware_sim.rig import ServoSettings
from firmware_sim.servo import Servo

SCHEMA = "firmware-sim-state-1"

_FILE_SIZE_CAP = 10_000_000  # bytes; a servo takes about 2,000
_PERIOD = 0.05  # s between looks at one servo's memory

_Snapshot = Mapping[str, Any]


def read_state(path: Path, settings: Sequence[ServoSettings]) -> list[_Snapshot] | None:
    """Return the servos' snapshots out of a state file.

    Parameters
    ----------
    path : Path
        The file.
    settings : sequence of ServoSettings
        The servos that it must be of.

    Returns
    -------
    list of mapping, or None
        One a servo, in the order of `settings`; None when there is no file yet.

    Raises
    ------
    StateFileError
        If it cannot be read, is malformed, or belongs to other servos.
    """
    try:
        if path.stat().st_size > _FILE_SIZE_CAP:
            raise StateFileError(f"{path} is larger than {_FILE_SIZE_CAP} bytes", str(path))
        document = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    except OSError as error:
        raise StateFileError(f"{path} cannot be read: {error.strerror}", str(path)) from error
    except (ValueError, RecursionError) as error:
        reason = str(error).replace("\n", " ")
        raise StateFileError(f"{path} is no state file: {reason}", str(path)) from error
    try:
        return _check_document(document, settings)
    except StateFileError as error:
        raise StateFileError(f"{path}: {error}", str(path)) from None


def _check_document(document: object, settings: Sequence[ServoSettings]) -> list[_Snapshot]:
    if not isinstance(document, dict) or document.get("schema") != SCHEMA:
        raise StateFileError(f'no state file: "schema" is not "{SCHEMA}"', "")
    servos = document.get("servos")
    if not isinstance(servos, list) or not all(isinstance(servo, dict) for servo in servos):
        raise StateFileError('"servos" is not a list of objects', "")
    found = [str(servo.get("place")) for servo in servos]
    expected = [servo.name for servo in settings]
    if found != expected:
        raise StateFileError(
            f"it is the state of {', '.join(found)}, not of {', '.join(expected)}:"
            " give the servos it was made with, or another --state",
            "",
        )
    for servo, setting in zip(servos, settings, strict=True):
        _check_snapshot(servo, setting)
    return servos


def _check_snapshot(snapshot: _Snapshot, setting: ServoSettings) -> None:
    model = setting.model
    if snapshot.get("model") != model.name:
        raise StateFileError(f"{setting.name}: model {snapshot.get('model')!r}", "")
    angle = snapshot.get("angle")
    if not isinstance(angle, int | float) or not math.isfinite(angle):
        raise StateFileError(f"{setting.name}: angle {angle!r} is not a number", "")
    _check_registers(snapshot.get("eeprom"), model, f"{setting.name}: eeprom", whole=True)
    if snapshot.get("backup") is not None:
        _check_registers(snapshot["backup"], model, f"{setting.name}: backup", whole=False)


def _check_registers(values: object, model: ServoModel, where: str, *, whole: bool) -> None:
    if not isinstance(values, dict):
        raise StateFileError(f"{where} is not an object", "")
    if whole:
        names = {row.name for row in model.table.registers if row.area is Area.EEPROM}
        if names != set(values):
            other = ", ".join(sorted(names ^ set(values)))
            raise StateFileError(f"{where}: other registers than the firmware's: {other}", "")
    for name, value in values.items():
        register = model.table.by_name.get(name)
        if register is None:
            raise StateFileError(f"{where}: {model.name} has no register {name!r}", "")
        if type(value) is not int or not register.minimum <= value <= register.maximum:
            raise StateFileError(f"{where}: {name} = {value!r} is not possible", "")
    if values.get("Baud Rate", next(iter(model.baud_rates))) not in model.baud_rates:
        raise StateFileError(f"{where}: Baud Rate = {values['Baud Rate']} is not possible", "")


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
