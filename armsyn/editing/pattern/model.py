"""The motion pattern: mean motion, principal components and the examples' place among them.

    Psi = Psi_0 + alpha E    (second paper, Eqs. 3 and 4)

Psi stacks the poses of all frames. Lengths and angles share that vector, so lengths are first
multiplied by `radians_per_metre`; rows of E are orthonormal in those units. alpha is whitened:
a coefficient of 1 is one standard deviation of the examples along that component.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from armsyn.editing.figure import Clip, Figure
from armsyn.editing.pattern.branches import unwrapped_poses
from armsyn.editing.pattern.timing import normalised_poses
from armsyn.errors import PatternError

FloatArray = NDArray[np.float64]
NEGLIGIBLE = 2e-3
"""rad or m; a component that moves no joint farther by one standard deviation is noise, and edits
along it look far from the examples that are not."""
FEWEST_TO_PLACE = 3
"""Fewer components cannot lead a point to any place nearby."""


@dataclass(frozen=True, eq=False)
class MotionModel:
    """A learned motion pattern.

    Parameters
    ----------
    figure : Figure
        What moves.
    mean : array, shape (frames, n)
        Mean motion, rad and m.
    components : array, shape (m, frames, n)
        Rows of E: orthonormal in weighted units.
    sigma : array, shape (m,)
        Standard deviation of the examples along each, weighted units.
    radians_per_metre : float
        Weight of lengths against angles.
    duration : float
        Mean of the examples', s.
    names : tuple of str
        The examples.
    examples : array, shape (examples, m)
        Their whitened coefficients.
    shares : array, shape (rank,)
        Of the variance, of every component the examples have, the kept ones first.
    left_out_m : array, shape (examples,)
        Leave-one-out reconstruction error: mean distance of the bodies of each example from its
        reconstruction by a model of the others with as many components, m.
    inputs_sha256 : str
        Hash of the examples and options that it was learned from.
    seed : int
        Learning draws nothing at random; for what is later drawn from the model.
    """

    figure: Figure
    mean: FloatArray
    components: FloatArray
    sigma: FloatArray
    radians_per_metre: float
    duration: float
    names: tuple[str, ...]
    examples: FloatArray
    shares: FloatArray
    left_out_m: FloatArray
    inputs_sha256: str = ""
    seed: int = 0

    SCHEMA: ClassVar[str] = "armsyn-motion-model-1"

    @property
    def frames(self) -> int:
        """Number of frames N of the normalised motion."""
        return len(self.mean)

    @property
    def size(self) -> int:
        """Number of components m."""
        return len(self.sigma)

    @property
    def variance(self) -> float:
        """Share of the examples' variance that the components hold."""
        return float(self.shares[: self.size].sum())

    @cached_property
    def weights(self) -> FloatArray:
        """Of the pose vector's columns, shape (n,): rad a unit."""
        return np.where(self.figure.metres, self.radians_per_metre, 1.0)

    @cached_property
    def directions(self) -> FloatArray:
        """Pose change of one standard deviation a component, (m, frames, n), rad and m."""
        return np.asarray(self.sigma[:, None, None] * self.components / self.weights)

    @property
    def doubts(self) -> list[str]:
        """What speaks against editing by this model, a line each."""
        found = []
        if self.size < FEWEST_TO_PLACE:
            found.append(
                f"{self.size} component{'s' * (self.size > 1)} cannot lead a point to any place:"
                " keep more of the variance (--variance 1), or learn from more motions"
            )
        sizes = np.abs(self.directions).max(axis=(1, 2))
        return found + [
            f"component {place + 1} moves no joint by more than {1000 * sizes[place]:.2g} mrad"
            " or mm a standard deviation: edits along it count as far from the examples"
            for place in np.flatnonzero(sizes < NEGLIGIBLE)
        ]

    def poses(self, coefficients: FloatArray) -> FloatArray:
        """Return the motion of whitened coefficients (Eq. 3).

        Parameters
        ----------
        coefficients : array, shape (m,)

        Returns
        -------
        array, shape (frames, n)
            rad and m.
        """
        return self.mean + np.tensordot(coefficients, self.directions, 1)

    def coefficients(self, clip: Clip) -> FloatArray:
        """Return the whitened coefficients of a clip's projection on the components.

        Parameters
        ----------
        clip : BodyMotion or Motion
            The whole movement; it is normalised in time.

        Returns
        -------
        array, shape (m,)

        Raises
        ------
        PatternError
            When the clip is of another figure.
        """
        return self.coefficients_of(clip.time, self.figure.poses(clip))

    def coefficients_of(self, time: FloatArray, poses: FloatArray) -> FloatArray:
        """Return the whitened coefficients of poses, shape (captured, n), at times, s."""
        turns = self.figure.turns
        poses = normalised_poses(time, poses, turns, self.frames)
        poses = unwrapped_poses(poses, turns, self.mean[0])
        away = ((poses - self.mean) * self.weights).ravel()
        return np.asarray(self.components.reshape(self.size, -1) @ away / self.sigma)

    def directions_at(self, at: FloatArray) -> FloatArray:
        """Return the pose changes at phases of the motion, by cubic splines through its frames.

        A clip at another rate than the pattern so gets no step of its speed at each of the
        pattern's frames, which would be an acceleration that no arm can follow.

        Parameters
        ----------
        at : array, shape (instants,)
            In frames of the normalised motion (`pattern.timing.phases`).

        Returns
        -------
        array, shape (instants, m, n)
            rad and m a standard deviation.
        """
        values, nearest = self.directions.swapaxes(0, 1), np.round(at).astype(np.int64)
        whole = nearest == at
        if whole.all():
            return np.asarray(values[nearest])
        between = self._spline(at)
        between[whole] = values[nearest[whole]]
        return np.asarray(between)

    @cached_property
    def _spline(self) -> CubicSpline:
        """Through the directions, (frames, m, n)."""
        return CubicSpline(np.arange(self.frames), self.directions.swapaxes(0, 1))

    def nearest_example(self, coefficients: FloatArray) -> tuple[str, float]:
        """Return the example nearest to coefficients, shape (m,), and how far it is, sigma."""
        if not len(self.examples):
            raise PatternError("the pattern keeps no examples")
        gaps = np.linalg.norm(self.examples - coefficients, axis=1)
        nearest = int(np.argmin(gaps))
        return self.names[nearest], float(gaps[nearest])
