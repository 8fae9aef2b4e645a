"""What firmware older than a table's lacks, so that a table's file shows the newest rows only.

Sources: e-Manual, X430 and X540 pages: "Startup Configuration(60)" and "Backup Ready(147)" from
firmware 45, "Drive Mode(10)": bit 3 (torque on by goal update) from 45, bit 2 (time-based profile)
from 42, the register itself and "Bus Watchdog(98)" from 38. X330 pages: 60, 147 and bit 3 from 46.
MX pages: protocol 2.0 from firmware 39, time-based profile from 42. Initial values of older
firmware are in no page that was read: Velocity Limit "has been decreased since firmware V42".
"""

from __future__ import annotations

from dataclasses import replace

from firmware_sim.firmware.control_table import ControlTable
from firmware_sim.firmware.model import ServoModel

_WITH_BACKUP = frozenset(("Startup Configuration", "Backup Ready"))
_TORQUE_ON_BY_GOAL = 0b1000
_TIME_BASED = 0b0100

_PWM_SLOPE = 1.977e-3
_X330_ERRORS = 0x35


def _before(
    model: ServoModel,
    firmware: int,
    first: int,
    missing: frozenset[str] = frozenset(),
    missing_bits: int = 0,
) -> ServoModel:
    """Return a model as it was before a firmware version.

    Parameters
    ----------
    model : ServoModel
        As it is from `firmware` on.
    firmware : int
        First version that has what is taken away here.
    first : int
        First version that is like this.
    missing : frozenset of str
        Registers that it lacks.
    missing_bits : int
        Of Drive Mode(10).
    """
    last = firmware - 1
    bits = model.table["Drive Mode"].maximum & ~missing_bits
    changed = {
        "Firmware Version": replace(model.table["Firmware Version"], default=last),
        "Drive Mode": replace(model.table["Drive Mode"], maximum=bits),
    }
    registers = [
        changed.get(register.name, register)
        for register in model.table.registers
        if register.name not in missing
    ]
    return replace(
        model,
        firmware=last,
        table=ControlTable(registers),
        drive_mode_bits=model.drive_mode_bits & ~missing_bits,
        first_firmware=first,
        last_firmware=last,
    )


def x430_versions(model: ServoModel) -> tuple[ServoModel, ...]:
    """Return an X430 or X540 and its older layouts, newest first.

    Parameters
    ----------
    model : ServoModel
        With firmware 45 or newer.
    """
    to_44 = _before(model, 45, 42, _WITH_BACKUP, _TORQUE_ON_BY_GOAL)
    return model, to_44, _before(to_44, 42, 38, missing_bits=_TIME_BASED)


def x330_versions(model: ServoModel, table_to_52: ControlTable) -> tuple[ServoModel, ...]:
    """Return an X330 and its older layouts, newest first.

    What all of them have: no encoder error ("Shutdown(63)" of the present XL330 page: bit 3 unused;
    an older state of the page and the maker's newer site have it), a current measured at the input
    ("Current Limit(38)", note), a slope of the PWM in 1.977 mV/ms unless the model says otherwise
    ("PWM Slope(62)").

    Parameters
    ----------
    model : ServoModel
        With firmware 53 or newer.
    table_to_52 : ControlTable
        Its rows up to firmware 52, whose indirect data begin at 208.
    """
    model = replace(
        model,
        detects=_X330_ERRORS,
        pwm_slope_unit=model.pwm_slope_unit or _PWM_SLOPE,
        senses_input=True,
    )
    to_52 = _before(replace(model, table=table_to_52), 53, 46)
    return model, to_52, _before(to_52, 46, 0, _WITH_BACKUP, _TORQUE_ON_BY_GOAL)


def mx_versions(model: ServoModel) -> tuple[ServoModel, ...]:
    """Return an MX with protocol 2.0 and its older layout, newest first.

    Parameters
    ----------
    model : ServoModel
        With firmware 42 or newer.
    """
    return model, _before(model, 42, 39, missing_bits=_TIME_BASED)
