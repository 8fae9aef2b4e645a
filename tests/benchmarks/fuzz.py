"""Hostile bytes against simulated servos of every model, in both protocols, with faults among them.

A case is made by its seed alone: servos, faults, and a stream of packets that are right, nearly
right, or noise, cut into chunks at times of its own. No case may raise, and none may leave more
than a bounded heap of bytes behind. ``python tests/benchmarks/fuzz.py MINUTES [FIRST_SEED]`` goes
through seeds, one process a core, until the time is up, and names those that failed; failed seeds
that were mended stand in ``tests/data/fuzz_seeds.txt`` and are run by the tests.
"""

from __future__ import annotations

import struct
import sys
import time
import traceback
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from multiprocessing import get_context
from random import Random

from armsyn.driver.protocol import packet
from firmware_sim.assembly import build_simulation
from firmware_sim.clock import SteppedClock
from firmware_sim.errors import FaultError
from firmware_sim.faults.registry import KINDS
from firmware_sim.rig.settings import Rig, centre_tick, parse_servo, with_protocol
from firmware_sim.tables import MODEL_NAMES
from firmware_sim.testing import SteppedPort

SERVOS = 6
"""On the bus of one case."""

CHUNKS = 120
"""Sent in one case."""

INSTRUCTIONS = (1, 2, 3, 4, 5, 6, 8, 0x10, 0x20, 0x55, 0x82, 0x83, 0x8A, 0x92, 0x93, 0x9A)
ADDRESSES = (0, 7, 8, 10, 11, 12, 13, 20, 60, 63, 64, 98, 100, 102, 104, 108, 112, 116, 126, 132)
RATES = (0, 50, 9_600, 57_600, 1_000_000, 4_000_000, 123_456)
"""0 is refused."""

PENDING_CAP = 8_192
"""Bytes that parsers may keep of unfinished packets."""

ARRIVED_CAP = 4_000_000
"""Bytes that all answers of a case may have."""


def run_case(seed: int) -> None:
    """Run one case.

    Raises
    ------
    Exception
        Whatever the simulator raises; AssertionError if it keeps too much.
    """
    draw = Random(seed)  # noqa: S311 - chance, not secrets
    port = make_port(draw)
    arrived = 0
    for _ in range(CHUNKS):
        if draw.random() < 0.05:
            try_fault(port, draw)
        try:
            port.write(make_chunk(draw))
            port.wait_until(port.clock.now() + draw.choice((0.0, 1e-4, 2e-3, 0.05)))
            arrived += len(port.read(port.in_waiting(), 0.0))
        except OSError:  # unplugged
            port.wait_until(port.clock.now() + 0.1)
        if draw.random() < 0.02:
            with suppress(ValueError, OSError):  # no rate, or no port
                port.baud_rate = draw.choice(RATES)
    ears = port.bus.ears
    pending = ears.parser.pending + ears.parser1.pending
    assert pending <= PENDING_CAP, f"{pending} bytes are pending"
    assert arrived <= ARRIVED_CAP, f"{arrived} bytes came"


def make_port(draw: Random) -> SteppedPort:
    """Return a stepped port to random servos, some of them with one ID."""
    servos = []
    for _ in range(SERVOS):
        name = draw.choice(MODEL_NAMES)
        servo = parse_servo(f"{name}:{draw.randrange(8)}")
        if draw.random() < 0.3 and 2 in servo.model.protocols and 1 in servo.model.protocols:
            servo = with_protocol(servo, draw.choice((1, 2)))
        assert servo.start_tick == centre_tick(servo.model)
        servos.append(servo.with_registers({"Return Delay Time": draw.randrange(255)}))
    simulation = build_simulation(Rig(servos), seed=draw.randrange(1000))
    return SteppedPort(simulation, SteppedClock(), draw.choice((57_600, 57_600, *RATES[1:])))


def try_fault(port: SteppedPort, draw: Random) -> None:
    """Inject a fault for a while; those that do not fit are refused."""
    name = draw.choice(sorted(KINDS))
    spec = f"{name}:for={draw.uniform(0.01, 0.5):.3f}"
    if draw.random() < 0.5:
        spec += f",id={draw.randrange(8)}"
    with suppress(FaultError):
        port.simulation.inject(spec)


def make_chunk(draw: Random) -> bytes:
    """Return packets of either protocol, whole, damaged or cut, or noise."""
    data = b"".join(make_packet(draw) for _ in range(draw.randrange(1, 4)))
    kind = draw.random()
    if kind < 0.25:
        data = damage(data, draw)
    elif kind < 0.35:
        data = data[: draw.randrange(len(data) + 1)]
    elif kind < 0.45:
        data = bytes(draw.choice((0xFF, 0xFF, 0xFD, 0, draw.randrange(256))) for _ in range(300))
    return data


def damage(data: bytes, draw: Random) -> bytes:
    """Flip, drop or put in a few bytes."""
    damaged = bytearray(data)
    for _ in range(draw.randrange(1, 4)):
        place = draw.randrange(len(damaged))
        damaged[place : place + draw.randrange(2)] = draw.randbytes(draw.randrange(3))
        if not damaged:
            return b"\xff"
    return bytes(damaged)


def make_packet(draw: Random) -> bytes:
    """Return a packet with a right check sum and any contents."""
    servo_id = draw.choice((*range(8), 252, 254, 254, 255))
    instruction = draw.choice((*INSTRUCTIONS, draw.randrange(256)))
    params = make_params(draw, instruction)
    if draw.random() < 0.3 or servo_id == 255:
        body = bytes((servo_id, (len(params) + 2) & 0xFF, instruction)) + params
        return b"\xff\xff" + body + bytes((~sum(body) & 0xFF,))
    return packet(servo_id, instruction, params)


def make_params(draw: Random, instruction: int) -> bytes:
    """Return parameters that fit the instruction more often than not."""
    address = draw.choice((*ADDRESSES, draw.randrange(700)))
    value = draw.choice((0, 1, 255, draw.randrange(4096), draw.getrandbits(32)))
    size = draw.choice((1, 2, 4, 4, 4, 10, draw.randrange(700)))
    if draw.random() < 0.15:
        return draw.randbytes(draw.choice((0, 1, 2, 5, 40)))
    if instruction in (0x82, 0x8A, 0x92, 0x9A):
        head = struct.pack("<HH", address, size)
        if instruction in (0x92, 0x9A):
            return b"".join(bytes((i,)) + head for i in range(draw.randrange(8)))
        return head + bytes(draw.randrange(9) for _ in range(draw.randrange(12)))
    if instruction in (0x83, 0x93):
        return struct.pack("<HH", address, 4) + struct.pack("<BI", draw.randrange(8), value)
    if instruction == 2:
        return struct.pack("<HH", address, size)
    return struct.pack("<H", address) + value.to_bytes(4, "little")[: draw.choice((1, 2, 4))]


def run_seeds(seeds: range) -> list[str]:
    """Run cases; return a line with the traceback of each that failed."""
    failures = []
    for seed in seeds:
        try:
            run_case(seed)
        except Exception:  # noqa: BLE001 - whatever it is, it is what is looked for
            failures.append(f"seed {seed}\n{traceback.format_exc()}")
    return failures


def main() -> int:
    """Fuzz for a while on two cores."""
    minutes = float(sys.argv[1]) if len(sys.argv) > 1 else 1.0
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    deadline, failures, seed = time.monotonic() + 60.0 * minutes, list[str](), first
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        while time.monotonic() < deadline:
            batches = [range(seed + 20 * n, seed + 20 * (n + 1)) for n in range(4)]
            for found in pool.map(run_seeds, batches):
                failures += found
            seed += 80
    print("\n".join(failures[:20]))
    for reason, count in Counter(text.splitlines()[-1] for text in failures).items():
        print(f"{count} x {reason}")
    print(f"seeds {first} to {seed - 1}: {len(failures)} failed; {minutes:g} minutes")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
