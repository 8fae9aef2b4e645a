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
changed is still known; the rest is `Servo.snapshot`. While a simulator runs, what is written to
EEPROM is in the file a tenth of a second later at the latest, also if the simulator is killed then;
angles are written at its end. The file is replaced as a whole: whoever reads it finds the old one
or the new one.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from firmware_sim.errors import OutputError, StateFileError
from firmware_sim.files import InUseError, OwnerMark, read_capped
from firmware_sim.firmware.control_table import Area
from firmware_sim.firmware.servo import Servo

SCHEMA = "firmware-sim-state-1"

_FILE_SIZE_CAP = 10_000_000  # bytes; a servo takes about 2,000
_NAMES_SHOWN = 300  # characters of a list of servos in an error
_PERIOD = 0.05  # s between looks at the servos' memories

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

    def with_registers(self, registers: Sequence[Mapping[str, int]]) -> SavedState:
        """Return a state in which EEPROM registers of each servo hold something else."""
        snapshots: list[_Snapshot] = []
        for snapshot, own in zip(self.snapshots, registers, strict=True):
            eeprom = snapshot.get("eeprom")
            if isinstance(eeprom, dict):  # or it is refused when it is restored
                snapshots.append({**snapshot, "eeprom": {**eeprom, **own}})
            else:
                snapshots.append(snapshot)
        return replace(self, snapshots=tuple(snapshots))

    def differences(self, registers: Sequence[Mapping[str, int]]) -> list[str]:
        """Return a few words for each register that is otherwise than somebody asked for."""
        words = []
        for name, snapshot, asked in zip(self.names, self.snapshots, registers, strict=True):
            eeprom = snapshot.get("eeprom")
            held = eeprom if isinstance(eeprom, dict) else {}
            words += [
                f"{name} {register} = {held[register]}, not {value}"
                for register, value in asked.items()
                if held.get(register, value) != value
            ]
        return words


def lock_state(path: Path) -> OwnerMark:
    """Return the mark that keeps other simulators off a state file until it is closed.

    Raises
    ------
    StateFileError
        If another simulator holds it.
    OutputError
        If the file's folder is not there, or not to be written in.
    """
    try:
        return OwnerMark(path)
    except InUseError:
        raise StateFileError(
            f"{path} is in use by another simulator: end it, or give another --state", str(path)
        ) from None
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {error.strerror}", str(path)) from error


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
        content = read_capped(path, _FILE_SIZE_CAP)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise StateFileError(f"{file} cannot be read: {error.strerror}", file) from error
    if len(content) > _FILE_SIZE_CAP:
        raise StateFileError(f"{file} is larger than {_FILE_SIZE_CAP} bytes", file)
    try:
        document = json.loads(content, object_pairs_hook=_without_doubles)
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


def _without_doubles(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    """Return a JSON object none of whose names stands twice."""
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        double = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"{double[:40]!r} stands twice in one object")
    return found


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
    lines = [
        json.dumps({"place": name, **held}) for name, held in zip(names, snapshots, strict=True)
    ]
    _replace(path, lines)


def _replace(path: Path, lines: Sequence[str]) -> None:
    """Replace a state file by one with these lines, one for each servo."""
    text = f'{{"schema": "{SCHEMA}", "servos": [\n' + ",\n".join(lines) + "\n]}\n"
    draft = _draft(path)
    try:
        draft.write_text(text, encoding="utf-8")
        draft.replace(path)
    except OSError as error:
        with suppress(OSError):
            draft.unlink()
        raise OutputError(f"{path} cannot be written: {error.strerror}", str(path)) from error


def _draft(path: Path) -> Path:
    """Return where a file is written before it takes the old one's place.

    One that a killed simulator left has the same name, and goes with the next.
    """
    return path.with_name(f".{path.name}.new")


class StateKeeper:
    """Keeps a state file true while a simulation runs: a `server.Chore`.

    Parameters
    ----------
    path : Path
        The file, which is not touched before `begin`.
    servos : sequence of Servo
        All of them.
    names : sequence of str
        ``MODEL:ID`` of each, as it was asked for.
    snapshot : callable
        Returns what is to be kept of a servo.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """

    def __init__(
        self,
        path: Path,
        servos: Sequence[Servo],
        names: Sequence[str],
        snapshot: Callable[[Servo], _Snapshot] = Servo.snapshot,
    ) -> None:
        self._path = path
        self._kept = [_Kept(servo, name) for servo, name in zip(servos, names, strict=True)]
        self._snapshot = snapshot
        self.problem = ""
        """Why the file could not be written the last time; empty when it was."""
        self.next_due = 0.0
        self._changed = False
        try:  # what can go wrong is to go wrong before anything else has been made
            _draft(path).touch()
            _draft(path).unlink()
        except OSError as error:
            raise OutputError(f"{path} cannot be written: {error.strerror}", str(path)) from error

    def begin(self) -> None:
        """Write the file for the first time.

        Raises
        ------
        OutputError
            If it cannot be written.
        """
        self._write_all()

    def work(self, now: float) -> None:
        """Look at all servos, and write the file if any has changed."""
        for kept in self._kept:
            if kept.has_changed():
                self._changed |= kept.take(self._snapshot)
        if self._changed:
            self._save()
        self.next_due = now + _PERIOD

    def close(self) -> None:
        """Write all as it is now, angles too.

        Raises
        ------
        OutputError
            If it cannot be written.
        """
        self._write_all()

    def _write_all(self) -> None:
        for kept in self._kept:
            kept.has_changed()
            kept.take(self._snapshot)
        _replace(self._path, [kept.line for kept in self._kept])

    def _save(self) -> None:
        try:
            _replace(self._path, [kept.line for kept in self._kept])
        except OutputError as error:
            self.problem = str(error)
        else:
            self.problem = ""
            self._changed = False


class _Kept:
    """One servo, and its line in the file."""

    def __init__(self, servo: Servo, name: str) -> None:
        self._servo = servo
        self._name = name
        registers = servo.model.table.registers
        self._size = max(row.end for row in registers if row.area is Area.EEPROM)
        self._seen: tuple[bytes, object] = (b"", None)
        self._held: _Snapshot = {}
        self.line = ""

    def has_changed(self) -> bool:
        """Return whether its memory is another than when this was asked last."""
        servo = self._servo
        now = bytes(servo.memory.data[: self._size]), servo.backed_up.values
        changed = now[0] != self._seen[0] or now[1] is not self._seen[1]
        self._seen = now
        return changed

    def take(self, snapshot: Callable[[Servo], _Snapshot]) -> bool:
        """Take over what the servo keeps; return whether that is anything new but an angle."""
        before, self._held = self._held, snapshot(self._servo)
        self.line = json.dumps({"place": self._name, **self._held})
        return any(before.get(key) != self._held[key] for key in ("eeprom", "backup"))
