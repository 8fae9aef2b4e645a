"""The one place where bytes meet faults: bytes go in, pieces with times come out.

Requests pass the adapter first and the wire after it; replies the other way round.
"""

from __future__ import annotations

from collections.abc import Sequence

from firmware_sim.faults.fault import Fault, Line, Piece
from firmware_sim.faults.frames import RequestCutter, owner
from firmware_sim.wire.bus import Transmission


class Seam:
    """Bytes between a client and the servos, as the faults in force let them through."""

    def __init__(self) -> None:
        self._cutter = RequestCutter()
        self._outward: tuple[Fault, ...] = ()
        self._inward: tuple[Fault, ...] = ()
        self._cut = False

    @property
    def holds(self) -> bool:
        """Whether the start of a packet waits here for its end."""
        return self._cutter.holds

    def take(self, faults: Sequence[Fault]) -> None:
        """Let these faults act from now on, those of one stage in the order given."""
        self._outward = tuple(sorted(faults, key=lambda fault: fault.stage))
        self._inward = tuple(reversed(self._outward))
        self._cut = any(fault.wants_requests for fault in faults)

    def reset(self) -> None:
        """Forget what waits, as when the port goes."""
        self._cutter.flush()

    def inward(self, chunk: bytes, line: Line) -> list[Piece]:
        """Return what reaches the servos of a client's bytes, in order of time."""
        if not self._inward:
            held = self._cutter.flush()
            return [Piece(held + chunk, line.when)]
        parts = self._cutter.feed(chunk) if self._cut else [self._cutter.flush() + chunk]
        pieces = [Piece(part, line.when, owner(part)) for part in parts]
        for fault in self._inward:
            pieces = fault.inward(pieces, line)
        return pieces

    def outward(self, sent: Sequence[Transmission], line: Line) -> list[Transmission]:
        """Return what reaches the client of what is on the wire, in order of time."""
        if not self._outward:
            return list(sent)
        pieces = [Piece(reply.data, reply.due, owner(reply.data)) for reply in sent]
        for fault in self._outward:
            pieces = fault.outward(pieces, line)
        pieces.sort(key=lambda piece: piece.when)
        return [Transmission(piece.when, piece.data) for piece in pieces if piece.data]
