"""A serial port that is a PortHandler of the vendor's SDK as well.

Code written for the SDK can so share our port; it then waits instead of spinning, and on the
monotonic clock. The transactions that the driver itself uses are in `armsyn.driver.transactions`.
"""

# ruff: noqa: N802 - the names are the SDK's

from __future__ import annotations

from collections.abc import Sequence

from dynamixel_sdk.port_handler import PortHandler

from armsyn.driver.adapter import adapter_latency
from armsyn.driver.serial_port import SerialPort
from armsyn.driver.timing import wire_time

DEFAULT_MARGIN = 0.034
"""Seconds a reply may be later than the wire explains: two 16 ms latency timers of an adapter."""


class BusPort(PortHandler):  # type: ignore[misc]  # the SDK has no types
    """A serial port with the interface of the SDK's PortHandler, opened at once.

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
    latency : float
        Seconds for which the adapter may keep a reply to itself.

    Raises
    ------
    PortError
        The port cannot be opened.
    """

    def __init__(self, path: str, baud: int, margin: float = DEFAULT_MARGIN) -> None:
        super().__init__(path)
        self.is_open: bool = False
        self.baudrate: int = baud
        self.margin = margin
        self.latency = 0.0
        self.openPort()

    def close(self) -> None:
        """Close the port; a second call does nothing."""
        self.closePort()

    def openPort(self) -> bool:
        """Open the port; PortError when it cannot be."""
        if not self.is_open:
            self.serial_port = SerialPort(self.port_name, self.baudrate)
            self.ser = self.serial_port.serial
            self.latency = adapter_latency(self.port_name)  # now that it was asked to be low
            self.is_open = True
            self.tx_time_per_byte = 1e3 * wire_time(1, self.baudrate)
        return True

    def closePort(self) -> None:
        """Close the port; a second call does nothing."""
        self.serial_port.close()
        self.is_open = False

    def clearPort(self) -> None:
        """Throw away what has arrived."""
        while self.serial_port.read_now():
            pass

    def setBaudRate(self, baudrate: int) -> bool:
        """Any baud rate that the adapter takes; PortError otherwise."""
        self.serial_port.set_baud(baudrate)
        self.baudrate = baudrate
        self.tx_time_per_byte = 1e3 * wire_time(1, baudrate)
        return True

    def readPort(self, length: int) -> bytes:
        """Up to `length` bytes, waiting for the first until the packet's time-out."""
        left = self.packet_timeout - self.getTimeSinceStart()
        self.serial_port.wait(self.serial_port.now() + left * 1e-3)
        return self.serial_port.read_now(length)

    def getBytesAvailable(self) -> int:
        """Return how many bytes have arrived."""
        return self.serial_port.waiting()

    def writePort(self, packet: Sequence[int]) -> int:
        """Send bytes; returns their number."""
        self.serial_port.write(bytes(packet))
        return len(packet)

    def setPacketTimeout(self, packet_length: int) -> None:
        """Start the time-out of a reply of `packet_length` bytes."""
        self.setPacketTimeoutMillis(self.tx_time_per_byte * packet_length + self.margin * 1e3)

    def getCurrentTime(self) -> float:
        """Milliseconds of the monotonic clock."""
        return self.serial_port.now() * 1e3
