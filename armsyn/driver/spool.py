"""Rows that go to disk while they come in, off the loop that makes them.

The loop fills a chunk of memory and hands it to a thread, through a queue of a few chunks. A disk
that is slow or full never holds up the loop: what does not fit is dropped and counted, and the
first error is kept for the end. Memory stays the same however long it goes on.
"""

from __future__ import annotations

import queue
import tempfile
import threading
from pathlib import Path
from typing import IO, Any, Self

import numpy as np
from numpy.typing import NDArray

from armsyn.driver.joints import JointState
from armsyn.errors import InputError

CHUNK = 256
"""Rows that are handed over at once."""

WAITING = 16
"""Chunks that may wait for the disk."""


def row_type(joints: int) -> np.dtype[Any]:
    """One tick of an arm: SI units, as in `armsyn.driver.recording.Recording`."""
    each = (joints,)
    return np.dtype(
        [
            ("time", np.float64),
            ("position", np.float64, each),
            ("velocity", np.float64, each),
            ("current", np.float64, each),
            ("temperature", np.float32, each),
            ("voltage", np.float32, each),
            ("fresh", np.bool_, each),
            ("hardware_error", np.uint8, each),
        ]
    )


class Spool:
    """Rows on their way to a temporary file; a context manager that removes it in the end.

    Parameters
    ----------
    folder : Path
        Where the file is made.
    joints : int

    Attributes
    ----------
    rows, dropped : int
        Handed over so far, and lost to a disk that is slow or full.
    error : OSError or None
        The first that the disk answered with; rows after it are lost.

    Raises
    ------
    InputError
        No file can be made there.
    """

    def __init__(self, folder: Path, joints: int) -> None:
        self.rows = self.dropped = 0
        self.error: OSError | None = None
        self._type = row_type(joints)
        self._chunk = np.zeros(CHUNK, self._type)
        self._filled = 0
        self._queue: queue.Queue[NDArray[Any] | None] = queue.Queue(WAITING)
        self._closed = False
        try:
            self._file: IO[bytes] = tempfile.TemporaryFile(  # noqa: SIM115 - closed by `__exit__`
                dir=folder, buffering=0
            )
        except OSError as error:
            raise InputError(f"{folder}: cannot write there: {error.strerror}") from error
        self._thread = threading.Thread(target=self._write, name="armsyn spool", daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._close()
        self._file.close()

    def append(self, time: float, state: JointState, hardware_error: NDArray[np.uint8]) -> None:
        """Take a row; never waits.

        Parameters
        ----------
        time : float
            s.
        state : JointState
        hardware_error : array of uint8, shape (n,)
        """
        row = self._chunk[self._filled]
        row["time"] = time
        for name in ("position", "velocity", "current", "temperature", "voltage", "fresh"):
            row[name] = getattr(state, name)
        row["hardware_error"] = hardware_error
        self._filled += 1
        if self._filled == CHUNK:
            self._hand_over()

    def _hand_over(self) -> None:
        chunk = self._chunk[: self._filled].copy()
        self._filled = 0
        try:
            self._queue.put_nowait(chunk)
            self.rows += len(chunk)
        except queue.Full:
            self.dropped += len(chunk)

    def _write(self) -> None:
        while (chunk := self._queue.get()) is not None:
            if self.error is None:
                try:
                    self._write_all(chunk.tobytes())
                    continue
                except OSError as error:
                    self.error = error
            self.dropped += len(chunk)
            self.rows -= len(chunk)

    def _write_all(self, data: bytes) -> None:
        view = memoryview(data)
        while view:
            view = view[self._file.write(view) :]

    def _close(self) -> None:
        if not self._closed:
            self._closed = True
            self._hand_over()
            self._queue.put(None)
            self._thread.join()

    def read(self) -> NDArray[Any]:
        """Take no more rows, and return those that the disk has kept, of `row_type`."""
        self._close()
        self._file.seek(0)
        data = self._file.read()
        whole = len(data) // self._type.itemsize
        return np.frombuffer(data, self._type, count=whole)
