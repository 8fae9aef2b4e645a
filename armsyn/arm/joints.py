"""The joints and the tip of an arm's description."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from armsyn.arm.link import LinkDescription, Positive, Triple
from armsyn.arm.shapes import CapsuleDescription

NotNegative = Annotated[float, msgspec.Meta(ge=0)]

ACCELERATION_TIME = 0.004
"""Seconds in which a joint may come from no acceleration to its greatest, where no jerk is given:
less than a tick of a 200 Hz stream, which sees steps of acceleration as large as the limit."""


class JointDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A ``[[joint]]`` table.

    Attributes
    ----------
    name, kind, xyz, rpy, axis, lower, upper
        As in :class:`armsyn.kinematics.Joint`; m and rad.
    rest : float
        Where the joint stands at rest, rad or m.
    max_velocity : float
        Greatest planned speed, rad/s or m/s: 80 % of the servo's no-load speed.
    max_acceleration : float
        Greatest planned acceleration, rad/s2 or m/s2.
    link : LinkDescription or None
        What the joint moves, as a body: only a simulation of the whole arm needs it.
    shape : tuple of CapsuleDescription, or None
        What the joint's link fills (`armsyn.arm.shapes`); None for a stand-in.
    max_jerk : float or None
        Greatest planned jerk, rad/s3 or m/s3; None for `ACCELERATION_TIME`.
    """

    name: str
    axis: Triple
    lower: float
    upper: float
    rest: float
    max_velocity: Positive
    max_acceleration: Positive
    kind: Literal["revolute", "prismatic"] = "revolute"
    xyz: Triple = (0.0, 0.0, 0.0)
    rpy: Triple = (0.0, 0.0, 0.0)
    link: LinkDescription | None = None
    shape: Annotated[tuple[CapsuleDescription, ...], msgspec.Meta(max_length=100)] | None = None
    max_jerk: Positive | None = None


class TipDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The ``[tip]`` table: the hand in the last joint's frame, m and rad.

    Attributes
    ----------
    xyz, rpy : 3-tuple of float
    mass : float
        Of what sits at the tip, a tool or a payload, taken as a point, kg.
    """

    xyz: Triple
    rpy: Triple = (0.0, 0.0, 0.0)
    mass: NotNegative = 0.0
