"""Servos on a stepped clock behind a driver's bus that may change its baud rate."""

from __future__ import annotations

from armsyn.driver.transactions import Bus
from armsyn.errors import PortError
from firmware_sim.testing import SteppedPort


class SteppedLine:
    """What `armsyn.driver.serial_port.SerialPort` offers, on a stepped port."""

    def __init__(self, port: SteppedPort) -> None:
        self.port = port
        self.serial = None
        self.refuses: set[int] = set()

    def now(self) -> float:
        return self.port.clock.now()

    def set_baud(self, baud: int) -> None:
        if baud in self.refuses:
            raise PortError(f"port stepped does not take {baud} baud")
        self.port.baud_rate = baud

    def write(self, data: bytes) -> None:
        self.port.write(data)

    def read(self, deadline: float) -> bytes:
        """Wait for the first byte only, as the port does."""
        first = self.port.read(1, max(0.0, deadline - self.now()))
        return first + self.read_now()

    def read_now(self) -> bytes:
        return self.port.read(self.port.in_waiting(), 0.0)

    def gather(self, count: int, expected: float) -> bytes:
        return self.port.read(count, max(0.0, expected - self.now()))

    def close(self) -> None:
        pass


class SteppedLineBus(Bus):
    """A bus on a stepped port."""

    def __init__(self, port: SteppedPort) -> None:
        self.line = SteppedLine(port)
        super().__init__("stepped", int(port.baud_rate))

    def openPort(self) -> bool:  # noqa: N802 - the SDK's name
        self.serial_port = self.line  # type: ignore[assignment]
        self.is_open = True
        return True
