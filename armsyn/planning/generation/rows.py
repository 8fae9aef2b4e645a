"""The table of all reaches: each chunk's rows, made beside it."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from armsyn.motion.formats.files import replacing
from armsyn.planning.generation.batch import Batch
from armsyn.planning.generation.order import DATASET, Order

COLUMNS = (
    *("index", "x_m", "y_m", "z_m", "repeat", "duration_s", "predicted_time_s", "time_scale"),
    *("outside_m", "planned_error_m", "orientation_error_rad", "evened", "swivel_m", "file"),
)
"""Columns of the table of all reaches; numbers are written so that they are read back the same."""


def write_rows(order: Order, number: int, batch: Batch) -> None:
    """Write a chunk's rows of the table of all reaches, whose columns are `COLUMNS`."""
    paced, file = batch.paced, order.file(number).name
    columns = (
        *(batch.index, *batch.targets.T, batch.index % order.recipe.repeats),
        *((np.diff(paced.first) - 1) / paced.rate_hz, batch.durations, paced.scales),
        *(batch.outside, np.linalg.norm(batch.hands - batch.targets, axis=1)),
        *(batch.turned, batch.evened, batch.swivels),
    )
    files = [_file_of(order, file, index) for index in batch.index.tolist()]
    rows = zip(*map(_texts, columns), files, strict=True) if files else ()
    lines = [",".join(row) + "\n" for row in rows]
    with replacing(order.rows(number)) as temporary:
        temporary.write_text("".join(lines), encoding="utf-8")


def _file_of(order: Order, file: str, index: int) -> str:
    """Name the file that a reach of a chunk is in at the end, within the folder."""
    if order.format == "lerobot":
        return DATASET
    return f"{file}/reach-{index:09d}.bvh" if order.format == "bvh" else file


def _texts(column: NDArray[Any]) -> list[str]:
    """Shortest texts of numbers; nothing for one that is not known (NaN)."""
    numbers = msgspec.json.encode(column.tolist()).decode()  # several times as fast as str()
    return numbers[1:-1].replace("null", "").split(",")
