"""A packet trace for people: what the client sent, what the servos heard and said, what struck.

While the wire is busy only references are kept; lines are made of them while it is idle, and
written by a thread. See `trace_text` for the lines.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from firmware_sim.faults.roster import Strike
from firmware_sim.faults.spec import FaultSpec
from firmware_sim.simulation import Simulation
from firmware_sim.trace.file import TraceFile
from firmware_sim.trace.text import Narrator
from firmware_sim.wire.bus import GAP_TIME, Bus, Transmission
from firmware_sim.wire.observed import Heard, Said
from firmware_sim.wire.parser import DamagedPacket

RECORD_CAP = 50_000
"""Most things kept until there is time to make lines of them: several seconds of a full bus."""

_HEADER = b"\xff\xff\xfd\x00"
_LACKS_STUFFING = "a header within it: stuffing missing?"
_HEAD_SIZE = 8  # bytes of a frame of protocol 2.0 before its parameters

_PIECE = 200.0e-6  # s of work at a time
_SPOKEN_CAP = 1000
"""Answers kept to compare with what the client gets; a broadcast has at most 253."""

_EXCHANGE_CAP = 1000
"""Lines of one exchange that are put in order."""

_PENDING_CAP = 8192  # bytes of the client kept to find those that were in no frame


@dataclass(frozen=True, slots=True)
class _Sent:
    """What the client sent, at a rate in bit/s, beginning at a time in s."""

    when: float
    baud_rate: float
    data: bytes


@dataclass(frozen=True, slots=True)
class _Got:
    """What is to reach the client."""

    transmissions: Sequence[Transmission]


@dataclass(frozen=True, slots=True)
class _Struck:
    """A fault struck."""

    strike: Strike


_Record = _Sent | _Got | _Struck | Heard | Said


class Trace:
    """Keeps what happens on a bus and makes lines of it: a `server.Chore`.

    Parameters
    ----------
    file : TraceFile
        Where the lines go, once it is open.
    bus : Bus
        Whose packets are traced, from now on.
    start : float
        The time that lines count from, s.
    """

    def __init__(self, file: TraceFile, bus: Bus, start: float) -> None:
        self.file = file
        self.lost_records = 0
        """What came while too much was waiting already."""
        self._records: deque[_Record] = deque()
        self._narrator = Narrator(bus.servos, start)
        self._sent_at = start
        self._baud_rate = 0.0
        self._pending = b""  # what the client sent and was in no frame yet
        self._spoken: list[bytes] = []  # what the servos said since the client sent something
        self._exchange: list[str] = []  # lines since the client got something
        self._lost_said = 0
        bus.observers.append(self.note)
        names = ", ".join(f"{servo.model.name}:{servo.servo_id}" for servo in bus.servos)
        file.write(f"# firmware-sim, {time.strftime('%Y-%m-%d %H:%M:%S')}: {names}\n")

    @property
    def problem(self) -> str:
        """What is wrong with it, in a line; empty for nothing."""
        if self.file.problem or not (self.lost_records or self.file.lost_lines):
            return self.file.problem
        return f"packets are missing in {self.file.path}"

    @property
    def next_due(self) -> float:
        """When there is something to do, s."""
        return 0.0 if self._records else float("inf")

    def note(self, record: _Record) -> None:
        """Keep something that happened."""
        if len(self._records) >= RECORD_CAP:
            self.lost_records += 1
        else:
            self._records.append(record)

    def struck(self, strike: Strike) -> None:
        """Keep a fault's strike: the `report` of a simulation."""
        self.note(_Struck(strike))

    def sent(self, chunk: bytes, when: float, baud_rate: float) -> None:
        """Keep what the client sent."""
        self.note(_Sent(when, baud_rate, chunk))

    def got(self, transmissions: Sequence[Transmission]) -> None:
        """Keep what is to reach the client."""
        self.note(_Got(tuple(transmissions)))

    def work(self, now: float) -> None:
        """Make lines for a fraction of a millisecond; `now` is on the monotonic clock, s."""
        end = now + _PIECE
        lines = []
        while self._records and time.monotonic() < end:
            lines += self._in_order(self._records.popleft())
        if not self._records:
            lines += sorted(self._exchange, key=_time_of)
            self._exchange = []
        if self.lost_records > self._lost_said:
            lines.append(f"# {self.lost_records - self._lost_said} packets are missing here\n")
            self._lost_said = self.lost_records
        if lines:
            self.file.write("".join(lines))

    def close(self) -> None:
        """Make the last lines and close the file."""
        while self._records:
            self.work(time.monotonic())
        if self._pending:
            self.file.write("".join(self._no_frame(self._pending)))
        self.file.close()

    def _in_order(self, record: _Record) -> list[str]:
        """Return the lines of an exchange, in order of their times, once it is over."""
        self._exchange += self._lines_of(record)
        if not isinstance(record, _Got) and len(self._exchange) < _EXCHANGE_CAP:
            return []
        done, self._exchange = self._exchange, []
        return sorted(done, key=_time_of)

    def _lines_of(self, record: _Record) -> list[str]:
        if isinstance(record, Heard):
            lines = [*self._unused(record), self._narrator.heard(record)]
            if isinstance(record.packet, DamagedPacket) and _lacks_stuffing(record.data):
                lines.append(self._narrator.line(record.when, "??", _LACKS_STUFFING))
            return lines
        if isinstance(record, Said):
            self._spoken.append(record.data)
            del self._spoken[:-_SPOKEN_CAP]
            return [self._narrator.said(record)]
        if isinstance(record, _Sent):
            return self._take(record)
        if isinstance(record, _Struck):
            return [f"{record.strike.time:14.6f} ** {strike_words(record.strike)}\n"]
        return self._changed(record)

    def _take(self, sent: _Sent) -> list[str]:
        """Take what the client sent; what no frame had in it until now is as good as lost."""
        lines = []
        if self._pending and sent.when - self._sent_at > GAP_TIME:
            lines = self._no_frame(self._pending)
            self._pending = b""
        self._pending = (self._pending + sent.data)[-_PENDING_CAP:]
        self._sent_at, self._baud_rate = sent.when, sent.baud_rate
        return lines

    def _unused(self, heard: Heard) -> list[str]:
        """Return a line for bytes before a frame that were in none."""
        before, frame, after = self._pending.partition(heard.data)
        if not frame:  # changed on its way, or within one that was shown already
            return []
        self._pending = after
        return self._no_frame(before) if before else []

    def _no_frame(self, data: bytes) -> list[str]:
        words = f"{len(data)} bytes in no frame, at {self._baud_rate:.0f} bit/s"
        if _lacks_stuffing(data):
            words += f"; {_LACKS_STUFFING}"
        return [self._narrator.line(self._sent_at, "??", words, data)]

    def _changed(self, got: _Got) -> list[str]:
        """Return lines for what reaches the client otherwise than the servos said it."""
        said, self._spoken = self._spoken, []
        kept = b"".join(said) == b"".join(sent.data for sent in got.transmissions)
        if kept:
            return []
        lines = []
        for sent in got.transmissions:
            if sent.data not in said:
                words = f"the client gets {len(sent.data)} bytes"
                lines.append(self._narrator.line(sent.due, "!!", words, sent.data))
        return lines


class TracedSimulation(Simulation):
    """A simulation whose trace is kept.

    Parameters
    ----------
    bus, start, faults, seed
        See `Simulation`.
    path : Path
        The trace's file, which is not touched before ``trace.file.open()``.
    """

    def __init__(
        self, bus: Bus, start: float, faults: Sequence[FaultSpec], seed: int, path: Path
    ) -> None:
        self.trace = Trace(TraceFile(path), bus, start)
        super().__init__(bus, start, faults=faults, seed=seed, report=self.trace.struck)

    def advance(self, when: float) -> list[Transmission]:
        """Bring everything to a time, s; return what left without a request of the client."""
        sent = super().advance(when)
        if sent or self.unplugged:  # what servos say into a port that is gone gets nowhere
            self.trace.got(sent)
        return sent

    def receive(self, chunk: bytes, when: float, baud_rate: float) -> list[Transmission]:
        """Take bytes from the client; return what comes back."""
        self.trace.sent(chunk, when, baud_rate)
        answers = super().receive(chunk, when, baud_rate)
        self.trace.got(answers)
        return answers


def _lacks_stuffing(data: bytes) -> bool:
    """Return whether bytes begin as a frame of protocol 2.0 and have a header further on."""
    return data.startswith(_HEADER) and _HEADER[:3] in data[_HEAD_SIZE:]


def _time_of(line: str) -> float:
    return float(line.split(maxsplit=1)[0])


def strike_words(strike: Strike) -> str:
    """Return what a fault did, without the time."""
    servo = "" if strike.servo_id is None else f" at servo {strike.servo_id}"
    detail = f": {strike.detail}" if strike.detail else ""
    if strike.ends:
        return f"tick {strike.tick}: fault {strike.number} {strike.name} ends{servo}"
    return f"tick {strike.tick}: fault {strike.number} {strike.name} strikes{servo}{detail}"
