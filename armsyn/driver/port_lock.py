"""A lock file for each port, so that no two programs of this driver share one.

The exclusive lock on the port itself (pyserial's ``exclusive=True``) is seen only by programs
that take it on the same device; the file also names who holds the port. The kernel releases
both when the holder dies, however it dies. All users share one folder, so that they exclude each
other too; a file that a killed program of another user left behind must be removed by its owner.
"""

from __future__ import annotations

import fcntl
import os
import tempfile
import time
from pathlib import Path

from armsyn.errors import PortError

PATIENCE = 0.05
"""Seconds for which a port that is taken is asked for again: its holder may be closing it, or
another program may be looking who holds it."""

_AGAIN = 0.005


def lock_file(port: str) -> Path:
    """Path of a port's lock file, there or not; links to a port mean the same one."""
    name = str(Path(port).resolve()).strip("/").replace("/", "-")
    return Path(tempfile.gettempdir()) / f"armsyn-{name}.lock"


def look(port: str) -> PortError | None:
    """Say why a port could not be locked now, without locking it; None when it could be.

    Parameters
    ----------
    port : str
        Path of the port; links to it mean the same port.

    Returns
    -------
    PortError or None
        Another program holds it (the message names its process), or this user could not make its
        lock file.
    """
    path = lock_file(port)
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC)
    except FileNotFoundError:
        return None
    except OSError:
        return _closed_to_us(port)
    try:
        # shared, and only for this moment: who wants the port in it asks again
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:
        return _taken(port, descriptor)
    finally:
        os.close(descriptor)
    return None if os.access(path, os.W_OK) else _left_behind(port)


def _taken(port: str, descriptor: int) -> PortError:
    holder = os.read(descriptor, 32).decode("ascii", "replace").strip()
    return PortError(f"port {port} is taken by process {holder or 'unknown'}: end it first")


def _closed_to_us(port: str) -> PortError:
    return PortError(
        f"port {port} cannot be locked: this user may not open {lock_file(port)}; have it removed"
        " by its owner if no program uses the port"
    )


def _left_behind(port: str) -> PortError:
    return PortError(
        f"port {port} cannot be locked: {lock_file(port)} was left behind by another user's"
        " program, which has ended; have its owner (or root) remove the file"
    )


class PortLock:
    """Exclusive hold of a port by this process, until `release`.

    Parameters
    ----------
    port : str
        Path of the port; links to it mean the same port.

    Raises
    ------
    PortError
        Another program holds it (the message names its process), or no lock file can be made (the
        message names the file and the cure).
    """

    def __init__(self, port: str) -> None:
        self.path = lock_file(port)
        self._descriptor: int | None = self._acquire(port)

    def _acquire(self, port: str) -> int:
        deadline = time.monotonic() + PATIENCE
        while True:
            descriptor = self._open(port)
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                taken = _taken(port, descriptor)
                os.close(descriptor)
                if time.monotonic() > deadline:
                    raise taken from None
                time.sleep(_AGAIN)
                continue
            if self._is_current(descriptor):
                break
            os.close(descriptor)  # its holder removed the file in between
        os.ftruncate(descriptor, 0)
        os.write(descriptor, f"{os.getpid()}\n".encode())
        return descriptor

    def _open(self, port: str) -> int:
        flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC
        try:
            return os.open(self.path, flags, 0o644)
        except PermissionError as error:
            unlocked = _left_behind if self.path.exists() else _closed_to_us
            raise (look(port) or unlocked(port)) from error
        except OSError as error:
            raise PortError(
                f"port {port} cannot be locked: {self.path}: {error.strerror}; remove what is there"
            ) from error

    def _is_current(self, descriptor: int) -> bool:
        try:
            return os.fstat(descriptor).st_ino == self.path.stat().st_ino
        except FileNotFoundError:
            return False

    def release(self) -> None:
        """Give the port back; a second call does nothing."""
        if self._descriptor is not None:
            self.path.unlink(missing_ok=True)
            os.close(self._descriptor)
            self._descriptor = None
