"""A pseudo-terminal that a client opens as a serial port."""

from __future__ import annotations

import fcntl
import os
import pty
import struct
import termios
import time
import tty
from collections.abc import Sequence
from pathlib import Path

from firmware_sim.command.open_watch import OpenWatch
from firmware_sim.errors import LinkTakenError
from firmware_sim.files import InUseError, OwnerMark

_TCGETS2 = 0x802C542A
"""Linux's request for ``struct termios2``, which holds any baud rate as a number."""

_TERMIOS2_SIZE = 44
_OUTPUT_SPEED_AT = 40
_READ_SIZE = 1024

_RETRY = 0.2
"""How often a port that is to come back tries to, s."""

_WORDS_CAP = 1000
"""Most pieces that are read of a client that has gone; Linux keeps fewer."""

_TIOCGEXCL = 0x80045440
"""Linux's request for whether a terminal is exclusive, <asm-generic/ioctls.h>."""

_TIOCGPTPEER = 0x5441
"""Linux's request for a new descriptor of the slave, whatever its mode or name."""


class PtyPort:
    """The master end of a pseudo-terminal, raw before anybody knows its name.

    Parameters
    ----------
    link : Path, optional
        Where to put a symbolic link to it. One left behind by a simulator that was killed is
        replaced: that says so in the mark beside it, or points to a pseudo-terminal that is gone.
        Anything else there is left alone.

    Raises
    ------
    LinkTakenError
        If the link's path exists or cannot be made, or another simulator holds it.
    """

    def __init__(self, link: Path | None = None) -> None:
        self.link = link
        self.name = ""
        """Where a client finds it; another after each `plug`, which the link follows."""
        self.master = -1
        self.dropped_bytes = 0
        """Bytes no client took, bytes: a full buffer loses them as an idle line does."""
        self.problem = ""
        """Why it is not back though it should be; empty when it is."""
        self._next_try = 0.0
        self._slave = -1
        self._watch: OpenWatch | None = None
        self._linked = False
        self._mode: int | None = None
        self._mark = self._mark_link(link) if link is not None else None
        try:
            self.plug()
        except BaseException:
            self.close()
            raise

    def plug(self) -> None:
        """Make the port and its link, as an adapter that is plugged in.

        Raises
        ------
        LinkTakenError
            If the link's path exists or cannot be made; the port is gone then.
        """
        # The slave stays open here, or the master would fail whenever no client has it open.
        self.master, self._slave = pty.openpty()
        try:
            tty.setraw(self._slave)
            os.set_blocking(self.master, False)
            self.name = os.ttyname(self._slave)
            self._watch = OpenWatch(self.name)
            if self.link is not None:
                self._make_link(self.link)
        except BaseException:
            self.unplug()
            raise

    def close(self) -> None:
        """Remove everything; may be called twice."""
        self.unplug()
        if self._mark is not None:
            self._mark.close()

    def unplug(self) -> None:
        """Remove the link and close both ends, as an adapter pulled out; may be called twice."""
        if self._linked and self.link is not None:
            if self.link.is_symlink() and str(self.link.readlink()) == self.name:
                self.link.unlink()
            self._linked = False
        for descriptor in (self.master, self._slave):
            if descriptor >= 0:
                os.close(descriptor)
        self.master = self._slave = -1
        if self._watch is not None:
            self._watch.close()
        self._watch = None
        self._mode = None

    @property
    def plugged(self) -> bool:
        """Whether there is a port."""
        return self.master >= 0

    def follow(self, unplugged: bool, forbidden: bool) -> None:
        """Be there or not, and let nobody open it or everybody that may by right.

        Where it is to come back and its link's path is taken by then, it says so in `problem` and
        tries again.
        """
        if unplugged:
            self.problem = ""
        if unplugged == self.plugged:
            if unplugged:
                self.unplug()
            else:
                self._come_back()
        if self.plugged and forbidden != (self._mode is not None):
            self._forbid(on=forbidden)

    def _come_back(self) -> None:
        now = time.monotonic()
        if self.problem and now < self._next_try:
            return
        try:
            self.plug()
            self.problem = ""
        except LinkTakenError as error:
            self.problem = str(error)
            self._next_try = now + _RETRY

    def _forbid(self, *, on: bool) -> None:
        if on:
            self._mode = os.fstat(self._slave).st_mode & 0o777
        os.fchmod(self._slave, 0 if on else self._mode or 0)
        if not on:
            self._mode = None

    def _mark_link(self, link: Path) -> OwnerMark:
        try:
            return OwnerMark(link)
        except InUseError:
            raise LinkTakenError(
                f"{link} is another simulator's: end it, or give another --link", str(link)
            ) from None
        except OSError as error:
            raise _cannot_be_made(link, error) from error

    def _make_link(self, link: Path) -> None:
        try:
            if link.is_symlink() and self._is_stale(str(link.readlink())):
                link.unlink()
            link.symlink_to(self.name)
        except FileExistsError:
            raise LinkTakenError(
                f"{link} exists already: remove it, or give another --link", str(link)
            ) from None
        except OSError as error:
            raise _cannot_be_made(link, error) from error
        self._linked = True
        if self._mark is not None:
            self._mark.write(self.name)

    def _is_stale(self, target: str) -> bool:
        """Return whether a link is a dead simulator's, or leads to what is gone, or ours by now."""
        if not target.startswith("/dev/pts/"):
            return False
        left = self._mark is not None and target == self._mark.left_behind
        return left or target == self.name or not Path(target).exists()

    @property
    def comings(self) -> Sequence[int]:
        """What becomes readable when a client has opened or closed the port: see `left`."""
        if self._watch is None or self._watch.descriptor < 0:
            return ()
        return (self._watch.descriptor,)

    def left(self) -> bool:
        """Return whether the last client has closed the port since this was asked last."""
        return self._watch is not None and self._watch.left()

    def let_in(self) -> tuple[bool, list[bytes]]:
        """Let everybody open a port that has been left.

        A client that was killed may have kept the port for itself (TIOCEXCL), which a
        pseudo-terminal would remember for as long as it lives.

        Returns
        -------
        alone : bool
            Whether nobody has opened it yet.
        words : list of bytes
            What had arrived; if alone, of the one who has left.
        """
        if self._watch is None:
            return False, []
        self._watch.pause()
        exclusive = any(fcntl.ioctl(self._slave, _TIOCGEXCL, bytes(4)))
        if exclusive:
            fcntl.ioctl(self._slave, termios.TIOCNXCL)
        # Only without an end of our own does the master say whether others have one.
        os.close(self._slave)
        self._watch.follow(opens=False)
        alone, words = self._drain()
        self._slave = fcntl.ioctl(self.master, _TIOCGPTPEER, os.O_RDWR | os.O_NOCTTY)
        self._watch.follow(opens=True)
        self._watch.correct(0 if alone else 1)
        if exclusive and not alone:
            fcntl.ioctl(self._slave, termios.TIOCEXCL)
        return alone, words

    def _drain(self) -> tuple[bool, list[bytes]]:
        """Read until nobody has the port open any more, or somebody has and is silent."""
        words: list[bytes] = []
        while len(words) < _WORDS_CAP:
            try:
                words.append(os.read(self.master, _READ_SIZE))
            except BlockingIOError:
                break
            except OSError:  # EIO: all is read, and nobody there
                return True, words
        return False, words

    def forget_unread(self) -> None:
        """Drop what no client has read."""
        termios.tcflush(self._slave, termios.TCIFLUSH)

    @property
    def baud_rate(self) -> int:
        """The client's baud rate, bit/s, standard or not; 0 while it has hung up."""
        answer = fcntl.ioctl(self.master, _TCGETS2, bytes(_TERMIOS2_SIZE))
        return int(struct.unpack_from("=I", answer, _OUTPUT_SPEED_AT)[0])

    def read(self, size: int = _READ_SIZE) -> bytes:
        """Return what has arrived, at most some bytes of it; empty if nothing has."""
        try:
            return os.read(self.master, min(size, _READ_SIZE))
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> None:
        """Send bytes; what does not fit into the client's buffer is lost and counted."""
        try:
            written = os.write(self.master, data)
        except BlockingIOError:
            written = 0
        self.dropped_bytes += len(data) - written


def _cannot_be_made(link: Path, error: OSError) -> LinkTakenError:
    return LinkTakenError(
        f"{link} cannot be made ({error.strerror}): give another --link", str(link)
    )
