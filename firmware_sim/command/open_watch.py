"""Notices when a file is opened and closed: Linux's inotify, which Python has no module for."""

from __future__ import annotations

import ctypes
import os
import struct

_IN_CLOSE = 0x08 | 0x10  # IN_CLOSE_WRITE | IN_CLOSE_NOWRITE, <sys/inotify.h>
_IN_OPEN = 0x20
_EVENT = struct.Struct("=iIII")
"""Watch, mask, cookie and length of a name, which a watch of one file never has."""

_EVENTS_SIZE = 256 * _EVENT.size


class OpenWatch:
    """Counts who has one file open.

    Linux merges equal events that follow each other at once, so that the count is an estimate:
    `correct` it where more is known.

    Parameters
    ----------
    path : str
        The file.

    Attributes
    ----------
    descriptor : int
        Becomes readable when somebody has opened or closed the file; -1 where the system lets
        nobody watch: then nothing is noticed.
    """

    def __init__(self, path: str) -> None:
        self._path = os.fsencode(path)
        self._libc = ctypes.CDLL(None, use_errno=True)
        self._count = 0
        self.descriptor: int = self._libc.inotify_init1(os.O_NONBLOCK | os.O_CLOEXEC)
        self.follow(opens=True)

    def follow(self, *, opens: bool) -> None:
        """Notice closes from now on, and opens or not."""
        if self.descriptor >= 0:
            mask = _IN_CLOSE | (_IN_OPEN if opens else 0)
            self._watch = self._libc.inotify_add_watch(self.descriptor, self._path, mask)

    def pause(self) -> None:
        """Notice nothing before `follow`."""
        if self.descriptor >= 0:
            self._libc.inotify_rm_watch(self.descriptor, self._watch)

    def left(self) -> bool:
        """Return whether the last who had it open has closed it since this was asked last."""
        if self.descriptor < 0:
            return False
        try:
            events = os.read(self.descriptor, _EVENTS_SIZE)
        except BlockingIOError:
            return False
        left = False
        for _watch, mask, _cookie, _length in _EVENT.iter_unpack(events):
            if mask & _IN_OPEN:
                self._count += 1
            elif mask & _IN_CLOSE:
                self._count = max(0, self._count - 1)
                left |= not self._count
        return left

    def correct(self, count: int) -> None:
        """Say how many have it open."""
        self._count = count

    def close(self) -> None:
        """End; may be called twice."""
        if self.descriptor >= 0:
            os.close(self.descriptor)
        self.descriptor = -1
