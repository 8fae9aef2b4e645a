"""Exchanges with servos of both protocols on one serial bus: requests out, replies back.

One lock makes an exchange whole, so that several threads can share a bus. A reply is matched by
its servo, its size and, where the packet says so, its protocol; after a time-out the line is left
to fall silent before the next request, so that a late reply answers nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from threading import RLock

from armsyn.driver.budget import ErrorBudget
from armsyn.driver.bus import DEFAULT_MARGIN, BusPort
from armsyn.driver.collecting import BusCounters
from armsyn.driver.line import Line
from armsyn.driver.parser import ParserCounters, StatusPacket
from armsyn.driver.plans import ReadPlan
from armsyn.driver.requests import Request
from armsyn.errors import BusBudgetError, BusTimeoutError, ServoStatusError

LEAST_MARGIN = 10e-3
"""Seconds, beyond twice the adapter's latency, for which an answer is waited for even where others
of the same cycle have used up the margin: a host is that late without being late for long."""

_MISHEARD = {1: 0x10, 2: 3}
"""By protocol, what a servo answers to a request that noise has struck: checksum or CRC error."""


class ExchangeBus(BusPort):
    """A serial port on which requests are exchanged for replies.

    Parameters
    ----------
    path : str
        Of the port.
    baud : int
        Bits a second.
    margin : float
        Seconds that a reply may come after its time on the wire.

    Attributes
    ----------
    protocols : dict of int to {1, 2}
        Which protocol a servo speaks; 2 where it is not said.
    return_delays : dict of int to float
        Return delay time of each servo, s; the greatest there is where it is not said.
    budget : ErrorBudget
        Repetitions that are left.
    late : float
        Seconds that the last `exchange` waited beyond the time on the wire.

    Raises
    ------
    PortError
        The port cannot be opened.
    """

    def __init__(self, path: str, baud: int, margin: float = DEFAULT_MARGIN) -> None:
        self.protocols: dict[int, int] = {}
        self.return_delays: dict[int, float] = {}
        self.budget = ErrorBudget()
        self.late = 0.0
        self._line = Line()
        self._lock = RLock()
        super().__init__(path, baud, margin)
        self._line.latency = self.latency

    @property
    def counters(self) -> BusCounters:
        """What the bus has met so far."""
        return self._line.counters

    @property
    def parser_counters(self) -> ParserCounters:
        """What its parsers have met so far."""
        return self._line.parser_counters

    @property
    def foreign_traffic(self) -> int:
        """Packets of another master that were heard so far (protocol 2.0)."""
        return self.parser_counters.foreign

    def reopen(self) -> None:
        """Open the port again after it was lost or closed; PortError when it cannot be.

        Nothing is sent, and nothing that was under way goes on.
        """
        with self._lock:
            self.close()
            self._line.reset()
            self.openPort()
            self._line.latency = self.latency

    def send(self, packets: bytes) -> None:
        """Send packets that nobody answers; PortLostError when the port went away."""
        with self._lock:
            self._line.send(self.serial_port, packets)

    def exchange(
        self, before: bytes, reads: Iterable[ReadPlan], margin: float | None = None
    ) -> dict[int, StatusPacket]:
        """One cycle: packets that nobody answers, then reads.

        Parameters
        ----------
        before : bytes
            Packets, such as sync writes; sent in the same breath as the first read.
        reads : iterable of ReadPlan
            Of different servos.
        margin : float, optional
            Seconds that all replies together may come after their time on the wire, so that
            several silent servos do not hold up a cycle for longer than one (but for
            `LEAST_MARGIN` each); without it each may be late by the bus's own.

        Returns
        -------
        dict of int to StatusPacket
            One for each servo that answered in time, alert or not; who is missing is not in it.
            A reply with an error number may hold no parameters.

        Raises
        ------
        PortLostError
            The port went away.
        """
        replies: dict[int, StatusPacket] = {}
        left = margin
        with self._lock:
            self.late = 0.0
            for plan in reads:
                for request in plan.requests:
                    replies |= self._run(request, before, left)
                    before = b""
                    self.late += self._line.late
                    if margin is not None:
                        left = self.margin_left(margin)
            if before:
                self._line.send(self.serial_port, before)
        return replies

    def margin_left(self, margin: float) -> float:
        """What the last `exchange` has left of a margin; `LEAST_MARGIN` of it at least, s."""
        return max(margin - self.late, min(margin, LEAST_MARGIN + 2.0 * self.latency))

    def _protocol(self, servo_id: int) -> int:
        return self.protocols.get(servo_id, 2)

    def _ask(self, request: Request, attempts: int) -> StatusPacket:
        """Ask one servo until it answers."""
        (servo_id,) = request.sizes
        for attempt in range(attempts):
            if attempt:
                self._spend([servo_id])
            if replies := heard(self._run(request)):
                self._check(replies.values())
                return replies[servo_id]
        raise self._silent((servo_id,))

    def _spend(self, servo_ids: Iterable[int]) -> None:
        """Take one repetition out of the budget."""
        if not self.budget.take(self.serial_port.now()):
            ids = tuple(servo_ids)
            raise BusBudgetError(
                f"{self._silent(ids)}; {self.budget.spent} answers had to be asked for again"
                " already: the bus is not fit for use",
                ids,
            )

    def _silent(self, servo_ids: tuple[int, ...]) -> BusTimeoutError:
        names = ", ".join(map(str, servo_ids))
        return BusTimeoutError(
            f"no answer from servo {names} on {self.port_name} at {self.baudrate} baud:"
            " check power, cable, ID and baud rate",
            servo_ids,
        )

    def _check(self, replies: Iterable[StatusPacket]) -> None:
        for reply in replies:
            if reply.error_number:
                raise ServoStatusError(
                    f"servo {reply.servo_id} on {self.port_name} refused a request:"
                    f" {reply.error_name}",
                    reply.servo_id,
                    reply.error_number,
                )

    def _run(
        self, request: Request, before: bytes = b"", margin: float | None = None
    ) -> dict[int, StatusPacket]:
        """Carry out one request, after packets that nobody answers."""
        duration = partial(request.duration, len(before), self.baudrate, self.return_delays)
        allowed = self.margin if margin is None else margin
        with self._lock:
            return self._line.exchange(self.serial_port, request, before, duration, allowed)


def heard(replies: Mapping[int, StatusPacket]) -> dict[int, StatusPacket]:
    """Answers without those that only say that a request came damaged: they count as none."""
    return {i: reply for i, reply in replies.items() if not _misheard(reply)}


def _misheard(reply: StatusPacket) -> bool:
    error, code = reply.error_number, _MISHEARD[reply.protocol]
    return bool(error & code) if reply.protocol == 1 else error == code
