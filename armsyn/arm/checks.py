"""What the types of a description cannot say."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import msgspec

from armsyn.arm.link import InertiaDescription, check_inertia
from armsyn.arm.servos import check_servos
from armsyn.arm.shapes import check_shapes
from armsyn.errors import InputError

if TYPE_CHECKING:
    from armsyn.arm.description import ArmDescription

TIP = "tip"

GREATEST = 1e6
"""Of any number of a description: what is beyond is a slip, and would overflow further on."""


def check_description(arm: ArmDescription) -> None:
    """Refuse a description whose parts do not fit each other.

    Parameters
    ----------
    arm : ArmDescription

    Raises
    ------
    InputError
        A number that is not finite or beyond `GREATEST`; names, axes or limits that make no chain;
        a rest posture outside the limits; an inertia of no body; a landmark that is nowhere, or a
        hand that is not the tip; shapes (`check_shapes`) or servos (`check_servos`) that do not
        belong to the arm.
    """
    _check_numbers(arm)
    _ = arm.chain  # names, axes and limits
    for joint in arm.joint:
        if not joint.lower <= joint.rest <= joint.upper:
            raise InputError(f"joint {joint.name}: rest {joint.rest:g} is outside its limits")
        if joint.link is not None and joint.link.inertia is not None:
            _check_link(joint.name, joint.link.inertia)
    frames = {*arm.joint_names, TIP}
    for landmark, frame in arm.anatomy.items():
        if frame not in frames:
            raise InputError(f"landmark {landmark}: {frame!r} is neither a joint nor {TIP!r}")
    if not arm.anatomy or list(arm.anatomy.values())[-1] != TIP:
        raise InputError(f"landmarks: the last one is the hand and must be {TIP!r}")
    check_shapes(arm)
    if arm.servo:
        check_servos(arm)


def _check_link(joint: str, inertia: InertiaDescription) -> None:
    try:
        check_inertia(inertia)
    except InputError as error:
        raise InputError(f"joint {joint}: link: {error}") from None


def _check_numbers(arm: ArmDescription) -> None:
    """TOML knows nan and inf; no number of an arm may be one."""
    tables: list[tuple[str, msgspec.Struct]] = [("", arm), ("tip: ", arm.tip)]
    tables += [("base_shape: ", shape) for shape in arm.base_shape]
    tables += [(f"plane {plane.name}: ", plane) for plane in arm.plane]
    tables += [(f"box {box.name}: ", box) for box in arm.box]
    for joint in arm.joint:
        tables.append((f"joint {joint.name}: ", joint))
        tables += [(f"joint {joint.name}: shape: ", shape) for shape in joint.shape or ()]
        if joint.link is not None:
            tables.append((f"joint {joint.name}: link: ", joint.link))
        if joint.link is not None and joint.link.inertia is not None:
            tables.append((f"joint {joint.name}: link: inertia: ", joint.link.inertia))
    tables += [(f"servo {servo.id}: ", servo) for servo in arm.servo]
    if arm.gripper is not None:
        tables.append(("gripper: ", arm.gripper))
    for where, table in tables:
        for field, value in msgspec.structs.asdict(table).items():
            for x in value if isinstance(value, tuple) else (value,):
                if not isinstance(x, float) or abs(x) <= GREATEST:
                    continue
                fault = "is beyond any arm's" if math.isfinite(x) else "must be finite"
                raise InputError(f"{where}{field} {fault}, got {value}")
