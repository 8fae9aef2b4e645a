"""What the simulated servos cost, and how many of them keep up.

On a pseudo-terminal: bytes a second, the round trip of a 14-byte request, and the share of a core
at 7 moving servos and 500 cycles a second. On the stepped clock: the largest number of servos of
one bus that are read 100 times a second, and the simulated seconds a second of a 7-servo arm.
"""

from __future__ import annotations

import os
import select
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import serial

from armsyn.arm import load_arm
from armsyn.arm.rig import build_rig
from armsyn.driver.protocol import packet, read, sync_read, sync_write
from firmware_sim.assembly import build_simulation
from firmware_sim.clock import SteppedClock
from firmware_sim.rig.file import read_rig
from firmware_sim.rig.settings import Rig, parse_servo, with_baud_rate
from firmware_sim.testing import SimulatorProcess, SteppedPort

BAUD = 4_000_000
MODEL = "xm430-w350"
IDS = tuple(range(1, 8))
ALL_IDS = 253
STATE = sync_read(126, 10, IDS)
STATE_SIZE = 21 * len(IDS)
FAST_SYNC_READ = 0x8A
RATE = 100.0
"""Cycles a second of simulated time."""


def goals(ids: tuple[int, ...], tick: int) -> bytes:
    """Return a sync write of one goal position to all."""
    return sync_write(116, 4, ids, tick.to_bytes(4, "little") * len(ids))


def torque_on(ids: tuple[int, ...]) -> bytes:
    """Return a sync write that switches the torque on."""
    return sync_write(64, 1, ids, bytes([1] * len(ids)))


def exchange(descriptor: int, request: bytes, expected: int) -> None:
    """Write a request and wait for as many bytes as its answers have."""
    os.write(descriptor, request)
    count = 0
    while count < expected:
        if not select.select([descriptor], [], [], 1.0)[0]:
            raise RuntimeError(f"{count} of {expected} bytes came")
        count += len(os.read(descriptor, 4096))


def round_trip(descriptor: int) -> float:
    """Return the median time of a read of 4 bytes of one servo, s."""
    request, durations = read(1, 132, 4), []
    for _ in range(2_000):
        start = time.perf_counter()
        exchange(descriptor, request, 15)
        durations.append(time.perf_counter() - start)
    return statistics.median(durations)


def speed(descriptor: int) -> float:
    """Return bytes a second, both ways, of cycles back to back."""
    cycles, request = 1_000, goals(IDS, 2048) + STATE
    start = time.perf_counter()
    for _ in range(cycles):
        exchange(descriptor, request, STATE_SIZE)
    return cycles * (len(request) + STATE_SIZE) / (time.perf_counter() - start)


def processor_time(process_id: int) -> float:
    """Return how long a process has run on any core, s."""
    fields = Path(f"/proc/{process_id}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def share(descriptor: int, process_id: int, rate: float, seconds: float) -> float:
    """Return the part of a core that the simulator takes at a rate of cycles, servos moving."""
    busy, start = processor_time(process_id), time.perf_counter()
    for cycle in range(int(rate * seconds)):
        exchange(descriptor, goals(IDS, 2048 + cycle % 1_000) + STATE, STATE_SIZE)
        time.sleep(max(0.0, start + (cycle + 1) / rate - time.perf_counter()))
    return (processor_time(process_id) - busy) / (time.perf_counter() - start)


def on_a_port() -> tuple[float, float, float]:
    """Measure a simulator in a process of its own: round trip, bytes a second, share of a core."""
    servos = ("--servo", *(f"{MODEL}:{i}" for i in IDS))
    simulator = SimulatorProcess(*servos, "--baud", str(BAUD), "--return-delay", "0")
    try:
        with serial.Serial(simulator.port, BAUD, timeout=0) as opened:
            descriptor = opened.fileno()
            exchange(descriptor, torque_on(IDS) + STATE, STATE_SIZE)
            return (
                round_trip(descriptor),
                speed(descriptor),
                share(descriptor, simulator.process.pid, rate=500.0, seconds=6.0),
            )
    finally:
        simulator.stop()


def simulated_per_second(port: SteppedPort, cycle: Callable[[int], None], seconds: float) -> float:
    """Return simulated seconds a second, with a cycle at each absolute time."""
    cycle(0)
    begin, start = port.clock.now(), time.perf_counter()
    for number in range(1, int(seconds * RATE) + 1):
        port.wait_until(begin + number / RATE)
        cycle(number)
    return (port.clock.now() - begin) / (time.perf_counter() - start)


def read_many(count: int) -> tuple[float, float]:
    """Return wire time, s, and pace of writing goals to, and fast sync reading 4 bytes of, many."""
    servos = [with_baud_rate(parse_servo(f"{MODEL}:{i}"), BAUD) for i in range(count)]
    rig = Rig([servo.with_registers({"Return Delay Time": 0}) for servo in servos])
    port = SteppedPort(build_simulation(rig), SteppedClock(), BAUD)
    ids = tuple(range(count))
    port.exchange(torque_on(ids))
    request = goals(ids, 2048) + packet(0xFE, FAST_SYNC_READ, bytes((132, 0, 4, 0, *ids)))
    expected = 8 + 8 * count

    def cycle(_number: int) -> None:
        if len(port.exchange(request)) != expected:
            raise RuntimeError(f"not all of {count} servos answered")

    wire = (len(request) + expected) * 10.0 / BAUD
    return wire, simulated_per_second(port, cycle, 5.0)


def most_servos() -> tuple[int, float, float]:
    """Return the largest number read in 10 ms of wire and of time, with its figures."""
    for count in (ALL_IDS, 200, 150, 100, 50, 25):
        wire, pace = read_many(count)
        if wire <= 1.0 / RATE and pace >= 1.0:
            return count, wire, pace
    raise RuntimeError("not even 25 servos keep up")


def arm_rig() -> Rig:
    """Return the human-like arm, with its bodies, at 4 Mbaud."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "human7.rig.toml"
        path.write_text(build_rig(load_arm("human7")), encoding="utf-8")
        rig = read_rig(path)
    return replace(rig, servos=[with_baud_rate(servo, BAUD) for servo in rig.servos])


def move_arm(rig: Rig, seconds: float) -> float:
    """Return simulated seconds a second of an arm that is written to and read at 100 Hz."""
    port = SteppedPort(build_simulation(rig), SteppedClock(), BAUD)
    ids = tuple(servo.servo_id for servo in rig.servos)
    starts = [servo.start_tick for servo in rig.servos]
    state = sync_read(126, 10, ids)
    port.exchange(torque_on(ids))

    def cycle(number: int) -> None:
        offset = abs(number % 200 - 100)
        ticks = b"".join((start + offset).to_bytes(4, "little") for start in starts)
        answer = port.exchange(sync_write(116, 4, ids, ticks) + state)
        if len(answer) < 21 * len(ids):  # a byte is stuffed in now and then
            raise RuntimeError("a reply is missing")

    return simulated_per_second(port, cycle, seconds)


def report() -> bool:
    """Measure all, print it, and return whether the goals are met."""
    delay, rate, part = on_a_port()
    wire = (14 + 15) * 10.0 / BAUD
    print(f"simulated servos ({MODEL}) at {BAUD} baud")
    print(f"  round trip of a 14-byte request {delay * 1e6:6.0f} us ({wire * 1e6:.1f} us of wire)")
    print(f"  back to back                    {rate / 1e3:6.0f} kB/s (the wire: {BAUD / 1e4:.0f})")
    print(f"  7 servos, 500 cycles a second   {part:6.0%} of a core (goal: below 35 %)")
    count, wire, pace = most_servos()
    print(
        f"  kept at 100 Hz on one bus       {count:6} servos (goal 253):"
        f" {wire * 1e3:.1f} ms of wire, {pace:.1f} x real time"
    )
    rig = arm_rig()
    joints, bodies = move_arm(replace(rig, mjcf=None), 30.0), move_arm(rig, 10.0)
    print(f"  7-servo arm, stepped clock      {joints:6.0f} x real time (goal 50)")
    print(f"  the same as bodies (MuJoCo)     {bodies:6.0f} x real time (goal 10)")
    return part < 0.35 and count == ALL_IDS and joints >= 50.0 and bodies >= 10.0


if __name__ == "__main__":
    sys.exit(0 if report() else 1)
