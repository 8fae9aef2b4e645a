"""Splines through keys, and easing in and out of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import ConstraintError

FloatArray = NDArray[np.float64]


def ease(share: ArrayLike) -> FloatArray:
    """Return 3 u^2 - 2 u^3, held at 0 below u = 0 and at 1 above u = 1."""
    u = np.clip(np.asarray(share, dtype=np.float64), 0.0, 1.0)
    return np.asarray(u * u * (3.0 - 2.0 * u))


@dataclass(frozen=True, eq=False)
class KochanekBartels:
    """An interpolating spline with tension, continuity and bias.

    Kochanek and Bartels, "Interpolating splines with local tension, continuity, and bias
    control" (SIGGRAPH 1984), with their correction of both tangents for uneven keys.

    Parameters
    ----------
    keys : array, shape (keys,)
        Frames, increasing; one or more.
    values : array, shape (keys, ...)
        What is interpolated.
    tension, continuity, bias : float
        In [-1, 1]; all 0 is the Catmull-Rom spline.

    Raises
    ------
    ConstraintError
        When the keys do not increase, or something is not finite or out of range.
    """

    keys: FloatArray
    values: FloatArray
    tension: float = 0.0
    continuity: float = 0.0
    bias: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "keys", np.asarray(self.keys, dtype=np.float64))
        object.__setattr__(self, "values", np.asarray(self.values, dtype=np.float64))
        if self.keys.ndim != 1 or len(self.keys) != len(self.values) or not len(self.keys):
            raise ConstraintError("a spline has as many values as keys, at least one")
        if not (np.diff(self.keys) > 0).all():
            raise ConstraintError(f"a spline's keys increase, not {self.keys.tolist()}")
        if not (np.isfinite(self.keys).all() and np.isfinite(self.values).all()):
            raise ConstraintError("a spline's keys and values are finite")
        for name in ("tension", "continuity", "bias"):
            if not -1.0 <= getattr(self, name) <= 1.0:
                raise ConstraintError(f"{name} {getattr(self, name):g} is not in [-1, 1]")

    def tangents(self) -> tuple[FloatArray, FloatArray]:
        """In-tangents DS and out-tangents DD at the keys, shapes as `values`, a segment each."""
        if len(self.keys) == 1:
            return np.zeros_like(self.values), np.zeros_like(self.values)
        t, c, b = self.tension, self.continuity, self.bias
        chords = np.diff(self.values, axis=0)
        before = np.concatenate([chords[:1], chords])  # ends: the one chord there is
        after = np.concatenate([chords, chords[-1:]])
        spans = np.diff(self.keys)
        earlier = np.concatenate([spans[:1], spans]).reshape(-1, *[1] * (self.values.ndim - 1))
        later = np.concatenate([spans, spans[-1:]]).reshape(earlier.shape)
        inward = (1 - t) / 2 * ((1 + b) * (1 - c) * before + (1 - b) * (1 + c) * after)
        outward = (1 - t) / 2 * ((1 + b) * (1 + c) * before + (1 - b) * (1 - c) * after)
        both = earlier + later
        return inward * 2.0 * earlier / both, outward * 2.0 * later / both

    def at(self, frames: ArrayLike) -> FloatArray:
        """Return the spline's values; the first and last value hold outside the keys.

        Parameters
        ----------
        frames : array_like, shape (frames,)

        Returns
        -------
        array, shape (frames, ...)
        """
        where = np.clip(np.asarray(frames, dtype=np.float64), self.keys[0], self.keys[-1])
        if len(self.keys) == 1:
            return np.repeat(self.values, where.size, axis=0)
        left = np.clip(np.searchsorted(self.keys, where, side="right") - 1, 0, len(self.keys) - 2)
        u = (where - self.keys[left]) / (self.keys[left + 1] - self.keys[left])
        u = u.reshape(-1, *[1] * (self.values.ndim - 1))
        inward, outward = self.tangents()
        return np.asarray(
            (2 * u**3 - 3 * u**2 + 1) * self.values[left]
            + (u**3 - 2 * u**2 + u) * outward[left]
            + (3 * u**2 - 2 * u**3) * self.values[left + 1]
            + (u**3 - u**2) * inward[left + 1]
        )
