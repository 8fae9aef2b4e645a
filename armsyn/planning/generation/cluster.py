"""Chunks made by the workers of a cluster: dask.distributed (extra ``cluster``).

Workers write into the generation's folder, which they share; what travels is the order, once a
worker, and a chunk's number and note. A worker that dies takes nothing along: its chunks are given
to others, and one that it had finished is found with its note.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

from armsyn.errors import ArmFaultError, InputError
from armsyn.planning.generation.chunks import make_chunk_of

PATIENCE_S = 10.0
"""For a scheduler to answer, and for a first worker."""

AHEAD = 4
"""Chunks that are handed out for every thread of the cluster: a window, so that the scheduler does
not hold a million."""


def each_on_cluster(address: str, order: bytes, numbers: Sequence[int]) -> Iterator[dict[str, Any]]:
    """Make chunks on a cluster; yield each one's note as soon as it is there, in any order.

    Parameters
    ----------
    address : str
        Of the scheduler, ``tcp://HOST:PORT``.
    order : bytes
        As `armsyn.planning.generation.chunks.sent_order` packs it.
    numbers : sequence of int

    Yields
    ------
    dict

    Raises
    ------
    InputError
        When dask.distributed is missing, or no scheduler or worker answers; when a worker cannot
        see or write the folder.
    ArmFaultError
        When workers die again and again.
    """
    try:
        from distributed import Client, as_completed  # noqa: PLC0415  an extra
        from distributed.scheduler import KilledWorker  # noqa: PLC0415
    except ImportError as error:
        raise InputError(
            "--cluster needs the package distributed: install it with pip install 'armsyn[cluster]'"
        ) from error
    client = _connected(Client, address)
    try:
        # A task rather than scattered data, so that it is made again if all who had it die
        sent = client.submit(bytes, order, pure=False)
        left = iter(numbers)

        def handed_out(count: int) -> list[Any]:
            return [
                client.submit(make_chunk_of, sent, number, pure=False)
                for number in itertools.islice(left, count)
            ]

        waiting: Any = as_completed(handed_out(AHEAD * sum(client.nthreads().values())))  # type: ignore[no-untyped-call]
        for future in waiting:
            try:
                yield future.result()
            except KilledWorker as error:
                raise ArmFaultError(
                    f"{address}: worker after worker dies over one chunk: see their logs"
                ) from error
            waiting.update(handed_out(1))
    finally:
        client.close()


def _connected(make_client: Any, address: str) -> Any:
    try:
        client = make_client(address, timeout=PATIENCE_S, set_as_default=False)
    except (OSError, TimeoutError, ValueError, ImportError) as error:
        raise InputError(
            f"{address[:80]}: no scheduler of dask.distributed answers: start one with"
            " `dask scheduler`, and `dask worker ADDRESS` on every machine"
        ) from error
    try:
        client.wait_for_workers(1, timeout=PATIENCE_S)
    except TimeoutError as error:
        client.close()
        raise InputError(
            f"{address}: the scheduler has no workers: start `dask worker {address}` on every"
            " machine"
        ) from error
    return client
