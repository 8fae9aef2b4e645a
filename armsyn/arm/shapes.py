"""The shapes of an arm's description: what its links and the things around them fill.

In ``<arm>.toml``, m and rad::

    collision_ignore = [["table", "joint1"]]   # at the top: pairs that are not judged

    [[plane]]                     # what lies behind it is solid
    name = "table"
    point = [0.0, 0.0, 0.0]       # base frame
    normal = [0.0, 0.0, 1.0]      # out of the solid

    [[box]]
    name = "camera"
    centre = [0.3, 0.2, 0.25]     # base frame
    size = [0.05, 0.10, 0.50]
    rpy = [0.0, 0.0, 0.0]         # may be left out

    [[base_shape]]                # capsules of what does not move, base frame
    from = [0.0, 0.0, 0.0]
    to = [0.0, 0.0, 0.05]
    radius = 0.03

    [[joint]]                     # its capsules, if any, below its other keys
    ...
    [[joint.shape]]               # joint's frame, moves with the joint
    from = [0.0, 0.0, 0.0]
    to = [0.0, 0.0, -0.3]
    radius = 0.03

A joint without shapes gets a capsule of `STAND_IN_RADIUS` from its frame to the next joint's, or
the tip; ``shape = []`` says that there is none. Not judged are links next to each other (links
without shapes in between do not count) and others that one joint alone moves against each other:
its limits are their judge. Nor is what stands in ``collision_ignore`` (a link has its joint's name,
the base ``base``), nor pairs of links with a stand-in that touch at rest. Anything else that
touches at rest is refused, when a motion is checked for the first time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import numpy as np

from armsyn.arm.link import STAND_IN_RADIUS, Positive, Triple
from armsyn.errors import InputError

if TYPE_CHECKING:
    from armsyn.arm.description import ArmDescription

BASE = "base"

_SHORTEST_STAND_IN = 1e-6


class CapsuleDescription(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, rename={"start": "from", "end": "to"}
):
    """A ``[[joint.shape]]`` or ``[[base_shape]]`` table: a segment with a radius.

    Attributes
    ----------
    start, end : 3-tuple of float
        ``from`` and ``to``: the segment's ends, in the joint's or the base's frame, m.
    radius : float
        m; the ends are round.
    """

    start: Triple
    end: Triple
    radius: Positive


class PlaneDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A ``[[plane]]`` table: all behind it is solid.

    Attributes
    ----------
    name : str
    point, normal : 3-tuple of float
        In the base's frame, m; the normal points out of the solid and is made a unit vector.
    """

    name: str
    point: Triple
    normal: Triple


class BoxDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A ``[[box]]`` table.

    Attributes
    ----------
    name : str
    centre : 3-tuple of float
        In the base's frame, m.
    size : 3-tuple of float
        Edges, m.
    rpy : 3-tuple of float
        Orientation in the base's frame: fixed-axis roll, pitch, yaw, rad.
    """

    name: str
    centre: Triple
    size: tuple[Positive, Positive, Positive]
    rpy: Triple = (0.0, 0.0, 0.0)


def capsules_of(arm: ArmDescription, row: int) -> tuple[CapsuleDescription, ...]:
    """Capsules of the link behind a joint: those described, or a stand-in.

    Parameters
    ----------
    arm : ArmDescription
    row : int
        Of the joint, from 0.

    Returns
    -------
    tuple of CapsuleDescription
        In the joint's frame; none where the next joint's frame is at the same place.
    """
    shapes = arm.joint[row].shape
    if shapes is not None:
        return shapes
    beyond = arm.joint[row + 1].xyz if row + 1 < len(arm.joint) else arm.tip.xyz
    if np.linalg.norm(beyond) < _SHORTEST_STAND_IN:
        return ()
    return (CapsuleDescription((0.0, 0.0, 0.0), beyond, STAND_IN_RADIUS),)


def check_shapes(arm: ArmDescription) -> None:
    """Refuse shapes that make no sense.

    Raises
    ------
    InputError
        A name given twice, a normal without length, or a pair to be ignored of which one does
        not exist or that is one and the same.
    """
    things = [*(plane.name for plane in arm.plane), *(box.name for box in arm.box)]
    names = [*arm.joint_names, BASE, *things]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(
            f"{twice[0]!r} names two of joints, planes, boxes and the base: each needs its own name"
        )
    for plane in arm.plane:
        if not np.linalg.norm(plane.normal) > 1e-9:
            raise InputError(f"plane {plane.name}: its normal has no length")
    for pair in arm.collision_ignore:
        for name in pair:
            if name not in names:
                raise InputError(
                    f"collision_ignore: {name!r} is no joint, plane or box, and not {BASE!r}"
                )
        if pair[0] == pair[1]:
            raise InputError(f"collision_ignore: {pair[0]!r} stands beside itself")
