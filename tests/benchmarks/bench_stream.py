"""Streaming to the simulated human-like arm at 200 Hz: success rate, and memory of the driver.

The goal for the success rate (1.0 in the median of the runs, over the last 100 commands and over
all of them) is for 60 s a run, the goal for memory (flat) for 10 minutes: ``--runs 5 --seconds 60
--memory-seconds 600``. By default shorter ones are made, and the print says so. Beside it stands
how a bare loop of sleeping to deadlines does, without any bus: what the machine takes away.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from armsyn.arm import load_arm
from armsyn.driver import ArmSession, Ending
from armsyn.driver.clock import MonotonicClock
from armsyn.driver.collector import collector_frozen
from armsyn.driver.joints import JointState
from armsyn.driver.path import minimum_jerk
from armsyn.errors import ArmFaultError
from firmware_sim.testing import running

RATE = 200.0
ARM = "human7"
SIMULATOR = ("--arm", ARM)
FLAT_MB = 1.0
"""Growth of resident memory that counts as none, MB."""

WARM_UP = 10.0
"""Seconds after which memory is compared: the first motion brings in what is loaded late."""


def resident_mb() -> float:
    """Resident memory of this process, MB (Linux)."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def stream(port: str, seconds: float, *, realtime: bool) -> dict[str, float]:
    """Stream for some seconds; returns rates, misses and memory."""
    arm = load_arm(ARM)
    grown = {"begin": 0.0, "end": 0.0}

    def wanted(t: float, _: JointState) -> np.ndarray:
        posture = arm.rest.copy()
        swing = 0.2 * minimum_jerk(t / 2.0) * np.sin(np.pi * t)
        posture[3:] = posture[3:] + swing * np.array([1.0, 0.5, 0.5, 0.5])
        return posture

    def on_tick(path_time: float, _: float) -> None:
        if round(path_time * RATE) % round(RATE) == 0:
            moment = "begin" if path_time <= min(WARM_UP, 0.5 * seconds) else "end"
            grown[moment] = max(grown[moment], resident_mb())

    with ArmSession.open(port, arm, RATE, simulated=True) as session:
        session.gravity, session.realtime = False, realtime
        try:
            session.run_setpoint(wanted, seconds, on_tick)
        except ArmFaultError as error:
            print(f"  {error}", file=sys.stderr)
        recording = session.recording
    if recording is None or recording.ending is not Ending.COMPLETED:
        return dict.fromkeys(("success", "success_all", "missed", "ticks"), 0.0) | {
            "longest_gap_ms": float("nan"),
            "growth_mb": grown["end"] - grown["begin"],
        }
    whole = ~recording.stale.any(axis=1)
    return {
        "success": recording.command_success_rate,
        "success_all": float(np.count_nonzero(whole)) / (recording.ticks + recording.missed_ticks),
        "missed": recording.missed_ticks,
        "ticks": recording.ticks,
        "longest_gap_ms": 1e3 * float(np.diff(recording.time_s).max()),
        "growth_mb": grown["end"] - grown["begin"],
    }


def bare_misses(seconds: float) -> int:
    """Ticks that a loop without any bus misses in the same way."""
    clock, missed = MonotonicClock(), 0
    with collector_frozen():
        begin = due = clock.now()
        while due - begin < seconds:
            clock.sleep_until(due)
            late = int((clock.now() - due) * RATE)
            missed += late
            due += (late + 1) / RATE
    return missed


def in_child(port: str, seconds: float, *, realtime: bool) -> dict[str, float]:
    """One run in a process of its own, as a user's program is."""
    command = [sys.executable, __file__, "--one", port, str(seconds), str(int(realtime))]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    found: dict[str, float] = json.loads(done.stdout)
    return found


def report(runs: int, seconds: float, memory_seconds: float, *, realtime: bool) -> bool:
    """Measure, print, and say whether the goals are met."""
    print(f"stream of {RATE:g} Hz to the simulated {ARM}, {runs} runs of {seconds:g} s")
    found = []
    for number in range(runs):
        with running(arguments=SIMULATOR) as port:
            found.append(in_child(port, seconds, realtime=realtime))
        run = found[-1]
        bare = bare_misses(min(seconds, 10.0))
        print(
            f"  run {number + 1}: success {run['success']:.3f} of the last 100,"
            f" {run['success_all']:.4f} of all {run['ticks']:.0f}, {run['missed']:.0f} missed,"
            f" longest gap {run['longest_gap_ms']:.1f} ms; bare loop: {bare} missed in"
            f" {min(seconds, 10.0):g} s"
        )
    success = statistics.median(run["success"] for run in found)
    overall = statistics.median(run["success_all"] for run in found)
    print(
        f"  median: {success:.3f} of the last 100, {overall:.4f} of all (goal 1.0 of the last 100)"
    )
    with running(arguments=SIMULATOR) as port:
        grown = in_child(port, memory_seconds, realtime=realtime)["growth_mb"]
    print(f"  memory over {memory_seconds:g} s: {grown:+.2f} MB (goal: flat, below {FLAT_MB:g} MB)")
    return success == 1.0 and grown < FLAT_MB


def main() -> int:
    """Run one stream for the parent, or all of them."""
    if sys.argv[1:2] == ["--one"]:
        port, seconds, realtime = sys.argv[2], float(sys.argv[3]), sys.argv[4] == "1"
        print(json.dumps(stream(port, seconds, realtime=realtime)))
        return 0
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=10.0, help="a run; the goal is for 60")
    parser.add_argument("--memory-seconds", type=float, default=30.0, help="the goal is for 600")
    parser.add_argument("--realtime", action="store_true", help="with SCHED_FIFO, if permitted")
    options = parser.parse_args()
    begin = time.monotonic()
    met = report(options.runs, options.seconds, options.memory_seconds, realtime=options.realtime)
    print(f"  ({time.monotonic() - begin:.0f} s in all)")
    return int(not met)


if __name__ == "__main__":
    sys.exit(main())
