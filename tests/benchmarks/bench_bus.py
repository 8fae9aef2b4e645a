"""One bus cycle of seven servos (write goals, read 10 bytes of each) against its wire time.

The replier spins out the time that the bytes would take at 1 Mbaud with no return delay. Beside
the driver's cycle stand the same bytes written and awaited by a bare loop (what the machine and
its pseudo-terminals take by themselves) and the vendor's SDK, all on one replier.
"""

from __future__ import annotations

import os
import select
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import serial
from dynamixel_sdk import COMM_SUCCESS, GroupSyncRead, GroupSyncWrite, PacketHandler, PortHandler

from armsyn.arm import load_arm
from armsyn.driver.joints import JointGroup
from armsyn.driver.protocol import sync_read, sync_write
from armsyn.driver.timing import cycle_wire_time
from armsyn.driver.transactions import Bus

BAUD = 1_000_000
IDS = tuple(range(1, 8))
CYCLES = 1_000
GREATEST_RATIO = 1.3


@dataclass(frozen=True)
class Cycle:
    """What a cycle took.

    Attributes
    ----------
    median_s, worst_percent_s : float
        Median and 99th percentile of the cycle's duration, s.
    processor_share : float
        Part of one core that this process used.
    """

    median_s: float
    worst_percent_s: float
    processor_share: float


@contextmanager
def replier(servos: int, baud: int) -> Iterator[str]:
    """Run the replier in a process of its own; yields the port."""
    command = [sys.executable, str(Path(__file__).with_name("replier.py")), str(servos), str(baud)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            yield process.stdout.readline().strip()
        finally:
            process.stdin.close()


def measure(cycle: Callable[[], None]) -> Cycle:
    """Time a cycle, back to back."""
    for _ in range(50):
        cycle()
    durations = []
    begun, busy = time.perf_counter(), time.process_time()
    for _ in range(CYCLES):
        start = time.perf_counter()
        cycle()
        durations.append(time.perf_counter() - start)
    share = (time.process_time() - busy) / (time.perf_counter() - begun)
    return Cycle(statistics.median(durations), float(np.quantile(durations, 0.99)), share)


def measure_ours(port: str) -> Cycle:
    """Measure the driver's cycle, radians in and SI units out."""
    arm = load_arm("human7")
    bus = Bus(port, BAUD)
    bus.return_delays = dict.fromkeys(IDS, 0.0)
    joints = JointGroup(bus, arm, margin=0.2)
    goals = arm.rest

    def cycle() -> None:
        if not joints.exchange(goals).fresh.all():
            raise RuntimeError("a reply is missing")

    try:
        return measure(cycle)
    finally:
        bus.close()


def measure_bare(port: str) -> Cycle:
    """Measure the same bytes without any driver: one write, and reads until all has come."""
    request = sync_write(116, 4, IDS, bytes(4 * len(IDS))) + sync_read(126, 10, IDS)
    expected = 21 * len(IDS)
    with serial.Serial(port, BAUD, timeout=0) as opened:
        descriptor = opened.fileno()

        def cycle() -> None:
            os.write(descriptor, request)
            count = 0
            while count < expected:
                select.select([descriptor], [], [])
                count += len(os.read(descriptor, 4096))

        return measure(cycle)


def measure_sdk(port: str) -> Cycle:
    """Measure the vendor's cycle: GroupSyncWrite and GroupSyncRead, ticks in and out."""
    handler, packets = PortHandler(port), PacketHandler(2.0)
    handler.setBaudRate(BAUD)
    writer = GroupSyncWrite(handler, packets, 116, 4)
    reader = GroupSyncRead(handler, packets, 126, 10)
    for servo_id in IDS:
        reader.addParam(servo_id)

    def cycle() -> None:
        writer.clearParam()
        for servo_id in IDS:
            writer.addParam(servo_id, list((2048).to_bytes(4, "little")))
        writer.txPacket()
        if reader.txRxPacket() != COMM_SUCCESS:
            raise RuntimeError("a reply is missing")
        for servo_id in IDS:
            for address, size in ((126, 2), (128, 4), (132, 4)):
                reader.getData(servo_id, address, size)

    try:
        return measure(cycle)
    finally:
        handler.closePort()


def report() -> dict[str, Cycle]:
    """Measure all on one replier and print them beside the wire time."""
    wire = cycle_wire_time(len(IDS), BAUD, [0.0] * len(IDS))
    with replier(len(IDS), BAUD) as port:
        results = {
            "armsyn": measure_ours(port),
            "bare loop": measure_bare(port),
            "dynamixel-sdk": measure_sdk(port),
        }
    print(f"bus cycle, {len(IDS)} servos, 10 bytes each, {BAUD} baud: {wire * 1e3:.2f} ms of wire")
    for name, result in results.items():
        print(
            f"  {name:14} median {result.median_s * 1e3:6.3f} ms = {result.median_s / wire:.2f} x"
            f" wire, 99 % {result.worst_percent_s * 1e3:6.2f} ms,"
            f" {result.processor_share:4.0%} of a core"
        )
    return results


if __name__ == "__main__":
    ratio = report()["armsyn"].median_s / cycle_wire_time(len(IDS), BAUD, [0.0] * len(IDS))
    sys.exit(0 if ratio <= GREATEST_RATIO else 1)
