"""Choices that several commands offer."""

from __future__ import annotations

import math
from typing import Any

import click

IKS = click.Choice(["svd", "jt", "njt", "dls"])
LEARNERS = click.Choice(["least-squares", "annealing", "cma", "evolution"])
MODELS = click.Choice(["A", "B", "C", "D"])
PLANS = click.Choice(["synergy", "latent", "linear", "minjerk"])


class FiniteRange(click.FloatRange):
    """A number within bounds; click's own takes NaN, which is neither below nor above any."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Read a number; refuse one out of the bounds, and what is none."""
        number = float(super().convert(value, param, ctx))
        if not math.isfinite(number):
            self.fail(f"{value!r} is not a finite number.", param, ctx)
        return number
