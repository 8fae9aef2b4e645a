"""Asking IDs that need not be there, at a pace that only the wire sets."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from types import ModuleType

from armsyn.driver import protocol, protocol1
from armsyn.driver.parser import StatusPacket, StatusParser
from armsyn.driver.parser1 import StatusParser1
from armsyn.driver.timing import wire_time
from armsyn.driver.transactions import Bus

SLACK = 2e-3
"""Seconds for which an ID is waited for beyond its time on the wire: a USB adapter sends what it
is given up to a millisecond later, and nobody may talk into an answer."""

LATEST = 34e-3
"""Seconds that the last answer may be late: what a slow adapter keeps to itself, twice."""

_LONGEST_RETURN_DELAY = 508e-6
_UNANSWERABLE = protocol.packet(protocol.MAXIMUM_ID, protocol.STATUS, b"\0")
"""A status packet, which no servo answers: who gives it back is the adapter."""

_STATUS_BYTES = {1: 6, 2: 11}
_PING_BYTES = {1: 0, 2: 3}


@dataclass(frozen=True)
class Answer:
    """What came back while an ID was asked.

    Attributes
    ----------
    packets : tuple of StatusPacket
    garbled : bool
        Bytes came, and no packet was among them.
    """

    packets: tuple[StatusPacket, ...]
    garbled: bool


class Probe:
    """Asks servos of one protocol at a bus's present baud rate.

    Parameters
    ----------
    bus : Bus
        Used by nobody else meanwhile.
    number : {1, 2}
        The protocol.

    Raises
    ------
    PortLostError
        From all methods: the port went away.
    """

    def __init__(self, bus: Bus, number: int) -> None:
        self.protocol = number
        self._port = bus.serial_port
        self._baud = bus.baudrate
        self._latest = max(LATEST, 2.0 * bus.latency)
        self._codec: ModuleType = protocol if number == 2 else protocol1
        self._parser: StatusParser | StatusParser1
        self._parser = StatusParser(64) if number == 2 else StatusParser1()
        while self._port.read(self._port.now()):  # what came before is nobody's answer
            pass
        self._echoes = self._hears_itself()

    def ping_each(self, ids: Iterable[int]) -> tuple[set[int], set[int]]:
        """Ask IDs one after the other.

        Returns
        -------
        answered : set of int
        garbled : set of int
            While they were asked, bytes came that are no packet.
        """
        answered, garbled = set(), set()
        for servo_id in ids:
            answer = self._ask(self._codec.ping(servo_id), _PING_BYTES[self.protocol])
            answered |= {packet.servo_id for packet in answer.packets}
            if answer.garbled:
                garbled.add(servo_id)
        late = self._parser.feed(self._listen(self._latest))
        return answered | {packet.servo_id for packet in late}, garbled

    @property
    def latest_ids(self) -> int:
        """How many IDs further `ping_each` may be when a late answer comes."""
        size = len(self._codec.ping(0)) + _STATUS_BYTES[self.protocol] + _PING_BYTES[self.protocol]
        return math.ceil(self._latest / (wire_time(size, self._baud) + SLACK))

    def ping(self, servo_id: int) -> Answer:
        """Ask one ID, with the patience that a slow adapter needs."""
        request = self._codec.ping(servo_id)
        return self._patiently(request, _PING_BYTES[self.protocol], servo_id)

    def read(self, servo_id: int, address: int, size: int) -> Answer:
        """Ask one servo for bytes, as `ping`."""
        return self._patiently(self._codec.read(servo_id, address, size), size, servo_id)

    def _patiently(self, request: bytes, size: int, servo_id: int) -> Answer:
        answer = self._ask(request, size)
        late = b"" if answer.packets else self._listen(self._latest)
        packets = (*answer.packets, *self._parser.feed(late))
        own = tuple(packet for packet in packets if packet.servo_id == servo_id)
        self._parser.reset()
        return Answer(own, not own and (answer.garbled or bool(late)))

    def _ask(self, request: bytes, size: int) -> Answer:
        self._port.write(request)
        answer = _STATUS_BYTES[self.protocol] + size
        wire = wire_time(len(request) + answer, self._baud)
        data = self._listen(wire + _LONGEST_RETURN_DELAY + SLACK)
        if self._echoes and data.startswith(request):
            data = data[len(request) :]
        packets = tuple(self._parser.feed(data))
        return Answer(packets, bool(data) and not packets)

    def _listen(self, seconds: float) -> bytes:
        """All that comes in a time."""
        deadline = self._port.now() + seconds
        data = b""
        while True:
            data += self._port.read(deadline)
            if self._port.now() >= deadline:
                return data

    def _hears_itself(self) -> bool:
        """Whether the adapter gives back what it sends."""
        self._port.write(_UNANSWERABLE)
        wire = wire_time(2 * len(_UNANSWERABLE), self._baud)
        return self._listen(wire + SLACK + self._latest).startswith(_UNANSWERABLE)
