"""Seven servos, a million cycles on the stepped clock, and something always going wrong.

A client writes goals and reads positions at 100 Hz while named faults come and go by a seeded
schedule; it drops what is damaged, reboots servos with the alert bit, and switches torque on again.
In the end all faults are cleared, and every servo must answer every cycle; goals and positions
never leave their limits; memory must not have grown.

``python tests/benchmarks/soak.py [CYCLES] [SEED]`` runs half of the cycles on each of two cores.
"""

from __future__ import annotations

import gc
import os
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from random import Random

from armsyn.driver.parser import StatusParser
from armsyn.driver.protocol import packet, sync_read, sync_write, write
from firmware_sim.assembly import build_simulation
from firmware_sim.clock import SteppedClock
from firmware_sim.rig.settings import Rig, parse_servo, with_baud_rate
from firmware_sim.testing import SteppedPort

BAUD = 4_000_000
MODELS = (
    "xm540-w270",
    "xm540-w270",
    "xm430-w350",
    "xm430-w350",
    "xl430-w250",
    "xc430-w150",
    "xm540-w270",
)
IDS = tuple(range(1, 8))
PERIOD = 0.01
"""From one cycle to the next, s."""

MEAN_PAUSE = 50
"""Cycles from one fault to the next, on the mean."""

LOW, HIGH = 1024, 3072
"""The servos' position limits, ticks."""

OVERSHOOT = 200
"""How far a horn may swing beyond a limit, ticks; where it boots, its goal is where it is."""

BLIND = 1_000
"""Cycles after a stuck encoder in which a horn may be anywhere: a loop that sees nothing runs, and
a boot makes its goal where it went."""

GROWTH_CAP = 4_000_000
"""Growth of memory from a tenth of the way to the end that counts as flat, bytes."""

EVERYWHERE = (
    "bit-errors:rate=0.002", "chunked-reply", "crc-error:probability=0.3",
    "crc-error:to=servos,probability=0.3", "duplicate-reply", "foreign-traffic:every=0.02",
    "idle-noise:bytes=40,every=0.005", "late-reply", "late-reply:delay=0.004", "latency-timer",
    "local-echo", "local-echo:share=0.5", "lost-bytes:bytes=3", "lost-instructions:probability=0.5",
    "lost-replies:probability=0.5", "lying-length", "lying-length:length=0,to=servos",
    "lying-length:to=servos", "missing-stuffing", "noise:place=inside", "noise:bytes=200",
    "noise:to=servos", "power-cut:count=1", "return-delay", "slow-adapter:jitter=0.003",
    "truncated-status", "truncated-status:to=servos", "unplugged", "supply-sag:voltage=10",
)  # fmt: skip
"""Faults of the line, or of all servos."""

OF_A_SERVO = (
    "alert-bit", "electrical-shock:count=1", "encoder-error:count=1", "friction", "jam",
    "missing-servo", "multi-turn-fold:count=1", "overheating:count=1", "overload:count=1",
    "reboot:count=1", "silent-servo", "stuck-encoder", "watchdog-expired", "wrong-baud",
)  # fmt: skip
"""Faults of one servo; an ID is put to them."""


@dataclass(frozen=True)
class SoakReport:
    """What a soak saw.

    Parameters
    ----------
    cycles : int
        How many it ran.
    fresh : int
        Replies with a right CRC and the data asked for; seven a cycle without faults.
    struck : Counter of str
        How often faults of each name struck.
    growth : int
        Of resident memory, from a tenth of the way to the end, bytes.
    duration : float
        s.
    """

    cycles: int
    fresh: int
    struck: Counter[str]
    growth: int
    duration: float


class Client:
    """Goals out, positions in, and the most stubborn recovery there is.

    Parameters
    ----------
    port : SteppedPort
        Where the servos are.
    """

    def __init__(self, port: SteppedPort) -> None:
        self.port = port
        self.fresh = 0
        self._parser = StatusParser()
        self._state = sync_read(116, 20, IDS)  # goal and present position, with all between
        self._torque = sync_write(64, 1, IDS, b"\x01" * 7)
        self._watchdog = sync_write(98, 1, IDS, bytes(7))

    def start(self) -> None:
        """Set position limits and switch torque on."""
        limits = HIGH.to_bytes(4, "little") + LOW.to_bytes(4, "little")
        for servo_id in IDS:
            self._send(write(servo_id, 48, limits))
        self._send(self._torque)

    def cycle(self, tick: int) -> None:
        """Write a goal to all, read all, and look after those that are in trouble."""
        goals = sync_write(116, 4, IDS, tick.to_bytes(4, "little") * 7)
        statuses = self._parser.feed(self._send(goals + self._state))
        for status in statuses:
            if status.alert:
                self._send(packet(status.servo_id, 0x08))
            if len(status.parameters) == 20 and not status.error_number:
                self.fresh += 1

    def look_after(self) -> None:
        """Clear watchdogs and switch torque on again, whoever lost it."""
        self._send(self._watchdog + self._torque)

    def _send(self, request: bytes) -> bytes:
        try:
            return self.port.exchange(request)
        except OSError:  # unplugged
            return b""


def soak(cycles: int, seed: int) -> SoakReport:
    """Run a client and faults against seven servos.

    Parameters
    ----------
    cycles : int
        How many, at 100 Hz.
    seed : int
        Of the faults and of what they do.

    Raises
    ------
    AssertionError
        If a goal or position leaves its limits, or a servo is missing in the end.
    """
    started, draw = time.perf_counter(), Random(seed)  # noqa: S311
    servos = [
        with_baud_rate(parse_servo(f"{m}:{i}"), BAUD) for m, i in zip(MODELS, IDS, strict=True)
    ]
    rig = Rig([servo.with_registers({"Return Delay Time": 0}) for servo in servos])
    port = SteppedPort(build_simulation(rig, seed=seed), SteppedClock(), BAUD)
    client = Client(port)
    client.start()
    struck, memory, next_fault, blind = Counter[str](), 0, 0, 0
    for number in range(cycles):
        port.wait_until(number * PERIOD)
        if number >= next_fault:
            inject(port, draw)
            next_fault = number + 1 + int(draw.expovariate(1.0 / MEAN_PAUSE))
        client.cycle(2048 + (number * 7) % 512)
        if any(fault.spec.kind.name == "stuck-encoder" for fault in port.simulation.faults):
            blind = number + BLIND
        if number % 20 == 0:
            client.look_after()
            if number >= blind:
                check_limits(port)
        if number == cycles // 10:
            memory = resident()
    growth = resident() - memory
    struck.update(port.simulation.strikes)
    check_recovery(port, client)
    return SoakReport(cycles, client.fresh, struck, growth, time.perf_counter() - started)


def inject(port: SteppedPort, draw: Random) -> None:
    """Let one more thing go wrong for a while."""
    if draw.random() < 0.6:
        spec = draw.choice(EVERYWHERE)
    else:
        name, _, rest = draw.choice(OF_A_SERVO).partition(":")
        spec = f"{name}:id={draw.choice(IDS)}" + (f",{rest}" if rest else "")
    duration = f"for={draw.uniform(0.02, 1.0):.3f}"
    port.simulation.inject(f"{spec}{',' if ':' in spec else ':'}{duration}")


def check_limits(port: SteppedPort) -> None:
    """Look behind the protocol: no goal and no horn beyond its limits."""
    for servo in port.simulation.bus.servos:
        registers = (servo.read(address, 4)[1] for address in (116, 132))
        goal, position = (int.from_bytes(data, "little", signed=True) for data in registers)
        assert LOW - OVERSHOOT <= goal <= HIGH + OVERSHOOT, f"{servo.servo_id}: goal {goal}"
        assert LOW - OVERSHOOT <= position <= HIGH + OVERSHOOT, f"{servo.servo_id}: {position}"


def check_recovery(port: SteppedPort, client: Client) -> None:
    """Clear every fault, look after all for two seconds, and see all answer all the time."""
    port.simulation.clear("all")
    for _ in range(200):
        port.wait_until(port.clock.now() + PERIOD)
        client.cycle(2048)
        client.look_after()
    before = client.fresh
    for _ in range(100):
        port.wait_until(port.clock.now() + PERIOD)
        client.cycle(2048)
    assert client.fresh - before == 700, f"{client.fresh - before} of 700 replies"


def resident() -> int:
    """Return the memory that this process holds, bytes."""
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGESIZE")


def main() -> int:
    """Soak on two cores and print what was seen."""
    cycles = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    start = time.perf_counter()
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        reports = list(pool.map(soak, [cycles // 2, cycles - cycles // 2], [seed, seed + 1]))
    duration = time.perf_counter() - start
    struck = sum((report.struck for report in reports), Counter[str]())
    fresh = sum(report.fresh for report in reports)
    growth = max(report.growth for report in reports)
    print(f"{cycles} cycles of 7 servos, seeds {seed} and {seed + 1}: {duration:.0f} s")
    print(f"  replies with the data asked for: {fresh} of {7 * cycles} ({fresh / 7 / cycles:.1%})")
    print(f"  faults struck {struck.total()} times, {len(struck)} kinds; growth {growth} bytes")
    for name, count in sorted(struck.items()):
        print(f"    {name:20} {count}")
    return 0 if growth < GROWTH_CAP and duration < 600.0 else 1


if __name__ == "__main__":
    sys.exit(main())
