"""Files as every format opens them: bounded when read, replaced as a whole when written."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from armsyn.errors import FormatError, InputError

_TEMPORARY = re.compile(r"\.(.+)\.[a-z0-9_]{8}", re.DOTALL)
"""What `tempfile` calls temporaries with the prefixes given here."""


def check_size(path: Path, largest: int) -> int:
    """Look at a file before anything of it is read.

    Parameters
    ----------
    path : Path
        Of the file.
    largest : int
        Bytes that are allowed.

    Returns
    -------
    int
        Its size, bytes.

    Raises
    ------
    FormatError
        When there is no such regular file, or it is empty or larger.
    """
    try:
        size = path.stat().st_size
    except OSError as error:
        raise FormatError(f"{path}: cannot read it: {error.strerror}") from error
    if not path.is_file():
        raise FormatError(f"{path}: not a file")
    if size == 0:
        raise FormatError(f"{path}: the file is empty")
    if size > largest:
        raise FormatError(f"{path}: {size} bytes, more than the {largest} allowed: cut the motion")
    return size


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary file beside `path` that takes its place when the block ends well.

    Parameters
    ----------
    path : Path
        The file to write; its folder must exist.

    Yields
    ------
    Path
        What to write to. When the block raises, it is removed and `path` stays as it was.

    Raises
    ------
    InputError
        When the folder or the file cannot be written.
    """
    temporary: Path | None = None
    try:
        descriptor, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
        os.close(descriptor)
        temporary = Path(name)
        # mkstemp keeps others out; a result file is as readable as any the user makes.
        temporary.chmod(0o666 & ~_umask())
        yield temporary
        _keep(temporary)
        temporary.replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot write it: {error.strerror or error}") from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def folder_beside(path: Path) -> Iterator[Path]:
    """Yield a temporary folder beside `path`, which is removed with what is left in it.

    Parameters
    ----------
    path : Path
        What is being written; its folder must exist.

    Yields
    ------
    Path
        An empty folder on the same file system, from which a result can be renamed to `path`.

    Raises
    ------
    InputError
        When something cannot be written in the block.
    """
    temporary: Path | None = None
    try:
        temporary = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
        temporary.chmod(0o777 & ~_umask())
        yield temporary
    except OSError as error:
        raise InputError(f"{path}: cannot write it: {error.strerror or error}") from error
    finally:
        if temporary is not None:
            shutil.rmtree(temporary, ignore_errors=True)


@contextlib.contextmanager
def new_folder(path: Path) -> Iterator[Path]:
    """Yield a temporary folder beside `path` that becomes it when the block ends well.

    Parameters
    ----------
    path : Path
        The folder to make; it must not exist, or be empty.

    Yields
    ------
    Path
        The folder to write in. When the block raises, it is removed with all that is in it.

    Raises
    ------
    InputError
        When there is something at `path` already, or it cannot be written.
    """
    if path.exists() and not (path.is_dir() and not any(path.iterdir())):
        raise InputError(f"{path}: is there already: name a new folder, or remove it")
    with folder_beside(path) as temporary:
        yield temporary
        temporary.replace(path)


def left_behind(folder: Path) -> Iterator[tuple[Path, str]]:
    """Give what has the name of a temporary of this module, as a killed process leaves them.

    Parameters
    ----------
    folder : Path

    Yields
    ------
    tuple of (Path, str)
        A file or folder in it, and the name of what was being written so.
    """
    for path in folder.iterdir():
        if found := _TEMPORARY.fullmatch(path.name):
            yield path, found[1]


def _keep(path: Path) -> None:
    """Wait until a file is on the disk: else its name may outlive a loss of power without it."""
    descriptor = os.open(path, os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _umask() -> int:
    umask = os.umask(0)
    os.umask(umask)
    return umask
