"""The signals that mean stop."""

from __future__ import annotations

import signal
from collections.abc import Callable
from types import FrameType


def catch_stops(handler: Callable[[int, FrameType | None], None]) -> None:
    """Let a handler have SIGINT, SIGTERM and, unless it is ignored as under nohup, SIGHUP."""
    numbers = [signal.SIGINT, signal.SIGTERM]
    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        numbers.append(signal.SIGHUP)
    for number in numbers:
        signal.signal(number, handler)
