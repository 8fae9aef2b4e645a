"""Faults of what is between the wire and the client's program: adapter, driver, USB."""

from __future__ import annotations

import math
from random import Random

from firmware_sim.faults.argument import Argument
from firmware_sim.faults.fault import ADAPTER, Line, Piece
from firmware_sim.faults.spec import FaultKind, FaultSpec
from firmware_sim.faults.striking import PacketFault, StateFault
from firmware_sim.wire.line import wire_time

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


class AdapterState(StateFault):
    """Delays bytes for a time; those that come after it do not overtake them."""

    stage = ADAPTER

    def __init__(self, spec: FaultSpec, random: Random) -> None:
        super().__init__(spec, random)
        self.last = {"client": 0.0, "servos": 0.0}
        """When the last bytes delayed arrive, s."""

    def inward(self, pieces: list[Piece], line: Line) -> list[Piece]:
        """Return the requests, later."""
        return self._in_order(self.delayed(pieces, line, "servos") if self.on else pieces, "servos")

    def outward(self, pieces: list[Piece], line: Line) -> list[Piece]:
        """Return the replies, later."""
        return self._in_order(self.delayed(pieces, line, "client") if self.on else pieces, "client")

    def spent(self, when: float) -> bool:
        """Return whether it is over, and all that it delayed has arrived."""
        return super().spent(when) and when >= max(self.last.values())

    def delayed(self, pieces: list[Piece], line: Line, to: str) -> list[Piece]:
        """Return bytes with the times they have through this adapter."""
        raise NotImplementedError

    def _in_order(self, pieces: list[Piece], to: str) -> list[Piece]:
        ordered = []
        for piece in pieces:
            when = max(self.last[to], piece.when)
            ordered.append(Piece(piece.data, when, piece.servo_id, piece.deaf))
            if self.on:
                self.last[to] = when
        return ordered


class SlowAdapter(AdapterState):
    """Everything takes longer, and not always equally long; the order stays."""

    def delayed(self, pieces: list[Piece], _line: Line, to: str) -> list[Piece]:
        """Return bytes later, by a time that varies."""
        if self.spec.choice("to") not in (to, "both"):
            return pieces
        delay, jitter = self.spec.number("delay"), self.spec.number("jitter")
        times = [piece.when + delay + self.random.random() * jitter for piece in pieces]
        return [
            Piece(piece.data, when, piece.servo_id, piece.deaf)
            for piece, when in zip(pieces, times, strict=True)
        ]


class LatencyTimer(AdapterState):
    """The adapter keeps bytes until its timer runs out, or until a USB packet is full.

    The timer runs freely from the simulator's start. Bytes that join those of an earlier request in
    the adapter do not make the packet leave earlier.
    """

    stage = ADAPTER + 1

    def delayed(self, pieces: list[Piece], line: Line, to: str) -> list[Piece]:
        """Return the replies' bytes, together as the adapter passes them on."""
        if to == "servos":
            return pieces
        byte_time = wire_time(1, line.baud_rate)
        passed: list[Piece] = []
        waiting = bytearray()
        timeout = 0.0
        for piece in pieces:
            for place, byte in enumerate(piece.data, 1 - len(piece.data)):
                when = piece.when + place * byte_time
                if waiting and when > timeout:
                    passed.append(Piece(bytes(waiting), timeout))
                    waiting.clear()
                timeout = self._timeout(when)
                waiting.append(byte)
                if len(waiting) == _USB_PACKET and timeout != self.last["client"]:
                    passed.append(Piece(bytes(waiting), when))
                    waiting.clear()
        return [*passed, Piece(bytes(waiting), timeout)] if waiting else passed

    def _timeout(self, when: float) -> float:
        """Return when the timer runs out next, s."""
        latency = self.spec.number("latency")
        ticks = math.ceil((when - self.site.start) / latency - 1.0e-9)
        return self.site.start + ticks * latency


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
