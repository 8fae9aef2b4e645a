"""Asking the person at the terminal, in one place, so that tests can play the person.

Questions go to standard error: standard output is for results.
"""

from __future__ import annotations

import select
import sys
from collections.abc import Callable, Mapping
from typing import Any, Protocol

import click

LOOK_EVERY = 0.01
"""Seconds from one look at the servos to the next, while the person is moving them."""

_SHOW_EVERY = 10
"""Looks from one picture on the terminal to the next."""


class Person(Protocol):
    """Who answers questions."""

    def say(self, text: str) -> None:
        """Tell something."""
        ...

    def confirm(self, question: str) -> bool:
        """Ask yes or no."""
        ...

    def ask(self, question: str) -> str:
        """Ask for a line; the answer in lower case, without blanks."""
        ...

    def watch(self, text: str, look: Callable[[], str]) -> None:
        """Ask for Enter, and look again and again until it comes, showing what is seen."""
        ...


class TerminalPerson:
    """The person at the terminal; at the end of the input, `click.Abort`."""

    def say(self, text: str) -> None:
        """Tell something."""
        click.echo(text, err=True)

    def confirm(self, question: str) -> bool:
        """Ask yes or no; no is the answer to Enter."""
        return self.ask(f"{question} [y/N]") in ("y", "yes")

    def ask(self, question: str) -> str:
        """Ask for a line."""
        click.echo(f"{question} ", err=True, nl=False)
        line = sys.stdin.readline()
        if not line:
            click.echo(err=True)
            raise click.Abort
        return line.strip().lower()

    def watch(self, text: str, look: Callable[[], str]) -> None:
        """Ask for Enter, and look until it comes."""
        from rich.console import Console
        from rich.live import Live
        from rich.text import Text

        click.echo(f"{text}, then press Enter", err=True)
        console = Console(stderr=True)
        with Live(console=console, transient=True, auto_refresh=False) as live:
            count = 0
            while not select.select([sys.stdin], [], [], LOOK_EVERY)[0]:
                seen = look()
                if console.is_terminal and count % _SHOW_EVERY == 0:
                    live.update(Text(seen), refresh=True)
                count += 1
        if not sys.stdin.readline():
            raise click.Abort
        look()


def next_command(name: str, options: Mapping[str, Any]) -> str:
    """A command for the same arm, to be named as the next step.

    Parameters
    ----------
    name : str
        Of the command, with what else belongs to it.
    options : mapping of str to object
        Of the command that has ended; ``arm_name`` and ``port``, and if given ``name`` and
        ``calibration``.
    """
    words = ["armsyn", name, "--arm", options["arm_name"], "--port", options["port"]]
    for option in ("name", "calibration"):
        if options.get(option) is not None:
            words += [f"--{option}", str(options[option])]
    return " ".join(words)


def person() -> Person:
    """Return who is asked; tests put another one here."""
    return TerminalPerson()
