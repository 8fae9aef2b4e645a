"""The clients whose bus cycles are compared: each writes goals and reads 10 bytes of all servos."""

from __future__ import annotations

import os
import select
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import rustypot
import serial
from dynamixel_sdk import COMM_SUCCESS, GroupSyncRead, GroupSyncWrite, PacketHandler, PortHandler

from armsyn.arm import load_arm
from armsyn.driver.joints import JointGroup
from armsyn.driver.plans import Kind, ReadPlan
from armsyn.driver.protocol import sync_read, sync_write
from armsyn.driver.transactions import Bus

Cycle = Callable[[], None]

STATE = struct.Struct("<hii")
"""Present current, velocity and position, side by side from address 126."""

STATE_ADDRESS, GOAL_ADDRESS = 126, 116
GOAL = 2048
FAST_FIRMWARE = 60
"""A version that answers fast reads."""


class MissingReplyError(Exception):
    """A reply that had to come did not."""


def bus_cycle(bus: Bus, kind: Kind, ids: tuple[int, ...], answering: int, margin: float) -> Cycle:
    """Return the driver's cycle on an open bus, ticks in and out."""
    bus.return_delays = dict.fromkeys(ids, 0.0)
    reads = (ReadPlan(kind, 2, STATE_ADDRESS, STATE.size, ids),)
    goals = struct.Struct(f"<{len(ids)}i")

    def cycle() -> None:
        data = goals.pack(*(GOAL for _ in ids))
        replies = bus.exchange(sync_write(GOAL_ADDRESS, 4, ids, data), reads, margin)
        states = {i: STATE.unpack(reply.parameters) for i, reply in replies.items()}
        if len(states) != answering:
            raise MissingReplyError

    return cycle


@contextmanager
def armsyn(
    port: str, baud: int, ids: tuple[int, ...], kind: Kind, absent: int = 0
) -> Iterator[Cycle]:
    """Offer the driver's cycle; `absent` servos of all are not there."""
    bus = Bus(port, baud)
    try:
        yield bus_cycle(bus, kind, ids, len(ids) - absent, 1.5e-3 if absent else 0.2)
    finally:
        bus.close()


def arm_cycle(bus: Bus, kind: Kind, margin: float = 0.2) -> Cycle:
    """Return the driver's cycle of a whole arm on an open bus, radians in and SI units out."""
    arm = load_arm("human7")
    bus.return_delays = dict.fromkeys((servo.id for servo in arm.servo), 0.0)
    firmware = dict.fromkeys(bus.return_delays, FAST_FIRMWARE if kind == "fast" else 0)
    joints = JointGroup(bus, arm, margin, firmware)
    goals = arm.rest

    def cycle() -> None:
        if not joints.exchange(goals).fresh.all():
            raise MissingReplyError

    return cycle


@contextmanager
def armsyn_arm(port: str, baud: int, kind: Kind) -> Iterator[Cycle]:
    """Offer the driver's cycle of the human-like arm, in SI units."""
    bus = Bus(port, baud)
    try:
        yield arm_cycle(bus, kind)
    finally:
        bus.close()


@contextmanager
def bare_loop(port: str, baud: int, ids: tuple[int, ...]) -> Iterator[Cycle]:
    """Offer the same bytes without any driver: one write, and reads until all has come."""
    data = GOAL.to_bytes(4, "little") * len(ids)
    request = sync_write(GOAL_ADDRESS, 4, ids, data) + sync_read(STATE_ADDRESS, STATE.size, ids)
    expected = (11 + STATE.size) * len(ids)
    with serial.Serial(port, baud, timeout=0) as opened:
        descriptor = opened.fileno()

        def cycle() -> None:
            os.write(descriptor, request)
            count = 0
            while count < expected:
                select.select([descriptor], [], [])
                count += len(os.read(descriptor, 4096))

        yield cycle


@contextmanager
def sdk(port: str, baud: int, ids: tuple[int, ...], absent: int = 0) -> Iterator[Cycle]:
    """Offer the vendor's cycle: GroupSyncWrite and GroupSyncRead, ticks in and out."""
    handler, packets = PortHandler(port), PacketHandler(2.0)
    handler.setBaudRate(baud)
    writer = GroupSyncWrite(handler, packets, GOAL_ADDRESS, 4)
    reader = GroupSyncRead(handler, packets, STATE_ADDRESS, STATE.size)
    for servo_id in ids:
        reader.addParam(servo_id)

    def cycle() -> None:
        writer.clearParam()
        for servo_id in ids:
            writer.addParam(servo_id, list(GOAL.to_bytes(4, "little")))
        writer.txPacket()
        if (reader.txRxPacket() == COMM_SUCCESS) == bool(absent):
            raise MissingReplyError
        for servo_id in ids if not absent else ():
            for address, size in ((126, 2), (128, 4), (132, 4)):
                reader.getData(servo_id, address, size)

    try:
        yield cycle
    finally:
        handler.closePort()


@contextmanager
def rusty(port: str, baud: int, ids: tuple[int, ...], *, fast: bool) -> Iterator[Cycle]:
    """Offer rustypot's cycle, raw ticks in and bytes out."""
    client = rustypot.Xl330PyController(port, baud, 0.2)
    client.set_fast_sync_read(fast)
    names, goals = list(ids), [GOAL] * len(ids)

    def cycle() -> None:
        client.sync_write_raw_goal_position(names, goals)
        for raw in client.sync_read_raw_data(names, STATE_ADDRESS, STATE.size):
            STATE.unpack(bytes(raw))

    try:
        yield cycle
    finally:
        client.close()
