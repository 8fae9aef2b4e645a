"""What the command says, where those who listen may be gone."""

from __future__ import annotations

import os
import sys

from firmware_sim.errors import OutputError


def complain(text: str) -> None:
    """Write a line to standard error; where that is closed or full, there is nobody to tell."""
    if sys.stderr is None:
        return
    try:
        print(f"firmware-sim: {text}", file=sys.stderr, flush=True)
    except (OSError, ValueError):
        _forget(sys.stderr.fileno())


def say(text: str) -> None:
    """Write lines to standard output.

    Raises
    ------
    OutputError
        If it is closed, full, or a pipe that nobody reads.
    """
    if sys.stdout is None:
        raise OutputError("standard output is closed", "standard output")
    try:
        print(text, flush=True)
    except OSError as error:
        _forget(sys.stdout.fileno())
        raise OutputError(
            f"standard output cannot be written: {error.strerror}", "standard output"
        ) from error


def _forget(descriptor: int) -> None:
    """Let what is still buffered go nowhere, or Python would complain of it at its end."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, descriptor)
    os.close(nowhere)
