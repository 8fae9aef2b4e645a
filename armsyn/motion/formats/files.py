"""Files as every format opens them: bounded when read, replaced as a whole when written."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from armsyn.errors import FormatError, InputError


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
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        yield temporary
        temporary.replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot write it: {error.strerror or error}") from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
