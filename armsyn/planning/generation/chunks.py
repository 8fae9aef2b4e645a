"""Chunks of a generation: each is made, written and noted down before the next.

A chunk is done once its note is there: what was written, how many reaches, which were refused. A
file takes its name when it is whole, and its note comes after it, so that a generation that was
ended in any way goes on with what has no note.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import ThreadpoolController

import armsyn
from armsyn.errors import InputError
from armsyn.motion.formats.files import replacing
from armsyn.planning.generation.batch import Batch, Recipe, make_batch
from armsyn.planning.generation.files import FORMATS, TASK

NOTES = ".notes"
"""Folder beside the chunks, until all of them are there."""

DATASET = "dataset.lerobot"
"""What the chunks of that format are gathered into."""

TOKEN = "generation.json"  # noqa: S105  the name of a file
"""In it: what is being generated."""


@dataclass(frozen=True)
class Order:
    """What every chunk is made by, sent to every process that makes some.

    Parameters
    ----------
    recipe : Recipe
    folder : str
        Where they go; for workers of a cluster, too.
    format : str
        Of `armsyn.planning.generation.files.FORMATS`.
    chunk : int
        Reaches in a chunk.
    digest : str
        Of all inputs, so that no chunk of another generation is taken for one of this.
    task : str
        What every reach does, in words.
    """

    recipe: Recipe
    folder: str
    format: str
    chunk: int
    digest: str
    task: str = TASK

    @property
    def count(self) -> int:
        """How many chunks there are."""
        return -(-self.recipe.size // self.chunk)

    def span(self, number: int) -> tuple[int, int]:
        """First reach of a chunk, and the first beyond."""
        return number * self.chunk, min((number + 1) * self.chunk, self.recipe.size)

    def file(self, number: int) -> Path:
        """Where a chunk goes."""
        return Path(self.folder) / f"reaches-{number:06d}{FORMATS[self.format][0]}"

    def rows(self, number: int) -> Path:
        """Where the rows of a chunk's reaches wait for their table."""
        return Path(self.folder) / NOTES / f"{number:06d}.csv"

    def note(self, number: int) -> Path:
        """Where its note goes."""
        return Path(self.folder) / NOTES / f"{number:06d}.json"


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
    return make_chunk(_unpacked(sent), number)


def sent_order(order: Order) -> bytes:
    """Pack an order for other processes, which must run this version of armsyn."""
    import pickle  # noqa: PLC0415

    return pickle.dumps((armsyn.__version__, order))


@cache
def _linear_algebra() -> ThreadpoolController:
    return ThreadpoolController()


@lru_cache(maxsize=2)
def _unpacked(sent: bytes) -> Order:
    import pickle  # noqa: PLC0415

    version, order = pickle.loads(sent)  # noqa: S301  of the process that sends the work
    if version != armsyn.__version__:
        raise InputError(f"this worker has armsyn {armsyn.__version__}, who sends work {version}")
    assert isinstance(order, Order)  # noqa: S101
    return order


def check_folder(order: Order) -> None:
    """Refuse to write beside another generation, or where nobody will look for it.

    Raises
    ------
    InputError
        When the folder does not hold this order's token.
    """
    token = Path(order.folder) / NOTES / TOKEN
    try:
        digest = json.loads(token.read_text(encoding="utf-8"))["digest"]
    except (OSError, ValueError, KeyError) as error:
        raise InputError(
            f"{order.folder}: this worker does not see the folder of the generation: all workers"
            " must share it, by the same path"
        ) from error
    if digest != order.digest:
        raise InputError(f"{order.folder}: holds another generation: name another folder")


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


REACHES = (
    *("index", "x_m", "y_m", "z_m", "repeat", "duration_s", "person_s", "time_scale"),
    *("outside_m", "error_m", "orientation_error_rad", "evened", "swivel_m", "file"),
)
"""Columns of the table of all reaches; numbers are written so that they are read back the same."""


def write_rows(order: Order, number: int, batch: Batch) -> None:
    """Write a chunk's rows of the table of all reaches, whose columns are `REACHES`."""
    paced, file = batch.paced, order.file(number).name
    columns = (
        *(batch.index, *batch.targets.T, batch.index % order.recipe.repeats),
        *((np.diff(paced.first) - 1) / paced.rate_hz, batch.durations, paced.scales),
        *(batch.outside, np.linalg.norm(batch.hands - batch.targets, axis=1)),
        *(batch.turned, batch.evened, batch.swivels),
    )
    lines = [
        ",".join(_cell(value) for value in (*row, _file_of(order, file, row[0]))) + "\n"
        for row in zip(*(column.tolist() for column in columns), strict=True)
    ]
    with replacing(order.rows(number)) as temporary:
        temporary.write_text("".join(lines), encoding="utf-8")


def _file_of(order: Order, file: str, index: int) -> str:
    """Name the file that a reach of a chunk is in at the end, within the folder."""
    if order.format == "lerobot":
        return DATASET
    return f"{file}/reach-{index:09d}.bvh" if order.format == "bvh" else file


def _cell(value: object) -> str:
    """Shortest text of a number; nothing for one that is not known."""
    return "" if value != value else str(value)  # noqa: PLR0124  NaN


def _note(order: Order, number: int, batch: Batch, file: Path | None) -> dict[str, Any]:
    return {
        "digest": order.digest,
        "chunk": number,
        "file": None if file is None else file.name,
        "sha256": None if file is None else checksum(file),
        "first": order.span(number)[0],
        "reaches": int(batch.index.size),
        "frames": int(batch.paced.first[-1]),
        "outside": int(np.count_nonzero(batch.outside > 0.0)),
        "slowed": float(batch.paced.scales.sum()),
        "changed": [list(vars(change).values()) for change in batch.changed],
        "refused": [list(vars(refusal).values()) for refusal in batch.refused],
    }


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
    import shutil  # noqa: PLC0415

    if file.is_dir():
        shutil.rmtree(file)
    else:
        file.unlink(missing_ok=True)
