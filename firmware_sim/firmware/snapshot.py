"""What a servo keeps without power, as a JSON object, and back.

``{"model": str, "eeprom": {name: value}, "backup": {name: value} or null, "angle": rad}``
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from firmware_sim.errors import RigError
from firmware_sim.firmware.checking import check_value
from firmware_sim.firmware.control_table import Access, Area, ControlTable
from firmware_sim.firmware.model import ServoModel

if TYPE_CHECKING:
    from firmware_sim.firmware.servo import Servo

_FARTHEST = 1e7
"""Largest angle of a horn, rad: positions of 4 bytes end before."""

_FIELDS = {"model", "eeprom", "backup", "angle"}


def take_snapshot(servo: Servo) -> dict[str, Any]:
    """Return what survives without power."""
    value = servo.memory.value
    backup = servo.backed_up.values
    return {
        "model": servo.model.name,
        "eeprom": {name: value(name) for name in _kept(servo.model.table)},
        "backup": None if backup is None else dict(backup),
        "angle": servo.axis.angle,
    }


def put_snapshot(servo: Servo, snapshot: Mapping[str, Any]) -> None:
    """Take over what `take_snapshot` returned; the servo is to be booted after that.

    Raises
    ------
    ValueError
        If it is not one of this model; nothing was changed.
    """
    if set(snapshot) != _FIELDS:
        raise ValueError(f"a servo's state has the fields {', '.join(sorted(_FIELDS))}")
    model, eeprom, backup, angle = (
        snapshot[name] for name in ("model", "eeprom", "backup", "angle")
    )
    if model != servo.model.name:
        raise ValueError(f"the state is of a {model!r}, the servo is a {servo.model.name}")
    _check(servo.model, eeprom, set(_kept(servo.model.table)), "eeprom")
    if backup is not None:
        _check(servo.model, backup, servo.backed_up.names, "backup")
    if type(angle) not in (int, float) or not abs(angle) <= _FARTHEST:
        raise ValueError(f"angle = {angle!r} is not a number of radians")
    for name, value in eeprom.items():
        servo.memory.store(name, value)
    servo.backed_up.values = None if backup is None else dict(backup)
    servo.firmware.install(float(angle), servo.supply_voltage)


def _kept(table: ControlTable) -> list[str]:
    return [
        register.name
        for register in table.registers
        if register.area is Area.EEPROM and register.access is Access.READ_WRITE
    ]


def _check(model: ServoModel, values: object, names: set[str], where: str) -> None:
    if not isinstance(values, dict) or not set(values) <= names:
        raise ValueError(f"{where} holds something else than registers of this model")
    for name, value in values.items():
        try:
            check_value(model, name, value)
        except RigError as error:
            raise ValueError(f"{where}: {error}") from None
