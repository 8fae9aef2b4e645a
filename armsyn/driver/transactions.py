"""Transactions with DYNAMIXEL servos on one serial bus, Protocol 2.0."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

from armsyn.driver import protocol
from armsyn.driver.bus import DEFAULT_MARGIN, BusPort
from armsyn.driver.parser import ParserCounters, StatusPacket, StatusParser
from armsyn.driver.registers import Register
from armsyn.driver.timing import STATUS_OVERHEAD, wire_time
from armsyn.errors import BusTimeoutError, ServoStatusError

UNKNOWN_RETURN_DELAY = 508e-6
"""Seconds: the greatest return delay time, assumed until it is read."""

QUIET = 1e-3
"""Seconds of silence after which no late reply is expected any more."""

LONGEST_DRAIN = 20e-3
"""Seconds after which draining ends even if the line never falls silent."""

_PING_SIZE = 3

_PING_SLOT = 3e-3
"""Seconds that the vendor's SDK gives each ID to answer a broadcast ping in its turn."""


@dataclass
class BusCounters:
    """What a bus has met so far.

    Attributes
    ----------
    transactions : int
        Requests that wait for replies.
    timeouts : int
        Those that lacked one at their deadline.
    unexpected : int
        Good packets of a servo, or of a size, that was not asked for.
    drained_bytes : int
        Late bytes thrown away after a time-out.
    """

    transactions: int = 0
    timeouts: int = 0
    unexpected: int = 0
    drained_bytes: int = 0


@dataclass
class _Pending:
    """Replies that are waited for."""

    ids: set[int]
    size: int | None
    replies: dict[int, StatusPacket] = field(default_factory=dict)

    def accept(self, packet: StatusPacket) -> bool:
        fits = self.size is None or len(packet.parameters) == self.size or packet.error_number
        if packet.servo_id not in self.ids or not fits:
            return False
        self.ids.discard(packet.servo_id)
        self.replies[packet.servo_id] = packet
        return True


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

    Raises
    ------
    PortError
        The port cannot be opened.
    """

    def __init__(self, path: str, baud: int, margin: float = DEFAULT_MARGIN) -> None:
        super().__init__(path, baud, margin)
        self.return_delays: dict[int, float] = {}
        self.counters = BusCounters()
        self._parser = StatusParser()
        self._late_replies_possible = False

    @property
    def parser_counters(self) -> ParserCounters:
        """What the parser has met so far."""
        return self._parser.counters

    def ping(self, servo_id: int, attempts: int = 3) -> tuple[int, int]:
        """Ask whether a servo is there.

        Parameters
        ----------
        servo_id : int
        attempts : int
            How often to ask before giving up.

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
        reply = self._ask(servo_id, protocol.ping(servo_id), _PING_SIZE, attempts)
        return int.from_bytes(reply.parameters[:2], "little"), reply.parameters[2]

    def broadcast_ping(self) -> dict[int, int]:
        """Ask all servos at once; takes the whole window in which 253 could answer.

        Returns
        -------
        dict of int to int
            ID to model number.
        """
        everyone = protocol.MAXIMUM_ID + 1
        answer = wire_time(STATUS_OVERHEAD + _PING_SIZE, self.baudrate) + UNKNOWN_RETURN_DELAY
        window = everyone * (answer + _PING_SLOT)
        self._send(protocol.ping(protocol.BROADCAST_ID), _PING_SIZE)
        pending = _Pending(set(range(everyone)), _PING_SIZE)
        self._collect(pending, self.serial_port.now() + window + self.margin)
        found = sorted(pending.replies.items())
        return {i: int.from_bytes(r.parameters[:2], "little") for i, r in found}

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
        request = protocol.read(servo_id, register.address, register.size)
        return register.decode(self._ask(servo_id, request, register.size, attempts).parameters)

    def write(self, servo_id: int, register: Register, value: int, attempts: int = 3) -> None:
        """Write a register and wait for the servo's word that it did; errors as `read`."""
        request = protocol.write(servo_id, register.address, register.encode(value))
        self._ask(servo_id, request, 0, attempts)

    def sync_write(self, register: Register, values: dict[int, int]) -> None:
        """Write one register of several servos; none of them answers.

        Parameters
        ----------
        register : Register
        values : dict of int to int
            ID to value, in the register's own unit.
        """
        data = b"".join(register.encode(value) for value in values.values())
        self._send(protocol.sync_write(register.address, register.size, list(values), data), 0)

    def sync_read(
        self,
        address: int,
        size: int,
        servo_ids: tuple[int, ...],
        *,
        before: bytes = b"",
        margin: float | None = None,
    ) -> dict[int, StatusPacket]:
        """Read the same bytes of several servos.

        Parameters
        ----------
        address, size : int
        servo_ids : tuple of int
        before : bytes
            Packets that nobody answers (a sync write), sent in the same breath.
        margin : float, optional
            Instead of the bus's own.

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
        request = before + _sync_read_request(address, size, servo_ids)
        self._send(request, size)
        back = len(servo_ids) * (STATUS_OVERHEAD + size)
        delay = sum(self.return_delays.get(i, UNKNOWN_RETURN_DELAY) for i in servo_ids)
        duration = wire_time(len(request) + back, self.baudrate) + delay
        pending = _Pending(set(servo_ids), size)
        allowed = self.margin if margin is None else margin
        self._collect(pending, self.serial_port.now() + duration + allowed)
        self.counters.timeouts += bool(pending.ids)
        return pending.replies

    def read_all(
        self, register: Register, servo_ids: tuple[int, ...], attempts: int = 3
    ) -> dict[int, int]:
        """One register of several servos, in the order of `servo_ids`; errors as `read`."""
        replies: dict[int, StatusPacket] = {}
        for _ in range(attempts):
            missing = tuple(i for i in servo_ids if i not in replies)
            if not missing:
                break
            replies |= self.sync_read(register.address, register.size, missing)
        if silent := tuple(i for i in servo_ids if i not in replies):
            raise self._silent(silent)
        for reply in replies.values():
            _check_status(reply, self.port_name)
        return {i: register.decode(replies[i].parameters) for i in servo_ids}

    def _ask(self, servo_id: int, request: bytes, size: int, attempts: int) -> StatusPacket:
        delay = self.return_delays.get(servo_id, UNKNOWN_RETURN_DELAY)
        duration = wire_time(len(request) + STATUS_OVERHEAD + size, self.baudrate) + delay
        for _ in range(attempts):
            self._send(request, size)
            pending = _Pending({servo_id}, size)
            self._collect(pending, self.serial_port.now() + duration + self.margin)
            if reply := pending.replies.get(servo_id):
                _check_status(reply, self.port_name)
                return reply
            self.counters.timeouts += 1
        raise self._silent((servo_id,))

    def _silent(self, servo_ids: tuple[int, ...]) -> BusTimeoutError:
        names = ", ".join(map(str, servo_ids))
        return BusTimeoutError(
            f"no answer from servo {names} on {self.port_name} at {self.baudrate} baud:"
            " check power, cable, ID and baud rate",
            servo_ids,
        )

    def _send(self, request: bytes, size: int) -> None:
        """Send a request whose replies hold `size` bytes, on a line without late replies."""
        if self._late_replies_possible:
            self._drain()
        # instruction, error, CRC, the data, and what stuffing may add to them
        self._parser.maximum_length = 4 + size + (size + 4) // 3
        self.serial_port.write(request)

    def _collect(self, pending: _Pending, deadline: float) -> None:
        """Gather replies until all are there or `deadline` has passed."""
        self.counters.transactions += 1
        read, feed = self.serial_port.read, self._parser.feed
        while pending.ids:
            data = read(deadline)
            if not data:
                self._late_replies_possible = True
                return
            for packet in feed(data):
                if not pending.accept(packet):
                    self.counters.unexpected += 1

    def _drain(self) -> None:
        end = self.serial_port.now() + LONGEST_DRAIN
        while data := self.serial_port.read(min(end, self.serial_port.now() + QUIET)):
            self.counters.drained_bytes += len(data)
            if self.serial_port.now() > end:
                break
        self._parser.reset()
        self._late_replies_possible = False


@lru_cache(maxsize=256)
def _sync_read_request(address: int, size: int, servo_ids: tuple[int, ...]) -> bytes:
    return protocol.sync_read(address, size, servo_ids)


def _check_status(reply: StatusPacket, port: str) -> None:
    if number := reply.error_number:
        name = protocol.STATUS_ERRORS.get(number, f"error {number}")
        raise ServoStatusError(
            f"servo {reply.servo_id} on {port} refused a request: {name}", reply.servo_id, number
        )
