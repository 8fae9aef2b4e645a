"""Baud rates as people write them: 57600, 1M, 57.6k."""

from __future__ import annotations

import re

import click

_RATE = re.compile(r"(\d+(?:\.\d+)?)([kM]?)")
_FACTORS = {"": 1.0, "k": 1e3, "M": 1e6}


class BaudType(click.ParamType[int]):
    """Bits a second, a whole number; with the suffix k or M, thousands or millions."""

    name = "baud rate"

    def convert(
        self, value: str | int, param: click.Parameter | None, ctx: click.Context | None
    ) -> int:
        """Bits a second of what was given; a usage error for what is no rate."""
        found = _RATE.fullmatch(str(value).strip())
        rate = float(found[1]) * _FACTORS[found[2]] if found else 0.0
        if rate < 1.0 or round(rate, 3) != round(rate):
            self.fail(f"{value!r} is no baud rate: such as 57600, 57.6k or 1M", param, ctx)
        return round(rate)


BAUD = BaudType()
