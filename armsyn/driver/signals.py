"""Requests to stop: SIGINT, SIGTERM, or the program itself."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable
from types import FrameType
from typing import Any, Self

from armsyn.errors import ArmFaultError

SIGNALS = (signal.SIGINT, signal.SIGTERM)

STUCK_AFTER = 0.3
"""Seconds without a tick after which a stream is stuck in somebody's code: by then the servos' own
watchdog has stopped them."""

_Handler = Callable[[int, FrameType | None], Any] | int | None


class StopRequests:
    """Counts requests to stop, until they are met.

    While it is entered signals count too; it may be entered again meanwhile. They are taken over in
    the main thread only (Python delivers them nowhere else) and given back on leaving; a program
    that streams from another thread calls `request`, at any time.

    A stream that is stuck, because a function that it called does not return, heeds no requests.
    The second signal then breaks into that function with an ArmFaultError.

    Attributes
    ----------
    count : int
        Requests not yet met. 1: come to a stop and see to the arm. 2 or more: hold at once.
    park : bool
        Whether a stopped arm may go to its rest posture; without it, it holds where it stands.
    """

    def __init__(self) -> None:
        self.count = 0
        self.park = True
        self._last_beat: float | None = None
        self._previous: list[dict[signal.Signals, _Handler]] = []

    def request(self) -> None:
        """Ask to stop, as a signal does."""
        self.count += 1

    def met(self) -> None:
        """Forget the requests: what they asked for was done."""
        self.count = 0

    def beat(self) -> None:
        """Say that the stream goes on."""
        self._last_beat = time.monotonic()

    def rest(self) -> None:
        """Say that the stream is over: what comes now may take its time."""
        self._last_beat = None

    def __enter__(self) -> Self:
        if _in_main_thread():
            self._previous.append({n: signal.signal(n, self._on_signal) for n in SIGNALS})
        return self

    def __exit__(self, *_: object) -> None:
        self.rest()
        if not _in_main_thread():
            return
        for number, handler in self._previous.pop().items():
            # None: the handler was not set by Python; its default is the best that is known
            signal.signal(number, signal.SIG_DFL if handler is None else handler)

    def _on_signal(self, _number: int, _frame: FrameType | None) -> None:
        self.request()
        if self._last_beat is None or self.count < 2:
            return
        silence = time.monotonic() - self._last_beat
        if silence > STUCK_AFTER:
            raise ArmFaultError(
                f"asked to stop while the program had not come back to the stream for"
                f" {silence:.1f} s: a function called at each tick is stuck"
            )


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()
