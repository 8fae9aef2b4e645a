"""Faults of what is between the wire and the client's program: adapter, driver, USB."""

from __future__ import annotations

import math
from random import Random

from firmware_sim.faults.argument import Argument
from firmware_sim.faults.fault import ADAPTER, Line, Piece
from firmware_sim.faults.spec import FaultKind, FaultSpec
from firmware_sim.faults.striking import PacketFault, StateFault
from firmware_sim.line import wire_time

_USB_PACKET = 62
"""Bytes an FTDI adapter sends without waiting for its timer (FTDI AN232B-04, section 2: packets of
64 bytes, 2 of them status)."""


class LocalEcho(PacketFault):
    """The adapter hears what it sends, and passes it on to the client."""

    stage = ADAPTER

    def __init__(self, spec: FaultSpec, random: Random) -> None:
        super().__init__(spec, random)
        self._echoes: list[Piece] = []

    def inward(self, pieces: list[Piece], line: Line) -> list[Piece]:
        """Return the request as it is, and remember its echo."""
        data = b"".join(piece.data for piece in pieces)
        if data and self.may_strike(Piece(data, line.when), line.when):
            self.rest(line.when)
            echo = data[: math.ceil(self.spec.number("share") * len(data))]
            self._echoes.append(Piece(echo, line.begin + wire_time(len(echo), line.baud_rate)))
            self.struck(line.when, None, f"{len(echo)} of {len(data)} bytes")
        return pieces

    def outward(self, pieces: list[Piece], _line: Line) -> list[Piece]:
        """Return the echo, and what follows it."""
        echoes, self._echoes = self._echoes, []
        return echoes + pieces


class Chunking(PacketFault):
    """Replies arrive cut into chunks, with pauses in between."""

    stage = ADAPTER

    def change(self, piece: Piece, _line: Line) -> list[Piece] | None:
        """Return the chunks of a reply, None where it is a single one."""
        size, gap = self.spec.whole("bytes"), self.spec.number("gap")
        if len(piece.data) <= size:
            return None
        starts = range(0, len(piece.data), size)
        return [
            Piece(piece.data[start : start + size], piece.when + turn * gap, piece.servo_id)
            for turn, start in enumerate(starts)
        ]


class SlowAdapter(StateFault):
    """Everything takes longer, and not always equally long; the order stays."""

    stage = ADAPTER

    def __init__(self, spec: FaultSpec, random: Random) -> None:
        super().__init__(spec, random)
        self._last = {"client": 0.0, "servos": 0.0}

    def inward(self, pieces: list[Piece], _line: Line) -> list[Piece]:
        """Return the requests, later."""
        return self._delayed(pieces, "servos")

    def outward(self, pieces: list[Piece], _line: Line) -> list[Piece]:
        """Return the replies, later."""
        return self._delayed(pieces, "client")

    def _delayed(self, pieces: list[Piece], to: str) -> list[Piece]:
        if not self.on or self.spec.choice("to") not in (to, "both"):
            return pieces
        later = []
        for piece in pieces:
            delay = self.spec.number("delay") + self.random.random() * self.spec.number("jitter")
            self._last[to] = max(self._last[to], piece.when + delay)
            later.append(Piece(piece.data, self._last[to], piece.servo_id, piece.deaf))
        return later


class LatencyTimer(StateFault):
    """The adapter keeps bytes until its timer runs out, or until a USB packet is full.

    The timer runs freely from the simulator's start.
    """

    stage = ADAPTER + 1

    def __init__(self, spec: FaultSpec, random: Random) -> None:
        super().__init__(spec, random)
        self._timeout = 0.0
        self._waiting = 0  # bytes in the adapter that leave at the time-out

    def outward(self, pieces: list[Piece], line: Line) -> list[Piece]:
        """Return the replies' bytes, together as the adapter passes them on."""
        if not self.on:
            return pieces
        passed: dict[float, bytearray] = {}
        byte_time = wire_time(1, line.baud_rate)
        for piece in pieces:
            first = piece.when - byte_time * (len(piece.data) - 1)
            for place, byte in enumerate(piece.data):
                self._pass_on(passed, byte, first + place * byte_time)
        return [Piece(bytes(data), when) for when, data in passed.items()]

    def _pass_on(self, passed: dict[float, bytearray], byte: int, when: float) -> None:
        latency = self.spec.number("latency")
        ticks = math.ceil((when - self.site.start) / latency - 1.0e-9)
        timeout = self.site.start + ticks * latency
        if timeout != self._timeout:
            self._timeout, self._waiting = timeout, 0
        passed.setdefault(timeout, bytearray()).append(byte)
        self._waiting += 1
        if self._waiting == _USB_PACKET:
            full = passed.pop(timeout)
            passed.setdefault(when, bytearray()).extend(full)
            self._waiting = 0


KINDS = (
    FaultKind(
        "local-echo",
        (6,),
        "the client hears what it sends, wholly or in part",
        LocalEcho,
        (Argument("share", "how much of each request", 1.0, high=1.0),),
        concerns_servo=False,
    ),
    FaultKind(
        "chunked-reply",
        (2,),
        "replies arrive in chunks, with pauses in between",
        Chunking,
        (
            Argument("bytes", "in a chunk", 4, "bytes", low=1, high=4096, whole=True),
            Argument("gap", "from chunk to chunk", 2.0e-3, "s", high=1.0),
        ),
    ),
    FaultKind(
        "slow-adapter",
        (15,),
        "everything is late, by a time that varies; the order stays",
        SlowAdapter,
        (
            Argument("delay", "at least this much", 4.0e-3, "s", high=1.0),
            Argument("jitter", "up to this much more, by chance", 0.0, "s", high=1.0),
            Argument("to", "which way", "client", choices=("client", "servos", "both")),
        ),
        concerns_servo=False,
    ),
    FaultKind(
        "latency-timer",
        (15,),
        "the adapter passes bytes on only when its timer runs out or 62 of them wait",
        LatencyTimer,
        (Argument("latency", "of the timer; 1 ms where tuned", 16.0e-3, "s", 1.0e-3, 0.255),),
        concerns_servo=False,
    ),
)
