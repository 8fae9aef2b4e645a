"""An arm that is moved by a process of its own: who dies, and what becomes of the arm."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from armsyn.arm import ArmDescription
from armsyn.driver import ArmSession, Ending, straight_way
from armsyn.driver import registers as reg
from armsyn.driver.process import Job, JobFailedError, run_in_process
from armsyn.driver.signals import StopRequests
from armsyn.driver.timing import WATCHDOG_SECONDS
from armsyn.errors import LimitError
from armsyn.motion import Motion
from firmware_sim.testing import running
from tests.driver.test_processes import ARM, registers

RATE = 50.0
"""Hz: who dies when is the matter here, not how fast this machine is."""

CALLER = """
import sys
from tests.driver.test_own_process import children, slow_job
from armsyn.driver.process import run_in_process

def on_tick(path_time, _duration):
    if path_time > 1.5:  # well off the rest posture
        print(*children(), flush=True)

run_in_process(slow_job(sys.argv[1]), on_tick=on_tick)
"""


def children() -> list[int]:
    """Processes that this one has started."""
    found = Path("/proc/self/task").glob("*/children")
    return [int(child) for file in found for child in file.read_text().split()]


def slow_job(port: str) -> Job:
    """A way of some seconds."""
    from armsyn.arm import load_arm

    arm = load_arm("human7")
    slow = replace(arm, joint=tuple(replace(j, max_velocity=0.5) for j in arm.joint))
    goal = arm.rest.copy()
    goal[3] += 1.0
    way = straight_way(arm.rest, goal, slow, RATE)
    return Job(port, slow, RATE, ((way, None),), simulated=True, gravity=False)


@pytest.fixture(scope="module")
def port() -> Iterator[str]:
    with running(arguments=ARM) as path:
        yield path


@pytest.fixture(autouse=True)
def at_rest(port: str, human7: ArmDescription) -> Iterator[None]:
    yield
    from armsyn.driver import clear_watchdogs

    clear_watchdogs(port, human7)
    with ArmSession.open(port, human7, RATE) as session:
        session.gravity = False
        session.run(straight_way(session.read_posture(), human7.rest, human7, RATE))


def test_motions_are_run_one_after_the_other(port: str, human7: ArmDescription) -> None:
    goal = human7.rest + 0.1
    out = straight_way(human7.rest, goal, human7, RATE)
    back = straight_way(goal, human7.rest, human7, RATE)
    seen: list[float] = []
    job = Job(port, human7, RATE, ((out, None), (back, None)), simulated=True, gravity=False)
    result = run_in_process(job, on_tick=lambda t, _: seen.append(t))
    assert result.error is None
    assert [recording.ending for recording in result.recordings] == [Ending.COMPLETED] * 2
    assert result.recordings[0].commanded_rad[-1] == pytest.approx(goal)
    assert result.recordings[1].simulated
    assert seen


def test_a_request_to_stop_goes_through(port: str) -> None:
    stops = StopRequests()

    def on_tick(path_time: float, _: float) -> None:
        if path_time > 0.3 and not stops.count:
            stops.request()

    result = run_in_process(slow_job(port), stops, on_tick)
    assert result.error is None
    ending = result.recordings[-1].ending
    assert ending in (Ending.STOPPED_PARKED, Ending.STOPPED_HOLDING)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_to_both_processes_is_one_request(port: str, number: signal.Signals) -> None:
    before, told = children(), []

    def on_tick(path_time: float, _: float) -> None:
        if path_time > 0.3 and not told:
            told.extend(set(children()) - set(before))
            for process in (*told, os.getpid()):
                os.kill(process, number)

    result = run_in_process(slow_job(port), on_tick=on_tick)
    assert result.error is None
    assert told
    ending = result.recordings[-1].ending
    assert ending in (Ending.STOPPED_PARKED, Ending.STOPPED_HOLDING)


def test_an_error_comes_back_with_its_evidence(port: str, human7: ArmDescription) -> None:
    way = straight_way(human7.rest + 0.3, human7.rest, human7, RATE)
    result = run_in_process(Job(port, human7, RATE, ((way, None),)))
    assert isinstance(result.error, LimitError)
    assert "but the trajectory starts at" in str(result.error)
    assert result.error.joint == human7.joint_names[0]
    assert result.error.limit == 0.05
    assert result.recordings == ()


def test_no_motion_goes_on_after_one_that_was_refused(port: str, human7: ArmDescription) -> None:
    wrong = Motion(np.arange(3) / RATE, human7.joint_names, np.full((3, 7), np.nan))
    right = straight_way(human7.rest, human7.rest + 0.1, human7, RATE)
    result = run_in_process(Job(port, human7, RATE, ((wrong, None), (right, None))))
    assert result.error is not None
    assert result.recordings == ()


@pytest.mark.fault(26)
def test_a_caller_that_is_killed_leaves_an_arm_that_holds_and_no_orphan(
    port: str, human7: ArmDescription
) -> None:
    caller = subprocess.Popen(
        [sys.executable, "-c", CALLER, port], stdout=subprocess.PIPE, text=True
    )
    assert caller.stdout is not None
    child = int(caller.stdout.readline())
    caller.send_signal(signal.SIGKILL)
    caller.wait()
    caller.stdout.close()
    for _ in range(200):  # until the child has brought the arm to rest and ended
        if not _runs(child):
            break
        time.sleep(0.05)
    assert not _runs(child)
    assert registers(port, reg.TORQUE_ENABLE) == [1] * 7
    assert registers(port, reg.BUS_WATCHDOG) == [0] * 7  # stopped as on any request
    assert max(map(abs, registers(port, reg.PRESENT_VELOCITY))) <= 1
    angles = human7.calibration.to_radians(registers(port, reg.PRESENT_POSITION))
    assert angles[3] - human7.rest[3] > 0.15  # where it stood, and not back at rest


def _runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.fault(26)
def test_a_child_that_is_killed_leaves_the_watchdog_to_stop_the_arm(port: str) -> None:
    before = children()

    def on_tick(path_time: float, _: float) -> None:
        if path_time > 0.3:
            for child in set(children()) - set(before):
                os.kill(child, signal.SIGKILL)

    with pytest.raises(JobFailedError, match="the servos stop by their own watchdog"):
        run_in_process(slow_job(port), on_tick=on_tick)
    time.sleep(2.0 * WATCHDOG_SECONDS)  # in silence: any packet would feed the watchdogs
    assert registers(port, reg.BUS_WATCHDOG) == [reg.WATCHDOG_EXPIRED] * 7
    assert registers(port, reg.TORQUE_ENABLE) == [1] * 7
