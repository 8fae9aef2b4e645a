"""How speeds are measured: options that every measuring command offers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from armsyn.cli.choices import FiniteRange


class _Cutoff(click.ParamType[float | None]):
    name = "hz|none"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float | None:
        if value == "none":
            return None
        try:
            cutoff = float(value)
        except ValueError:
            cutoff = -1.0
        if not 0 < cutoff < float("inf"):
            self.fail(f"{value!r} is neither a positive number of Hz nor 'none'", param, ctx)
        return cutoff


cutoff_option = click.option(
    "--cutoff",
    type=_Cutoff(),
    default="6",
    show_default=True,
    help="Of the zero-lag Butterworth low-pass on positions, the same for all.",
)


def measuring_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add ``--cutoff`` and ``--cut``, as `cutoff` (Hz or None) and `cut` (a fraction)."""
    cut = click.option(
        "--cut",
        type=FiniteRange(min=0, max=1, max_open=True),
        default=0.05,
        show_default=True,
        help="Share of the peak speed at which a movement begins and ends.",
    )
    return cutoff_option(cut(command))
