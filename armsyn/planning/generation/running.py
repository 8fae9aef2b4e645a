"""A whole generation: chunks spread over processes, gathered, and described by a manifest."""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from armsyn.errors import ArmFaultError, InputError, StopRequestedError, by_interrupt
from armsyn.planning.generation import chunks
from armsyn.planning.generation.batch import warm_up
from armsyn.planning.generation.cluster import connected, each_on_cluster
from armsyn.planning.generation.files import check_packages
from armsyn.planning.generation.folder import all_there, prepare
from armsyn.planning.generation.lock import alone_in
from armsyn.planning.generation.order import Order, sent_order
from armsyn.planning.generation.report import Report
from armsyn.planning.generation.results import OnProgress, finish, gather
from armsyn.synergy.parallel import checked_workers, each

MOST_REACHES, MOST_CHUNKS = 100_000_000, 100_000
"""In one generation."""


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
        Too many reaches or chunks; a rate that the format cannot say; more workers than cores; a
        folder with other things in it, that cannot be written, or that another generation writes
        to; workers that do not see it; a format whose packages are missing here.
    """
    _check_count(order)
    _check_rate(order)
    checked_workers(workers, 1)
    if resume and (finished := all_there(order)) is not None:
        return finished
    folder = Path(order.folder)
    check_packages(order.format, folder)
    with (
        contextlib.nullcontext() if cluster is None else connected(cluster) as client,
        alone_in(folder),
    ):
        prepare(order, inputs, resume=resume)
        return _generated(order, inputs, workers, client, on_progress)


def _generated(
    order: Order,
    inputs: Mapping[str, Any],
    workers: int | None,
    client: Any,
    on_progress: OnProgress,
) -> Report:
    report = Report(order.recipe.size, order.count)
    missing: list[int] = []
    try:
        for number in range(order.count):
            if (note := chunks.checked_note(order, number)) is None:
                missing.append(number)
                continue
            report.add(note)
            on_progress("chunks found", number + 1, order.count, "")
        for note in _made(order, missing, workers, client):
            report.add(note)
            made = f"{report.made} reaches, {sum(report.refused.values())} refused"
            on_progress("chunks", report.done, report.chunks, made)
        if report.complete and report.made and order.format == "lerobot":
            gather(order, on_progress)
    except (KeyboardInterrupt, SystemError) as error:
        if not by_interrupt(error):
            raise
        report.error = StopRequestedError("interrupted")
    except (InputError, ArmFaultError) as error:  # a full disk, a lost cluster
        report.error = error
    in_order = Report(report.asked, report.chunks, error=report.error)
    for note in chunks.notes_of(order):
        in_order.add(note)  # sums round by their order, and chunks came in any
    finish(order, inputs, in_order)
    return in_order


def _made(
    order: Order, missing: list[int], workers: int | None, client: Any
) -> Iterator[dict[str, Any]]:
    if client is not None:
        yield from each_on_cluster(client, sent_order(order), missing)
        return
    worth = min(len(missing), 1 + len(missing) * order.chunk // _WORTH_A_PROCESS)
    count = checked_workers(workers, worth)
    if count == 1:
        for number in missing:
            yield chunks.make_chunk(order, number)
        return
    warm_up(order.recipe)  # once, and not in every process
    work = partial(chunks.make_chunk_of, sent_order(order))
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
