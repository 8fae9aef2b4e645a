"""What a register of a model can hold, for files that name registers by hand."""

from __future__ import annotations

from firmware_sim.errors import RigError
from firmware_sim.firmware.model import ServoModel


def check_value(model: ServoModel, name: str, value: object) -> None:
    """Refuse what a register of a model cannot hold.

    Raises
    ------
    RigError
        If it is no whole number within the register's range, or one that the model has no use for:
        a mode, a bit or a rate.
    """
    register = model.table[name]
    if type(value) is not int or not register.minimum <= value <= register.maximum:
        raise RigError(
            f"{name} = {value!r} is not a whole number from"
            f" {register.minimum} to {register.maximum}",
            field=name,
        )
    known = {
        "Drive Mode": value & ~model.drive_mode_bits == 0,
        "Operating Mode": value in model.operating_modes,
        "Baud Rate": value in model.baud_rates,
    }
    if not known.get(name, True):
        raise RigError(f"{name} = {value} is none that {model.name} has", field=name)
