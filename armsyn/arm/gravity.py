"""What an arm's own weight asks of its joints."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.arm.link import LinkDescription
from armsyn.errors import InputError
from armsyn.kinematics.rotation import turning_z_to

if TYPE_CHECKING:
    from armsyn.arm.description import ArmDescription

FloatArray = NDArray[np.float64]


class Bodies(NamedTuple):
    """An arm's links and what sits at its tip, in frames whose z is the joint's axis.

    Attributes
    ----------
    placements : array, shape (n + 1, 4, 4)
        Fixed transforms from each frame to the next; the last is the tip's.
    centres : array, shape (n + 1, 4)
        Centres of mass in those frames, m, and 1.
    masses : array, shape (n + 1,)
        kg.
    carried : array, shape (n,)
        Mass of everything beyond each joint, kg.
    weight : array, shape (3,)
        Acceleration of free fall, m/s2.
    turned : array, shape (3, 3)
        ``d @ turned`` is the cross product of `weight` and d.
    """

    placements: FloatArray
    centres: FloatArray
    masses: FloatArray
    carried: FloatArray
    weight: FloatArray
    turned: FloatArray


def links_of(arm: ArmDescription) -> list[LinkDescription]:
    """The joints' links; InputError for a joint that has none."""
    found = []
    for joint in arm.joint:
        if joint.link is None:
            raise InputError(
                f"{arm.name}: joint {joint.name} has no mass: give it a [joint.link] table with"
                " mass and centre_of_mass"
            )
        found.append(joint.link)
    return found


def bodies_of(arm: ArmDescription) -> Bodies:
    """An arm's masses, made ready for `gravity_torque`; InputError for a joint without mass."""
    links = links_of(arm)
    arrays = arm.chain.arrays
    placements = np.tile(np.eye(4), (len(links) + 1, 1, 1))
    placements[:, :3, :3] = arrays.rotation
    placements[:, :3, 3] = arrays.translation
    centres = np.zeros((len(links) + 1, 4))
    centres[:, 3] = 1.0
    for row, (joint, link) in enumerate(zip(arm.joint, links, strict=True)):
        centres[row, :3] = turning_z_to(joint.axis).T @ link.centre_of_mass
    masses = np.array([*(link.mass for link in links), arm.tip.mass])
    weight = np.array(arm.gravity)
    turned = np.cross(weight, np.eye(3))
    return Bodies(placements, centres, masses, masses[::-1].cumsum()[:0:-1], weight, turned)


def gravity_torque(arm: ArmDescription, angles: ArrayLike) -> FloatArray:
    r"""Torques with which the joints' motors hold the arm still against its weight.

    Every joint carries what is beyond it: of mass :math:`M_j` and moment
    :math:`S_j = \sum m_i c_i` in the base's frame, a joint at :math:`p_j` with the axis
    :math:`z_j` must give :math:`z_j \cdot (g \times (S_j - M_j p_j))`, the centre of mass's
    transposed Jacobian times the weight (Siciliano et al., *Robotics*, section 7.1.2).

    Parameters
    ----------
    arm : ArmDescription
        Every joint with its link; the tip's mass counts.
    angles : array_like, shape (n,)
        rad or m.

    Returns
    -------
    array, shape (n,)
        N m about the joints' axes; N along those of prismatic joints.

    Raises
    ------
    InputError
        A joint without mass, or angles that are not n finite numbers.
    """
    q = arm.chain.checked_posture(angles)
    bodies, prismatic = arm.bodies, arm.chain.arrays.prismatic
    frames = _frames(bodies.placements, q, prismatic)
    centres = (frames @ bodies.centres[:, :, None])[:, :3, 0]
    moments = (bodies.masses[:, None] * centres)[::-1].cumsum(axis=0)[:0:-1]
    axes = frames[:-1, :3, 2]
    arms = moments - bodies.carried[:, None] * frames[:-1, :3, 3]
    torques = (axes * (arms @ bodies.turned)).sum(axis=1)
    if prismatic.any():
        return np.where(prismatic, -bodies.carried * (axes @ bodies.weight), torques)
    return np.asarray(torques)


def _frames(placements: FloatArray, q: FloatArray, prismatic: NDArray[np.bool_]) -> FloatArray:
    """Frames of the joints, after their own motion, and of the tip; shape (n + 1, 4, 4)."""
    moved = placements.copy()
    turns = np.where(prismatic, 0.0, q)[:, None]
    first, second = placements[:-1, :, 0], placements[:-1, :, 1]
    sines, cosines = np.sin(turns), np.cos(turns)
    moved[:-1, :, 0] = first * cosines + second * sines
    moved[:-1, :, 1] = second * cosines - first * sines
    moved[:-1, :, 3] += placements[:-1, :, 2] * np.where(prismatic, q, 0.0)[:, None]
    for row in range(1, len(moved)):
        moved[row] = moved[row - 1] @ moved[row]
    return moved
