"""Transactions with DYNAMIXEL servos of both protocols on one serial bus.

One lock makes a transaction whole, so that several threads can share a bus. A reply is matched by
its servo, its size and, where the packet says so, its protocol; after a time-out the line is left
to fall silent before the next request, so that a late reply answers nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from threading import RLock

from armsyn.driver.budget import ErrorBudget
from armsyn.driver.bus import DEFAULT_MARGIN, BusPort
from armsyn.driver.collecting import BusCounters
from armsyn.driver.line import Line
from armsyn.driver.parser import ParserCounters, StatusPacket
from armsyn.driver.plans import Kind, ReadPlan
from armsyn.driver.protocol import BROADCAST_ID
from armsyn.driver.protocol1 import MAXIMUM_ID as LAST_ID_1
from armsyn.driver.registers import Register
from armsyn.driver.requests import (
    Request,
    codec,
    ping_request,
    read_request,
    reboot_request,
    write_request,
)
from armsyn.errors import BusBudgetError, BusError, BusTimeoutError, ServoStatusError

PING_SLOT = 3e-3
"""Seconds that the vendor's SDK gives each ID to answer a broadcast ping in its turn."""

_PING_SIZE = 3
_SCAN_MARGIN = 3e-3
_FIRST_X_NUMBER = 1000


class Bus(BusPort):
    """A bus of servos behind a serial port.

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

    Raises
    ------
    PortError
        The port cannot be opened.
    """

    def __init__(self, path: str, baud: int, margin: float = DEFAULT_MARGIN) -> None:
        self.protocols: dict[int, int] = {}
        self.return_delays: dict[int, float] = {}
        self.budget = ErrorBudget()
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

    def ping(
        self, servo_id: int, attempts: int = 3, protocol: int | None = None
    ) -> tuple[int, int]:
        """Ask whether a servo is there.

        Parameters
        ----------
        servo_id : int
        attempts : int
            How often to ask before giving up.
        protocol : {1, 2}, optional
            By default the servo's own. A servo of protocol 1.0 is asked for its registers, for
            its answer to a ping says nothing.

        Returns
        -------
        model_number, firmware_version : int

        Raises
        ------
        BusTimeoutError
            No answer.
        PortLostError
            The port went away.
        """
        if (protocol or self._protocol(servo_id)) == 2:
            data = self._ask(ping_request(servo_id, _PING_SIZE), attempts).parameters
            return int.from_bytes(data[:2], "little"), data[2]
        data = self._ask(read_request(1, servo_id, 0, _PING_SIZE), attempts).parameters
        number = int.from_bytes(data[:2], "little")
        if number >= _FIRST_X_NUMBER:  # set to speak 1.0, with its own table
            data = self._ask(read_request(1, servo_id, 6, 1), attempts).parameters
        return number, data[-1]

    def broadcast_ping(self, protocol: int = 2) -> dict[int, int]:
        """Ask all servos of a protocol; takes the whole window in which they could answer.

        Servos of protocol 1.0 would answer all at once: every ID is asked by itself.

        Returns
        -------
        dict of int to int
            ID to model number.
        """
        if protocol == 1:
            return self._ping_each()
        request = ping_request(BROADCAST_ID, _PING_SIZE)
        replies = self._run(request, b"", self.margin + len(request.sizes) * PING_SLOT)
        found = sorted(replies.items())
        return {i: int.from_bytes(r.parameters[:2], "little") for i, r in found}

    def _ping_each(self) -> dict[int, int]:
        found = {}
        for servo_id in range(LAST_ID_1 + 1):
            request = read_request(1, servo_id, 0, 2)
            replies = self._run(request, b"", _SCAN_MARGIN + 2.0 * self.latency)
            if replies and replies[servo_id].parameters:
                found[servo_id] = int.from_bytes(replies[servo_id].parameters, "little")
        return found

    def read(self, servo_id: int, register: Register, attempts: int = 3) -> int:
        """Value of a register, in its own unit.

        Raises
        ------
        BusTimeoutError
            No answer.
        ServoStatusError
            The servo refused.
        PortLostError
            The port went away.
        """
        number = self._protocol(servo_id)
        request = read_request(number, servo_id, register.address, register.size)
        return register.decode(self._ask(request, attempts).parameters)

    def write(self, servo_id: int, register: Register, value: int, attempts: int = 3) -> None:
        """Write a register and wait for the servo's word that it did; errors as `read`."""
        data = register.encode(value)
        request = write_request(self._protocol(servo_id), servo_id, register.address, data)
        self._ask(request, attempts)

    def reboot(self, servo_id: int) -> None:
        """Let a servo start anew; it is deaf for a while then, and its RAM is as at power-on.

        The servo's word is waited for, but need not come: low Status Return Levels forbid it.

        Raises
        ------
        BusError
            The servo speaks protocol 1.0, which has no such instruction, or refuses.
        PortLostError
            The port went away.
        """
        if self._protocol(servo_id) == 1:
            raise BusError(
                f"servo {servo_id} on {self.port_name} speaks protocol 1.0, which cannot reboot:"
                " switch its power off and on"
            )
        replies = self._run(reboot_request(servo_id))
        self._check(replies.values())

    def sync_write(self, register: Register, values: dict[int, int]) -> None:
        """Write one register of several servos; none of them answers.

        Parameters
        ----------
        register : Register
        values : dict of int to int
            ID to value, in the register's own unit.
        """
        data = b""
        for number in (2, 1):
            ids = [i for i in values if self._protocol(i) == number]
            if ids:
                payload = b"".join(register.encode(values[i]) for i in ids)
                data += codec(number).sync_write(register.address, register.size, ids, payload)
        self.send(data)

    def send(self, packets: bytes) -> None:
        """Send packets that nobody answers; PortLostError when the port went away."""
        with self._lock:
            self.serial_port.write(packets)

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
            Seconds that a reply may come after its time on the wire, instead of the bus's own.

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
        with self._lock:
            for plan in reads:
                for request in plan.requests:
                    replies |= self._run(request, before, margin)
                    before = b""
            if before:
                self.serial_port.write(before)
        return replies

    def read_all(
        self, register: Register, servo_ids: tuple[int, ...], attempts: int = 3
    ) -> dict[int, int]:
        """One register of several servos, in the order of `servo_ids`; errors as `read`.

        Who did not answer is asked again by itself: a silent servo keeps those waiting that are
        to answer after it.
        """
        replies = self.exchange(b"", self._plans(register, servo_ids, "sync"))
        for _ in range(attempts - 1):
            missing = tuple(i for i in servo_ids if i not in replies)
            if not missing:
                break
            self._spend(missing)
            replies |= self.exchange(b"", self._plans(register, missing, "single"))
        if silent := tuple(i for i in servo_ids if i not in replies):
            raise self._silent(silent)
        self._check(replies.values())
        return {i: register.decode(replies[i].parameters) for i in servo_ids}

    def _plans(self, register: Register, servo_ids: tuple[int, ...], kind: Kind) -> list[ReadPlan]:
        both = {n: tuple(i for i in servo_ids if self._protocol(i) == n) for n in (2, 1)}
        address, size = register.address, register.size
        return [
            ReadPlan(kind if number == 2 else "single", number, address, size, ids)
            for number, ids in both.items()
            if ids
        ]

    def _protocol(self, servo_id: int) -> int:
        return self.protocols.get(servo_id, 2)

    def _ask(self, request: Request, attempts: int) -> StatusPacket:
        """Ask one servo until it answers."""
        (servo_id,) = request.sizes
        for attempt in range(attempts):
            if attempt:
                self._spend([servo_id])
            if replies := self._run(request):
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
