"""One request and its replies on a serial line: echoes, late replies and strangers told apart."""

from __future__ import annotations

from collections.abc import Callable

from armsyn.driver.collecting import BusCounters, Collector, Echo, FastCollector, StatusCollector
from armsyn.driver.parser import ParserCounters, StatusPacket, StatusParser
from armsyn.driver.parser1 import StatusParser1
from armsyn.driver.quick import FastLayout
from armsyn.driver.requests import Request
from armsyn.driver.serial_port import SerialPort

QUIET = 1e-3
"""Seconds of silence, beyond the adapter's latency, after which no late reply is expected."""

LONGEST_DRAIN = 20e-3
"""Seconds, beyond the adapter's latency, after which draining ends even on a line that never
falls silent."""

_MOST_UNHEARD = 4096
"""Bytes of what was sent without an answer whose echo is looked for; what a terminal keeps."""


class Line:
    """What a bus knows of its line from one request to the next.

    Attributes
    ----------
    counters : BusCounters
    parser_counters : ParserCounters
        What has been met so far.
    latency : float
        Seconds for which the adapter may keep a reply to itself.
    late : float
        Seconds beyond its time on the wire that the last request took.
    """

    def __init__(self) -> None:
        self.counters = BusCounters()
        self.parser_counters = ParserCounters()
        self.latency = 0.0
        self.late = 0.0
        self._parser = StatusParser(counters=self.parser_counters)
        self._parser1 = StatusParser1(self.parser_counters)
        self._silent_since: float | None = None  # of a time-out: replies may still come late
        self._echoes = False
        self._unheard = b""  # sent without waiting for an answer: its echo may still come

    def reset(self) -> None:
        """Forget what was under way."""
        self._parser.reset()
        self._parser1.reset()
        self._silent_since = None
        self._unheard = b""

    def send(self, port: SerialPort, packets: bytes) -> None:
        """Send packets that nobody answers; PortLostError when the port went away."""
        port.write(packets)
        self._unheard = (self._unheard + packets)[-_MOST_UNHEARD:]

    def exchange(
        self,
        port: SerialPort,
        request: Request,
        before: bytes,
        duration: Callable[[], float],
        margin: float,
    ) -> dict[int, StatusPacket]:
        """Send a request and gather its replies.

        Parameters
        ----------
        port : SerialPort
        request : Request
        before : bytes
            Packets that nobody answers, sent in the same breath.
        duration : callable
            Seconds of all that on the wire; worked out while the bytes are on their way.
        margin : float
            Seconds that replies may be later.

        Returns
        -------
        dict of int to StatusPacket
            Of the servos that answered in time.

        Raises
        ------
        PortLostError
            The port went away.
        """
        self._clear(port)
        port.write(before + request.data)
        sent, self._unheard = self._unheard + before + request.data, b""
        self.counters.transactions += 1
        expected = port.now() + duration()
        replies, data = self._expect(port, request, sent, expected)
        if replies is None:
            collected = self._collect(port, request, sent, data, expected + margin)
            self.late = max(0.0, port.now() - expected)
            return collected
        self.late = 0.0
        self.parser_counters.packets += len(replies)
        return replies

    def _expect(
        self, port: SerialPort, request: Request, sent: bytes, expected: float
    ) -> tuple[dict[int, StatusPacket] | None, bytes]:
        """Return the replies, if they are as expected and in time; and all that came."""
        if request.protocol == 1 or self._echoes:
            echoed = len(sent) if self._echoes else 0
            return None, port.gather(echoed + request.reply_bytes, expected)
        decoding = request.decoding()
        data = port.gather(request.reply_bytes, expected, decoding.look)
        return decoding.result(data), data

    def _collect(
        self, port: SerialPort, request: Request, sent: bytes, data: bytes, deadline: float
    ) -> dict[int, StatusPacket]:
        """Find replies in `data` and in what comes until all are there or `deadline` is past."""
        collector, echo = self._collector(request, sent), Echo(sent)
        collector.feed(echo.strip(data))
        while not collector.complete:
            data = port.read(deadline)
            if not data:
                collector.feed(echo.rest())
                collector.finish()
                break
            collector.feed(echo.strip(data))
        if not collector.complete:
            self.counters.timeouts += 1
            self._silent_since = port.now()
        self._echoes = bool(echo.stripped)
        self.counters.echoed_bytes += echo.stripped
        return collector.replies

    def _collector(self, request: Request, sent: bytes) -> Collector:
        if isinstance(request.layout, FastLayout):
            return FastCollector(request.layout, self.parser_counters)
        sizes = request.sizes
        if request.protocol == 1:
            self._parser1.own = sent
            self._parser1.lengths = {2, *(size + 2 for size in sizes.values())}
            return StatusCollector(sizes, self._parser1, self.counters)
        # instruction, error, CRC, the data, and what stuffing may add to them
        size = max(sizes.values())
        self._parser.maximum_length = 4 + size + (size + 4) // 3
        self._parser.own = sent
        return StatusCollector(sizes, self._parser, self.counters)

    def _clear(self, port: SerialPort) -> None:
        """Leave nothing on the line that came before the request."""
        if self._silent_since is not None:
            self._drain(port, self._silent_since)
        elif data := self._without_echo(port.read_now()):
            self._overhear(data)

    def _without_echo(self, data: bytes) -> bytes:
        """Take out of what came the echo of what was sent without waiting for an answer."""
        size = min(len(data), len(self._unheard))
        if data[:size] != self._unheard[:size]:
            return data
        self._unheard = self._unheard[size:]
        self.counters.echoed_bytes += size
        return data[size:]

    def _drain(self, port: SerialPort, since: float) -> None:
        """Wait for late replies to be over, and throw them away."""
        quiet = QUIET + self.latency
        end = port.now() + LONGEST_DRAIN + self.latency
        until = since + quiet
        while data := port.read(min(end, until)):
            self.counters.drained_bytes += len(self._without_echo(data))
            until = port.now() + quiet
            if port.now() > end:
                break
        self._parser.reset()
        self._parser1.reset()
        self._silent_since = None

    def _overhear(self, data: bytes) -> None:
        """Count what nobody asked for, and whether it is another master's."""
        self.counters.unsolicited_bytes += len(data)
        stranger = StatusParser()
        stranger.own = self._unheard
        stranger.feed(data)
        self.parser_counters.foreign += stranger.counters.foreign
