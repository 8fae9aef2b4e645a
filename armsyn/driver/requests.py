"""Instructions that are answered: their packets, who answers, and how long that takes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType

from armsyn.driver import protocol, protocol1
from armsyn.driver.quick import FastDecoding, FastLayout, StatusDecoding, StatusLayout
from armsyn.driver.timing import BITS_PER_BYTE, STATUS_OVERHEAD

UNKNOWN_RETURN_DELAY = 508e-6
"""Seconds: the greatest return delay time, assumed until it is read."""

_STATUS_OVERHEAD = {1: 6, 2: STATUS_OVERHEAD}
"""Bytes of a status packet beside its data, by protocol."""


@dataclass(frozen=True)
class Request:
    """One instruction, and the status packets that answer it.

    Parameters
    ----------
    data : bytes
        Of the instruction packet.
    sizes : mapping of int to int
        Who answers, in this order, each with how many bytes.
    protocol : {1, 2}
    fast : bool
        Whether the answers are one packet, as of a fast sync read.
    """

    data: bytes
    sizes: Mapping[int, int]
    protocol: int = 2
    fast: bool = False

    @cached_property
    def reply_bytes(self) -> int:
        """Bytes of all answers together, where nothing is stuffed."""
        if self.fast:
            return self.layout.size
        return sum(self.sizes.values()) + _STATUS_OVERHEAD[self.protocol] * len(self.sizes)

    @cached_property
    def layout(self) -> FastLayout | StatusLayout:
        """Of the answers, where nothing is stuffed and protocol 2.0 is spoken."""
        return (FastLayout if self.fast else StatusLayout)(self.sizes)

    def decoding(self) -> StatusDecoding | FastDecoding:
        """Return a decoder of the answers to one such request of protocol 2.0."""
        layout = self.layout
        return FastDecoding(layout) if isinstance(layout, FastLayout) else StatusDecoding(layout)

    def duration(self, before: int, baud: int, return_delays: Mapping[int, float]) -> float:
        """Seconds on the wire, of `before` bytes, the request and its answers.

        Parameters
        ----------
        before : int
            Bytes sent in the same breath.
        baud : int
            Bits a second.
        return_delays : mapping of int to float
            Return delay time by ID, s; the greatest there is where it is not known.
        """
        delays = [return_delays.get(i, UNKNOWN_RETURN_DELAY) for i in self.sizes]
        delay = max(delays) if self.fast else sum(delays)
        return (before + len(self.data) + self.reply_bytes) * BITS_PER_BYTE / baud + delay


def codec(number: int) -> ModuleType:
    """Packets of a protocol, 1 or 2: the functions that build them have the same names."""
    return protocol1 if number == 1 else protocol


def read_request(number: int, servo_id: int, address: int, size: int) -> Request:
    """Read bytes of one servo, in protocol `number`."""
    return Request(codec(number).read(servo_id, address, size), {servo_id: size}, number)


def write_request(number: int, servo_id: int, address: int, data: bytes) -> Request:
    """Write bytes of one servo, in protocol `number`."""
    return Request(codec(number).write(servo_id, address, data), {servo_id: 0}, number)


def ping_request(servo_id: int, size: int) -> Request:
    """Ping of protocol 2.0, answered with `size` bytes; of one servo or, with 254, of all."""
    everyone = range(protocol.MAXIMUM_ID + 1)
    asked = everyone if servo_id == protocol.BROADCAST_ID else (servo_id,)
    return Request(protocol.ping(servo_id), dict.fromkeys(asked, size))


def reboot_request(servo_id: int) -> Request:
    """Reboot of protocol 2.0."""
    return Request(protocol.reboot(servo_id), {servo_id: 0})
