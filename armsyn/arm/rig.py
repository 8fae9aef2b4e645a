"""The rig file of an arm: all that ``firmware-sim --rig FILE`` must know of it.

A TOML file with

- one ``[[servo]]`` table a servo: ``id``, ``model``, ``joint``, ``direction``, ``zero_tick``,
  ``start_tick`` (the rest posture), ``baud``, ``return_delay_us``, ``drive_mode``, ``protocol``,
  ``supply_voltage``, and ``shadow_of`` for a second motor on a joint;
- ``[supply]``: ``resistance`` of the supply and its cables, ohm;
- ``[plant]``: ``mjcf``, the arm's bodies and shapes (`armsyn.arm.mjcf`), for ``--plant mujoco``.
"""

from __future__ import annotations

import json

import msgspec

from armsyn.arm.description import ArmDescription
from armsyn.arm.mjcf import build_mjcf
from armsyn.arm.servos import ServoDescription
from armsyn.errors import InputError

SUPPLY_RESISTANCE = 0.03
"""Of a supply with its cables, ohm; chosen: an ampere costs 30 mV."""


def build_rig(arm: ArmDescription) -> str:
    """Return the text of an arm's rig file.

    Parameters
    ----------
    arm : ArmDescription
        With servos, and a link with every joint.

    Returns
    -------
    str
        TOML.

    Raises
    ------
    InputError
        If the arm has no servos, a joint has no mass, or a name cannot be written.
    """
    if not arm.servo:
        raise InputError(f"{arm.name} has no servos: there is nothing to simulate")
    mjcf = build_mjcf(arm)
    servos = "\n".join(_servo_table(servo) for servo in arm.servo)
    return (
        f"# {arm.name}: servos, supply and bodies for firmware-sim.\n"
        "# Written by `armsyn arms rig`; what is changed here does not change the arm.\n\n"
        f"{servos}\n"
        f"[supply]\nresistance = {SUPPLY_RESISTANCE} # ohm, with its cables; chosen\n\n"
        f"[plant]\nmjcf = '''\n{mjcf}'''\n"
    )


def _servo_table(servo: ServoDescription) -> str:
    if not servo.model.isprintable():
        raise InputError(f"servo {servo.id}: model {servo.model!r}: this name cannot be written")
    fields = msgspec.structs.asdict(servo)
    fields["start_tick"] = fields.pop("rest_tick")
    # JSON's strings and numbers are TOML's too; None is left unsaid
    lines = (
        f"{name} = {json.dumps(value, ensure_ascii=False)}"
        for name, value in fields.items()
        if value is not None
    )
    return "[[servo]]\n" + "\n".join(lines) + "\n"
