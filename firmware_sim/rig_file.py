"""Rig files and arm descriptions: which servos a TOML file asks for.

Of a file only its ``[[servo]]`` tables are read; `SERVO_FIELDS` says what one may hold.
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from firmware_sim.errors import RigError
from firmware_sim.packet import MAX_ID
from firmware_sim.rig import ServoSettings, with_baud_rate
from firmware_sim.tables import find_model

FACTORY = MappingProxyType({"baud": 57_600, "return_delay_us": 500})
"""How servos leave the factory: what a rig file means where it does not say."""

SET_UP = MappingProxyType({"baud": 1_000_000, "return_delay_us": 0})
"""How an arm's set-up leaves its servos: what a description means where it does not say."""

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


def read_rig(path: Path, defaults: Mapping[str, int] = FACTORY) -> list[ServoSettings]:
    """Read the ``[[servo]]`` tables of a TOML file.

    Parameters
    ----------
    path : Path
        A rig file or an arm's description.
    defaults : mapping of str to int
        What ``baud`` and ``return_delay_us`` are where a table does not say.

    Returns
    -------
    list of ServoSettings
        In the file's order, at least one.

    Raises
    ------
    RigError
        If the file cannot be read, a table has a missing, unknown or impossible field, or two have
        one ID.
    """
    try:
        if path.stat().st_size > _FILE_SIZE_CAP:
            raise RigError(f"{path} is larger than {_FILE_SIZE_CAP} bytes", str(path))
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise RigError(f"{path} cannot be read: {error.strerror}", str(path)) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise RigError(f"{path} is not TOML: {error}", str(path)) from error
    tables = document.get("servo")
    if not isinstance(tables, list) or not tables:
        raise RigError(f"{path} has no [[servo]] table", str(path), 0, "servo")
    servos = [
        _read_table(table, defaults, str(path), number) for number, table in enumerate(tables, 1)
    ]
    _check_ids(servos, str(path))
    return servos


def _check_ids(servos: list[ServoSettings], file: str) -> None:
    owners: dict[int, int] = {}
    for number, servo in enumerate(servos, 1):
        owner = owners.setdefault(servo.servo_id, number)
        if owner != number:
            raise RigError(
                f"{file}: [[servo]] table {number}: id = {servo.servo_id} is table {owner}'s too",
                file,
                number,
                "id",
            )


def _read_table(
    table: object, defaults: Mapping[str, int], file: str, number: int
) -> ServoSettings:
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
    if table.get("return_delay_us", 0) % 2:
        raise wrong("return_delay_us", "return_delay_us is not a multiple of 2 us")
    voltage = table.get("supply_voltage")
    if voltage is not None and (type(voltage) not in (int, float) or not 0.0 < voltage < 100.0):
        raise wrong("supply_voltage", f"supply_voltage = {voltage!r} is not a number of volts")
    try:
        return _settings({**defaults, **table})
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
        return_delay=table["return_delay_us"] // 2,
        drive_mode=drive_mode,
        supply_voltage=table.get("supply_voltage"),
    )
    return with_baud_rate(settings, table["baud"])


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
