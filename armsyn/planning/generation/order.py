"""What a generation is made by, packed for other processes, and where its parts go."""

from __future__ import annotations

import json
import pickle
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import armsyn
from armsyn.errors import InputError
from armsyn.planning.generation.batch import Recipe
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


def sent_order(order: Order) -> bytes:
    """Pack an order for other processes, which must run this version of armsyn."""
    return pickle.dumps((armsyn.__version__, order))


@lru_cache(maxsize=2)
def unpacked(sent: bytes) -> Order:
    """Unpack what `sent_order` packed."""
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
