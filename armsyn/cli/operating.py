"""What commands share that an operator gives beside an arm: questions, the bus, a progress bar."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

import click

from armsyn.cli.arm_options import Connection, arm_options, connected
from armsyn.cli.choices import FiniteRange
from armsyn.cli.prompts import person

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.driver.operate import Load
    from armsyn.driver.presence import Presence

Command = TypeVar("Command", bound=Callable[..., Any])

yes_option = click.option("--yes", is_flag=True, help="Do it without asking.")
rate_option = click.option(
    "--rate",
    "rate_hz",
    type=FiniteRange(10.0, 2000.0),
    default=100.0,
    show_default=True,
    help="Commands a second.",
)
consent_option = click.option(
    "--accept-no-watchdog",
    is_flag=True,
    help="Also move servos that do not stop by themselves when this program dies.",
)
own_process_option = click.option(
    "--own-process", is_flag=True, help="Move the arm in a process that this one cannot hold up."
)

__all__ = [
    "arm_options",
    "ask",
    "consent_option",
    "fall_text",
    "own_process_option",
    "present_arm",
    "print_json",
    "rate_option",
    "say",
    "yes_option",
]


def say(text: str, options: dict[str, Any]) -> None:
    """Tell people, beside a JSON document where that is asked for."""
    click.echo(text, err=options["as_json"])


def print_json(content: dict[str, Any]) -> None:
    """Print one JSON document."""
    import json

    click.echo(json.dumps(content, indent=2, allow_nan=False))


def ask(question: str, *, yes: bool) -> None:
    """Ask a person before something happens.

    Parameters
    ----------
    question : str
    yes : bool
        Answered already.

    Raises
    ------
    StopRequestedError
        The answer is no.
    InputError
        Nobody is there to answer.
    """
    from armsyn.errors import InputError, StopRequestedError

    if yes:
        return
    try:
        agreed = person().confirm(question)
    except click.Abort:
        raise InputError("nobody answers: nothing was done; --yes says yes") from None
    if not agreed:
        raise StopRequestedError("nothing was done")


@contextmanager
def present_arm(options: dict[str, Any]) -> Iterator[tuple[Connection, Presence]]:
    """Open an arm's bus and find who is there; servos that are missing are told of.

    Raises
    ------
    ServoMissingError
        Nobody answers.
    PortError
        The port cannot be opened.
    """
    from armsyn.driver.presence import find_present, require_somebody
    from armsyn.driver.transactions import Bus

    with connected(options) as there, closing(Bus(there.port, there.arm.servo[0].baud)) as bus:
        presence = find_present(bus, there.arm.servo)
        require_somebody(presence, there.arm.name)
        if presence.missing:
            click.echo(f"no answer from servo {presence.missing_titles}: left out", err=True)
        yield there, presence


def fall_text(arm: ArmDescription, loads: tuple[Load, ...] | None) -> str:
    """What people are told before joints are let go."""
    if loads is None:
        return f"where {arm.name} is, or what it weighs, is not known: whatever is raised will fall"
    if not loads:
        return "nothing is held up against its weight"
    named = ", ".join(f"{load.joint} (holds {load.torque:.1f} N m)" for load in loads)
    return f"what will fall: {named}; support the arm"
