"""An arm's collision shapes as MJCF: so that a limp simulated arm lies on what it falls upon.

Contacts are those of the pairs that `armsyn.arm.solids.Solids` judges and of no others, without
friction: real arms lie more firmly.
"""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree import ElementTree as ET

import numpy as np

from armsyn.arm.description import ArmDescription
from armsyn.arm.shapes import (
    BASE,
    BoxDescription,
    CapsuleDescription,
    PlaneDescription,
    capsules_of,
)
from armsyn.errors import InputError
from armsyn.kernels import distance
from armsyn.kinematics.rotation import turning_z_to

_NO_FRICTION = "1"
_SOLID = {"contype": "0", "conaffinity": "0", "condim": _NO_FRICTION}
"""Geoms meet in named pairs only."""


def add_shapes(arm: ArmDescription, root: ET.Element) -> None:
    """Add an arm's shapes, and what stands around it, to its bodies.

    Parameters
    ----------
    arm : ArmDescription
    root : Element
        Of `armsyn.arm.mjcf`, with a body of each joint's name.

    Raises
    ------
    InputError
        A plane's or box's name that cannot be written in XML.
    """
    world = root.find("worldbody")
    assert world is not None  # noqa: S101 - the caller has just made it
    bodies = {body.get("name"): body for body in root.iter("body")}
    capsules = _capsules(world, BASE, arm.base_shape)
    for row, joint in enumerate(arm.joint):
        capsules += _capsules(bodies[joint.name], joint.name, capsules_of(arm, row))
    planes = [_plane(world, plane) for plane in arm.plane]
    boxes = [_box(world, box) for box in arm.box]
    others = {distance.CAPSULE: capsules, distance.PLANE: planes, distance.BOX: boxes}
    contact = ET.SubElement(root, "contact")
    for kind, one, other in arm.solids.pairs.tolist():
        ET.SubElement(
            contact, "pair", geom1=capsules[one], geom2=others[kind][other], condim=_NO_FRICTION
        )


def _capsules(body: ET.Element, name: str, capsules: Iterable[CapsuleDescription]) -> list[str]:
    found = []
    for number, capsule in enumerate(capsules):
        kind, place = "capsule", {"fromto": text_of((*capsule.start, *capsule.end))}
        if np.allclose(capsule.start, capsule.end):
            kind, place = "sphere", {"pos": text_of(capsule.start)}
        place["size"] = text_of((capsule.radius,))
        found.append(_geom(body, f"{name} {number}", kind, place))
    return found


def _plane(world: ET.Element, plane: PlaneDescription) -> str:
    normal = turning_z_to(plane.normal)[:, 2]
    place = {"pos": text_of(plane.point), "zaxis": text_of(normal), "size": "0 0 0.1"}
    return _geom(world, plane.name, "plane", place)


def _box(world: ET.Element, box: BoxDescription) -> str:
    place = {
        "pos": text_of(box.centre),
        "euler": text_of(box.rpy),
        "size": text_of(0.5 * edge for edge in box.size),
    }
    return _geom(world, box.name, "box", place)


def _geom(body: ET.Element, name: str, kind: str, place: dict[str, str]) -> str:
    if not name.isprintable():
        raise InputError(f"{name!r}: this name cannot be written")
    ET.SubElement(body, "geom", {"name": name, "type": kind, **place, **_SOLID})
    return name


def text_of(numbers: Iterable[float]) -> str:
    """Numbers as MJCF's attributes have them."""
    return " ".join(f"{number:.12g}" for number in numbers)
