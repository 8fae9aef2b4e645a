"""Skeletons and their motions as numpy archives: two layouts, told apart by their keys.

Exponential maps (``reach/garza``, ``jump/garza`` of the captures, and what `write` makes)
    ``joint`` names, ``parent`` indices, ``offset`` (m), ``prerot_xyzw``, ``motions`` (names) and,
    of each motion, ``NAME|t`` (s), ``NAME|expmap`` (frames x joints x 3, rad), ``NAME|root``
    (frames x 3, m), perhaps ``NAME|translation`` (frames x joints x 3, m, beyond the offsets). The
    local rotation of a joint is its pre-rotation times the exponential of its channel. ``up`` is
    the axis that points up; y is assumed, and said, where it is missing.

Quaternions (``golf``)
    ``parent`` and, of each motion, ``NAME|t``, ``NAME|local_pos`` (frames x joints x 3, m) and
    ``NAME|quat_xyzw``. A joint's mean local position is its offset, what it departs from that its
    translation, so nothing is refitted. With ``marker_label``, the landmarks are the motion's
    ``NAME|markers`` (m; NaN is a gap), else its joints. The skeleton there is left-handed (its
    left side lies where its right should be, and it is the markers' mirror image): its x is
    turned round, after which both agree. Joints have no names in the file; the tree of the golf
    captures gets those of its limbs, told by the markers beside them.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from armsyn.errors import FormatError, InputError
from armsyn.kinematics import quaternion
from armsyn.kinematics.rotation import from_quaternion_xyzw
from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion.body import BodyMotion
from armsyn.motion.formats.archive import Archive, opened
from armsyn.motion.formats.files import replacing
from armsyn.motion.formats.options import UPS, Reading, ReadOptions, fact, z_up
from armsyn.motion.motion import FloatArray, Motion

SCHEMA = "armsyn-body-1"
_SIDE_NAMES = ("clavicle", "shoulder", "elbow", "wrist")
_GOLF_NAMES = (
    *("pelvis", "spine", "chest", "neck", "head"),
    *(f"{side}_{joint}" for side in ("left", "right") for joint in _SIDE_NAMES),
    *(f"{side}_{joint}" for side in ("left", "right") for joint in ("hip", "knee", "ankle")),
    *("left_toe", "right_toe"),
)
_GOLF_PARENTS = (-1, 0, 1, 2, 3, 2, 5, 6, 7, 2, 9, 10, 11, 0, 13, 14, 0, 16, 17, 15, 18)
_RIGID = 1e-5
"""m; what a joint's local position may vary by and still count as a rigid offset (the archives
hold single precision)."""


def is_body(keys: frozenset[str]) -> bool:
    """Return whether an archive with these keys holds skeletons."""
    return "parent" in keys


def takes(path: Path) -> tuple[str, ...]:
    """Return the names of the motions in an archive; none when it holds no skeleton.

    Raises
    ------
    FormatError
        When it cannot be read.
    """
    with opened(path) as archive:
        return _takes(archive) if is_body(archive.keys) else ()


def _takes(archive: Archive) -> tuple[str, ...]:
    if "motions" in archive.keys:
        names = archive.names("motions")
        if len(set(names)) != len(names):
            raise FormatError(f"{archive.path}: 'motions' names a motion twice")
        return names
    return tuple(sorted(key.removesuffix("|t") for key in archive.keys if key.endswith("|t")))


def read(path: Path, options: ReadOptions) -> Reading:
    """Read one motion of an archive.

    Parameters
    ----------
    path : Path
    options : ReadOptions
        `take` and `up` are heard.

    Returns
    -------
    Reading

    Raises
    ------
    FormatError
        When no take is named and there are several, or there is none of that name; else one line
        with the file and the key that is wrong.
    """
    with opened(path) as archive:
        take = chosen(options.take, _takes(archive), path)
        said = _up(archive)
        up = options.up or said or "y"
        body = _body(archive, take, up)
        motion = _motion(archive, take, up, body)
    facts = {"take": take, "up": fact(up, options.up or said)}
    moving = _moving(body)
    if moving:
        facts["moving offsets"] = ", ".join(moving)
    return Reading(motion, facts, body)


def read_bodies(path: Path) -> dict[str, BodyMotion]:
    """Read every motion of an archive.

    Parameters
    ----------
    path : Path

    Returns
    -------
    dict of str to BodyMotion
        By the motion's name.

    Raises
    ------
    FormatError
        One line with the file and the key that is wrong.
    """
    with opened(path) as archive:
        up = _up(archive) or "y"
        return {take: _body(archive, take, up) for take in _takes(archive)}


def _up(archive: Archive) -> str | None:
    up = archive.text("up") if "up" in archive.keys else None
    if up is not None and up not in UPS:
        raise FormatError(f"{archive.path}: 'up' is '{up[:40]}', not one of {', '.join(UPS)}")
    return up


def _body(archive: Archive, take: str, up: str) -> BodyMotion:
    try:
        if f"{take}|local_pos" in archive.keys:
            return _quaternions(archive, take, up)
        return _exponential_maps(archive, take, up)
    except FormatError:
        raise
    except InputError as error:
        raise FormatError(f"{archive.path}: {take}: {error}") from error


def chosen(take: str | None, there: tuple[str, ...], path: Path) -> str:
    """Return the one motion that is wanted.

    Raises
    ------
    FormatError
        When that is none, or several: the message names them.
    """
    names = ", ".join(there[:6]) + (", ..." if len(there) > 6 else "")
    if take is None and len(there) == 1:
        return there[0]
    if take is None:
        raise FormatError(f"{path}: holds {len(there)} motions: name one, as FILE#TAKE: {names}")
    if take not in there:
        raise FormatError(f"{path}: no motion '{take[:60]}' in it; there are {names}")
    return take


def _parents(archive: Archive) -> tuple[int, ...]:
    values = archive.numbers("parent")
    if values.ndim != 1 or not np.isfinite(values).all():
        raise FormatError(f"{archive.path}: 'parent' is not a row of numbers")
    return tuple(int(value) for value in values)


def _shaped(archive: Archive, key: str, *shape: int) -> FloatArray:
    """Return finite numbers of a shape, in which -1 stands for any length."""
    values = archive.numbers(key)
    fits = len(shape) == values.ndim and all(
        wanted in (-1, there) for wanted, there in zip(shape, values.shape, strict=True)
    )
    if not fits or not np.isfinite(values).all():
        wanted = " x ".join("frames" if size == -1 else str(size) for size in shape)
        raise FormatError(
            f"{archive.path}: '{key}' has shape {values.shape}, expected finite {wanted}"
        )
    return values


def _exponential_maps(archive: Archive, take: str, up: str) -> BodyMotion:
    names, parents = archive.names("joint"), _parents(archive)
    count = len(names)
    before = _turned_frames(_unit(archive, "prerot_xyzw", count, 4), up)
    skeleton = Skeleton(names, parents, z_up(_shaped(archive, "offset", count, 3), up), before)
    moved = None
    if f"{take}|translation" in archive.keys:
        moved = z_up(_shaped(archive, f"{take}|translation", -1, count, 3), up)
    return BodyMotion(
        archive.numbers(f"{take}|t"),
        skeleton,
        z_up(_shaped(archive, f"{take}|expmap", -1, count, 3), up),
        z_up(_shaped(archive, f"{take}|root", -1, 3), up),
        moved,
        f"{archive.path.name} {take}",
    )


def _unit(archive: Archive, key: str, *shape: int) -> FloatArray:
    values = _shaped(archive, key, *shape)
    if np.abs(np.linalg.norm(values, axis=-1) - 1.0).max(initial=0.0) > 1e-3:
        raise FormatError(f"{archive.path}: '{key}' are not quaternions of unit length")
    return values


def _turned_frames(quaternions: FloatArray, up: str) -> FloatArray:
    """Rotations in our axes: a quaternion's vector is turned like any other."""
    vectors = z_up(quaternions[..., :3], up)
    return from_quaternion_xyzw(np.concatenate([vectors, quaternions[..., 3:]], axis=-1))


def _quaternions(archive: Archive, take: str, up: str) -> BodyMotion:
    parents = _parents(archive)
    count = len(parents)
    # Mirrored in x, a vector changes its x; the vector of a rotation, which is axial, y and z
    places = z_up(_shaped(archive, f"{take}|local_pos", -1, count, 3) * (-1, 1, 1), up)
    turns = quaternion.to_expmap(_unit(archive, f"{take}|quat_xyzw", -1, count, 4)) * (1, -1, -1)
    names = tuple(f"joint{index}" for index in range(count))
    if parents == _GOLF_PARENTS:
        names = _GOLF_NAMES
    offsets = places.mean(axis=0) if len(places) else np.zeros((count, 3))
    moved = places - offsets
    moved[:, 0] = 0.0  # the root's whole position is the root's channel
    rigid = np.abs(moved).max(initial=0.0) <= _RIGID
    return BodyMotion(
        archive.numbers(f"{take}|t"),
        Skeleton(names, parents, offsets),
        z_up(turns, up),
        places[:, 0],
        None if rigid else moved,
        f"{archive.path.name} {take}",
    )


def _moving(body: BodyMotion) -> list[str]:
    """Names of the joints that are moved beside being turned."""
    if body.translations is None:
        return []
    most = np.abs(body.translations).max(axis=(0, 2)).tolist()
    return [name for name, far in zip(body.skeleton.names, most, strict=True) if far > _RIGID]


def _motion(archive: Archive, take: str, up: str, body: BodyMotion) -> Motion:
    try:
        return _markers(archive, take, up, body) or body.as_motion()
    except FormatError as error:
        if str(error).startswith(str(archive.path)):
            raise
        raise FormatError(f"{archive.path}: {take}: {error}") from error


def _markers(archive: Archive, take: str, up: str, body: BodyMotion) -> Motion | None:
    key = f"{take}|markers"
    if key not in archive.keys or "marker_label" not in archive.keys:
        return None
    labels, positions = archive.names("marker_label"), archive.numbers(key)
    if np.isinf(positions).any() or positions.shape != (body.frames, len(labels), 3):
        raise FormatError(
            f"{archive.path}: '{key}' has shape {positions.shape}, expected"
            f" {body.frames} x {len(labels)} x 3 positions or gaps"
        )
    return Motion(
        body.time, landmark_names=labels, landmarks=z_up(positions, up), source=body.source
    )


def write(path: Path, body: BodyMotion) -> None:
    """Write a body's motion as an archive of exponential maps, z up, in double precision.

    Parameters
    ----------
    path : Path
        The file appears whole or not at all.
    body : BodyMotion

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    skeleton, take = body.skeleton, "motion"
    arrays = {
        "schema": np.array(SCHEMA),
        "up": np.array("z"),
        "joint": np.array(skeleton.names, dtype=np.str_),
        "parent": np.array(skeleton.parents),
        "offset": skeleton.offsets,
        "prerot_xyzw": quaternion.from_matrix(np.asarray(skeleton.prerotations)),
        "motions": np.array([take]),
        f"{take}|t": body.time,
        f"{take}|expmap": body.rotations,
        f"{take}|root": body.root,
    }
    if body.translations is not None:
        arrays[f"{take}|translation"] = body.translations
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)
