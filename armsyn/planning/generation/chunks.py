"""Chunks of a generation: each is made, written and noted down before the next.

A chunk is done once its note is there: what was written, how many reaches, which were refused. A
file takes its name when it is whole, and its note comes after it, so that a generation that was
ended in any way goes on with what has no note.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import ThreadpoolController

from armsyn.motion.formats.files import replacing
from armsyn.planning.generation.batch import Batch, make_batch
from armsyn.planning.generation.files import FORMATS
from armsyn.planning.generation.memory import keep_memory
from armsyn.planning.generation.order import Order, check_folder, unpacked
from armsyn.planning.generation.rows import write_rows


def make_chunk(order: Order, number: int) -> dict[str, Any]:
    """Make one chunk, unless it is there; return its note.

    Parameters
    ----------
    order : Order
    number : int

    Returns
    -------
    dict

    Raises
    ------
    InputError
        When it cannot be written, or the folder is not that of the order.
    """
    check_folder(order)
    if (done := noted(order, number)) is not None:
        return done
    first, last = order.span(number)
    keep_memory()
    with _linear_algebra().limit(limits=1):  # in several, sums may round otherwise
        batch = make_batch(order.recipe, first, last)
    file = order.file(number)
    if batch.index.size:
        remove(file)
        FORMATS[order.format][1](file, batch, order.recipe.arm, order.task)
    write_rows(order, number, batch)
    note = _note(order, number, batch, file if batch.index.size else None)
    with replacing(order.note(number)) as temporary:
        temporary.write_text(json.dumps(note, allow_nan=False) + "\n", encoding="utf-8")
    return note


def make_chunk_of(sent: bytes, number: int) -> dict[str, Any]:
    """`make_chunk` by an order as `sent_order` makes it; it is unpacked once a process."""
    return make_chunk(unpacked(sent), number)


@cache
def _linear_algebra() -> ThreadpoolController:
    return ThreadpoolController()


def noted(order: Order, number: int) -> dict[str, Any] | None:
    """Return the note of a chunk that is done; None for one that is not."""
    try:
        note = json.loads(order.note(number).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    if not isinstance(note, dict) or note.get("digest") != order.digest:
        return None
    if note["file"] is not None and not (Path(order.folder) / note["file"]).exists():
        return None
    return note if order.rows(number).exists() else None


def checked_note(order: Order, number: int) -> dict[str, Any] | None:
    """Return the note of a chunk that is done and whole; take the note of any other away.

    A loss of power may leave a file with its name but not its content.
    """
    note = noted(order, number)
    if note is None or note["file"] is None:
        return note
    if checksum(Path(order.folder) / note["file"]) == note["sha256"]:
        return note
    order.note(number).unlink()
    return None


def notes_of(order: Order) -> Iterator[dict[str, Any]]:
    """Give the notes of all chunks that are done, in their order."""
    for number in range(order.count):
        if (note := noted(order, number)) is not None:
            yield note


def _note(order: Order, number: int, batch: Batch, file: Path | None) -> dict[str, Any]:
    return {
        "digest": order.digest,
        "chunk": number,
        "file": None if file is None else file.name,
        "sha256": None if file is None else checksum(file),
        "first": order.span(number)[0],
        "reaches": int(batch.index.size),
        "frames": int(batch.paced.first[-1]),
        "outside": _outside(batch),
        "slowed": float(batch.paced.scales.sum()),
        "changed": [list(vars(change).values()) for change in batch.changed],
        "refused": [list(vars(refusal).values()) for refusal in batch.refused],
    }


def _outside(batch: Batch) -> int | None:
    """How many reaches go outside the captured workspace; None where none is known."""
    if np.isnan(batch.outside).any():
        return None
    return int(np.count_nonzero(batch.outside > 0.0))


def checksum(path: Path) -> str:
    """SHA-256 of a file; of a folder, that of its files' names and checksums."""
    if path.is_dir():
        files = sorted(entry for entry in path.rglob("*") if entry.is_file())
        lines = [f"{checksum(file)}  {file.relative_to(path).as_posix()}\n" for file in files]
        return hashlib.sha256("".join(lines).encode()).hexdigest()
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def remove(file: Path) -> None:
    """Remove a file or folder, if there is one."""
    if file.is_dir():
        shutil.rmtree(file)
    else:
        file.unlink(missing_ok=True)
