"""Motions as numpy archives, without pickles.

Keys: `schema` ("armsyn-motion-1"), `time_s` (frames), `joint_names` with `angles_rad` (frames x
joints), `landmark_names` with `landmarks_m` (frames x landmarks x 3, NaN is a gap, the end effector
last), `source`. Angles or landmarks may be missing, not both. Everything else is ignored and not
even read, so that a recording may keep more beside them. The same motion is the same bytes.

Archives are read member by member: what a member claims to hold is compared with what it has
before memory is given to it.
"""

from __future__ import annotations

import lzma
import math
import tokenize
import zipfile
import zlib
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from armsyn.errors import FormatError
from armsyn.motion.formats.files import check_size, replacing
from armsyn.motion.motion import FloatArray, Motion

SCHEMA = "armsyn-motion-1"
LARGEST_FILE = 256 * 2**20
LARGEST_ARRAY = 256 * 2**20
"""Bytes; 2 hours at 200 Hz with 20 landmarks."""
_DAMAGE = (
    *(zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError, OSError),
    *(ValueError, TypeError, KeyError, SyntaxError, tokenize.TokenError),
    *(NotImplementedError, RuntimeError, OverflowError, MemoryError),
)
"""What zipfile and numpy raise on damaged, encrypted or foreign archives."""


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
    check_size(path, LARGEST_FILE)
    try:
        archive = zipfile.ZipFile(path)
    except _DAMAGE as error:
        raise FormatError(f"{path}: not a numpy archive, or cut: {_line(error)}") from error
    with archive:
        keys = {name.removesuffix(".npy") for name in archive.namelist()}
        if "schema" not in keys:
            raise FormatError(f"{path}: no key 'schema': not a motion of armsyn")
        schema = _text(archive, "schema", path)
        if schema != SCHEMA:
            raise FormatError(f"{path}: schema '{schema[:40]}', expected '{SCHEMA}'")
        return _assemble(archive, keys, path)


def _assemble(archive: zipfile.ZipFile, keys: set[str], path: Path) -> Motion:
    time = _numbers(archive, "time_s", path)
    joints, angles = _part(archive, keys, "joint_names", "angles_rad", path)
    marks, landmarks = _part(archive, keys, "landmark_names", "landmarks_m", path)
    source = _text(archive, "source", path) if "source" in keys else path.name
    if angles is not None and not np.isfinite(angles).all():
        raise FormatError(f"{path}: 'angles_rad' are not all finite")
    if landmarks is not None and np.isinf(landmarks).any():
        raise FormatError(f"{path}: 'landmarks_m' are not all finite or gaps")
    try:
        return Motion(time, joints, angles, marks, landmarks, source)
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from error


def _part(
    archive: zipfile.ZipFile, keys: set[str], names: str, values: str, path: Path
) -> tuple[tuple[str, ...], FloatArray | None]:
    if values not in keys:
        return (), None
    return _names(archive, names, path), _numbers(archive, values, path)


def _array(archive: zipfile.ZipFile, key: str, path: Path) -> NDArray[Any]:
    """Read one member, after its header has been compared with its size."""
    try:
        member = archive.getinfo(f"{key}.npy")
    except KeyError:
        raise FormatError(f"{path}: no key '{key}'") from None
    if member.file_size > LARGEST_ARRAY:
        raise FormatError(f"{path}: '{key}' has {member.file_size} bytes: cut the motion")
    try:
        with archive.open(member) as stream:
            shape, dtype = _header(stream)
            claimed = math.prod(shape) * dtype.itemsize
            if dtype.kind not in "fiuU" or stream.tell() + claimed != member.file_size:
                raise ValueError(f"{dtype} of shape {shape} in {member.file_size} bytes")
        with archive.open(member) as stream:
            array: NDArray[Any] = npy.read_array(stream, allow_pickle=False)
            return array
    except _DAMAGE as error:
        raise FormatError(f"{path}: '{key}' is damaged: {_line(error)}") from error


def _header(stream: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any]]:
    version = npy.read_magic(stream)
    reader = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, _, dtype = reader(stream)
    return shape, dtype


def _numbers(archive: zipfile.ZipFile, key: str, path: Path) -> FloatArray:
    array = _array(archive, key, path)
    if array.dtype.kind not in "fiu":
        raise FormatError(f"{path}: '{key}' holds {array.dtype}, expected numbers")
    return array.astype(np.float64)


def _names(archive: zipfile.ZipFile, key: str, path: Path) -> tuple[str, ...]:
    array = _array(archive, key, path)
    if array.dtype.kind != "U" or array.ndim != 1:
        raise FormatError(f"{path}: '{key}' holds {array.dtype}, expected a row of names")
    return tuple(_decoded(array, key, path))


def _text(archive: zipfile.ZipFile, key: str, path: Path) -> str:
    array = _array(archive, key, path)
    if array.dtype.kind != "U" or array.ndim != 0:
        raise FormatError(f"{path}: '{key}' holds {array.dtype}, expected text")
    return _decoded(array.reshape(1), key, path)[0]


def _decoded(array: NDArray[Any], key: str, path: Path) -> list[str]:
    try:
        texts: list[str] = array.tolist()
    except (ValueError, SystemError) as error:  # code points beyond Unicode
        raise FormatError(f"{path}: '{key}' is not text") from error
    return texts


def _line(error: BaseException) -> str:
    return (str(error) or type(error).__name__).splitlines()[0][:120]


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
