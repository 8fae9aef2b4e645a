"""A serial chain out of a URDF file (wiki.ros.org/urdf/XML/joint).

What a chain does not need (inertias, meshes, transmissions, soft limits) is not read.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal, cast
from xml.etree.ElementTree import Element

import numpy as np

from armsyn.errors import DescriptionError, InputError
from armsyn.kinematics.chain import Joint, SerialChain, Triple
from armsyn.kinematics.rotation import from_rpy, to_rpy
from armsyn.kinematics.urdf_tree import UrdfJoint, UrdfTree, read_tree

MAXIMUM_BYTES = 10_000_000
_KINDS: dict[str, Literal["revolute", "prismatic"]] = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
}
_ZERO: Triple = (0.0, 0.0, 0.0)
_Placement = tuple[Triple, Triple]


def load_urdf(path: str | Path, base: str | None = None, tip: str | None = None) -> SerialChain:
    """Read the chain between two links of a URDF file.

    Fixed joints become part of the next moving joint's origin, or of the tip. Continuous joints
    get the limits -pi and pi: one turn, so that every posture has one vector. A moving joint that
    lies beside the chain is left alone, whatever its kind.

    Parameters
    ----------
    path : str or Path
        UTF-8, without a document type declaration (no entity is ever expanded).
    base : str, optional
        Link whose frame is the chain's base frame; by default the root.
    tip : str, optional
        Link whose frame is the tip; by default the only leaf below `base`.

    Returns
    -------
    SerialChain

    Raises
    ------
    DescriptionError
        Unreadable or too large a file, not a URDF, links that form no tree, an unknown or
        ambiguous base or tip, or a joint on the chain that is planar, floating or a mimic, lacks
        its limits or has a number that is none; the message names file and joint.
    """
    file = Path(path)
    try:
        with file.open("rb") as stream:
            content = stream.read(MAXIMUM_BYTES + 1)
        if len(content) > MAXIMUM_BYTES:
            raise DescriptionError(f"{file}: larger than {MAXIMUM_BYTES} bytes")
        text = content.decode("utf-8-sig")
    except OSError as error:
        raise DescriptionError(f"{file}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise DescriptionError(f"{file}: is not UTF-8 text ({error.reason})") from error
    return parse_urdf(text, str(file), base, tip)


def parse_urdf(
    text: str, where: str, base: str | None = None, tip: str | None = None
) -> SerialChain:
    """Read the chain between two links of a URDF.

    Parameters
    ----------
    text : str
    where : str
        The file, for messages.
    base, tip : str, optional
        As for `load_urdf`.

    Returns
    -------
    SerialChain

    Raises
    ------
    DescriptionError
        As `load_urdf`.
    """
    try:
        tree = read_tree(text)
        start = tree.root if base is None else tree.known_link(base)
        end = tree.only_leaf(start) if tip is None else tree.known_link(tip)
        return _chain_of(tree, start, end)
    except InputError as error:
        # Names out of the file may hold line ends; messages are one line
        raise DescriptionError(f"{where}: {' '.join(str(error).split())}") from error


def _chain_of(tree: UrdfTree, base: str, tip: str) -> SerialChain:
    moving: list[Joint] = []
    waiting: list[_Placement] = []
    for joint in tree.joints_between(base, tip):
        waiting.append(
            (_triple(joint, "origin", "xyz", _ZERO), _triple(joint, "origin", "rpy", _ZERO))
        )
        if joint.kind != "fixed":
            moving.append(_moving_joint(joint, _composed(waiting)))
            waiting = []
    if not moving:
        raise InputError(f"no moving joint between link {base} and link {tip}: choose base and tip")
    return SerialChain(tuple(moving), *_composed(waiting))


def _moving_joint(joint: UrdfJoint, placement: _Placement) -> Joint:
    if joint.kind not in _KINDS:
        raise InputError(
            f"joint {joint.name}: {joint.kind!r} joints are not supported;"
            " choose base and tip so that it is not between them"
        )
    mimic = joint.element.find("mimic")
    if mimic is not None:
        raise InputError(
            f"joint {joint.name}: it mimics joint {mimic.get('joint')}, which is not supported;"
            " choose base and tip so that it is not between them"
        )
    axis = _triple(joint, "axis", "xyz", (1.0, 0.0, 0.0))
    lower, upper = _limits(joint)
    return Joint(joint.name, _KINDS[joint.kind], *placement, axis, lower, upper)


def _limits(joint: UrdfJoint) -> tuple[float, float]:
    if joint.kind == "continuous":
        return -np.pi, np.pi
    limit = joint.element.find("limit")
    if limit is None:
        raise InputError(f"joint {joint.name}: a {joint.kind} joint needs a <limit>")
    return _numbers(joint, limit, "lower", 1, (0.0,))[0], _numbers(
        joint, limit, "upper", 1, (0.0,)
    )[0]


def _composed(placements: list[_Placement]) -> _Placement:
    """One placement for several in a row; a single one keeps its numbers as written."""
    if len(placements) == 1:
        return placements[0]
    position, rotation = np.zeros(3), np.eye(3)
    for xyz, rpy in placements:
        position = position + rotation @ xyz
        rotation = rotation @ from_rpy(rpy)
    return cast(_Placement, (tuple(position.tolist()), tuple(to_rpy(rotation).tolist())))


def _triple(joint: UrdfJoint, tag: str, attribute: str, default: Triple) -> Triple:
    element = joint.element.find(tag)
    if element is None:
        return default
    return cast(Triple, _numbers(joint, element, attribute, 3, default))


def _numbers(
    joint: UrdfJoint, element: Element, attribute: str, count: int, default: tuple[float, ...]
) -> tuple[float, ...]:
    text = element.get(attribute)
    if text is None:
        return default
    try:
        values = tuple(float(word) for word in text.split())
    except ValueError:
        values = ()
    if len(values) != count or not np.isfinite(values).all():
        raise InputError(
            f"joint {joint.name}: {attribute} of <{element.tag}> must be {count} finite"
            f" number{'s' if count > 1 else ''}, got {text[:80]!r}"
        )
    return values
