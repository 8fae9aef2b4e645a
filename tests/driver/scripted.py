"""A pseudo-terminal that answers packets by a script, to send what no servo would."""

from __future__ import annotations

import os
import select
import threading
import tty
from collections.abc import Callable
from typing import Self

from armsyn.driver import protocol

HEADER = b"\xff\xff\xfd\x00"
Script = Callable[[bytes], bytes]


def status(servo_id: int, data: bytes = b"", error: int = 0) -> bytes:
    """A good status packet; the codec is tested against the manual elsewhere."""
    return protocol.packet(servo_id, 0x55, bytes([error]) + data)


def packet_size(buffer: bytes) -> int:
    """Bytes of the packet at a buffer's start, 0 while it is not whole."""
    size = 7 + buffer[5] + 256 * buffer[6] if len(buffer) >= 7 else 0
    return size if len(buffer) >= size else 0


class ScriptedPort:
    """Answers each instruction packet with what the script returns for it.

    `size_of` tells where packets end; by default those of Protocol 2.0.

    Attributes
    ----------
    path : str
        Of the port.
    requests : list of bytes
        Instruction packets received.
    """

    def __init__(self, script: Script, size_of: Callable[[bytes], int] = packet_size) -> None:
        self.script = script
        self._size_of = size_of
        self.requests: list[bytes] = []
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.path = os.ttyname(self._slave)
        self._wake, self._waker = os.pipe()
        self._thread = threading.Thread(target=self._serve)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        os.write(self._waker, b"x")
        self._thread.join()
        for descriptor in (self._master, self._slave, self._wake, self._waker):
            os.close(descriptor)

    def _serve(self) -> None:
        buffer = b""
        while True:
            ready, _, _ = select.select([self._master, self._wake], [], [])
            if self._wake in ready:
                return
            buffer += os.read(self._master, 4096)
            while end := self._size_of(buffer):
                request, buffer = buffer[:end], buffer[end:]
                self.requests.append(request)
                os.write(self._master, self.script(request))
