"""Chunks made by the workers of a cluster: dask.distributed (extra ``cluster``).

Workers write into the generation's folder, which they share; what travels is the order, once a
worker, and a chunk's number and note. A worker that dies takes nothing along: its chunks are given
to others, and one that it had finished is found with its note.
"""

from __future__ import annotations

import contextlib
import itertools
import re
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from typing import Any

from armsyn.errors import ArmFaultError, InputError
from armsyn.planning.generation.chunks import make_chunk_of

PATIENCE_S = 10.0
"""For a scheduler to answer, and for a first worker."""

_ADDRESS = re.compile(r"tcp://(\[[0-9a-fA-F:.]+\]|[^\s/:\[\]]+):(\d{1,5})/?")

AHEAD = 4
"""Chunks that are handed out for every thread of the cluster: a window, so that the scheduler does
not hold a million."""


@contextlib.contextmanager
def connected(address: str) -> Iterator[Any]:
    """Yield a client of a scheduler that has workers.

    Parameters
    ----------
    address : str
        ``tcp://HOST:PORT``.

    Yields
    ------
    distributed.Client

    Raises
    ------
    InputError
        For another address; when dask.distributed is missing, or no scheduler or worker answers.
    """
    _check_address(address)
    try:
        from distributed import Client  # noqa: PLC0415  an extra
    except ImportError as error:
        raise InputError(
            "--cluster needs the package distributed: install it with pip install 'armsyn[cluster]'"
        ) from error
    try:
        client = Client(address, timeout=PATIENCE_S, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, TimeoutError, ValueError, ImportError) as error:
        raise InputError(
            f"{address[:80]}: no scheduler of dask.distributed answers: start one with"
            " `dask scheduler`, and `dask worker ADDRESS` on every machine"
        ) from error
    try:
        try:
            client.wait_for_workers(1, timeout=PATIENCE_S)
        except TimeoutError as error:
            raise InputError(
                f"{address}: the scheduler has no workers: start `dask worker {address}` on every"
                " machine"
            ) from error
        yield client
    finally:
        with contextlib.suppress(OSError):  # of a scheduler that is gone: there is nothing to close
            client.close()  # type: ignore[no-untyped-call]


def _check_address(address: str) -> None:
    found = _ADDRESS.fullmatch(address)
    if found is None or not 0 < int(found[2]) < 65536:
        raise InputError(
            f"--cluster '{address[:80]}' is no tcp://HOST:PORT, which `dask scheduler` says when it"
            " starts"
        )


def each_on_cluster(client: Any, order: bytes, numbers: Sequence[int]) -> Iterator[dict[str, Any]]:
    """Make chunks on a cluster; yield each one's note as soon as it is there, in any order.

    Parameters
    ----------
    client : distributed.Client
    order : bytes
        As `armsyn.planning.generation.order.sent_order` packs it.
    numbers : sequence of int

    Yields
    ------
    dict

    Raises
    ------
    InputError
        When a worker cannot see or write the folder.
    ArmFaultError
        When workers die again and again, or the scheduler does.
    """
    from distributed import as_completed  # noqa: PLC0415  an extra
    from distributed.scheduler import KilledWorker  # noqa: PLC0415

    # A task rather than scattered data, so that it is made again if all who had it die
    sent = client.submit(bytes, order, pure=False)
    left = iter(numbers)

    def handed_out(count: int) -> list[Any]:
        return [
            client.submit(make_chunk_of, sent, number, pure=False)
            for number in itertools.islice(left, count)
        ]

    ahead = AHEAD * sum(client.nthreads().values())
    waiting: Any = as_completed(handed_out(ahead), loop=client.loop)  # type: ignore[no-untyped-call]
    try:
        for future in waiting:
            yield future.result()
            waiting.update(handed_out(1))
    except KilledWorker as error:
        raise ArmFaultError("worker after worker dies over one chunk: see their logs") from error
    except (OSError, CancelledError) as error:
        raise ArmFaultError(f"the cluster is lost: {error or type(error).__name__}") from error
