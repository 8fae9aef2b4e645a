"""The health of each servo by one read: its registers lie apart, indirect addresses gather them.

Indirect Address 1 to 6 of the X series, and of MX with protocol 2.0, are pointed at them before
torque, as they cannot be written under it (e-Manual, X series, "Indirect Address"), and are left
so: they are RAM, and a restart forgets them. Servos that hold already are only read that way if
they are pointed so from before, and others register by register, as ever.
"""

from __future__ import annotations

from collections.abc import Collection

from armsyn.driver import registers as reg
from armsyn.driver.blocks import Health, HealthBlock
from armsyn.driver.indirect import IndirectArea, IndirectBlock, indirect_area
from armsyn.driver.parser import StatusPacket
from armsyn.driver.servos import ServoGroup

GATHERED = (
    reg.TORQUE_ENABLE,
    reg.HARDWARE_ERROR_STATUS,
    reg.BUS_WATCHDOG,
    reg.X["Present Input Voltage"],
    reg.X["Present Temperature"],
)
"""What is asked of each servo in turns while it moves."""


def gather_health(group: ServoGroup, limp: Collection[int]) -> dict[int, HealthBlock]:
    """Let servos bring their health side by side, where model and firmware allow it.

    Parameters
    ----------
    group : ServoGroup
        Its firmware known.
    limp : collection of int
        IDs of those without torque.

    Returns
    -------
    dict of int to HealthBlock
        Where each servo that is pointed so now has its health; others are not in it, nor is one
        that does not take its indirect addresses.

    Raises
    ------
    BusError, PortLostError
        As the bus.
    """
    areas: dict[IndirectArea, list[int]] = {}
    for servo_id in group.having("Bus Watchdog"):
        firmware = group.firmware.get(servo_id)
        if firmware is not None:
            area = indirect_area(group.models[servo_id].name, firmware)
            areas.setdefault(area, []).append(servo_id)
    found: dict[int, HealthBlock] = {}
    for area, ids in areas.items():
        block = IndirectBlock(area, GATHERED)
        pointed = block.pointed(group.bus, tuple(ids))
        if free := tuple(i for i in ids if i in limp and i not in pointed):
            pointed += block.point(group.bus, free)
        found |= dict.fromkeys(pointed, _health_block(block))
    return found


def _health_block(block: IndirectBlock) -> HealthBlock:
    def decode(row: int, reply: StatusPacket) -> Health:
        values = block.decode(reply.parameters)
        return Health(
            row,
            torque_enabled=bool(values["Torque Enable"]),
            hardware_error=values["Hardware Error Status"],
            bus_watchdog=values["Bus Watchdog"],
            voltage=values["Present Input Voltage"] * reg.VOLTAGE_UNIT,
            temperature=float(values["Present Temperature"]),
        )

    return HealthBlock("Torque Enable", block.address, block.size, decode)
