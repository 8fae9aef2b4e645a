"""A serial port that is opened exclusively, read with deadlines, and fails with typed errors.

For systems with POSIX terminals (Linux, macOS): waiting is done by ``select`` on the port's
descriptor, so that nothing spins.
"""

from __future__ import annotations

import contextlib
import errno
import os
import select
import termios
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import serial

from armsyn.driver.port_lock import PortLock
from armsyn.driver.timing import wire_time
from armsyn.errors import PortError, PortLostError

WRITE_MARGIN = 0.5
"""Seconds beyond their time on the wire after which bytes must have been taken: a port that hangs
must not hang the program, which would then not even end on Ctrl-C."""

LOOK_BEFORE = 100e-6
"""Seconds before the last reply is due at which the others are looked at."""

LOOK_AFTER = 300e-6
"""Seconds after which replies that are not as expected are no longer waited for together."""

_LONGEST_OVERSLEEP = 300e-6
"""Seconds by which a sleep is ever expected to end late; what is more was another program's."""

_LEARNING = 0.05
"""Share of the newest sleep in how late sleeps are expected to end."""

_REFUSALS = (errno.EINVAL, errno.ENOTTY, errno.EOPNOTSUPP)
"""Error numbers that say no instead of goodbye."""

_CHUNK = 4096
_LOST = (serial.SerialException, OSError, termios.error, TypeError)
"""What pyserial and the system raise when the port vanishes (TypeError: a closed descriptor)."""


class SerialPort:
    """An open serial port, ours alone until `close`.

    Parameters
    ----------
    path : str
        Such as ``/dev/ttyUSB0``.
    baud : int
        Bits a second; any that the adapter takes.

    Raises
    ------
    PortError
        No such port, no permission, taken by another program, or not a serial port: each its
        own message with the cure.
    """

    def __init__(self, path: str, baud: int) -> None:
        self.path = path
        self._oversleep = 100e-6
        self._descriptor = -1
        self._lock: PortLock | None = None
        try:
            with _explained(path):
                Path(path).stat()
                self._lock = PortLock(path)
                self.serial = serial.Serial(path, baud, timeout=0, exclusive=True)
                self._descriptor = self.serial.fileno()
            with contextlib.suppress(OSError, ValueError, AttributeError):
                # an FTDI adapter then answers after 1 ms instead of 16; others do not need it
                self.serial.set_low_latency_mode(True)
        except BaseException:
            if hasattr(self, "serial"):
                self.serial.close()  # before the lock: who gets that finds the port free
            if self._lock is not None:
                self._lock.release()
            raise

    @property
    def is_open(self) -> bool:
        """Whether the port is open."""
        return bool(self.serial.is_open)

    @property
    def baud(self) -> int:
        """Bits a second."""
        return int(self.serial.baudrate)

    def now(self) -> float:
        """Seconds on the monotonic clock, on which deadlines are."""
        return time.monotonic()

    def set_baud(self, baud: int) -> None:
        """Change the baud rate; PortError when the adapter refuses it, PortLostError as `read`."""
        try:
            self.serial.baudrate = baud
        except ValueError as error:
            raise PortError(f"port {self.path} does not take {baud} baud: {error}") from error
        except _LOST as error:
            if _number(error) not in _REFUSALS:
                raise self._lost(error) from error
            raise PortError(f"port {self.path} does not take {baud} baud: {error}") from error

    def write(self, data: bytes) -> None:
        """Send all of `data`, waiting where the port is full: at most its wire time and 0.5 s.

        Raises
        ------
        PortLostError
            The port went away, or takes no more bytes.
        """
        view = memoryview(data)
        deadline = self.now() + wire_time(len(data), self.baud) + WRITE_MARGIN
        try:
            while view:
                view = view[self._write_some(view, deadline) :]
        except _LOST as error:
            raise self._lost(error) from error

    def _write_some(self, view: memoryview, deadline: float) -> int:
        try:
            return os.write(self._descriptor, view)
        except BlockingIOError:
            left = max(0.0, deadline - self.now())
            if not select.select((), (self._descriptor,), (), left)[1]:
                raise PortLostError(
                    f"port {self.path} takes no more bytes ({len(view)} were not sent): unplug its"
                    " adapter and plug it in again, then start again"
                ) from None
            return 0

    def waiting(self) -> int:
        """Return how many bytes have arrived; PortLostError when the port went away."""
        try:
            return int(self.serial.in_waiting)
        except _LOST as error:
            raise self._lost(error) from error

    def read_now(self, most: int = _CHUNK) -> bytes:
        """Bytes that have arrived, without waiting; a port that went away may go unnoticed."""
        try:
            return os.read(self._descriptor, most)
        except BlockingIOError:
            return b""
        except _LOST as error:
            raise self._lost(error) from error

    def gather(
        self, count: int, expected: float, look: Callable[[bytes], None] | None = None
    ) -> bytes:
        """Bytes that should all have arrived at a moment that is known.

        Sleeps until shortly before it, instead of waking up for each chunk, and then waits for
        what is left. It does not spin: that takes processor time, and keeps the system from
        passing the bytes on where processors are few.

        Parameters
        ----------
        count : int
            How many bytes are waited for.
        expected : float
            When the last of them should be here, on the port's clock, s.
        look : callable, optional
            Given all that has come, before it is complete: to begin with it while waiting.

        Returns
        -------
        bytes
            What has arrived: `count` of them, or fewer, or more.

        Raises
        ------
        PortLostError
            The port went away.
        """
        data = self.read_now()
        if len(data) < count:
            self._sleep_until(expected - LOOK_BEFORE)
        until = expected + LOOK_AFTER
        while len(data) < count:
            more = self.read(until)
            if not more:
                break
            data += more
            if look is not None and len(data) < count:
                look(data)
        return data

    def _sleep_until(self, moment: float) -> None:
        """Sleep, less by what sleeps of late took too long."""
        nap = moment - self._oversleep - time.monotonic()
        if nap <= 0.0:
            return
        time.sleep(nap)
        late = time.monotonic() - moment + self._oversleep
        self._oversleep += _LEARNING * (min(late, _LONGEST_OVERSLEEP) - self._oversleep)

    def read(self, deadline: float) -> bytes:
        """Bytes that have arrived, waiting for the first of them until `deadline`.

        Parameters
        ----------
        deadline : float
            On the port's clock (`now`), s; in the past: do not wait.

        Returns
        -------
        bytes
            Empty when nothing came in time.

        Raises
        ------
        PortLostError
            The port went away.
        """
        if not self.wait(deadline):
            return b""
        try:
            data = os.read(self._descriptor, _CHUNK)
        except BlockingIOError:
            return b""
        except _LOST as error:
            raise self._lost(error) from error
        if not data:  # readable and empty: hung up
            raise self._lost(None)
        return data

    def wait(self, deadline: float) -> bool:
        """Wait until bytes have arrived, or `deadline`; errors as `read`."""
        try:
            left = max(0.0, deadline - time.monotonic())
            return bool(select.select((self._descriptor,), (), (), left)[0])
        except (*_LOST, ValueError) as error:
            raise self._lost(error) from error

    def close(self) -> None:
        """Close the port and give it back; a second call does nothing."""
        with contextlib.suppress(*_LOST):  # a port that is gone cannot be closed any better
            self.serial.close()
        self._descriptor = -1
        if self._lock is not None:
            self._lock.release()

    def _lost(self, error: BaseException | None) -> PortLostError:
        """Give the port up, so that its device can come back under its name."""
        if self._descriptor < 0:
            return PortLostError(
                f"port {self.path} is closed: it was lost or given back; open it again"
            )
        self.close()
        reason = f" ({error})" if error is not None else ""
        return PortLostError(
            f"port {self.path} was lost while in use{reason}: check the cable and power,"
            " then start again"
        )


def _number(error: BaseException) -> int | None:
    """Error number of the system; `termios.error` has it as its first argument."""
    number = getattr(error, "errno", None)
    if number is None and error.args and isinstance(error.args[0], int):
        return error.args[0]
    return number


@contextlib.contextmanager
def _explained(path: str) -> Iterator[None]:
    """Turn what opening raises into a PortError that names the cure."""
    try:
        yield
    except PortError:
        raise
    except (*_LOST, ValueError) as error:
        raise PortError(f"port {path} {_reason(error)}") from error


def _reason(error: BaseException) -> str:
    number = _number(error)
    if number == errno.ENOENT:
        return "does not exist: plug the adapter in and look for it under /dev"
    if number in (errno.EACCES, errno.EPERM):
        return "may not be opened by this user: join the group that owns it (often dialout)"
    if number == errno.EBUSY or "lock" in str(error):
        return "is taken by another program: end it first"
    return f"cannot be used as a serial port: {error}"
