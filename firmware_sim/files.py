"""Files that are read whole, and marks beside files that say who is using them."""

from __future__ import annotations

import errno
import fcntl
import os
import stat
from contextlib import suppress
from pathlib import Path


def read_capped(path: Path, cap: int) -> bytes:
    """Return what a file holds, at most one byte more than a cap.

    Raises
    ------
    OSError
        If it cannot be read, or is no regular file: a FIFO or a device might never end.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    with os.fdopen(descriptor, "rb") as file:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise OSError(errno.EINVAL, "it is no regular file")
        return file.read(cap + 1)


class InUseError(Exception):
    """Another process holds the mark."""


class OwnerMark:
    """A mark beside a file, held by the process that uses the file for as long as it lives.

    The mark is a locked file ``.NAME.lock``. One that a killed process left is taken over, and
    what it says stays to be read in `left_behind`.

    Parameters
    ----------
    path : Path
        The file; it need not exist.

    Raises
    ------
    InUseError
        If another process holds it.
    OSError
        If the mark cannot be made.
    """

    def __init__(self, path: Path) -> None:
        self._path = path.with_name(f".{path.name}.lock")
        self._descriptor = -1
        while self._descriptor < 0:
            self._take()
        self.left_behind = os.pread(self._descriptor, 1000, 0).decode(errors="replace")

    def write(self, text: str) -> None:
        """Say something in it, for whoever finds it after this process was killed."""
        os.ftruncate(self._descriptor, 0)
        os.pwrite(self._descriptor, text.encode(), 0)

    def close(self) -> None:
        """Take the mark away; may be called twice."""
        if self._descriptor >= 0:
            with suppress(OSError):
                self._path.unlink()
            os.close(self._descriptor)
        self._descriptor = -1

    def _take(self) -> None:
        flags = os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW
        descriptor = os.open(self._path, flags, 0o600)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            with suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(descriptor), self._path.stat()):
                    self._descriptor = descriptor
                    return
            os.close(descriptor)  # its owner took it away just now
        except BlockingIOError:
            os.close(descriptor)
            raise InUseError from None
