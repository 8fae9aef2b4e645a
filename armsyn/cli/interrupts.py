"""Ctrl-C and SIGTERM end every command alike, whatever is running when they come.

Python raises ``KeyboardInterrupt`` wherever it happens to be. Where that is a callback of a C
library, such as those that numba compiles with, Python prints it and throws it away: the library
goes on with half of what it asked for, and fails later with an error of its own, or not at all.
"""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_AGAIN_S = 0.2
"""After a lost interrupt another one follows, s: by then the callback has returned."""


class LostInterrupts:
    """Interrupts that were raised where Python throws them away.

    Attributes
    ----------
    any : bool
        Whether there was one: an unexpected error after it is its consequence.
    """

    def __init__(self) -> None:
        self.any = False
        self._again: threading.Timer | None = None
        self._hook = sys.unraisablehook

    def on_unraisable(self, lost: sys.UnraisableHookArgs) -> None:
        """Keep a lost interrupt, to raise it again; leave what else is lost to Python's own hook.

        Parameters
        ----------
        lost : sys.UnraisableHookArgs
        """
        if not issubclass(lost.exc_type, KeyboardInterrupt):
            self._hook(lost)
            return
        self.any = True
        self.forget()
        self._again = threading.Timer(_AGAIN_S, _interrupt)
        self._again.daemon = True
        self._again.start()

    def forget(self) -> None:
        """Raise nothing again: the command has ended."""
        if self._again is not None:
            self._again.cancel()


def _interrupt() -> None:
    """By a signal, which ends also what the main thread waits in."""
    main = threading.main_thread().ident
    if main is not None:
        signal.pthread_kill(main, signal.SIGINT)


@contextmanager
def interruptible() -> Iterator[LostInterrupts]:
    """Let SIGTERM end a command as Ctrl-C does, and let no interrupt get lost.

    Yields
    ------
    LostInterrupts
    """
    lost = LostInterrupts()
    before, hook = signal.signal(signal.SIGTERM, signal.default_int_handler), sys.unraisablehook
    sys.unraisablehook = lost.on_unraisable
    try:
        yield lost
    finally:
        lost.forget()
        sys.unraisablehook = hook
        signal.signal(signal.SIGTERM, before)
