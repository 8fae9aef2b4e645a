"""A stepped port with the face of pyserial's ``Serial``, for code that was written for that."""

from __future__ import annotations

from types import TracebackType
from typing import Self

from firmware_sim.stepped import SteppedPort

_LOOK = 1.0e-4
"""Simulated time that a look takes which finds nothing, s: so that loops that poll come to an
end."""


class SteppedSerial:
    """What programs use of ``serial.Serial``, on a clock that moves only by waiting.

    Parameters
    ----------
    port : SteppedPort
        As `firmware_sim.testing.stepped` makes it.
    timeout : float or None
        How long `read` waits, simulated s; 0 for not at all, None for as long as it takes.

    Attributes
    ----------
    timeout : float or None
        As given; may be set.
    is_open : bool
        Whether it can be used.
    """

    def __init__(self, port: SteppedPort, timeout: float | None = None) -> None:
        self.stepped = port
        self.timeout = timeout
        self.write_timeout: float | None = None
        self.is_open = True
        self.port = self.name = "stepped"

    @property
    def baudrate(self) -> int:
        """bit/s; may be set."""
        return int(self.stepped.baud_rate)

    @baudrate.setter
    def baudrate(self, baudrate: int) -> None:
        self.stepped.baud_rate = baudrate

    @property
    def in_waiting(self) -> int:
        """How many bytes have arrived; a look that finds none takes 0.1 ms."""
        found = self.stepped.in_waiting()
        if not found:
            self._wait(_LOOK)
            found = self.stepped.in_waiting()
        return found

    def read(self, size: int = 1) -> bytes:
        """Return up to `size` bytes, waiting for them as long as `timeout` says.

        Raises
        ------
        TimeoutError
            Where a real port would wait for ever: without a timeout, when nothing is on its way.
        """
        if self.timeout is not None:
            found = self.stepped.read(size, self.timeout)
            if len(found) < size and self.timeout < _LOOK:
                self._wait(_LOOK)
            return found
        while self.stepped.in_waiting() < size:
            if not self.stepped.wait_for_next():
                raise TimeoutError("nothing is on its way, and no timeout is set")
        return self.stepped.read(size, 0.0)

    def read_all(self) -> bytes:
        """Return what has arrived."""
        return self.stepped.read(self.stepped.in_waiting(), 0.0)

    def write(self, data: bytes) -> int:
        """Send bytes; return how many."""
        self.stepped.write(bytes(data))
        return len(data)

    def flush(self) -> None:
        """Do nothing: what is written is on its way."""

    def reset_input_buffer(self) -> None:
        """Drop what has arrived."""
        self.read_all()

    def reset_output_buffer(self) -> None:
        """Do nothing: what is written is on its way."""

    def open(self) -> None:
        """Let it be used again."""
        self.is_open = True

    def close(self) -> None:
        """End using it; may be called twice."""
        self.is_open = False

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _wait(self, duration: float) -> None:
        self.stepped.wait_until(self.stepped.clock.now() + duration)
