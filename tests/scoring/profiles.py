"""Speed profiles whose measures are known, and movements made from them."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
PHASE = np.linspace(0.0, 1.0, 101)


def minimum_jerk(phase: Array) -> Array:
    return 30 * phase**2 - 60 * phase**3 + 30 * phase**4


def two_submovements(phase: Array) -> Array:
    return np.where(phase <= 0.5, minimum_jerk(2 * phase), minimum_jerk(2 * phase - 1))


def trapezoid(phase: Array) -> Array:
    return np.minimum(1.0, np.minimum(3 * phase, 3 * (1 - phase)))


# Name: profile, time to peak, peak over mean, r, R2, SPARC, LDLJ (monalysa 0.2.1, 100 Hz, 1 s).
PROFILES = {
    "minimum jerk": (minimum_jerk(PHASE), 0.50, 1.875, 1.0, 1.0, -1.4058, -5.3016),
    "cubic": (6 * PHASE * (1 - PHASE), 0.50, 1.500, 0.9743, 0.8697, -1.5832, -4.1787),
    "cosine": (np.sin(np.pi * PHASE), 0.50, 1.571, 0.9856, 0.9138, -1.5623, -3.9155),
    "septic": (140 * PHASE**3 * (1 - PHASE) ** 3, 0.50, 2.1875, 0.9899, 0.9316, -1.4054, -5.4839),
    "trapezoid": (trapezoid(PHASE), None, 1.500, 0.9801, 0.9166, -1.5947, -6.9376),
    "decay": (np.exp(-5 * PHASE), 0.0, 5.033, -0.454, -5.44, -1.5491, -4.1150),
    "beta": (60 * PHASE**2 * (1 - PHASE) ** 3, 0.40, 2.074, 0.8783, 0.7038, -1.4125, -5.6312),
    "two": (two_submovements(PHASE), 0.25, 1.875, 0.0837, -0.83, -2.2445, -8.0732),
}


def reach(
    rate: float, duration: float = 0.8, rest: float = 0.5, length: float = 0.3
) -> tuple[Array, Array]:
    """Return times and hand positions of a straight minimum-jerk reach between two rests."""
    time = np.arange(0.0, duration + 2 * rest + 1e-9, 1 / rate)
    phase = np.clip((time - rest) / duration, 0.0, 1.0)
    travelled = length * (10 * phase**3 - 15 * phase**4 + 6 * phase**5)
    return time, np.outer(travelled, [2 / 3, 1 / 3, 2 / 3])
