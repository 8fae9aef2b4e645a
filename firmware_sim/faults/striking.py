"""The two ways in which faults strike: at packets, and at times."""

from __future__ import annotations

from random import Random

from firmware_sim.errors import FaultError
from firmware_sim.faults.fault import Fault, Line, Piece
from firmware_sim.faults.spec import FaultSpec
from firmware_sim.wire.packet import BROADCAST_ID


class PacketFault(Fault):
    """Strikes packets one at a time, while its window is open.

    Each packet that it may strike (``id``, ``every``, ``count``) it strikes with its
    ``probability``.
    """

    def __init__(self, spec: FaultSpec, random: Random) -> None:
        super().__init__(spec, random)
        self._ready = 0.0
        if "to" in spec.kind.all_arguments:
            self.wants_requests = spec.choice("to") == "servos"

    def inward(self, pieces: list[Piece], line: Line) -> list[Piece]:
        """Return the requests, changed where it strikes."""
        return self._each(pieces, line) if self.wants_requests else pieces

    def outward(self, pieces: list[Piece], line: Line) -> list[Piece]:
        """Return the replies, changed where it strikes."""
        return pieces if self.wants_requests else self._each(pieces, line)

    def change(self, piece: Piece, _line: Line) -> list[Piece] | None:
        """Return what becomes of a packet it strikes; None if it cannot do anything to it."""
        return [piece]

    def _each(self, pieces: list[Piece], line: Line) -> list[Piece]:
        changed: list[Piece] = []
        for piece in pieces:
            hit = self.change(piece, line) if self.may_strike(piece, line.when) else None
            if hit is None:
                changed.append(piece)
                continue
            changed += hit
            self.rest(line.when)
            self.struck(line.when, self._victim(piece), _difference(piece, hit))
        return changed

    def _victim(self, piece: Piece) -> int | None:
        """Whom a strike is said to have hit; nobody in particular by a packet to all."""
        if self.spec.servo_id is not None:
            return self.spec.servo_id
        return None if piece.servo_id == BROADCAST_ID else piece.servo_id

    def rest(self, when: float) -> None:
        """Strike not again before ``every`` is over."""
        self._ready = when + (self.spec.optional("every") or 0.0)

    def may_strike(self, piece: Piece, when: float) -> bool:
        """Return whether it strikes a packet now, by chance where that is asked for."""
        if when < max(self.begin, self._ready) or self.spent(when):
            return False
        if self.spec.servo_id is not None and self.spec.servo_id != piece.servo_id:
            return False
        return self.happens()


def _difference(piece: Piece, hit: list[Piece]) -> str:
    """Say what became of a packet."""
    data = b"".join(other.data for other in hit)
    if data == piece.data:
        if hit and hit[0].when != piece.when:
            return f"{(hit[0].when - piece.when) * 1.0e3:.3f} ms late"
        return f"{len(data)} bytes"
    if len(data) != len(piece.data):
        return f"{len(piece.data)} bytes became {len(data)}"
    places = [i for i, (old, new) in enumerate(zip(piece.data, data, strict=True)) if old != new]
    return f"bytes {', '.join(map(str, places[:8]))} of {len(data)} changed"


class EventFault(Fault):
    """Strikes at a time, and again ``every`` so often until its window closes."""

    def check(self) -> None:
        """See that the servo is there, and begin."""
        super().check()
        self.wakes = self.begin

    def wake(self, when: float) -> None:
        """Strike, by chance where that is asked for, and see to the next time."""
        if self.happens():
            self.strike(when)
        every = self.spec.optional("every")
        self.wakes = None if every is None else when + every

    def strike(self, when: float) -> None:
        """Do it."""
        raise NotImplementedError

    def spent(self, when: float) -> bool:
        """Return whether it will not strike again."""
        return self.wakes is None or super().spent(self.wakes) or super().spent(when)


class StateFault(Fault):
    """Puts something into another state for a time, and back again.

    ``for`` is how long that lasts; ``every``, from one beginning to the next.
    """

    def __init__(self, spec: FaultSpec, random: Random) -> None:
        super().__init__(spec, random)
        self.on = False
        self._next_begin = 0.0

    def check(self) -> None:
        """See that the servo is there and the times fit, and begin."""
        super().check()
        every, duration = self.spec.optional("every"), self.duration
        if every is not None and (duration is None or duration >= every):
            raise FaultError(f"{self.spec.kind.name}: every={every:g} needs a shorter for=...")
        self.wakes = self.begin

    @property
    def end(self) -> float | None:
        """None: each occurrence ends by itself."""
        return None

    @property
    def duration(self) -> float | None:
        """How long each occurrence lasts, s; None for without end."""
        return self.spec.optional("for")

    def wake(self, when: float) -> None:
        """Begin or end."""
        if self.on:
            self._leave(when)
            self.wakes = self._following()
            return
        every, duration = self.spec.optional("every"), self.duration
        self._next_begin = when + (every or 0.0)
        if not self.happens():
            self.wakes = self._following()
            return
        self.on = True
        self.struck(when, self.spec.servo_id, "begins")
        self.enter(when)
        self.wakes = None if duration is None else when + duration

    def _following(self) -> float | None:
        return None if self.spec.optional("every") is None else self._next_begin

    def _leave(self, when: float) -> None:
        self.on = False
        self.leave(when)
        self.log(self, when, self.spec.servo_id, "ends", ends=True)

    def spent(self, _when: float) -> bool:
        """Return whether it is over and does not come again."""
        return not self.on and (self.wakes is None or self.exhausted)

    def stop(self, when: float) -> None:
        """End it now."""
        self.wakes = None
        if self.on:
            self._leave(when)

    def enter(self, when: float) -> None:
        """Put the state in force."""

    def leave(self, when: float) -> None:
        """Put back what was before."""
