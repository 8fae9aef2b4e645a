"""What is read of each family of servos in one go: its state at every tick, its health in turns.

Registers that belong together lie side by side, so that one read gets them; the addresses are
those of `armsyn.driver.registers`, which ``tests/driver/test_blocks.py`` checks.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

from armsyn.driver import registers as reg
from armsyn.driver.parser import StatusPacket
from armsyn.driver.plans import Kind, ReadPlan, bulk_plan
from armsyn.driver.registers import AX, MX1, XL320, Layout, X
from armsyn.driver.servos import ServoGroup

NAN = float("nan")


class Health(NamedTuple):
    """What a slow check of one servo found; None and NaN for what it did not ask about.

    Attributes
    ----------
    row : int
        Of the servo among those watched.
    torque_enabled : bool or None
        False also for a servo of an older family that has shut down (Torque Limit 0).
    hardware_error : int or None
        Hardware Error Status, in the X series' bits.
    bus_watchdog : int or None
        None also for a servo that has none.
    voltage, temperature : float
        V and degrees Celsius.
    moving_speed : int or None
        Moving Speed of an older family; 0 after a restart.
    apart : int or None
        Of a shadow: ticks that it reads off its leader.
    """

    row: int
    torque_enabled: bool | None = None
    hardware_error: int | None = None
    bus_watchdog: int | None = None
    voltage: float = NAN
    temperature: float = NAN
    moving_speed: int | None = None
    apart: int | None = None


class StateBlock(NamedTuple):
    """Where a family's state lies, and how it is decoded.

    `decode` gives current (0 where it is not measured), velocity and position in the registers'
    units; then, if they are there, voltage and temperature in V and degrees Celsius.
    """

    name: str
    address: int
    size: int
    decode: Callable[[bytes], tuple[float, ...]]


class HealthBlock(NamedTuple):
    """Where a part of a family's health lies, and how it is decoded.

    `decode` takes the row of the servo and the reply; `name` is the first register's.
    """

    name: str

    address: int
    size: int
    decode: Callable[[int, StatusPacket], Health]


_X_STATE = struct.Struct("<hii")
_CLASSIC_STATE = struct.Struct("<HHHBB")
_MX1_STATE = struct.Struct("<hHHBB")
_XL320_STATE = struct.Struct("<HH")
_X_MEASURES = struct.Struct("<HB")


def _classic_state(data: bytes) -> tuple[float, ...]:
    position, speed, _, voltage, temperature = _CLASSIC_STATE.unpack(data)
    return _of_classic(position, speed, voltage, temperature)


def _mx1_state(data: bytes) -> tuple[float, ...]:
    position, speed, _, voltage, temperature = _MX1_STATE.unpack(data)
    return _of_classic(position, speed, voltage, temperature)


def _of_classic(position: int, speed: int, voltage: int, temperature: int) -> tuple[float, ...]:
    volts = voltage * reg.VOLTAGE_UNIT
    return 0, reg.directed(speed), position, volts, float(temperature)


def _xl320_state(data: bytes) -> tuple[float, ...]:
    position, speed = _XL320_STATE.unpack(data)
    return 0, reg.directed(speed), position


STATE_BLOCKS: Mapping[Layout, StateBlock] = MappingProxyType(
    {
        X: StateBlock("Present Current", 126, 10, _X_STATE.unpack),
        XL320: StateBlock("Present Position", 37, 4, _xl320_state),
        MX1: StateBlock("Present Position", 36, 8, _mx1_state),
        AX: StateBlock("Present Position", 36, 8, _classic_state),
    }
)
"""Current, velocity and position; with protocol 1.0 load, voltage and temperature, too."""


def _x_health(row: int, reply: StatusPacket) -> Health:
    data = reply.parameters
    return Health(row, torque_enabled=bool(data[0]), hardware_error=data[-1])


def _x_watchdog(row: int, reply: StatusPacket) -> Health:
    return Health(row, bus_watchdog=reg.BUS_WATCHDOG.decode(reply.parameters))


def _x_measures(row: int, reply: StatusPacket) -> Health:
    voltage, temperature = _X_MEASURES.unpack(reply.parameters)
    return Health(row, voltage=voltage * reg.VOLTAGE_UNIT, temperature=float(temperature))


def _classic_health(row: int, reply: StatusPacket) -> Health:
    data = reply.parameters
    return Health(
        row,
        torque_enabled=bool(data[0]) and (data[10] or data[11]) != 0,
        hardware_error=reply.hardware_error or 0,
        moving_speed=data[8] | data[9] << 8,
        voltage=data[18] * reg.VOLTAGE_UNIT,
        temperature=float(data[19]),
    )


def _xl320_health(row: int, reply: StatusPacket) -> Health:
    data = reply.parameters
    return Health(
        row,
        torque_enabled=bool(data[0]) and (data[11] or data[12]) != 0,
        hardware_error=XL320.hardware_error(data[26]),
        moving_speed=data[8] | data[9] << 8,
        voltage=data[21] * reg.VOLTAGE_UNIT,
        temperature=float(data[22]),
    )


WATCHDOG_BLOCK = HealthBlock(
    "Bus Watchdog", reg.BUS_WATCHDOG.address, reg.BUS_WATCHDOG.size, _x_watchdog
)

HEALTH_BLOCKS: Mapping[Layout, tuple[HealthBlock, ...]] = MappingProxyType(
    {
        X: (
            HealthBlock("Torque Enable", reg.HEALTH_ADDRESS, reg.HEALTH_SIZE, _x_health),
            WATCHDOG_BLOCK,
            HealthBlock("Present Input Voltage", 144, 3, _x_measures),
        ),
        XL320: (HealthBlock("Torque Enable", 24, 27, _xl320_health),),
        MX1: (HealthBlock("Torque Enable", 24, 20, _classic_health),),
        AX: (HealthBlock("Torque Enable", 24, 20, _classic_health),),
    }
)
"""Torque and errors first."""


def state_plans(group: ServoGroup, *, fast: bool = True) -> tuple[ReadPlan, ...]:
    """How the state of servos is read at each tick, family by family.

    Parameters
    ----------
    group : ServoGroup
        Its firmware known, where fast reads are wanted.
    fast : bool
        Whether servos may answer with one packet together, where all of a family can; and MX of
        protocol 1.0, alone of their protocol, one after the other to a bulk read (e-Manual,
        Protocol 1.0, "Bulk Read"), in which a lost answer costs those after it.

    Returns
    -------
    tuple of ReadPlan
    """
    plans = []
    for layout, block in STATE_BLOCKS.items():
        ids = tuple(i for i in group.ids if group.models[i].layout is layout)
        if not ids:
            continue
        several = fast and len(ids) > 1
        if layout is MX1 and several:
            plans.append(bulk_plan(dict.fromkeys(ids, (block.address, block.size)), 1))
            continue
        together = several and all(group.reads_fast(i) for i in ids)
        kind: Kind = "single" if layout in (MX1, AX) else "fast" if together else "sync"
        plans.append(ReadPlan(kind, group.bus.protocols[ids[0]], block.address, block.size, ids))
    return tuple(plans)


def health_plan(group: ServoGroup, servo_id: int, block: HealthBlock) -> ReadPlan:
    """How a part of one servo's health is read."""
    protocol = group.bus.protocols[servo_id]
    return ReadPlan("single", protocol, block.address, block.size, (servo_id,))
