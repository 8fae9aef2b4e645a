"""A file that lines are written to without ever waiting for its disk."""

from __future__ import annotations

import threading
from io import FileIO
from pathlib import Path
from queue import SimpleQueue

from firmware_sim.errors import OutputError

BACKLOG_CAP = 16_000_000
"""Most bytes that wait for the disk."""

_END_PATIENCE = 5.0  # s for the last lines at the end


class TraceFile:
    """A text file written by a thread of its own.

    What the disk does not take is lost, counted and, once it takes something again, said in the
    file itself.

    Parameters
    ----------
    path : Path
        The file; it is not touched before `open`.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.problem = ""
        """Why the last write failed; empty while all is well."""
        self.lost_lines = 0
        self._waiting = 0
        self._said_lost = 0
        self._lock = threading.Lock()
        self._queue: SimpleQueue[bytes | None] = SimpleQueue()
        self._thread: threading.Thread | None = None

    def open(self) -> None:
        """Make the file, and write what waits; what it held before is gone.

        Raises
        ------
        OutputError
            If it cannot be made.
        """
        try:
            file = self.path.open("wb", buffering=0)
        except OSError as error:
            raise OutputError(
                f"{self.path} cannot be written: {error.strerror}", str(self.path)
            ) from error
        self._thread = threading.Thread(
            target=self._write_all, args=(file,), name="trace", daemon=True
        )
        self._thread.start()

    def write(self, text: str) -> None:
        """Take whole lines; returns at once."""
        data = text.encode()
        with self._lock:
            if self._waiting + len(data) > BACKLOG_CAP:
                self.lost_lines += text.count("\n")
                return
            self._waiting += len(data)
        self._queue.put(data)

    def close(self) -> None:
        """Write what waits, for a few seconds at most; may be called twice."""
        if self._thread is not None:
            self._queue.put(None)
            self._thread.join(_END_PATIENCE)
            self._thread = None

    def _write_all(self, file: FileIO) -> None:
        with file:
            while (data := self._queue.get()) is not None:
                self._write(file, data)
                with self._lock:
                    self._waiting -= len(data)

    def _write(self, file: FileIO, data: bytes) -> None:
        unsaid = self.lost_lines - self._said_lost
        note = f"# {unsaid} lines are missing here\n".encode() if unsaid else b""
        rest = note + data
        try:
            while rest:
                rest = rest[file.write(rest) :]
            self.problem = ""
            self._said_lost += unsaid
        except OSError as error:
            self.problem = f"{self.path} cannot be written: {error.strerror}"
            with self._lock:
                self.lost_lines += data.count(b"\n")
