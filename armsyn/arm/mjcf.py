"""An arm as MJCF, MuJoCo's XML: bodies, joints, masses and shapes, without meshes.

The elements and attributes are those of MuJoCo's "XML Reference". What belongs to the servos (the
rotors' inertia, damping, friction) is left to whoever simulates them.
"""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from armsyn.arm.description import ArmDescription
from armsyn.arm.gravity import links_of
from armsyn.arm.joints import JointDescription, TipDescription
from armsyn.arm.link import LinkDescription, stand_in_inertia
from armsyn.arm.mjcf_shapes import add_shapes, text_of
from armsyn.errors import InputError

_JOINT_TYPES = {"revolute": "hinge", "prismatic": "slide"}
_POINT_RADIUS = 0.005
"""Of the ball that stands for a point mass at the tip, m: MuJoCo wants bodies with extent."""


def build_mjcf(arm: ArmDescription) -> str:
    """Return an arm's bodies as MJCF.

    Parameters
    ----------
    arm : ArmDescription
        Every joint with its link.

    Returns
    -------
    str
        One body a joint, both with the joint's name; the body's frame is the joint's, as in
        `SerialChain`. Joints end at the description's limits. The tip is the body ``tip``. Shapes
        touch where `armsyn.arm.solids` judges them.

    Raises
    ------
    InputError
        If a link's mass is missing, or a name cannot be written in XML.
    """
    links = _links(arm)
    root = ET.Element("mujoco", model=arm.name)
    ET.SubElement(root, "compiler", angle="radian", eulerseq="XYZ")
    ET.SubElement(root, "option", gravity=text_of(arm.gravity))
    parent = ET.SubElement(root, "worldbody")
    extents = [joint.xyz for joint in arm.joint[1:]] + [arm.tip.xyz]
    for joint, link, extent in zip(arm.joint, links, extents, strict=True):
        parent = _body(parent, joint)
        inertia = stand_in_inertia(link.mass, extent)
        if link.inertia is not None:
            inertia = link.inertia.matrix
        _inertial(parent, link.mass, link.centre_of_mass, inertia)
    _tip(parent, arm.tip)
    add_shapes(arm, root)
    ET.indent(root)
    # So that the text also fits between three quotation marks of a TOML file
    return ET.tostring(root, encoding="unicode").replace("'", "&#39;") + "\n"


def _links(arm: ArmDescription) -> list[LinkDescription]:
    for joint in arm.joint:
        if not joint.name.isprintable():
            raise InputError(f"{arm.name}: joint {joint.name!r}: this name cannot be written")
    return links_of(arm)


def _body(parent: ET.Element, joint: JointDescription) -> ET.Element:
    body = ET.SubElement(
        parent, "body", name=joint.name, pos=text_of(joint.xyz), euler=text_of(joint.rpy)
    )
    ET.SubElement(
        body,
        "joint",
        name=joint.name,
        type=_JOINT_TYPES[joint.kind],
        axis=text_of(joint.axis),
        limited="true",
        range=text_of((joint.lower, joint.upper)),
    )
    return body


def _tip(parent: ET.Element, tip: TipDescription) -> None:
    body = ET.SubElement(parent, "body", name="tip", pos=text_of(tip.xyz), euler=text_of(tip.rpy))
    if tip.mass > 0.0:
        ball = 0.4 * tip.mass * _POINT_RADIUS**2 * np.eye(3)
        _inertial(body, tip.mass, (0.0, 0.0, 0.0), ball)


def _inertial(
    body: ET.Element, mass: float, centre: Iterable[float], inertia: NDArray[np.float64]
) -> None:
    order = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    ET.SubElement(
        body,
        "inertial",
        pos=text_of(centre),
        mass=f"{mass:.12g}",
        fullinertia=text_of(inertia[place] for place in order),
    )
