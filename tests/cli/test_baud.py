"""Baud rates as people give them."""

from __future__ import annotations

from collections.abc import Callable

import click
import pytest

from armsyn.cli.baud import BAUD
from tests.cli.commands import Outcome


@pytest.mark.parametrize(
    ("given", "rate"),
    [
        ("57600", 57_600),
        ("1M", 1_000_000),
        ("4.5M", 4_500_000),
        ("57.6k", 57_600),
        ("115.2k", 115_200),
        (1, 1),
    ],
)
def test_rates_with_a_suffix(given: str | int, rate: int) -> None:
    assert BAUD.convert(given, None, None) == rate


@pytest.mark.parametrize("given", ["", "M", "0", "-1", "1m", "1.5", "1e6", "nan", "1 M", "1MM"])
def test_what_is_no_rate_is_refused(given: str) -> None:
    with pytest.raises(click.BadParameter, match="is no baud rate: such as"):
        BAUD.convert(given, None, None)


@pytest.mark.parametrize("command", [("scan",), ("setup", "--arm", "koch")])
def test_commands_take_them(call: Callable[..., Outcome], command: tuple[str, ...]) -> None:
    call(*command, "--port", "/dev/nothing", "--baud", "fast").refused(2, "'fast' is no baud rate")
    call(*command, "--port", "/dev/nothing", "--baud", "1M").refused(3, "/dev/nothing")
