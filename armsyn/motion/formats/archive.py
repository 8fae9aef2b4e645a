"""Numpy archives (npz) read member by member, without pickles.

What a member claims to hold is compared with what it has before memory is given to it, and members
that nobody asks for are not even read.
"""

from __future__ import annotations

import contextlib
import lzma
import math
import tokenize
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from armsyn.errors import FormatError
from armsyn.motion.formats.files import check_size
from armsyn.motion.motion import BoolArray, FloatArray

LARGEST_FILE = 256 * 2**20
LARGEST_ARRAY = 256 * 2**20
"""Bytes; 2 hours at 200 Hz with 20 landmarks."""
_DAMAGE = (
    *(zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError, OSError),
    *(ValueError, TypeError, KeyError, SyntaxError, tokenize.TokenError),
    *(NotImplementedError, RuntimeError, OverflowError, MemoryError),
)
"""What zipfile and numpy raise on damaged, encrypted or foreign archives."""


@contextlib.contextmanager
def opened(path: Path) -> Iterator[Archive]:
    """Open an archive.

    Parameters
    ----------
    path : Path

    Yields
    ------
    Archive

    Raises
    ------
    FormatError
        When it is missing, too large, or not a numpy archive.
    """
    check_size(path, LARGEST_FILE)
    try:
        file = zipfile.ZipFile(path)
    except _DAMAGE as error:
        raise FormatError(f"{path}: not a numpy archive, or cut: {_line(error)}") from error
    with file:
        yield Archive(file, path)


class Archive:
    """An open archive; every method raises FormatError with the file and the key.

    Parameters
    ----------
    file : ZipFile
    path : Path
        For messages.
    """

    def __init__(self, file: zipfile.ZipFile, path: Path) -> None:
        self._file = file
        self.path = path
        self.keys = frozenset(name.removesuffix(".npy") for name in file.namelist())

    def numbers(self, key: str) -> FloatArray:
        """Return an array of numbers."""
        array = self._array(key)
        if array.dtype.kind not in "fiu":
            raise FormatError(f"{self.path}: '{key}' holds {array.dtype}, expected numbers")
        return array.astype(np.float64)

    def flags(self, key: str) -> BoolArray:
        """Return an array of truths."""
        array = self._array(key)
        if array.dtype.kind != "b":
            raise FormatError(f"{self.path}: '{key}' holds {array.dtype}, expected true or false")
        return array

    def names(self, key: str) -> tuple[str, ...]:
        """Return a row of texts."""
        array = self._array(key)
        if array.dtype.kind != "U" or array.ndim != 1:
            raise FormatError(f"{self.path}: '{key}' holds {array.dtype}, expected a row of names")
        return tuple(self._decoded(array, key))

    def text(self, key: str) -> str:
        """Return one text."""
        array = self._array(key)
        if array.dtype.kind != "U" or array.ndim != 0:
            raise FormatError(f"{self.path}: '{key}' holds {array.dtype}, expected text")
        return self._decoded(array.reshape(1), key)[0]

    def _array(self, key: str) -> NDArray[Any]:
        """Read one member, after its header has been compared with its size."""
        try:
            member = self._file.getinfo(f"{key}.npy")
        except KeyError:
            raise FormatError(f"{self.path}: no key '{key}'") from None
        if member.file_size > LARGEST_ARRAY:
            raise FormatError(f"{self.path}: '{key}' has {member.file_size} bytes: cut the motion")
        try:
            with self._file.open(member) as stream:
                shape, dtype = _header(stream)
                claimed = math.prod(shape) * dtype.itemsize
                if math.prod(shape) * np.dtype(np.float64).itemsize > LARGEST_ARRAY:
                    raise ValueError(f"{math.prod(shape)} values: cut the motion")
                if dtype.kind not in "fiubU" or stream.tell() + claimed != member.file_size:
                    raise ValueError(f"{dtype} of shape {shape} in {member.file_size} bytes")
            with self._file.open(member) as stream:
                array: NDArray[Any] = npy.read_array(stream, allow_pickle=False)
                return array
        except _DAMAGE as error:
            raise FormatError(f"{self.path}: '{key}' is damaged: {_line(error)}") from error

    def _decoded(self, array: NDArray[Any], key: str) -> list[str]:
        try:
            texts: list[str] = array.tolist()
        except (ValueError, SystemError) as error:  # code points beyond Unicode
            raise FormatError(f"{self.path}: '{key}' is not text") from error
        return texts


def _header(stream: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any]]:
    version = npy.read_magic(stream)
    reader = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, _, dtype = reader(stream)
    return shape, dtype


def _line(error: BaseException) -> str:
    return (str(error) or type(error).__name__).splitlines()[0][:120]
