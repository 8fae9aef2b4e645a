"""Tell people that something is compiled, where that takes long."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import click
from numba.core.event import Event, Listener, install_listener

PATIENCE_S = 2.0
"""Of less compilation than that, all in all, nothing is said."""

WORDS = "compiling what plans reaches (once; up to a minute or two)"


class _Teller(Listener):
    """Says once that something is compiled, if that takes long; what is cached is not."""

    def __init__(self) -> None:
        self._left = PATIENCE_S
        self._inside = 0  # kernels that call others compile these on the way
        self._began = 0.0
        self._timer: threading.Timer | None = None
        self._told = False

    def on_start(self, event: Event) -> None:
        """A compilation begins."""
        del event
        self._inside += 1
        if self._inside == 1 and not self._told:
            self._began = time.monotonic()
            self._timer = threading.Timer(max(self._left, 0.0), self._tell)
            self._timer.daemon = True
            self._timer.start()

    def on_end(self, event: Event) -> None:
        """A compilation ends: while none is under way, nothing takes long for that."""
        del event
        self._inside -= 1
        if self._inside == 0:
            self._left -= time.monotonic() - self._began
            self.stop()

    def stop(self) -> None:
        """Say nothing any more."""
        if self._timer is not None:
            self._timer.cancel()

    def _tell(self) -> None:
        self._told = True
        click.echo(WORDS, err=True)


@contextmanager
def telling_of_compilation() -> Iterator[None]:
    """Say on standard error that kernels are compiled, when they are and it takes long."""
    teller = _Teller()
    with install_listener("numba:compile", teller):
        try:
            yield
        finally:
            teller.stop()
