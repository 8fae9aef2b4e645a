"""What stands beside a generation's chunks: tables, the manifest, the dataset of lerobot."""

from __future__ import annotations

import csv
import json
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from armsyn.errors import InputError
from armsyn.motion.formats.episodes import Episode
from armsyn.motion.formats.files import replacing
from armsyn.planning.generation import chunks
from armsyn.planning.generation.files import PLANNED, episodes_of, read_npz
from armsyn.planning.generation.folder import CHANGES, MANIFEST, REACHES, REFUSALS, RESERVE, tidy
from armsyn.planning.generation.order import DATASET, NOTES, Order
from armsyn.planning.generation.report import Report
from armsyn.planning.generation.rows import COLUMNS as REACH_COLUMNS

SCHEMA = "armsyn-reaches-1"
COLUMNS = ("index", "x_m", "y_m", "z_m", "kind", "reason")
CHANGE_COLUMNS = ("index", "evened", "swivel_m", "reason")

OnProgress = Callable[[str, int, int, str], None]
"""Given a stage's name, how much is done, of how much, and a remark."""


def gather(order: Order, on_progress: OnProgress) -> None:
    """Write the dataset of lerobot from its parts, a part at a time in memory."""
    from armsyn.motion.formats import lerobot_format  # noqa: PLC0415  an extra

    def episodes() -> Iterator[Episode]:
        for number in range(order.count):
            if order.file(number).exists():
                yield from episodes_of(read_npz(order.file(number)), order.recipe.arm, order.task)
            on_progress("dataset", number + 1, order.count, "")

    folder = Path(order.folder) / DATASET
    if folder.exists():
        chunks.remove(folder)
    lerobot_format.write(folder, episodes(), **lerobot_format.options_of(order.recipe.arm))


def finish(order: Order, inputs: Mapping[str, Any], report: Report) -> None:
    """Write refusals, changes and manifest; take the notes away when nothing is left to do."""
    folder = Path(order.folder)
    (folder / NOTES / RESERVE).unlink(missing_ok=True)
    try:
        _write_table(order, REFUSALS, COLUMNS, _refusals)
        _write_table(order, CHANGES, CHANGE_COLUMNS, lambda note: note["changed"])
        if report.complete:
            _write_reaches(order)
        _write_manifest(order, inputs, report)
        if not report.complete:  # last: the largest, where a disk may be full
            _write_reaches(order)
    except InputError as error:  # a full disk: the chunks are there, and so are their notes
        report.error = report.error or error
        return
    if report.complete:
        tidy(order)


def _refusals(note: Mapping[str, Any]) -> list[list[Any]]:
    return [[index, *place, *why] for index, place, *why in note["refused"]]


def _write_table(
    order: Order,
    name: str,
    columns: Sequence[str],
    rows_of: Callable[[Mapping[str, Any]], list[list[Any]]],
) -> None:
    path = Path(order.folder) / name
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(columns)
        for note in chunks.notes_of(order):
            table.writerows(rows_of(note))


def _write_reaches(order: Order) -> None:
    """Put the rows of all chunks that are done together, in their order."""
    path = Path(order.folder) / REACHES
    with replacing(path) as temporary, temporary.open("wb") as file:
        file.write((",".join(REACH_COLUMNS) + "\n").encode())
        for note in chunks.notes_of(order):
            with order.rows(note["chunk"]).open("rb") as rows:
                shutil.copyfileobj(rows, file)


def _write_manifest(order: Order, inputs: Mapping[str, Any], report: Report) -> None:
    whole = order.format == "lerobot" and report.complete
    files = [] if whole else list(_files(order))
    if whole and report.made:
        folder = Path(order.folder) / DATASET
        files = [{"file": DATASET, "reaches": report.made, "sha256": chunks.checksum(folder)}]
    manifest = {
        "schema": SCHEMA,
        "what": PLANNED,
        "digest": order.digest,
        "inputs": inputs,
        **report.as_document(),
        "files": files,
    }
    with replacing(Path(order.folder) / MANIFEST) as temporary:
        text = json.dumps(manifest, indent=1, allow_nan=False, ensure_ascii=False)
        temporary.write_text(text + "\n", encoding="utf-8")


def _files(order: Order) -> Iterator[dict[str, Any]]:
    for note in chunks.notes_of(order):
        if note["file"] is not None:
            yield {key: note[key] for key in ("file", "first", "reaches", "frames", "sha256")}
