"""Mass, centre of mass and inertia of the link behind a joint."""

from __future__ import annotations

from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import InputError

FloatArray = NDArray[np.float64]
Triple = tuple[float, float, float]
Positive = Annotated[float, msgspec.Meta(gt=0)]

STAND_IN_RADIUS = 0.025
"""Of the cylinder that stands in for a link of unknown inertia, m: about a servo's width."""


class InertiaDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Inertia about the centre of mass, in the joint's frame, kg m2."""

    xx: Positive
    yy: Positive
    zz: Positive
    xy: float = 0.0
    xz: float = 0.0
    yz: float = 0.0

    @property
    def matrix(self) -> FloatArray:
        """The same, shape (3, 3)."""
        return np.array(
            [
                [self.xx, self.xy, self.xz],
                [self.xy, self.yy, self.yz],
                [self.xz, self.yz, self.zz],
            ]
        )


class LinkDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A ``[joint.link]`` table: what the joint moves, as far as the next joint.

    Attributes
    ----------
    mass : float
        With the servos that it carries, kg.
    centre_of_mass : 3-tuple of float
        In the joint's frame, m.
    inertia : InertiaDescription or None
        None where nobody knows it: `stand_in_inertia` then serves.
    """

    mass: Positive
    centre_of_mass: Triple
    inertia: InertiaDescription | None = None


def check_inertia(inertia: InertiaDescription) -> None:
    """Refuse an inertia that no body has.

    Raises
    ------
    InputError
        If a principal moment is not positive, or larger than the other two together.
    """
    low, middle, high = np.linalg.eigvalsh(inertia.matrix)
    if low <= 0.0 or high > (low + middle) * (1.0 + 1e-6):
        raise InputError(
            f"inertia: no body has principal moments of {low:.3g}, {middle:.3g} and {high:.3g}:"
            " each must be positive and at most the sum of the others"
        )


def stand_in_inertia(mass: float, extent: ArrayLike) -> FloatArray:
    """Inertia of a solid cylinder with the link's mass and length, or of a ball.

    Parameters
    ----------
    mass : float
        kg.
    extent : array_like, shape (3,)
        From the joint's frame to the next one's, m; the cylinder lies along it. Where it is
        shorter than the radius, `STAND_IN_RADIUS`, a solid ball of that radius is taken.

    Returns
    -------
    array, shape (3, 3)
        About the centre of mass, kg m2.
    """
    along = np.asarray(extent, dtype=np.float64)
    length = float(np.linalg.norm(along))
    if length < STAND_IN_RADIUS:
        return np.asarray(0.4 * mass * STAND_IN_RADIUS**2 * np.eye(3))
    axis = np.outer(along, along) / length**2
    about_axis = 0.5 * mass * STAND_IN_RADIUS**2
    across = mass * (3.0 * STAND_IN_RADIUS**2 + length**2) / 12.0
    return np.asarray(about_axis * axis + across * (np.eye(3) - axis))
