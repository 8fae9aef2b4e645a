"""Readings of all servos, sent to the process that draws them (`live_table`)."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress

from firmware_sim.command.readings import Reader
from firmware_sim.firmware.servo import Servo

PERIOD = 0.25
"""How often the table is drawn anew, s."""

_AT_ONCE = 8
"""Servos read in one piece of work: about a fifth of a millisecond."""

_END_PATIENCE = 2.0


class TableFeed:
    """Sends readings a few times a second: a `server.Chore`.

    Parameters
    ----------
    servos : sequence of Servo
        Whom the table shows.
    title : callable
        Returns the text above the table: the port, which may change.
    packets : callable
        Returns how many packets a servo's ID has been in since the start.
    faults : callable
        Returns the names of the faults in force for a servo's ID.
    note : callable
        Returns the text below the table, empty for none.
    """

    def __init__(
        self,
        servos: Sequence[Servo],
        title: Callable[[], str],
        packets: Callable[[int], int],
        faults: Callable[[int], Sequence[str]],
        note: Callable[[], str],
    ) -> None:
        self._readers = [(servo, Reader(servo)) for servo in servos]
        self._title, self._packets, self._faults, self._note = title, packets, faults, note
        self._rows: list[list[str]] = []
        self._counts: dict[int, int] = {}
        self._unsent = b""
        self._since = 0.0
        self.next_due = 0.0
        self._painter: subprocess.Popen[bytes] | None = subprocess.Popen(
            [sys.executable, "-m", "firmware_sim.command.live_table"], stdin=subprocess.PIPE
        )
        assert self._painter.stdin is not None  # noqa: S101 - a pipe
        os.set_blocking(self._painter.stdin.fileno(), False)

    def work(self, now: float) -> None:
        """Read some servos; after the last, send all and rest."""
        begin = len(self._rows)
        duration = max(now - self._since, 1e-3)
        for servo, reader in self._readers[begin : begin + _AT_ONCE]:
            self._rows.append(self._row(servo, reader, duration))
        if len(self._rows) == len(self._readers):
            self._send()
            self._counts = {
                servo.servo_id: self._packets(servo.servo_id) for servo, _ in self._readers
            }
            self._rows, self._since = [], now
            if self._painter is not None:
                self.next_due = now + PERIOD

    def close(self) -> None:
        """Leave the last table standing and end the process that drew it; may be called twice."""
        painter, self._painter = self._painter, None
        self.next_due = float("inf")
        if painter is None:
            return
        with suppress(OSError):  # a pipe that has broken need not be flushed
            if painter.stdin is not None:
                painter.stdin.close()
        try:
            painter.wait(_END_PATIENCE)
        except subprocess.TimeoutExpired:
            painter.kill()
            painter.wait()

    def _row(self, servo: Servo, reader: Reader, duration: float) -> list[str]:
        servo_id = servo.servo_id
        count = self._packets(servo_id)
        rate = (count - self._counts.get(servo_id, count)) / duration
        return [*reader.take(), f"{rate:.0f}", ", ".join(self._faults(servo_id))]

    def _send(self) -> None:
        """Send all rows, unless the painter is behind: then it gets the next ones."""
        if self._painter is None or self._painter.stdin is None:
            return
        if not self._unsent:
            document = {"title": self._title(), "rows": self._rows, "note": self._note()}
            self._unsent = json.dumps(document).encode() + b"\n"
        try:
            written = os.write(self._painter.stdin.fileno(), self._unsent)
        except BlockingIOError:
            return
        except OSError:  # it has ended, for instance because rich is not installed
            self.close()
            return
        self._unsent = self._unsent[written:]
