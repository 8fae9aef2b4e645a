"""The lock of a generation's folder: one generation at a time."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
from collections.abc import Iterator
from pathlib import Path

from armsyn.errors import InputError

_NO_LOCKS = (errno.EBADF, errno.EINVAL, errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP)
"""What a file system answers whose folders cannot be locked, such as NFS."""


@contextlib.contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Keep other generations out of a folder, which is made if there is none.

    The folder itself is locked, so nothing is left of a lock whose process was killed. Workers do
    not hold it. On a file system that does not lock folders (NFS) nobody is kept out.

    Parameters
    ----------
    folder : Path

    Raises
    ------
    InputError
        When another generation is in it, or it cannot be made or looked into.
    """
    try:
        if not folder.exists():
            folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot make it: {error.strerror}") from error
    try:
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except OSError as error:
        raise InputError(f"{folder}: cannot look into it: {error.strerror}") from error
    try:
        _lock(descriptor, folder)
        yield
    finally:
        os.close(descriptor)


def _lock(descriptor: int, folder: Path) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise InputError(
            f"{folder}: another armsyn generate writes there: wait until it ends, or name another"
            " folder"
        ) from None
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise InputError(f"{folder}: cannot lock it: {error.strerror}") from error
