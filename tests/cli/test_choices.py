"""Numbers within bounds: what is no number is within none, whatever command asks for it."""

from __future__ import annotations

from collections.abc import Iterator

import click
import pytest

from armsyn.cli.choices import FiniteRange
from armsyn.cli.main import cli


def commands(group: click.Group, context: click.Context) -> Iterator[click.Command]:
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None
        if isinstance(command, click.Group):
            yield from commands(command, context)
        else:
            yield command


@pytest.mark.parametrize("text", ["nan", "-nan", "inf", "9.9", "1000.1", "ten"])
def test_what_is_no_number_within_the_bounds_is_refused(text: str) -> None:
    with pytest.raises(click.BadParameter):
        FiniteRange(10.0, 1000.0).convert(text, None, None)
    assert FiniteRange(10.0, 1000.0).convert("62.5", None, None) == 62.5


def test_no_option_of_any_command_takes_nan_for_a_number_within_its_bounds() -> None:
    bounded = [
        option.type
        for command in commands(cli, click.Context(cli))
        for option in command.params
        if isinstance(option.type, click.FloatRange)
    ]
    assert len(bounded) > 8
    assert all(isinstance(kind, FiniteRange) for kind in bounded)
