"""Rig files and arm descriptions: what a TOML file asks to be simulated.

::

    [supply]              # optional
    voltage = 12.0        # V with no load; each motor's nominal voltage by default
    resistance = 0.05     # ohm of the supply and its cables; 0.03 by default

    [plant]               # optional; what --plant mujoco needs
    mjcf = "<mujoco> ..." # the arm's bodies, or: file = "arm.xml", beside the rig file

    [[servo]]             # one or more; `rig_table.SERVO_FIELDS` are its fields
    id = 1
    model = "xm430-w350"
    backlash = 0.25       # degrees; none by default
    registers = { "Min Position Limit" = 1024 }

    [[servo]]             # a second one on the joint of the first: see `rig.shadows`
    id = 2
    model = "xm430-w350"
    shadow_of = 1
    direction = -1

    [gripper]             # optional; a joint that the bodies need not have, "gripper" by default
    name = "gripper"

Other tables are left to whom they concern: an arm's description is a rig file too.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from types import MappingProxyType
from typing import Any

from firmware_sim.errors import RigError
from firmware_sim.files import read_capped
from firmware_sim.rig.settings import GRIPPER, Rig, ServoSettings, Supply
from firmware_sim.rig.shadows import join_shadows
from firmware_sim.rig.table import START_FIELDS, read_number, read_table

FACTORY: Mapping[str, int] = MappingProxyType({})
"""What a rig file means where it does not say: servos as the factory sets them."""

SET_UP: Mapping[str, int] = MappingProxyType({"baud": 1_000_000, "return_delay_us": 0})
"""How an arm's set-up leaves its servos: what a description means where it does not say."""

_TABLES = ("supply", "plant", "servo")
_OTHERS = ("plane",)
"""Tables of arms' descriptions that only look like a slip."""

_CLOSE = 0.75
"""How like one of them a name is that is taken for a slip: servos, Supply, plants."""

_FILE_SIZE_CAP = 1_000_000  # bytes; an arm's description is a few thousand


def read_rig(path: Path, defaults: Mapping[str, int] = FACTORY) -> Rig:
    """Read a rig file.

    Parameters
    ----------
    path : Path
        A rig file or an arm's description.
    defaults : mapping of str to int
        Fields of a ``[[servo]]`` table where it does not say.

    Returns
    -------
    Rig
        Servos in the file's order, supply, and the arm's bodies if it has them.

    Raises
    ------
    RigError
        If the file cannot be read, a table has a missing, unknown or impossible field, or two
        servos have one ID.
    """
    return _rig_of(tables_of(path), str(path), path.parent, defaults)


def parse_rig(text: str, defaults: Mapping[str, int] = FACTORY) -> Rig:
    """Return the rig that the text of such a file means; see `read_rig`."""
    return _rig_of(_parse(text, "rig"), "rig", Path(), defaults)


def _rig_of(
    document: Mapping[str, Any], file: str, folder: Path, defaults: Mapping[str, int]
) -> Rig:
    """Return the rig that a document means; files it names are found from a folder."""
    _refuse_slips(document, file)
    tables = document.get("servo")
    if not isinstance(tables, list) or not tables:
        raise RigError(f"{file} has no [[servo]] table", file, 0, "servo")
    servos = [read_table(table, defaults, file, number) for number, table in enumerate(tables, 1)]
    _check_ids(servos, file)
    placed = [any(field in table for field in START_FIELDS) for table in tables]
    servos = join_shadows(servos, placed, file)
    try:
        return Rig(
            servos,
            _read_supply(document),
            _read_bodies(document, folder),
            _read_gripper(document),
        )
    except RigError as error:
        raise RigError(f"{file}: {error}", file, 0, error.field) from None


def _refuse_slips(document: Mapping[str, Any], file: str) -> None:
    """Refuse tables whose names are nearly those of a rig file's."""
    for name in document:
        meant = get_close_matches(name.lower(), _TABLES, 1, _CLOSE)
        if meant and name not in (*_TABLES, *_OTHERS):
            raise RigError(f"{file}: unknown table {name!r}; did you mean {meant[0]}?", file)


def tables_of(path: Path) -> dict[str, Any]:
    """Return what a TOML file says.

    Raises
    ------
    RigError
        If it cannot be read, is too large or is not TOML.
    """
    return _parse(_read_text(path), str(path))


def _parse(text: str, file: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise _not_toml(file, error) from error


def _not_toml(file: str, error: Exception) -> RigError:
    reason = str(error).replace("\n", " ")
    return RigError(f"{file} is not TOML: {reason}", file)


def _read_text(path: Path) -> str:
    try:
        content = read_capped(path, _FILE_SIZE_CAP)
    except OSError as error:
        raise RigError(f"{path} cannot be read: {error.strerror}", str(path)) from error
    if len(content) > _FILE_SIZE_CAP:
        raise RigError(f"{path} is larger than {_FILE_SIZE_CAP} bytes", str(path))
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise _not_toml(str(path), error) from error


def _check_ids(servos: Sequence[ServoSettings], file: str) -> None:
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


def _section(document: Mapping[str, Any], name: str, fields: tuple[str, ...]) -> dict[str, Any]:
    """Return a table of the document that has no fields but these; empty if it is not there."""
    section = document.get(name, {})
    if not isinstance(section, dict):
        raise RigError(f"{name} is not a table", field=name)
    for field in section:
        if field not in fields:
            raise RigError(
                f"[{name}]: unknown field {field!r}; known are {', '.join(fields)}", field=field
            )
    return section


def _read_supply(document: Mapping[str, Any]) -> Supply:
    section = _section(document, "supply", ("voltage", "resistance"))
    voltage = read_number(section, "voltage", 0.1, 100.0, "volts")
    return Supply(voltage, read_number(section, "resistance", 0.0, 100.0, "ohms"))


def _read_bodies(document: Mapping[str, Any], folder: Path) -> str | None:
    """Return the MJCF that the file holds or names."""
    section = _section(document, "plant", ("mjcf", "file"))
    for field, value in section.items():
        if not isinstance(value, str) or len(section) > 1:
            raise RigError("[plant] has one text, mjcf or file", field=field)
    if "file" in section:
        return _read_text(folder / section["file"])
    return section.get("mjcf")


def _read_gripper(document: Mapping[str, Any]) -> str:
    """Return what the servos of the gripper name as their joint."""
    section = document.get("gripper")
    name = section.get("name") if isinstance(section, dict) else None
    return name if isinstance(name, str) and name else GRIPPER
