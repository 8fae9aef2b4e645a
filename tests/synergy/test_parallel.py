"""Work spread over processes, one of which may die."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

from armsyn.errors import ArmFaultError
from armsyn.synergy.parallel import each

PATIENCE = 60.0

STUCK = """
import os, time
from armsyn.synergy.parallel import each
def stuck(job):
    print(os.getpid(), flush=True)
    time.sleep(600.0)
list(each(stuck, [1, 2], 2))
"""


def halved(job: int) -> int:
    if job == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return job // 2


@pytest.fixture(scope="module")
def spread() -> None:
    """What joblib starts once a process and keeps, the trackers of its resources, is there."""
    assert sorted(each(abs, [-1, -2], 2)) == [(0, 1), (1, 2)]


@pytest.mark.usefixtures("spread")
def test_a_process_that_is_killed_is_told_as_a_fault_and_spoils_no_later_work() -> None:
    with pytest.raises(ArmFaultError, match="a worker process died"):
        list(each(halved, [8, 2, 6, 4], 2))
    assert dict(each(halved, [8, 4], 2)) == {0: 4, 1: 2}


def test_workers_end_with_the_process_that_started_them_when_it_is_killed() -> None:
    process = subprocess.Popen([sys.executable, "-c", STUCK], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    workers = [int(process.stdout.readline()) for _ in range(2)]
    assert process.pid not in workers
    process.kill()
    try:
        process.communicate(timeout=PATIENCE)  # to the end of what the workers write to, too
    except subprocess.TimeoutExpired:
        for worker in workers:
            os.kill(worker, signal.SIGKILL)
        raise
