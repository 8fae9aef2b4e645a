"""One ``[[servo]]`` table of a rig file: which fields it may have, and the servo it means."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from firmware_sim.errors import RigError
from firmware_sim.firmware.codes import MAX_ID
from firmware_sim.firmware.model import ServoModel
from firmware_sim.rig.settings import (
    Mount,
    ServoSettings,
    centre_tick,
    highest_tick,
    with_baud_rate,
    with_protocol,
    with_settings,
)
from firmware_sim.tables import find_model

_INTEGER_RANGES = {
    "id": (0, MAX_ID),
    "shadow_of": (0, MAX_ID),
    "firmware": (0, 255),
    "protocol": (1, 2),
    "rest_tick": (0, 4095),
    "start_tick": (0, 4095),
    "zero_tick": (-1_048_575, 1_048_575),
    "direction": (-1, 1),
    "baud": (1, 10_000_000),
    "return_delay_us": (0, 508),
    "drive_mode": (0, 255),
}

SERVO_FIELDS = ("model", "joint", "supply_voltage", "backlash", "registers", *_INTEGER_RANGES)
"""Every field that a ``[[servo]]`` table may have; ``id`` and ``model`` it must have."""

START_FIELDS = ("start_tick", "rest_tick")
"""Fields that say where a servo lies at the start; the first that is there counts."""

SECONDARY_ID = "Secondary(Shadow) ID"
"""The register by which a servo obeys another's ID; X and MX 2.0 have it."""

_Table = Mapping[str, Any]


def read_table(table: object, defaults: Mapping[str, int], file: str, number: int) -> ServoSettings:
    """Return the servo that a table means.

    Parameters
    ----------
    table : object
        What the TOML reader made of it.
    defaults : mapping of str to int
        What fields are where the table does not say.
    file : str
        Where it stands, for errors.
    number : int
        Which ``[[servo]]`` table it is, counted from 1.

    Returns
    -------
    ServoSettings
        The servo.

    Raises
    ------
    RigError
        If a field is missing, unknown or impossible; names file, table and field.
    """
    try:
        fields = _check_fields(table)
        return _settings({**defaults, **fields})
    except RigError as error:
        message = f"{file}: [[servo]] table {number}: {error}"
        raise RigError(message, file, number, error.field) from None


def _check_fields(table: object) -> _Table:
    """Return a table whose fields are all known and of the right kind."""
    if not isinstance(table, dict):
        raise RigError("is not a table")
    for field in table:
        if field not in SERVO_FIELDS:
            known = ", ".join(SERVO_FIELDS)
            raise RigError(f"unknown field {field!r}; known are {known}", field=field)
    for field in ("id", "model"):
        if field not in table:
            raise RigError(f"needs the field {field!r}", field=field)
    for field, (low, high) in _INTEGER_RANGES.items():
        value = table.get(field, low)
        if type(value) is not int or not low <= value <= high:
            raise RigError(
                f"{field} = {value!r} is not a whole number from {low} to {high}", field=field
            )
    for field, kind, what in (
        ("model", str, "a text"),
        ("joint", str, "a text"),
        ("registers", dict, "a table"),
    ):
        if not isinstance(table.get(field, kind()), kind):
            raise RigError(f"{field} = {table[field]!r} is not {what}", field=field)
    return table


def _settings(table: _Table) -> ServoSettings:
    """Return what a table of well-formed fields says."""
    model = find_model(table["model"], table.get("firmware"), table.get("protocol"))
    backlash = read_number(table, "backlash", 0.0, 10.0, "degrees")
    if backlash:
        model = replace(model, motor=replace(model.motor, backlash=math.radians(backlash)))
    settings = ServoSettings(
        model,
        table["id"],
        start_tick=_start_tick(table, model),
        supply_voltage=read_number(table, "supply_voltage", 0.1, 100.0, "volts"),
        mount=_mount(table, model),
        shadow_of=table.get("shadow_of"),
    )
    if "protocol" in table:
        settings = with_protocol(settings, table["protocol"])
    if "baud" in table:
        settings = with_baud_rate(settings, table["baud"])
    settings = with_settings(settings, _named_registers(table, settings.model))
    return with_settings(settings, table.get("registers", {}))


def _start_tick(table: _Table, model: ServoModel) -> int:
    for field in START_FIELDS:
        if field in table:
            if table[field] > highest_tick(model):
                raise RigError(
                    f"{field} = {table[field]} is above {model.name}'s {highest_tick(model)}",
                    field=field,
                )
            return int(table[field])
    return centre_tick(model)


def _named_registers(table: _Table, model: ServoModel) -> dict[str, int]:
    """Return the registers that have a field of their own; a drive mode of 0 is that of none."""
    registers = {}
    if "shadow_of" in table and SECONDARY_ID in model.table.by_name:
        registers[SECONDARY_ID] = table["shadow_of"]
    if "return_delay_us" in table:
        if table["return_delay_us"] % 2:
            raise RigError("return_delay_us is not a multiple of 2 us", field="return_delay_us")
        registers["Return Delay Time"] = table["return_delay_us"] // 2
    mode = table.get("drive_mode")
    if mode or (mode is not None and "Drive Mode" in model.table.by_name):
        registers["Drive Mode"] = table["drive_mode"]
    return registers


def _mount(table: _Table, model: ServoModel) -> Mount | None:
    if "joint" not in table and "shadow_of" not in table:
        return None
    direction = table.get("direction", 1)
    if not direction:
        raise RigError("direction = 0 is neither 1 nor -1", field="direction")
    return Mount(table.get("joint", ""), direction, table.get("zero_tick", centre_tick(model)))


def read_number(table: _Table, field: str, low: float, high: float, unit: str) -> float | None:
    """Return a field that is a number within a range, None if it is not there.

    Raises
    ------
    RigError
        If it is anything else.
    """
    value = table.get(field)
    if value is None:
        return None
    if type(value) not in (int, float) or not low <= value <= high:
        raise RigError(
            f"{field} = {value!r} is not a number of {unit} from {low:g} to {high:g}", field=field
        )
    return float(value)
