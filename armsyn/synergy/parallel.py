"""Work spread over processes, which changes nothing of its results."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TypeVar

import numba
from joblib import Parallel, delayed
from joblib.externals.loky import get_reusable_executor
from joblib.externals.loky.process_executor import BrokenProcessPool

from armsyn.errors import ArmFaultError, InputError

Job = TypeVar("Job")
Result = TypeVar("Result")

_CORES = numba.get_num_threads()
_LOOKS_S = 1.0
"""How often a process looks whether the one that started it is still there."""


def checked_workers(workers: int | None, worth: int) -> int:
    """Return how many processes are to work.

    Parameters
    ----------
    workers : int or None
        Wanted; as many as cores, and no more than `worth`, when None.
    worth : int
        How many there is enough work for: a process takes about two seconds to start.

    Returns
    -------
    int

    Raises
    ------
    InputError
        Fewer than one or more than there are cores.
    """
    if workers is None:
        return max(1, min(_CORES, worth))
    if not 1 <= workers <= _CORES:
        raise InputError(f"workers must be between 1 and {_CORES} on this machine, got {workers}")
    return workers


def each(
    work: Callable[[Job], Result], jobs: Sequence[Job], workers: int
) -> Iterator[tuple[int, Result]]:
    """Do every job; yield its number and its result as soon as it is done, in any order.

    Parameters
    ----------
    work : callable
        A function of a module, from a job to its result.
    jobs : sequence
    workers : int
        Processes; with one, or one job, everything is done in this one. They end with it, however
        it ends.

    Yields
    ------
    tuple of (int, result)

    Raises
    ------
    ArmFaultError
        When a process dies over a job.
    """
    if workers == 1 or len(jobs) < 2:
        with _threads(workers):
            for number, job in enumerate(jobs):
                yield number, work(job)
        return
    parallel = Parallel(
        n_jobs=min(workers, len(jobs)),
        return_as="generator_unordered",
        initializer=_end_with,
        initargs=(os.getpid(),),
    )
    try:
        yield from parallel(delayed(_numbered)(work, n, job) for n, job in enumerate(jobs))
    except BrokenProcessPool as error:
        raise ArmFaultError(
            "a worker process died: killed by someone, or by the system for want of memory: try"
            " fewer --workers"
        ) from error
    finally:
        # joblib keeps its processes for the next call; who calls this may be done
        get_reusable_executor().shutdown(wait=True, kill_workers=True)


def _end_with(parent: int) -> None:
    """End this process soon after the one that started it, which may have been killed."""

    def look() -> None:
        while os.getppid() == parent:
            time.sleep(_LOOKS_S)
        os._exit(1)

    threading.Thread(target=look, name="armsyn-parent", daemon=True).start()


def _numbered(work: Callable[[Job], Result], number: int, job: Job) -> tuple[int, Result]:
    with _threads(1):
        return number, work(job)


@contextmanager
def _threads(count: int) -> Iterator[None]:
    before = numba.get_num_threads()
    numba.set_num_threads(min(count, before))
    try:
        yield
    finally:
        numba.set_num_threads(before)
