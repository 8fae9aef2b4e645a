"""Joints of a description out of a URDF file: the ``[urdf]`` table.

In ``<arm>.toml``::

    [urdf]
    file = "my_arm.urdf"      # beside the description, or in a folder below it
    base = "base_link"        # link whose frame is the base; may be left out: the root
    tip = "hand_link"         # link whose frame is the hand; may be left out: the only end

The chain between the two gives joints, limits and the tip; ``<limit velocity>`` the greatest speed;
``<inertial>`` the links' masses. ``[[joint]]`` tables, found by their ``name``, say what a URDF
cannot (``rest``, ``max_acceleration``) and change what they name; so does ``[tip]``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from armsyn.arm.urdf_masses import read_masses
from armsyn.errors import DescriptionError, InputError
from armsyn.kinematics.urdf import MAXIMUM_BYTES, parse_urdf
from armsyn.kinematics.urdf_tree import read_tree

NEEDED = ("rest", "max_velocity", "max_acceleration")


class UrdfSource(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The ``[urdf]`` table.

    Attributes
    ----------
    file : str
        Relative to the description's folder, and inside of it.
    base, tip : str or None
        Links; None for the root, and for the only leaf.
    """

    file: str
    base: str | None = None
    tip: str | None = None


def with_urdf(document: dict[str, Any], folder: Path | None) -> dict[str, Any]:
    """Return a description's document with its URDF's joints in it, and no ``urdf``.

    Parameters
    ----------
    document : dict
        Of the TOML file. One without ``urdf`` is returned as it is.
    folder : Path or None
        Of the description; None where there is none, and no URDF can be named.

    Returns
    -------
    dict

    Raises
    ------
    InputError
        A path out of the folder, a URDF that cannot be used, a ``[[joint]]`` table of a joint that
        the chain does not have, or a joint that lacks what the URDF does not say.
    """
    if "urdf" not in document:
        return document
    try:
        source = msgspec.convert(document["urdf"], UrdfSource)
    except msgspec.ValidationError as error:
        raise InputError(f"urdf: {error}") from error
    file = _inside(folder, source.file)
    found = read_urdf(read_urdf_file(file), str(file), source.base, source.tip)
    merged = {**found, **{key: value for key, value in document.items() if key != "urdf"}}
    merged["joint"] = _merged_joints(found["joint"], document.get("joint", []))
    tip = document.get("tip", {})
    merged["tip"] = {**found["tip"], **tip} if isinstance(tip, dict) else tip
    return merged


def read_urdf(text: str, where: str, base: str | None, tip: str | None) -> dict[str, Any]:
    """Return ``joint`` and ``tip`` of a description as a URDF gives them.

    Parameters
    ----------
    text : str
    where : str
        The file, for messages.
    base, tip : str or None

    Returns
    -------
    dict
        ``joint``: a list of tables; ``tip``: a table.

    Raises
    ------
    InputError
        As `armsyn.kinematics.load_urdf`; a speed, mass or inertia that none can be.
    """
    chain = parse_urdf(text, where, base, tip)
    try:
        tree = read_tree(text)
        masses = read_masses(text, tree, chain.names)
        joints = {joint.name: joint for joint in tree.above.values()}
        speeds = {name: _speed(name, joints[name].element) for name in chain.names}
    except InputError as error:
        raise DescriptionError(f"{where}: {error}") from error
    tables = []
    for joint in chain.joints:
        table: dict[str, Any] = {
            key: getattr(joint, key)
            for key in ("name", "kind", "xyz", "rpy", "axis", "lower", "upper")
        }
        if speeds[joint.name] is not None:
            table["max_velocity"] = speeds[joint.name]
        if masses[joint.name] is not None:
            table["link"] = masses[joint.name]
        tables.append(table)
    return {"joint": tables, "tip": {"xyz": chain.tip_xyz, "rpy": chain.tip_rpy}}


def _speed(name: str, element: Any) -> float | None:
    """``<limit velocity>``; None where it is not given or 0, which many files have for unknown."""
    limit = element.find("limit")
    text = limit.get("velocity") if limit is not None else None
    try:
        speed = float(text) if text is not None else 0.0
    except ValueError:
        speed = -1.0
    if not 0.0 <= speed < float("inf"):
        raise InputError(f"joint {name}: velocity of <limit> must be a number, got {text!r}")
    return speed or None


def _merged_joints(found: list[dict[str, Any]], given: Any) -> list[dict[str, Any]]:
    names = [table["name"] for table in found]
    if not isinstance(given, list) or not all(isinstance(table, dict) for table in given):
        raise InputError("joint must be [[joint]] tables")
    changes: dict[str, dict[str, Any]] = {}
    for number, table in enumerate(given, 1):
        name = table.get("name")
        if name not in names:
            raise InputError(
                f"[[joint]] table {number}: name {name!r} is no joint of the URDF's chain:"
                f" {', '.join(names)}"
            )
        if name in changes:
            raise InputError(f"[[joint]] table {number}: joint {name} has one already")
        changes[name] = table
    merged = [{**table, **changes.get(table["name"], {})} for table in found]
    for table in merged:
        for key in NEEDED:
            if key not in table:
                raise InputError(
                    f"joint {table['name']}: {key} is missing, and the URDF does not say it:"
                    f" give it in a [[joint]] table with that name"
                )
    return merged


def _inside(folder: Path | None, name: str) -> Path:
    """A file in a folder or below, wherever links in its path lead."""
    if folder is None:
        raise InputError("urdf: a description that is not read from a file cannot name one")
    try:
        place = folder.resolve()
        file = (place / name).resolve()
        outside = Path(name).is_absolute() or not file.is_relative_to(place)
        if outside or not file.is_file():
            why = "is outside the description's folder" if outside else "is no file"
            raise InputError(f"urdf: file {name!r} {why}: name one in {folder}, relative to it")
    except (OSError, ValueError, RuntimeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"urdf: file {name!r} cannot be a path: {error}") from error
    return file


def read_urdf_file(file: Path) -> str:
    """Text of a URDF file; InputError for one that cannot be read, is too large or no text."""
    try:
        with file.open("rb") as stream:
            content = stream.read(MAXIMUM_BYTES + 1)
        if len(content) > MAXIMUM_BYTES:
            raise InputError(f"urdf: {file.name}: larger than {MAXIMUM_BYTES} bytes")
        return content.decode("utf-8-sig")
    except OSError as error:
        raise InputError(f"urdf: {file.name}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"urdf: {file.name}: is not UTF-8 text ({error.reason})") from error
