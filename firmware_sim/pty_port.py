"""A pseudo-terminal that a client opens as a serial port."""

from __future__ import annotations

import fcntl
import os
import pty
import struct
import tty
from pathlib import Path

from firmware_sim.errors import LinkTakenError

_TCGETS2 = 0x802C542A
"""Linux's request for ``struct termios2``, which holds any baud rate as a number."""

_TERMIOS2_SIZE = 44
_OUTPUT_SPEED_AT = 40
_READ_SIZE = 1024


class PtyPort:
    """The master end of a pseudo-terminal, raw before anybody knows its name.

    Parameters
    ----------
    link : Path, optional
        Where to put a symbolic link to it. One left behind by a simulator that was killed, pointing
        to a pseudo-terminal that is gone, is replaced; anything else there is left alone.

    Raises
    ------
    LinkTakenError
        If the link's path exists or cannot be made.
    """

    def __init__(self, link: Path | None = None) -> None:
        self.link = link
        self.name = ""
        """Where a client finds it; another after each `plug`, which the link follows."""
        self.master = -1
        self.dropped_bytes = 0
        """Bytes no client took, bytes: a full buffer loses them as an idle line does."""
        self._slave = -1
        self._linked = False
        self._mode: int | None = None
        self.plug()

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
            if self.link is not None:
                self._make_link(self.link)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Remove the link and close both ends, as an adapter pulled out; may be called twice."""
        if self._linked and self.link is not None:
            if self.link.is_symlink() and str(self.link.readlink()) == self.name:
                self.link.unlink()
            self._linked = False
        for descriptor in (self.master, self._slave):
            if descriptor >= 0:
                os.close(descriptor)
        self.master = self._slave = -1
        self._mode = None

    @property
    def plugged(self) -> bool:
        """Whether there is a port."""
        return self.master >= 0

    def follow(self, unplugged: bool, forbidden: bool) -> None:
        """Be there or not, and let nobody open it or everybody that may by right.

        Raises
        ------
        LinkTakenError
            If it is to come back, and its link's path is taken by then.
        """
        if unplugged == self.plugged:
            (self.close if unplugged else self.plug)()
        if self.plugged and forbidden != (self._mode is not None):
            self._forbid(on=forbidden)

    def _forbid(self, *, on: bool) -> None:
        if on:
            self._mode = os.fstat(self._slave).st_mode & 0o777
        os.fchmod(self._slave, 0 if on else self._mode or 0)
        if not on:
            self._mode = None

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
            raise LinkTakenError(
                f"{link} cannot be made ({error.strerror}): give another --link", str(link)
            ) from error
        self._linked = True

    def _is_stale(self, target: str) -> bool:
        """Return whether a link leads to a pseudo-terminal that is gone, or is ours by now."""
        is_pty = target.startswith("/dev/pts/")
        return is_pty and (target == self.name or not Path(target).exists())

    @property
    def baud_rate(self) -> int:
        """The client's baud rate, bit/s, standard or not."""
        answer = fcntl.ioctl(self.master, _TCGETS2, bytes(_TERMIOS2_SIZE))
        return int(struct.unpack_from("=I", answer, _OUTPUT_SPEED_AT)[0])

    def read(self) -> bytes:
        """Return what has arrived, empty if nothing has."""
        try:
            return os.read(self.master, _READ_SIZE)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> None:
        """Send bytes; what does not fit into the client's buffer is lost and counted."""
        try:
            written = os.write(self.master, data)
        except BlockingIOError:
            written = 0
        self.dropped_bytes += len(data) - written
