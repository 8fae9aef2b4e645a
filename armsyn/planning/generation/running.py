"""A whole generation: chunks spread over processes, gathered, and described by a manifest."""

from __future__ import annotations

import contextlib
import csv
import hashlib
import json
import shutil
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from armsyn.errors import ArmFaultError, ArmsynError, InputError, StopRequestedError
from armsyn.motion.formats.episodes import Episode
from armsyn.motion.formats.files import replacing
from armsyn.planning.generation import chunks
from armsyn.planning.generation.chunks import DATASET, NOTES, TOKEN, Order
from armsyn.planning.generation.cluster import connected, each_on_cluster
from armsyn.planning.generation.files import FORMATS, PLANNED, episodes_of, read_npz
from armsyn.planning.generation.version import differing
from armsyn.synergy.parallel import checked_workers, each

SCHEMA = "armsyn-reaches-1"
MANIFEST, REFUSALS = "manifest.json", "refusals.csv"
COLUMNS = ("index", "x", "y", "z", "kind", "reason")
REACHES = "reaches.csv"
CHANGES, CHANGE_COLUMNS = "changes.csv", ("index", "evened", "swivel_m", "reason")

MOST_REACHES, MOST_CHUNKS = 100_000_000, 100_000
"""In one generation."""

RESERVE = "reserve"
_RESERVED, _RESERVED_A_CHUNK, _MOST_RESERVED = 262_144, 4096, 67_108_864
"""Bytes; refusals of most chunks find room in that."""

OnProgress = Callable[[str, int, int, str], None]


@dataclass
class Report:
    """What a generation came to.

    Attributes
    ----------
    asked, made : int
        Reaches.
    chunks, done : int
    frames, outside : int
        Frames made, and reaches made to targets outside the captured workspace.
    slowed : float
        Mean of kappa, the times as long that reaches take than people would.
    evened, swivelled : int
        Reaches with minimum jerk mixed in, and with the elbow elsewhere at their ends.
    refused : Counter
        Refused reaches by kind.
    error : ArmsynError or None
        What it ended by, before all was done.
    found : bool
        Whether all of it was there already.
    """

    asked: int
    chunks: int
    made: int = 0
    done: int = 0
    frames: int = 0
    outside: int = 0
    slowed: float = 0.0
    evened: int = 0
    swivelled: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    error: ArmsynError | None = None
    found: bool = False

    @property
    def complete(self) -> bool:
        """Whether every reach is made or refused."""
        return self.done == self.chunks and self.error is None

    def add(self, note: Mapping[str, Any]) -> None:
        """Count a chunk that is done."""
        self.slowed = (self.slowed * self.made + note["slowed"]) / max(
            self.made + note["reaches"], 1
        )
        self.made += note["reaches"]
        self.done += 1
        self.frames += note["frames"]
        self.outside += note["outside"]
        for _index, evened, swivel, _reason in note["changed"]:
            self.evened += evened > 0.0
            self.swivelled += swivel > 0.0
        self.refused.update(refusal[2] for refusal in note["refused"])

    def as_document(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return {
            "complete": self.complete,
            "reaches_asked": self.asked,
            "reaches_made": self.made,
            "reaches_refused": dict(sorted(self.refused.items())),
            "reaches_evened": self.evened,
            "reaches_with_another_swivel": self.swivelled,
            "outside_captured_workspace": self.outside,
            "frames": self.frames,
            "mean_time_scale": self.slowed,
        }


def digest_of(inputs: Mapping[str, Any]) -> str:
    """Digest of what a generation is made from: names of options and inputs with their values."""
    return hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()


def generate(
    order: Order,
    inputs: Mapping[str, Any],
    *,
    workers: int | None = None,
    cluster: str | None = None,
    resume: bool = False,
    on_progress: OnProgress = lambda *_: None,
) -> Report:
    """Make all reaches of an order.

    Parameters
    ----------
    order : Order
        Its digest is that of `inputs`.
    inputs : mapping
        What the manifest says that the reaches are made from.
    workers : int, optional
        Processes on this machine; as many as cores, where there is work for them.
    cluster : str, optional
        Address of a scheduler of dask.distributed, ``tcp://HOST:PORT``, instead.
    resume : bool
        Whether to go on with what the folder holds.
    on_progress : callable
        Given a stage's name, how much is done, of how much, and a remark.

    Returns
    -------
    Report
        Of one that was interrupted, found no room or lost its workers, `error` says why; what was
        finished is there, and the manifest says that it is not all.

    Raises
    ------
    InputError
        Too many reaches or chunks; a rate that the format cannot say; a folder with other things in
        it, or that cannot be written; workers that do not see it.
    """
    _check_count(order)
    _check_rate(order)
    if resume and (finished := _all_there(order)) is not None:
        return finished
    with contextlib.nullcontext() if cluster is None else connected(cluster) as client:
        _prepare(order, inputs, resume=resume)
        return _generated(order, inputs, workers, client, on_progress)


def _generated(
    order: Order,
    inputs: Mapping[str, Any],
    workers: int | None,
    client: Any,
    on_progress: OnProgress,
) -> Report:
    report = Report(order.recipe.size, order.count)
    missing = []
    for number in range(order.count):
        if (note := chunks.checked_note(order, number)) is None:
            missing.append(number)
        else:
            report.add(note)
    try:
        for note in _made(order, missing, workers, client):
            report.add(note)
            made = f"{report.made} reaches, {sum(report.refused.values())} refused"
            on_progress("chunks", report.done, report.chunks, made)
        if report.complete and report.made and order.format == "lerobot":
            _gather(order, on_progress)
    except KeyboardInterrupt:
        report.error = StopRequestedError("interrupted")
    except (InputError, ArmFaultError) as error:  # a full disk, a lost cluster
        report.error = error
    in_order = Report(report.asked, report.chunks, error=report.error)
    for note in chunks.notes_of(order):
        in_order.add(note)  # sums round by their order, and chunks came in any
    _finish(order, inputs, in_order)
    return in_order


def _made(
    order: Order, missing: list[int], workers: int | None, client: Any
) -> Iterator[dict[str, Any]]:
    if client is not None:
        yield from each_on_cluster(client, chunks.sent_order(order), missing)
        return
    worth = min(len(missing), 1 + len(missing) * order.chunk // _WORTH_A_PROCESS)
    count = checked_workers(workers, worth)
    if count == 1:
        for number in missing:
            yield chunks.make_chunk(order, number)
        return
    work = partial(chunks.make_chunk_of, chunks.sent_order(order))
    for _, note in each(work, missing, count):
        yield note


_WORTH_A_PROCESS = 20_000
"""Reaches that are worth starting another process for: two seconds."""


def _check_count(order: Order) -> None:
    """Refuse what would fill memory or disk before anybody notices."""
    size = order.recipe.size
    if size > MOST_REACHES:
        raise InputError(
            f"{size} reaches, more than the {MOST_REACHES} of one generation: ask for fewer targets"
            " or repeats, and for the others in another folder"
        )
    if order.count > MOST_CHUNKS:
        raise InputError(
            f"{order.count} chunks, more than the {MOST_CHUNKS} of one generation: give a --chunk"
            f" of {-(-size // MOST_CHUNKS)} reaches or more"
        )


def _check_rate(order: Order) -> None:
    rate = order.recipe.rate_hz
    if order.format == "lerobot" and not rate.is_integer():
        raise InputError(
            f"--format lerobot holds whole frames a second, not {rate:g}: give another --rate"
        )


def _prepare(order: Order, inputs: Mapping[str, Any], *, resume: bool) -> None:
    """Make the folder, or look whether it is one to go on with."""
    folder = Path(order.folder)
    token = folder / NOTES / TOKEN
    manifest = folder / MANIFEST
    if folder.exists() and any(folder.iterdir()):
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
        for left in folder.glob(".reaches-*"):  # of a process that was killed
            chunks.remove(left)
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


def _all_there(order: Order) -> Report | None:
    """Return the report of a folder that holds all of this order; None of any other."""
    folder = Path(order.folder)
    try:
        said = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        if said["digest"] != order.digest or not said["complete"] or (folder / NOTES).exists():
            return None
        lost = [entry["file"] for entry in said["files"] if not (folder / entry["file"]).exists()]
        report = Report(said["reaches_asked"], order.count, said["reaches_made"], order.count)
        report.frames, report.slowed = said["frames"], said["mean_time_scale"]
        report.outside = said["outside_captured_workspace"]
        report.evened = said["reaches_evened"]
        report.swivelled = said["reaches_with_another_swivel"]
        report.refused = Counter(said["reaches_refused"])
    except (OSError, ValueError, KeyError, TypeError):
        return None
    if lost:
        raise InputError(
            f"{folder}: {lost[0]} is missing, which its manifest has: name a new folder"
        )
    report.found = True
    return report


def _reserve(order: Order) -> None:
    """Keep room for manifest and refusals, which a full disk has to leave to be told."""
    size = min(_RESERVED + _RESERVED_A_CHUNK * order.count, _MOST_RESERVED)
    with (
        replacing(Path(order.folder) / NOTES / RESERVE) as temporary,
        temporary.open("wb") as file,
    ):
        for begin in range(0, size, _RESERVED):
            file.write(bytes(min(_RESERVED, size - begin)))


def _gather(order: Order, on_progress: OnProgress) -> None:
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


def _finish(order: Order, inputs: Mapping[str, Any], report: Report) -> None:
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
        if order.format == "lerobot":
            for number in range(order.count):
                order.file(number).unlink(missing_ok=True)
        shutil.rmtree(folder / NOTES)


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
        file.write((",".join(chunks.REACHES) + "\n").encode())
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


__all__ = ["FORMATS", "Report", "digest_of", "generate"]
