"""Masses of a chain's links out of a URDF (wiki.ros.org/urdf/XML/link, ``<inertial>``)."""

from __future__ import annotations

from typing import Any, NamedTuple
from xml.etree.ElementTree import Element, fromstring

import numpy as np
from numpy.typing import NDArray

from armsyn.arm.link import InertiaDescription, check_inertia
from armsyn.errors import InputError
from armsyn.kinematics.rotation import from_rpy
from armsyn.kinematics.urdf_tree import UrdfTree

FloatArray = NDArray[np.float64]

_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


class _Body(NamedTuple):
    """Mass, centre and inertia about the centre, in the frame of the joint that moves it."""

    mass: float
    centre: FloatArray
    inertia: FloatArray


class _Placement(NamedTuple):
    position: FloatArray
    rotation: FloatArray


def read_masses(
    text: str, tree: UrdfTree, joints: tuple[str, ...]
) -> dict[str, dict[str, Any] | None]:
    """Masses that each joint of a chain moves, as far as the next one.

    What hangs on a link beside the chain (a gripper's fingers, a camera) counts with it, with its
    own joints at zero.

    Parameters
    ----------
    text : str
        The URDF; `tree` is of it.
    tree : UrdfTree
    joints : tuple of str
        The chain's moving joints, base to tip.

    Returns
    -------
    dict of str to dict or None
        For each joint a ``[joint.link]`` table; None where no link has a mass. Inertias that are
        zero throughout are left out.

    Raises
    ------
    InputError
        A mass, place or inertia that is no number, a negative mass, or an inertia that no body has.
    """
    elements = {link.get("name", ""): link for link in fromstring(text).findall("link")}  # noqa: S314
    masses: dict[str, dict[str, Any] | None] = {}
    for joint, beyond in zip(joints, (*joints[1:], None), strict=True):
        bodies = _bodies(elements, tree, joint, beyond)
        masses[joint] = _link(joint, bodies)
    return masses


def _bodies(
    elements: dict[str, Element], tree: UrdfTree, joint: str, beyond: str | None
) -> list[_Body]:
    """Bodies of all links that a joint moves and the next one of the chain does not."""
    first = next(link for link, above in tree.above.items() if above.name == joint)
    waiting = [(first, _Placement(np.zeros(3), np.eye(3)))]
    bodies = []
    for link, place in waiting:
        body = _body(link, elements[link], place)
        if body is not None:
            bodies.append(body)
        for below in tree.below[link]:
            if below.name != beyond:
                origin = _placement(f"joint {below.name}", below.element)
                waiting.append((below.child, _after(place, origin)))
    return bodies


def _body(name: str, link: Element, place: _Placement) -> _Body | None:
    inertial = link.find("inertial")
    mass = inertial.find("mass") if inertial is not None else None
    if inertial is None or mass is None:
        return None
    where = f"link {name}"
    kilograms = _numbers(where, mass, "value", 1)[0]
    if kilograms < 0.0:
        raise InputError(f"{where}: its mass is {kilograms:g}: none is below zero")
    origin = _after(place, _placement(where, inertial))
    moments = inertial.find("inertia")
    values = [0.0] * 6
    if moments is not None:
        values = [_numbers(where, moments, name, 1, (0.0,))[0] for name in _MOMENTS]
    xx, yy, zz, xy, xz, yz = values
    own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return _Body(kilograms, origin.position, origin.rotation @ own @ origin.rotation.T)


def _link(joint: str, bodies: list[_Body]) -> dict[str, Any] | None:
    mass = sum(body.mass for body in bodies)
    if mass <= 0.0:
        return None
    centre = np.asarray(sum(body.mass * body.centre for body in bodies)) / mass
    table: dict[str, Any] = {"mass": mass, "centre_of_mass": tuple(centre.tolist())}
    inertia = np.zeros((3, 3))
    for body in bodies:
        arm = body.centre - centre
        inertia += body.inertia + body.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    if not any(body.inertia.any() for body in bodies):
        return table
    found = InertiaDescription(
        *(float(inertia[place]) for place in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    )
    try:
        check_inertia(found)
    except InputError as error:
        raise InputError(f"joint {joint}: what it moves: {error}") from error
    table["inertia"] = {name: getattr(found, name) for name in ("xx", "yy", "zz", "xy", "xz", "yz")}
    return table


def _after(place: _Placement, origin: _Placement) -> _Placement:
    return _Placement(
        place.position + place.rotation @ origin.position, place.rotation @ origin.rotation
    )


def _placement(where: str, element: Element) -> _Placement:
    origin = element.find("origin")
    if origin is None:
        return _Placement(np.zeros(3), np.eye(3))
    none = (0.0, 0.0, 0.0)
    xyz = _numbers(where, origin, "xyz", 3, none)
    return _Placement(np.array(xyz), from_rpy(_numbers(where, origin, "rpy", 3, none)))


def _numbers(
    where: str, element: Element, attribute: str, count: int, default: tuple[float, ...] = ()
) -> tuple[float, ...]:
    text = element.get(attribute)
    if text is None and default:
        return default
    try:
        values = tuple(float(word) for word in (text or "").split())
    except ValueError:
        values = ()
    if len(values) != count or not np.isfinite(values).all():
        raise InputError(
            f"{where}: {attribute} of <{element.tag}> must be {count} finite"
            f" number{'s' if count > 1 else ''}, got {(text or '')[:80]!r}"
        )
    return values
