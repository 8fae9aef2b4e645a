"""What moves the axes: a common interface, and independent joints behind it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from firmware_sim.physics import kernel
from firmware_sim.physics.axis import Axes

SUPPLY_RESISTANCE = 0.03
"""Of a supply with its cables, ohm; chosen: an ampere costs 30 mV."""


class Plant(Protocol):
    """Axes and the mechanics between them."""

    axes: Axes

    def advance(self, steps: int) -> None:
        """Go on by a number of steps of `kernel.STEP`."""


def make_supplies(resistances: Sequence[float]) -> kernel.FloatArray:
    """Return the table of supplies that the kernel works with.

    Parameters
    ----------
    resistances : sequence of float
        Of each source with its cables, ohm.

    Returns
    -------
    ndarray of float, shape (supplies, kernel.SUPPLY_COLUMNS)
    """
    supplies = np.zeros((len(resistances), kernel.SUPPLY_COLUMNS))
    supplies[:, kernel.SOURCE_RESISTANCE] = resistances
    return supplies


class JointsPlant:
    """Joints that know nothing of each other but their supply.

    Parameters
    ----------
    axes : Axes
        What is moved.
    supply_resistance : float or sequence of float
        Of each supply, ohm; one figure for a single supply.
    """

    def __init__(
        self, axes: Axes, supply_resistance: float | Sequence[float] = SUPPLY_RESISTANCE
    ) -> None:
        self.axes = axes
        self._state = axes.state
        if isinstance(supply_resistance, Sequence):
            self._supplies = make_supplies(supply_resistance)
        else:
            self._supplies = make_supplies([supply_resistance])

    def advance(self, steps: int) -> None:
        """Go on by a number of steps of `kernel.STEP`."""
        kernel.advance(self._state, self._supplies, steps)
