"""What every predictor gives: whole reaches over normalised time, and how long they take."""

from __future__ import annotations

import reprlib
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import InputError
from armsyn.kinematics import SerialChain

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

REACHED_M = 1e-3
"""A predicted reach that ends within this distance of its target has reached it."""


@dataclass(frozen=True)
class Predicted:
    """Reaches to M targets.

    Parameters
    ----------
    angles : array, shape (M, PHASES, n)
        Joint angles over normalised time, from the given start, rad or m.
    durations : array, shape (M,)
        The movement time a person would take, s.
    outside : array, shape (M,)
        How far the target lies outside the hull of the captured ones, m; 0 inside.
    errors : array, shape (M,)
        Distance of the hand to the target at the end, m.
    """

    angles: FloatArray
    durations: FloatArray
    outside: FloatArray
    errors: FloatArray

    @property
    def reached(self) -> BoolArray:
        """Which reaches end within `REACHED_M` of their targets, shape (M,)."""
        return np.asarray(self.errors <= REACHED_M)


class Predictor(Protocol):
    """Predicts how a person would reach, on one chain."""

    @property
    def name(self) -> str:
        """As `armsyn.planning.predictor.learn_predictor` knows it."""

    @property
    def chain(self) -> SerialChain:
        """What moves; its tip is the hand."""

    def predict(self, starts: FloatArray, targets: FloatArray) -> Predicted:
        """Predict M reaches.

        Parameters
        ----------
        starts : array, shape (M, n)
            Postures to start from, rad or m.
        targets : array, shape (M, 3)
            Where the hand is to end, base frame, m.

        Returns
        -------
        Predicted

        Raises
        ------
        InputError
            Wrong shapes, or not finite.
        """


def real_numbers(given: ArrayLike, what: str) -> FloatArray:
    """Return something given as an array of its own, of any shape.

    Parameters
    ----------
    given : array_like
    what : str
        What it is, for people, such as "a target".

    Raises
    ------
    InputError
        Text, complex numbers, lists of different lengths, or integers beyond what a float holds.
    """
    try:
        found = np.asarray(given)
        if not np.iscomplexobj(found):
            return np.array(found, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{what} is made of real numbers, got {_short(given)}") from error
    raise InputError(f"{what} is made of real numbers, got {_short(given)}")


def _short(given: object) -> str:
    """Return one line of it."""
    return reprlib.repr(given).replace("\n", " ")


def checked_reaches(
    chain: SerialChain, starts: ArrayLike, targets: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return starts, shape (M, n), and targets, shape (M, 3), as arrays.

    Raises
    ------
    InputError
        Other shapes, no numbers, or not finite; the first such reach is named by its index.
    """
    first, goals = real_numbers(starts, "a start"), real_numbers(targets, "a target")
    if goals.ndim != 2 or goals.shape[1:] != (3,) or first.shape != (len(goals), chain.dof):
        raise InputError(
            f"M reaches need starts of shape (M, {chain.dof}) and targets of shape (M, 3),"
            f" got {first.shape} and {goals.shape}"
        )
    finite = np.isfinite(first).all(axis=1) & np.isfinite(goals).all(axis=1)
    if not finite.all():
        raise InputError(f"reach {int(np.argmin(finite))}: start and target must be finite numbers")
    return first, goals
