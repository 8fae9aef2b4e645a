"""What the tests of public clients share: a port, patience, and a list of what was called."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Iterator, Set
from contextlib import contextmanager
from typing import Any

import dynamixel_sdk as sdk

BAUD_RATE = 1_000_000
OK = (sdk.COMM_SUCCESS, 0)
SET_UP = ("--baud", str(BAUD_RATE), "--return-delay", "0")
"""Arguments of the command that set servos up as an arm's set-up leaves them."""

STICKS = 3
"""How far from its goal friction may leave a horn with the factory's gains, ticks of 4096."""

_PATIENCE = 10.0


@contextmanager
def opened(name: str) -> Iterator[sdk.PortHandler]:
    """Open a port as the SDK does, and close it afterwards."""
    port = sdk.PortHandler(name)
    assert port.openPort()
    assert port.setBaudRate(BAUD_RATE)
    try:
        yield port
    finally:
        port.closePort()


def until(holds: Callable[[], bool]) -> None:
    """Ask until something holds; fail where it never does."""
    deadline = time.monotonic() + _PATIENCE
    while not holds():
        assert time.monotonic() < deadline, "waited in vain"


def le(value: int, size: int = 4) -> list[int]:
    """Return the bytes of a number as the SDK's groups take them."""
    return list(value.to_bytes(size, "little", signed=value < 0))


def signed(value: int, size: int = 4) -> int:
    """Return the number whose bytes the SDK read as if it had no sign."""
    return int.from_bytes(value.to_bytes(size, "little"), "little", signed=True)


def public(kind: type) -> set[str]:
    """Return the names of a class's public methods."""
    return {
        name for name in dir(kind) if not name.startswith("_") and callable(getattr(kind, name))
    }


class Recorder:
    """Stands before an object and notes which of its methods others call."""

    def __init__(self, target: Any) -> None:
        self.target = target
        self.called: set[str] = set()

    def __getattr__(self, name: str) -> Any:
        value = getattr(self.target, name)
        if callable(value):
            self.called.add(name)
        return value


class Ledger:
    """Which methods of a recorded object the tests say that they call; each test is held to it."""

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self.listed: set[str] = set()

    def calls(self, *names: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
        """Say what a test calls; it fails if it does not."""
        self.listed.update(names)

        def hold_to(test: Callable[..., None]) -> Callable[..., None]:
            @functools.wraps(test)
            def held(**fixtures: Any) -> None:
                self._recorder.called.clear()
                test(**fixtures)
                left_out: Set[str] = set(names) - self._recorder.called
                assert not left_out, f"never called: {left_out}"

            return held

        return hold_to
