"""One bus cycle of seven servos (write goals, read 10 bytes of each) against its wire time.

The replier spins out the time that the bytes would take on the wire with no return delay. The
driver's cycles are those of an arm, radians in and SI units out; beside them stand those of its
bus alone, ticks in and out as of the others, a bare loop (what the machine and its
pseudo-terminals take by themselves), the vendor's SDK and rustypot, all on one replier and in
turns, so that a busy machine is busy for all of them; the best tenth of the cycles tells what an
idle one would do. The wire time of a cycle is that of its own bytes: a fast sync read has fewer.
"""

from __future__ import annotations

import functools
import os
import statistics
import subprocess
import sys
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import bus_clients as clients
import numpy as np
from replier import answers

from armsyn.driver.plans import Kind, ReadPlan, exchange_duration
from armsyn.driver.protocol import sync_write
from armsyn.driver.serial_port import SerialPort
from armsyn.driver.transactions import Bus

IDS = tuple(range(1, 8))
ROUNDS, CYCLES = 5, 300
LEAST_RATE = 800.0
GREATEST_RATIO, GREATEST_SHARE = 1.10, 0.15
GREATEST_WAIT = 3e-3
GREATEST_OVERHEAD = 120e-6

Client = Callable[[str], AbstractContextManager[clients.Cycle]]


@dataclass
class Result:
    """What cycles took.

    Attributes
    ----------
    durations : list of float
        s.
    busy, elapsed : float
        Processor time of this process and time in all, s.
    lost : int
        Cycles that lacked a reply.
    """

    durations: list[float] = field(default_factory=list)
    busy: float = 0.0
    elapsed: float = 0.0
    lost: int = 0

    @property
    def median(self) -> float:
        """Median duration, s."""
        return statistics.median(self.durations)

    @property
    def share(self) -> float:
        """Part of one core that this process used."""
        return self.busy / self.elapsed

    def run(self, cycle: clients.Cycle, cycles: int) -> None:
        """Time a cycle, back to back."""
        for _ in range(20):
            self._once(cycle)
        begun, busy = time.perf_counter(), time.process_time()
        for _ in range(cycles):
            start = time.perf_counter()
            self._once(cycle)
            self.durations.append(time.perf_counter() - start)
        self.busy += time.process_time() - busy
        self.elapsed += time.perf_counter() - begun

    def _once(self, cycle: clients.Cycle) -> None:
        try:
            cycle()
        except clients.MissingReplyError:  # the machine stalled for longer than the client waits
            self.lost += 1


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


def wire_time(kind: Kind, baud: int, servos: int = len(IDS)) -> float:
    """Seconds of a cycle's bytes on the wire."""
    ids = IDS[:servos]
    reads = (ReadPlan(kind, 2, clients.STATE_ADDRESS, clients.STATE.size, ids),)
    before = len(sync_write(clients.GOAL_ADDRESS, 4, ids, bytes(4 * servos)))
    return exchange_duration(before, reads, baud, dict.fromkeys(ids, 0.0))


def in_turns(port: str, contenders: dict[str, Client], cycles: int) -> dict[str, Result]:
    """Measure all on one port, in several rounds."""
    results = {name: Result() for name in contenders}
    for _ in range(ROUNDS):
        for name, client in contenders.items():
            with client(port) as cycle:
                results[name].run(cycle, cycles)
    return results


def judge(text: str, value: float, goal: float, form: str) -> bool:
    """Print a figure beside its goal; whether it is met (a rate is a least, all else a most)."""
    met = value >= goal if "Hz" in form else value <= goal
    print(f"  {text:46} {form.format(value)}, goal {form.format(goal)}{'' if met else ': MISSED'}")
    return met


def full_bus(baud: int) -> bool:
    """All servos there, at 1 Mbaud: duration and processor time of each client."""
    own = functools.partial
    contenders: dict[str, Client] = {
        "armsyn, sync read": own(clients.armsyn_arm, baud=baud, kind="sync"),
        "armsyn, fast sync read": own(clients.armsyn_arm, baud=baud, kind="fast"),
        "armsyn's bus, sync": own(clients.armsyn, baud=baud, ids=IDS, kind="sync"),
        "armsyn's bus, fast": own(clients.armsyn, baud=baud, ids=IDS, kind="fast"),
        "bare loop": own(clients.bare_loop, baud=baud, ids=IDS),
        "dynamixel-sdk": own(clients.sdk, baud=baud, ids=IDS),
        "rustypot, sync read": own(clients.rusty, baud=baud, ids=IDS, fast=False),
        "rustypot, fast sync read": own(clients.rusty, baud=baud, ids=IDS, fast=True),
    }
    with replier(len(IDS), baud) as port:
        results = in_turns(port, contenders, CYCLES)
    print(f"bus cycle, {len(IDS)} servos, 10 bytes each, {baud} baud")
    for name, result in results.items():
        wire = wire_time("fast" if "fast" in name else "sync", baud)
        best, worst = np.quantile(result.durations, (0.1, 0.99))
        print(
            f"  {name:24} median {result.median * 1e3:6.3f} ms = {result.median / wire:.2f} x"
            f" {wire * 1e3:.2f} ms of wire, 10 % {best / wire:.2f} x, 99 % {worst * 1e3:6.2f} ms,"
            f" {result.share:4.0%} of a core, {result.lost} lost"
        )
    met = True
    for kind, name in (("sync", "armsyn, sync read"), ("fast", "armsyn, fast sync read")):
        ratio = results[name].median / wire_time(kind, baud)
        met &= judge(f"{name}, over wire", ratio, GREATEST_RATIO, "{:.2f} x")
        met &= judge(f"{name}, of a core", results[name].share, GREATEST_SHARE, "{:.0%}")
    return met


def fast_wire(baud: int) -> bool:
    """Cycles a second at a high baud rate."""
    with replier(len(IDS), baud) as port:
        contenders: dict[str, Client] = {
            "sync": functools.partial(clients.armsyn_arm, baud=baud, kind="sync")
        }
        result = in_turns(port, contenders, CYCLES)["sync"]
    return judge(f"armsyn, sync read at {baud} baud", 1.0 / result.median, LEAST_RATE, "{:.0f} Hz")


def one_missing(baud: int) -> bool:
    """Cycles with one of the servos silent."""
    with replier(len(IDS) - 1, baud) as port:
        contenders: dict[str, Client] = {
            "sync": functools.partial(clients.armsyn, baud=baud, ids=IDS, kind="sync", absent=1),
            "fast": functools.partial(clients.armsyn, baud=baud, ids=IDS, kind="fast", absent=1),
            "sdk": functools.partial(clients.sdk, baud=baud, ids=IDS, absent=1),
        }
        results = in_turns(port, contenders, CYCLES // 10)
    wire = wire_time("sync", baud)
    print(f"  one missing: dynamixel-sdk {(results['sdk'].median - wire) * 1e3:.1f} ms over wire")
    met = True
    for kind in ("sync", "fast"):
        over = 1e3 * (results[kind].median - wire_time(kind, baud))
        met &= judge(f"armsyn, {kind}, one missing, over wire", over, 3.0, "{:.2f} ms")
    return met


class BufferedPort(SerialPort):
    """A port on which the replies to a request are there as soon as it is sent."""

    def __init__(self, path: str, master: int) -> None:
        super().__init__(path, 4_000_000)
        self._master = master
        self.aside = 0.0

    def write(self, data: bytes) -> None:
        """Send, and put the replies on the line; that is not the driver's time."""
        super().write(data)
        start = time.perf_counter()
        last = os.read(self._master, 4096).rpartition(b"\xff\xff\xfd\x00")
        replies = b"".join(answers(last[1] + last[2], len(IDS)))
        os.write(self._master, replies)
        while self.waiting() < len(replies):  # the system passes them on in a thread of its own
            pass
        self.aside += time.perf_counter() - start


def buffered(kind: Kind) -> bool:
    """What the driver itself takes, with the replies already there."""
    master, slave = os.openpty()
    tty.setraw(slave)
    bus = Bus(os.ttyname(slave), 4_000_000)
    bus.serial_port.close()
    bus.serial_port = port = BufferedPort(bus.port_name, master)
    cycle = clients.arm_cycle(bus, kind)
    durations = []
    for _ in range(ROUNDS * CYCLES):
        port.aside, start = 0.0, time.perf_counter()
        cycle()
        durations.append(time.perf_counter() - start - port.aside)
    bus.close()
    os.close(master)
    os.close(slave)
    overhead = statistics.median(durations) * 1e6
    name = f"armsyn, {kind}, replies already buffered"
    return judge(name, overhead, GREATEST_OVERHEAD * 1e6, "{:.0f} us")


def report() -> bool:
    """Measure all, print it, and return whether the goals are met."""
    return all(
        [
            full_bus(1_000_000),
            fast_wire(4_000_000),
            one_missing(1_000_000),
            buffered("sync"),
            buffered("fast"),
        ]
    )


if __name__ == "__main__":
    sys.exit(0 if report() else 1)
