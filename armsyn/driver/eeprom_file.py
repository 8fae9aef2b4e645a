"""``<arm>-<date>.eeprom.json``: what servos held before they were set up, and the way back."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from armsyn.driver.eeprom import EepromImage
from armsyn.errors import FormatError, InputError
from armsyn.motion.formats.files import replacing

SUFFIX = ".eeprom.json"
MAXIMUM_BYTES = 1_000_000

SCHEMA = "armsyn-eeprom-1"

_NO_BACKUP = (
    f"is no backup of servos' EEPROM (ARM-DATE{SUFFIX}, schema {SCHEMA}), which armsyn setup writes"
)

Byte = Annotated[int, msgspec.Meta(ge=0, le=255)]
Rate = Annotated[int, msgspec.Meta(ge=1, le=100_000_000)]
Value = Annotated[int, msgspec.Meta(ge=-(2**31), lt=2**32)]


class _Marked(msgspec.Struct):
    """Any file that says what it is."""

    schema: str


class Reach(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How a servo is reached.

    Attributes
    ----------
    id, protocol, baud : int
    """

    id: Annotated[int, msgspec.Meta(ge=0, le=253)]
    protocol: Literal[1, 2]
    baud: Rate


class ServoBackup(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One servo of a backup.

    Attributes
    ----------
    was, becomes : Reach
        How it was reached before it was set up, and how afterwards.
    model : str
    model_number : int
    firmware : int
    registers : dict of str to int
        By name, each in its own unit.
    """

    was: Reach
    becomes: Reach
    model: str
    model_number: Annotated[int, msgspec.Meta(ge=0, le=65535)]
    firmware: Byte
    registers: dict[str, Value]


class Backup(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A backup file.

    Attributes
    ----------
    schema : str
        ``armsyn-eeprom-1``.
    arm : str
        That the servos were to become.
    date : str
        ISO 8601, UTC.
    port : str
    servo : tuple of ServoBackup
    """

    schema: Literal["armsyn-eeprom-1"]
    arm: str
    date: str
    port: str
    servo: tuple[ServoBackup, ...]


class BackupFile:
    """A backup that is written before each servo is changed; the file grows with the servos.

    Parameters
    ----------
    folder : Path
        Made if it is not there.
    arm : str
        Begins the file's name.
    port : str

    Attributes
    ----------
    path : Path
        A new name: no other backup is replaced.
    """

    def __init__(self, folder: Path, arm: str, port: str) -> None:
        now = datetime.now(UTC)
        self._folder = folder
        self._stem = f"{arm}-{now:%Y-%m-%dT%H-%M-%SZ}"
        self.path = self._unused()
        self._backup = Backup("armsyn-eeprom-1", arm, now.isoformat(timespec="seconds"), port, ())

    def _unused(self) -> Path:
        path, number = self._folder / f"{self._stem}{SUFFIX}", 1
        while path.exists():
            number += 1
            path = self._folder / f"{self._stem}-{number}{SUFFIX}"
        return path

    def add(self, image: EepromImage, becomes: Reach) -> None:
        """Add a servo and write the file; InputError when it cannot be written."""
        found = image.found
        servo = ServoBackup(
            Reach(found.servo_id, _protocol(found.protocol), found.baud),
            becomes,
            image.model.name,
            image.model.number,
            image.registers["Firmware Version"],
            image.registers,
        )
        backup = msgspec.structs.replace(self._backup, servo=(*self._backup.servo, servo))
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{self._folder}: cannot make it: {error.strerror}") from error
        with replacing(self.path) as temporary:
            temporary.write_bytes(msgspec.json.format(msgspec.json.encode(backup), indent=2))
        self._backup = backup


def read_backup(path: Path) -> Backup:
    """Read a backup.

    Raises
    ------
    FormatError
        Unreadable, or a field that is missing, unknown or out of range; file and field are named.
    """
    try:
        if path.stat().st_size > MAXIMUM_BYTES:
            raise FormatError(f"{path} {_NO_BACKUP}: it is larger than {MAXIMUM_BYTES} bytes")
        text = path.read_bytes()
        backup = msgspec.json.decode(text, type=Backup)
    except OSError as error:
        raise FormatError(f"{path}: {error.strerror or error}") from error
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise FormatError(f"{path}{_unfit(text, error)}") from error
    if not backup.servo:
        raise FormatError(f"{path}: no servo in it")
    return backup


def _unfit(text: bytes, error: Exception) -> str:
    """What is wrong with a file: what it is instead of a backup, or its field."""
    try:
        schema = msgspec.json.decode(text, type=_Marked).schema
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return f" {_NO_BACKUP}, or a damaged one: {error}"
    return f": {error}" if schema == SCHEMA else f" {_NO_BACKUP}: its schema is {schema!r}"


def _protocol(number: int) -> Literal[1, 2]:
    return 1 if number == 1 else 2
