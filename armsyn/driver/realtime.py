"""Real-time scheduling of the thread that streams, where the system permits it."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator

PRIORITY = 20
"""Of SCHED_FIFO: above all ordinary programs, below the kernel's own threads (50)."""

CURE = (
    "real-time scheduling is not permitted: allow it in /etc/security/limits.d (a line"
    " '@dialout - rtprio 20', then log in again), or run without --realtime"
)


@contextlib.contextmanager
def realtime(*, wanted: bool = True) -> Iterator[str]:
    """Let this thread run before all ordinary programs for as long as the block lasts.

    Threads and processes that it starts meanwhile are scheduled as before.

    Parameters
    ----------
    wanted : bool
        False for nothing.

    Yields
    ------
    str
        Why it is not so, with the cure; empty when it is, or is not wanted.
    """
    if not wanted:
        yield ""
        return
    if not hasattr(os, "sched_setscheduler"):
        yield "real-time scheduling is not known on this system: running without it"
        return
    before, parameters = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        # reset on fork: a setpoint function that spins must not keep everything else waiting
        policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
        os.sched_setscheduler(0, policy, os.sched_param(PRIORITY))
    except PermissionError:
        yield CURE
        return
    try:
        yield ""
    finally:
        try:
            os.sched_setscheduler(0, before, parameters)
        except PermissionError:  # only the privileged may take the reset back
            os.sched_setscheduler(0, before | os.SCHED_RESET_ON_FORK, parameters)
