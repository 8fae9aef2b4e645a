"""Motions as numpy archives, without pickles.

Keys: `schema` ("armsyn-motion-1"), `time_s` (frames), `joint_names` with `angles_rad` (frames x
joints), `landmark_names` with `landmarks_m` (frames x landmarks x 3, NaN is a gap, the end effector
last), `filled` (frames x landmarks, whether a position was filled in; may be missing), `source`.
Angles or landmarks may be missing, not both. Everything else is ignored and not even read, so that
a recording may keep more beside them. The same motion is the same bytes.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import FormatError
from armsyn.motion.formats.archive import LARGEST_ARRAY, LARGEST_FILE, Archive, opened
from armsyn.motion.formats.files import replacing
from armsyn.motion.motion import FloatArray, Motion

__all__ = ["LARGEST_ARRAY", "LARGEST_FILE", "SCHEMA", "arrays_of", "read", "write"]

SCHEMA = "armsyn-motion-1"


def read(path: Path) -> Motion:
    """Read a motion from an npz file; see the module for its keys.

    Parameters
    ----------
    path : Path
        Of the file.

    Returns
    -------
    Motion
        Its source is the file's, else the file's name.

    Raises
    ------
    FormatError
        One line with the file and the key that is wrong.
    """
    with opened(path) as archive:
        if "schema" not in archive.keys:
            raise FormatError(f"{path}: no key 'schema': not a motion of armsyn")
        schema = archive.text("schema")
        if schema != SCHEMA:
            raise FormatError(f"{path}: schema '{schema[:40]}', expected '{SCHEMA}'")
        return _assemble(archive)


def _assemble(archive: Archive) -> Motion:
    path = archive.path
    time = archive.numbers("time_s")
    joints, angles = _part(archive, "joint_names", "angles_rad")
    marks, landmarks = _part(archive, "landmark_names", "landmarks_m")
    source = archive.text("source") if "source" in archive.keys else path.name
    if angles is not None and not np.isfinite(angles).all():
        raise FormatError(f"{path}: 'angles_rad' are not all finite")
    if landmarks is not None and np.isinf(landmarks).any():
        raise FormatError(f"{path}: 'landmarks_m' are not all finite or gaps")
    filled = archive.flags("filled") if "filled" in archive.keys else None
    try:
        return Motion(time, joints, angles, marks, landmarks, source, filled)
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from error


def _part(archive: Archive, names: str, values: str) -> tuple[tuple[str, ...], FloatArray | None]:
    if values not in archive.keys:
        return (), None
    return archive.names(names), archive.numbers(values)


def arrays_of(motion: Motion) -> dict[str, NDArray[Any]]:
    """Return a motion as the arrays that an archive holds, for a recording to add to.

    Parameters
    ----------
    motion : Motion
        Any.

    Returns
    -------
    dict of str to array
        By the module's keys, SI units.
    """
    arrays: dict[str, NDArray[Any]] = {"schema": np.array(SCHEMA), "time_s": motion.time}
    if motion.angles is not None:
        arrays["joint_names"] = np.array(motion.joint_names, dtype=np.str_)
        arrays["angles_rad"] = motion.angles
    if motion.landmarks is not None:
        arrays["landmark_names"] = np.array(motion.landmark_names, dtype=np.str_)
        arrays["landmarks_m"] = motion.landmarks
    if motion.filled is not None:
        arrays["filled"] = motion.filled
    return arrays | {"source": np.array(motion.source)}


def write(path: Path, motion: Motion, extra: dict[str, NDArray[Any]] | None = None) -> None:
    """Write a motion as an npz file; see the module for its keys.

    Parameters
    ----------
    path : Path
        Of the file; it appears whole or not at all.
    motion : Motion
        Any.
    extra : dict of str to array
        More keys, which `read` ignores.

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.savez(file, allow_pickle=False, **((extra or {}) | arrays_of(motion)))
