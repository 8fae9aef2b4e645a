"""Which servos to simulate: from the command line, a rig file, or an arm's description.

Of a file only its ``[[servo]]`` tables are read; `SERVO_FIELDS` says what one may hold.
"""

from __future__ import annotations

import os
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from firmware_sim.errors import RigError
from firmware_sim.model import ServoModel
from firmware_sim.packet import MAX_ID
from firmware_sim.servo import Servo
from firmware_sim.tables import find_model

_FILE_SIZE_CAP = 1_000_000  # bytes; an arm's description is a few thousand

_IGNORED_FIELDS = ("joint", "direction", "zero_tick")
"""Fields of an arm's description that say nothing about the servo itself."""

_INTEGER_RANGES = {
    "id": (0, MAX_ID),
    "rest_tick": (0, 4095),
    "start_tick": (0, 4095),
    "baud": (1, 10_000_000),
    "return_delay_us": (0, 508),
    "drive_mode": (0, 255),
}

SERVO_FIELDS = (*_IGNORED_FIELDS, *_INTEGER_RANGES, "model", "supply_voltage")
"""Every field that a ``[[servo]]`` table may have; ``id`` and ``model`` it must have."""


@dataclass(frozen=True, slots=True)
class ServoSettings:
    """One servo to be simulated.

    Parameters
    ----------
    model : ServoModel
        What it is.
    servo_id : int
        0 to 252.
    start_tick : int
        Where it lies at the start, 0 to 4095.
    baud_code : int
        Of Baud Rate(8); the factory's 1 by default, 57600 bit/s.
    return_delay : int
        Of Return Delay Time(9), 2 us; the factory's 250 by default.
    drive_mode : int
        Of Drive Mode(10).
    supply_voltage : float or None
        V; None for the motor's nominal voltage.
    """

    model: ServoModel
    servo_id: int
    start_tick: int = 2048
    baud_code: int = 1
    return_delay: int = 250
    drive_mode: int = 0
    supply_voltage: float | None = None

    def build(self, when: float) -> Servo:
        """Return the servo, powered up at a time in s."""
        registers = {
            "Baud Rate": self.baud_code,
            "Return Delay Time": self.return_delay,
            "Drive Mode": self.drive_mode,
        }
        return Servo(
            self.model,
            self.servo_id,
            self.start_tick,
            self.supply_voltage,
            settings=registers,
            when=when,
        )


def parse_servo(text: str) -> ServoSettings:
    """Return the servo that ``MODEL:ID`` names.

    Raises
    ------
    RigError
        If the text is of another form, or the model or ID is not possible.
    """
    name, colon, number = text.rpartition(":")
    if not colon or not number.isdecimal():
        raise RigError(f"--servo {text!r} is not of the form MODEL:ID, as in xm430-w350:1")
    if int(number) > MAX_ID:
        raise RigError(f"--servo {text!r}: IDs go from 0 to {MAX_ID}")
    return ServoSettings(find_model(name), int(number))


def read_rig(path: Path) -> list[ServoSettings]:
    """Read the ``[[servo]]`` tables of a TOML file.

    Parameters
    ----------
    path : Path
        A rig file or an arm's description.

    Returns
    -------
    list of ServoSettings
        In the file's order, at least one.

    Raises
    ------
    RigError
        If the file cannot be read, or a table has a missing, unknown or impossible field.
    """
    try:
        if path.stat().st_size > _FILE_SIZE_CAP:
            raise RigError(f"{path} is larger than {_FILE_SIZE_CAP} bytes", str(path))
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise RigError(f"{path} cannot be read: {error.strerror}", str(path)) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise RigError(f"{path} is not TOML: {error}", str(path)) from error
    tables = document.get("servo")
    if not isinstance(tables, list) or not tables:
        raise RigError(f"{path} has no [[servo]] table", str(path), 0, "servo")
    return [_read_table(table, str(path), number) for number, table in enumerate(tables, 1)]


def _read_table(table: object, file: str, number: int) -> ServoSettings:
    def wrong(field: str, what: str) -> RigError:
        return RigError(f"{file}: [[servo]] table {number}: {what}", file, number, field)

    if not isinstance(table, dict):
        raise wrong("", "is not a table")
    for field in table:
        if field not in SERVO_FIELDS:
            raise wrong(field, f"unknown field {field!r}; known are {', '.join(SERVO_FIELDS)}")
    for field in ("id", "model"):
        if field not in table:
            raise wrong(field, f"needs the field {field!r}")
    for field, (low, high) in _INTEGER_RANGES.items():
        value = table.get(field, low)
        if type(value) is not int or not low <= value <= high:
            raise wrong(field, f"{field} = {value!r} is not a whole number from {low} to {high}")
    voltage = table.get("supply_voltage")
    if voltage is not None and (type(voltage) not in (int, float) or not 0.0 < voltage < 100.0):
        raise wrong("supply_voltage", f"supply_voltage = {voltage!r} is not a number of volts")
    try:
        return _settings(table)
    except RigError as error:
        raise wrong(error.field, str(error)) from None


def _settings(table: dict[str, Any]) -> ServoSettings:
    """Return what a table of well-formed fields says."""
    model = find_model(str(table["model"]))
    drive_mode = table.get("drive_mode", 0)
    if drive_mode & ~model.drive_mode_bits:
        raise RigError(f"drive_mode = {drive_mode} has bits not simulated", field="drive_mode")
    settings = ServoSettings(
        model,
        table["id"],
        start_tick=table.get("start_tick", table.get("rest_tick", 2048)),
        return_delay=table.get("return_delay_us", 500) // 2,
        drive_mode=drive_mode,
        supply_voltage=table.get("supply_voltage"),
    )
    return with_baud_rate(settings, table["baud"]) if "baud" in table else settings


def with_baud_rate(settings: ServoSettings, baud_rate: int) -> ServoSettings:
    """Return the same servo set to another baud rate, bit/s.

    Raises
    ------
    RigError
        If the model has no such rate.
    """
    rates = settings.model.baud_rates
    if baud_rate not in rates:
        known = ", ".join(map(str, rates))
        raise RigError(
            f"baud = {baud_rate} is none of {settings.model.name}'s {known}", field="baud"
        )
    return replace(settings, baud_code=rates.index(baud_rate))


def check_ids(servos: list[ServoSettings]) -> None:
    """Refuse servos that share an ID.

    Raises
    ------
    RigError
        If two do.
    """
    seen: set[int] = set()
    for servo in servos:
        if servo.servo_id in seen:
            raise RigError(f"ID {servo.servo_id} is given twice: IDs must differ", field="id")
        seen.add(servo.servo_id)


def find_arm(name: str, calibration: Path | None) -> Path:
    """Return the description of an arm.

    Parameters
    ----------
    name : str
        The file's name without ``.toml``.
    calibration : Path or None
        The only folder to look in, if given; else ``$ARMSYN_CALIBRATION``, ``./calibration``, and
        the folders beside this package where a checkout and a wheel keep them.

    Returns
    -------
    Path
        The first such file that exists.

    Raises
    ------
    RigError
        If there is none, or the name is a path.
    """
    if not name or Path(name).name != name or name.startswith("."):
        raise RigError(f"--arm {name!r} is a path, not a name: use --rig for a file")
    folders = [calibration] if calibration is not None else _calibration_folders()
    for folder in folders:
        if (folder / f"{name}.toml").is_file():
            return folder / f"{name}.toml"
    searched = ", ".join(str(folder) for folder in folders)
    raise RigError(f"no arm {name!r}: {name}.toml is in none of {searched}")


def _calibration_folders() -> list[Path]:
    packages = Path(__file__).resolve().parent.parent
    named = os.environ.get("ARMSYN_CALIBRATION")
    return [
        *([Path(named)] if named else []),
        Path("calibration"),
        packages / "calibration",
        packages / "armsyn" / "calibration",
    ]
