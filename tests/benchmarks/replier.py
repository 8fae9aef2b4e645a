"""The benchmark's own servos: canned answers on a pseudo-terminal, at the wire's pace.

For every byte that arrives the line is busy for its ten bits; each answer to a (fast) sync read
leaves when the request, the answers before it and its own bytes have passed. That time is spun
out, and while requests keep coming they are looked for without sleeping, as a wire never sleeps:
what a cycle takes longer than its wire time is the client's doing, up to microseconds. Nothing
here is shared with the driver or the simulator.

``python replier.py SERVOS BAUD`` prints the port and runs until its standard input ends. Servos
have the IDs from 1; one that is asked for and not there is silent, and ends a fast answer.
"""

from __future__ import annotations

import contextlib
import functools
import os
import select
import sys
import time
import tty

HEADER = b"\xff\xff\xfd\x00"
SYNC_READ = 0x82
FAST_SYNC_READ = 0x8A
BITS_PER_BYTE = 10
PATIENCE = 10e-3
"""Seconds without a request after which the replier sleeps."""

STATE = bytes([5, 0, 2, 0, 0, 0, 0, 8, 0, 0])  # current 5, velocity 2, position 2048


@functools.cache
def crc16(data: bytes) -> int:
    """CRC of Protocol 2.0, bit by bit: polynomial 0x8005, most significant bit first."""
    crc = 0
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ 0x8005 if crc & 0x8000 else crc << 1) & 0xFFFF
    return crc


def answer(servo_id: int) -> bytes:
    """Status packet with the canned state."""
    body = bytes([servo_id, len(STATE) + 4, 0, 0x55, 0]) + STATE
    packet = HEADER + body
    return packet + crc16(packet).to_bytes(2, "little")


@functools.cache
def fast_answer(asked: bytes, servos: int) -> tuple[bytes, ...]:
    """Parts of the one packet that servos answer together, up to the first that is not there."""
    length = 1 + len(asked) * (len(STATE) + 4)
    packet = HEADER + bytes([0xFE, length & 0xFF, length >> 8, 0x55])
    parts = []
    for servo_id in asked:
        if servo_id > servos:
            break
        start = len(packet) if parts else 0
        packet += bytes([0, servo_id]) + STATE
        packet += crc16(packet).to_bytes(2, "little")
        parts.append(packet[start:])
    return tuple(parts)


@functools.cache
def answers(packet: bytes, servos: int) -> tuple[bytes, ...]:
    """What servos 1, 2, 3... say to an instruction, servo by servo."""
    asked = packet[12:-2]
    if packet[7] == SYNC_READ:
        return tuple(answer(servo_id) for servo_id in asked if servo_id <= servos)
    return fast_answer(asked, servos) if packet[7] == FAST_SYNC_READ else ()


class Line:
    """Time on a half-duplex wire."""

    def __init__(self, baud: int) -> None:
        self._byte = BITS_PER_BYTE / baud
        self._free = 0.0

    def carry(self, count: int) -> None:
        """Let `count` bytes pass after what is on the line, or from now."""
        self._free = max(self._free, time.perf_counter()) + count * self._byte

    def spin(self) -> None:
        """Wait until the line is free."""
        while time.perf_counter() < self._free:
            pass


def requests(buffer: bytes) -> tuple[list[bytes], bytes]:
    """Whole packets of a buffer that begins with one, and what is left of it."""
    packets = []
    while len(buffer) >= 7 and len(buffer) >= 7 + buffer[5] + 256 * buffer[6]:
        end = 7 + buffer[5] + 256 * buffer[6]
        packets.append(buffer[:end])
        buffer = buffer[end:]
    return packets, buffer


def incoming(master: int, awake_until: float) -> bytes | None:
    """Bytes of the client, looked for until `awake_until` and slept for from then on.

    None when standard input has ended.
    """
    while time.perf_counter() < awake_until:
        with contextlib.suppress(BlockingIOError):
            return os.read(master, 4096)
    ready, _, _ = select.select([master, sys.stdin], [], [])
    return None if sys.stdin in ready else os.read(master, 4096)


def serve(master: int, servos: int, baud: int) -> None:
    """Answer (fast) sync reads until standard input ends."""
    line, buffer, awake_until = Line(baud), b"", 0.0
    while (data := incoming(master, awake_until)) is not None:
        line.carry(len(data))
        packets, buffer = requests(buffer + data)
        for packet in packets:
            for part in answers(packet, servos):
                line.carry(len(part))
                line.spin()
                os.write(master, part)
        awake_until = time.perf_counter() + PATIENCE


def main() -> None:
    """Offer a port, say its path, and serve."""
    servos, baud = int(sys.argv[1]), int(sys.argv[2])
    master, slave = os.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    print(os.ttyname(slave), flush=True)
    serve(master, servos, baud)


if __name__ == "__main__":
    main()
