"""The folder of a generation: begun, gone on with, or found to be whole."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from armsyn.errors import InputError
from armsyn.motion.formats.files import left_behind, replacing
from armsyn.planning.generation import chunks
from armsyn.planning.generation.lock import alone_in
from armsyn.planning.generation.order import DATASET, NOTES, TOKEN, Order
from armsyn.planning.generation.report import Report
from armsyn.planning.generation.version import differing

MANIFEST, RUN = "manifest.json", "manifest.run.json"
REFUSALS, CHANGES, REACHES = "refusals.csv", "changes.csv", "reaches.csv"

RESERVE = "reserve"
_RESERVED, _RESERVED_A_CHUNK, _MOST_RESERVED = 262_144, 4096, 67_108_864
"""Bytes; refusals of most chunks find room in that."""


def prepare(order: Order, inputs: Mapping[str, Any], *, resume: bool) -> None:
    """Make the folder, or look whether it is one to go on with.

    Raises
    ------
    InputError
        Other things in it, or reaches made from something else; a folder that cannot be written.
    """
    folder = Path(order.folder)
    token = folder / NOTES / TOKEN
    manifest = folder / MANIFEST
    if _holds_something(folder):
        known = token if token.exists() else manifest
        try:
            said = json.loads(known.read_text(encoding="utf-8"))
            digest, before = said["digest"], dict(said["inputs"])
        except (OSError, ValueError, KeyError, TypeError):
            raise InputError(f"{folder}: has other things in it: name a new folder") from None
        if digest != order.digest:
            other = differing(before, inputs)
            raise InputError(f"{folder}: holds reaches made from {other}: name a new folder")
        if not token.exists():
            raise InputError(f"{folder}: these reaches are all there: nothing to do")
        if not resume:
            raise InputError(f"{folder}: holds a part of these reaches: --resume goes on with it")
        _remove_left(order)
        _reserve(order)
        return
    try:
        token.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot make it: {error.strerror}") from error
    with replacing(token) as temporary:
        said = {"digest": order.digest, "inputs": inputs}
        temporary.write_text(json.dumps(said, indent=1) + "\n", encoding="utf-8")
    _reserve(order)


def _holds_something(folder: Path) -> bool:
    try:
        return folder.exists() and any(folder.iterdir())
    except OSError as error:
        raise InputError(f"{folder}: cannot look into it: {error.strerror}") from error


def all_there(order: Order) -> Report | None:
    """Return the report of a folder that holds all of this order; None of any other.

    Raises
    ------
    InputError
        When a file is lost or damaged, or another generation is in it.
    """
    folder = Path(order.folder)
    try:
        said = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        under_way = (folder / NOTES / TOKEN).exists()
        if said["digest"] != order.digest or not said["complete"] or under_way:
            return None
        checksums = {entry["file"]: entry["sha256"] for entry in said["files"]}
        report = _report_of(said, order)
    except (OSError, ValueError, KeyError, TypeError):
        return None
    with alone_in(folder):
        for name, checksum in checksums.items():
            _check_file(folder, name, checksum)
        if (folder / NOTES).exists():
            tidy(order)
        _remove_left(order)
    return report


def _check_file(folder: Path, name: str, checksum: str) -> None:
    """Refuse a file, or folder, that is not what the manifest has."""
    try:
        found = chunks.checksum(folder / name)
    except FileNotFoundError:
        raise InputError(
            f"{folder}: {name} is missing, which its manifest has: name a new folder"
        ) from None
    except OSError as error:
        raise InputError(f"{folder}: cannot read {name}: {error.strerror}") from error
    if found != checksum:
        raise InputError(
            f"{folder}: {name} is damaged or was changed, by its manifest's checksum: name a new"
            " folder"
        )


def _report_of(said: Mapping[str, Any], order: Order) -> Report:
    """Read what a manifest says of reaches that are all there."""
    report = Report(said["reaches_asked"], order.count, said["reaches_made"], order.count)
    report.frames, report.slowed = said["frames"], said["mean_time_scale"]
    report.outside = said["outside_captured_workspace"]
    report.evened = said["reaches_evened"]
    report.swivelled = said["reaches_with_another_swivel"]
    report.refused = Counter(said["reaches_refused"])
    report.found = True
    return report


def _remove_left(order: Order) -> None:
    """Remove what a process that was killed was writing, but nothing of anybody else's."""
    written = {MANIFEST, RUN, REFUSALS, CHANGES, REACHES, DATASET}
    written |= {order.file(number).name for number in range(order.count)}
    for path, of in left_behind(Path(order.folder)):
        if of in written:
            chunks.remove(path)


def tidy(order: Order) -> None:
    """Take away what a generation under way needs; once its token is gone, it is none."""
    notes = Path(order.folder) / NOTES
    (notes / TOKEN).unlink(missing_ok=True)
    if order.format == "lerobot":
        for number in range(order.count):
            order.file(number).unlink(missing_ok=True)
    shutil.rmtree(notes)


def _reserve(order: Order) -> None:
    """Keep room for manifest and refusals, which a full disk has to leave to be told."""
    size = min(_RESERVED + _RESERVED_A_CHUNK * order.count, _MOST_RESERVED)
    with (
        replacing(Path(order.folder) / NOTES / RESERVE) as temporary,
        temporary.open("wb") as file,
    ):
        for begin in range(0, size, _RESERVED):
            file.write(bytes(min(_RESERVED, size - begin)))
