"""Faults of whole packets on the wire: lost, late, or twice."""

from __future__ import annotations

from random import Random

from firmware_sim.faults.argument import Argument
from firmware_sim.faults.fault import Line, Piece
from firmware_sim.faults.spec import FaultKind, FaultSpec
from firmware_sim.faults.striking import PacketFault
from firmware_sim.wire.line import wire_time
from firmware_sim.wire.packet import BROADCAST_ID

_HELD_CAP = 256
"""Most late replies that wait at a time."""


class LostReply(PacketFault):
    """Replies do not arrive; the wire was busy with them all the same."""

    def change(self, _piece: Piece, _line: Line) -> list[Piece] | None:
        """Return nothing."""
        return []


class DuplicateReply(PacketFault):
    """Replies arrive twice."""

    def change(self, piece: Piece, line: Line) -> list[Piece] | None:
        """Return the reply and its copy, which follows at once."""
        again = piece.when + wire_time(len(piece.data), line.baud_rate)
        return [piece, Piece(piece.data, again, piece.servo_id)]


class LostInstruction(PacketFault):
    """Requests do not reach a servo, nor its watchdog."""

    wants_requests = True

    def may_strike(self, piece: Piece, when: float) -> bool:
        """Return whether it strikes: a request to all reaches the servo too."""
        if piece.servo_id == BROADCAST_ID:
            piece = Piece(piece.data, piece.when, self.spec.servo_id)
        return super().may_strike(piece, when)

    def change(self, piece: Piece, _line: Line) -> list[Piece] | None:
        """Return the request, which the servo does not hear."""
        servo_id = self.spec.servo_id
        missed = {servo.servo_id for servo in self.site.chosen(servo_id)}
        return [Piece(piece.data, piece.when, piece.servo_id, piece.deaf | missed)]


class ReturnDelay(PacketFault):
    """A servo takes longer to answer; the replies behind its reply wait for it."""

    def outward(self, pieces: list[Piece], line: Line) -> list[Piece]:
        """Return the replies, each as late as those before it make it."""
        delay = 0.0
        later: list[Piece] = []
        for piece in pieces:
            if self.may_strike(piece, line.when):
                delay += self.spec.number("delay")
                self.rest(line.when)
                self.struck(line.when, piece.servo_id, f"{delay * 1.0e3:.3f} ms late")
            later.append(Piece(piece.data, piece.when + delay, piece.servo_id))
        return later


class LateReply(PacketFault):
    """Replies come when nobody expects them any more."""

    def __init__(self, spec: FaultSpec, random: Random) -> None:
        super().__init__(spec, random)
        self._held: list[Piece] = []

    def outward(self, pieces: list[Piece], line: Line) -> list[Piece]:
        """Return the replies that come now: those held back, as soon as this request has left."""
        freed = [Piece(piece.data, line.end, piece.servo_id) for piece in self._held]
        self._held.clear()
        return freed + super().outward(pieces, line)

    def change(self, piece: Piece, _line: Line) -> list[Piece] | None:
        """Return the reply with its delay, or hold it until the next request."""
        delay = self.spec.optional("delay")
        if delay is not None:
            return [Piece(piece.data, piece.when + delay, piece.servo_id)]
        if len(self._held) >= _HELD_CAP:
            return None
        self._held.append(piece)
        return []

    def spent(self, when: float) -> bool:
        """Return whether it is over and holds nothing back any more."""
        return super().spent(when) and not self._held


_DELAY = Argument("delay", "how much later", 500.0e-6, "s", high=10.0)
_LATE = Argument(
    "delay", "how much later; where not given, just behind the next request", None, "s", high=60.0
)

KINDS = (
    FaultKind("lost-replies", (2, 9), "replies do not arrive", LostReply),
    FaultKind("duplicate-reply", (17,), "replies arrive twice", DuplicateReply),
    FaultKind(
        "lost-instructions",
        (9,),
        "requests to a servo, or to all, do not reach it",
        LostInstruction,
    ),
    FaultKind(
        "return-delay",
        (16,),
        "a servo answers later, and those behind it wait",
        ReturnDelay,
        (_DELAY,),
    ),
    FaultKind(
        "late-reply",
        (17,),
        "replies come after the next request, or after a delay",
        LateReply,
        (_LATE,),
    ),
)
