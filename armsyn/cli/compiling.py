"""Tell people that something is compiled, where that takes long."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import click
from numba.core.event import Event, Listener, install_listener

PATIENCE_S = 2.0
"""Of less compilation than that nothing is said."""


class _Teller(Listener):
    """Says once that something is compiled, if that takes long; what is cached is not."""

    def __init__(self) -> None:
        words = "compiling what plans reaches (once; a minute or two)"
        self.timer = threading.Timer(PATIENCE_S, click.echo, (words,), {"err": True})
        self.timer.daemon = True

    def on_start(self, event: Event) -> None:
        """A compilation begins."""
        del event
        if self.timer.ident is None:
            self.timer.start()

    def on_end(self, event: Event) -> None:
        """A compilation ends: nothing to be said."""


@contextmanager
def telling_of_compilation() -> Iterator[None]:
    """Say on standard error that kernels are compiled, when they are and it takes long."""
    teller = _Teller()
    with install_listener("numba:compile", teller):
        try:
            yield
        finally:
            teller.timer.cancel()
