"""The tree of links and joints that a URDF describes, checked to be one."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple
from xml.etree.ElementTree import Element, ParseError, fromstring

from armsyn.errors import InputError


class UrdfJoint(NamedTuple):
    """One ``<joint>`` and the links it connects."""

    name: str
    kind: str
    parent: str
    child: str
    element: Element


@dataclass(frozen=True)
class UrdfTree:
    """Links and joints of one robot.

    Attributes
    ----------
    root : str
        The only link without a parent.
    above : dict of str to UrdfJoint
        For every other link the joint that it is the child of.
    below : dict of str to list of UrdfJoint
        For every link the joints that it is the parent of.
    """

    root: str
    above: dict[str, UrdfJoint]
    below: dict[str, list[UrdfJoint]]

    def known_link(self, name: str) -> str:
        """Return `name`, or raise InputError when no link has it."""
        if name not in self.below:
            raise InputError(f"no link {name!r}; its links are {_listed(self.below)}")
        return name

    def only_leaf(self, base: str) -> str:
        """Return the only link without children at or below `base`; InputError names several."""
        leaves = [link for link in self.links_from(base) if not self.below[link]]
        if len(leaves) > 1:
            raise InputError(
                f"{len(leaves)} links end a chain from {base}: name one as tip: {_listed(leaves)}"
            )
        return leaves[0]

    def links_from(self, base: str) -> list[str]:
        """`base` and every link below it."""
        links = [base]
        for link in links:
            links.extend(joint.child for joint in self.below[link])
        return links

    def joints_between(self, base: str, tip: str) -> list[UrdfJoint]:
        """Joints from `base` down to `tip`; InputError when `tip` is not below `base`."""
        joints: list[UrdfJoint] = []
        link = tip
        while link != base:
            if link not in self.above:
                raise InputError(f"no chain leads from link {base} to link {tip}")
            joints.append(self.above[link])
            link = joints[-1].parent
        return joints[::-1]


def read_tree(text: str) -> UrdfTree:
    """Read a URDF's links and joints.

    Parameters
    ----------
    text : str

    Returns
    -------
    UrdfTree

    Raises
    ------
    InputError
        Malformed XML, a document type declaration, not a URDF, or links that form no tree.
    """
    robot = _root_element(text)
    links = [_named(element, "name", "a link") for element in robot.findall("link")]
    joints = [_joint(element) for element in robot.findall("joint")]
    _refuse_doubles("links", links)
    _refuse_doubles("joints", [joint.name for joint in joints])
    below: dict[str, list[UrdfJoint]] = {link: [] for link in links}
    above: dict[str, UrdfJoint] = {}
    for joint in joints:
        for link in (joint.parent, joint.child):
            if link not in below:
                raise InputError(f"joint {joint.name}: there is no link {link!r}")
        if joint.child in above:
            raise InputError(
                f"joint {joint.name}: link {joint.child} is already the child of joint"
                f" {above[joint.child].name}; loops are not supported"
            )
        above[joint.child] = joint
        below[joint.parent].append(joint)
    return _checked_tree(above, below)


def _checked_tree(above: dict[str, UrdfJoint], below: dict[str, list[UrdfJoint]]) -> UrdfTree:
    if not below:
        raise InputError("it has no links")
    roots = [link for link in below if link not in above]
    if len(roots) > 1:
        raise InputError(f"{len(roots)} links have no parent, one must: {_listed(roots)}")
    reached = UrdfTree(roots[0], above, below).links_from(roots[0]) if roots else []
    looped = below.keys() - set(reached)
    if looped:
        first = next(above[link] for link in below if link in looped)
        raise InputError(f"joint {first.name}: it is part of a loop of {_listed(sorted(looped))}")
    return UrdfTree(roots[0], above, below)


def _root_element(text: str) -> Element:
    # Entities can be declared nowhere else, and a file that declares them is an attack or no URDF
    for declaration in ("<!DOCTYPE", "<!ENTITY"):
        if declaration in text:
            raise InputError(f"it has a {declaration} declaration, which is not read: remove it")
    try:
        element = fromstring(text)  # noqa: S314  nothing to expand is left
    except ParseError as error:
        raise InputError(f"is not well-formed XML: {error}") from error
    if element.tag != "robot":
        raise InputError(f"is not a URDF: its root element is <{element.tag}>, not <robot>")
    return element


def _joint(element: Element) -> UrdfJoint:
    name = _named(element, "name", "a joint")
    kind = _named(element, "type", f"joint {name}:")
    ends = []
    for tag in ("parent", "child"):
        end = element.find(tag)
        if end is None:
            raise InputError(f"joint {name}: it has no <{tag}>")
        ends.append(_named(end, "link", f"joint {name}: its <{tag}>"))
    return UrdfJoint(name, kind, ends[0], ends[1], element)


def _named(element: Element, attribute: str, what: str) -> str:
    value = element.get(attribute)
    if not value:
        raise InputError(f"{what} has no {attribute!r}")
    return value


def _refuse_doubles(what: str, names: list[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise InputError(f"two {what} are named {name!r}")
        seen.add(name)


def _listed(names: Iterable[str]) -> str:
    ordered = list(names)
    more = f" and {len(ordered) - 12} more" if len(ordered) > 12 else ""
    return ", ".join(ordered[:12]) + more
