"""Following targets: what a tick takes, alone and inside a stream, and what planning takes.

Alone, the setpoints of a reach are asked for one after the other on an idle machine. Inside, they
are asked for by the driver at 200 Hz, on a simulated arm, while a thread plans a new target ten
times a second. There a tick runs cold, after 5 ms in which others ran, and may wait for that
thread; its own processor time, without such waiting, stands beside it. The goal is a median below
100 us, both ways.
"""

from __future__ import annotations

import argparse
import contextlib
import statistics
import sys
import threading
import time
from types import SimpleNamespace

import numpy as np

from armsyn.arm import ArmDescription, find_file, load_arm
from armsyn.driver import ArmSession, still_posture
from armsyn.driver.joints import JointState
from armsyn.driver.path import BLEND
from armsyn.errors import ArmFaultError, RefusedMotionError
from armsyn.planning.planner import SYNERGIES
from armsyn.planning.tracking import ReachTracker
from armsyn.planning.tracking_plan import LawPlanner
from armsyn.planning.tracking_sources import sources_of
from armsyn.synergy import load_library
from firmware_sim.testing import running

ARMS = ("human7", "widowx_250s", "openmanipulator_x")
RATE = 200.0
GOAL_US = 100.0
REACHES = 20


def planner_of(arm: ArmDescription) -> LawPlanner:
    """Planner of an arm, compiled."""
    planner = LawPlanner(arm, sources_of(arm))
    planner.prepare()
    return planner


def reachable(planner: LawPlanner, count: int) -> list[np.ndarray]:
    """Targets that are planned to from rest without refusal: where learned reaches go, shifted."""
    rng, found = np.random.default_rng(0), list[np.ndarray]()
    tracker = ReachTracker(planner, planner.arm.rest)
    library = load_library(find_file(planner.arm.name, SYNERGIES, None))
    learned = [np.array(reach.target_m) for reach in library.reaches]
    while len(found) < count:
        target = learned[rng.integers(len(learned))] + rng.uniform(-0.02, 0.02, 3)
        try:
            tracker.aim(target)
        except RefusedMotionError:
            continue
        found.append(target)
    return found


def alone(planner: LawPlanner, targets: list[np.ndarray]) -> tuple[list[float], list[float]]:
    """Seconds of each tick, and of each planning, of reaches one after the other."""
    ticks, plannings = list[float](), list[float]()
    fresh = np.ones(planner.arm.rest.size, dtype=bool)
    tracker = ReachTracker(planner, planner.arm.rest)
    t, posture = 0.0, planner.arm.rest
    for target in targets:
        began = time.perf_counter()
        try:
            tracker.aim(target)
        except RefusedMotionError:
            continue
        plannings.append(time.perf_counter() - began)
        for _ in range(round(0.6 * RATE)):  # in mid-motion the next one comes
            t += 1.0 / RATE
            state = SimpleNamespace(position=posture, fresh=fresh)
            began = time.perf_counter()
            wanted = tracker.setpoint(t, state)
            ticks.append(time.perf_counter() - began)
            assert wanted is not None
            posture = wanted
    return ticks, plannings


def inside(
    planner: LawPlanner, targets: list[np.ndarray], seconds: float
) -> tuple[list[float], list[float], float]:
    """Seconds of each tick inside a stream, its own processor time, and the share of misses."""
    ticks, own = list[float](), list[float]()
    with (
        running(arguments=("--arm", planner.arm.name)) as port,
        ArmSession.open(port, planner.arm, RATE, simulated=True) as session,
    ):
        session.gravity = False
        tracker = ReachTracker(planner, still_posture(session), earliest=BLEND)
        over = threading.Event()

        def setpoint(t: float, state: JointState) -> np.ndarray | None:
            began, before = time.perf_counter(), time.thread_time()
            wanted = tracker.setpoint(t, state)
            own.append(time.thread_time() - before)
            ticks.append(time.perf_counter() - began)
            return wanted

        def aim() -> None:
            k = 0
            while not over.wait(0.1):
                target = targets[k // 10 % len(targets)] + 0.01 * np.sin([k, 2 * k, 3 * k])
                with contextlib.suppress(RefusedMotionError):
                    tracker.aim(target)
                k += 1

        thread = threading.Thread(target=aim)
        thread.start()
        try:
            recording = session.run_setpoint(setpoint, seconds)
        except ArmFaultError as error:
            print(f"  {error}", file=sys.stderr)
            return ticks, own, float("nan")
        finally:
            over.set()
            thread.join()
    return ticks, own, recording.missed_ticks / (recording.ticks + recording.missed_ticks)


def line(name: str, seconds: list[float], unit: float = 1e6, word: str = "us") -> str:
    """Median, 90 %, 99 % and greatest of times."""
    found = unit * np.array(seconds)
    median, most, nearly_all = np.percentile(found, (50, 90, 99))
    return (
        f"  {name:26} median {median:7.1f} {word}, 90 % {most:7.1f}, 99 % {nearly_all:7.1f},"
        f" greatest {found.max():7.1f} ({found.size})"
    )


def main() -> int:
    """Print the figures; 1 when a median is above the goal."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=10.0, help="of the stream")
    options = parser.parse_args()
    sys.setswitchinterval(5e-4)  # as armsyn track does
    print(f"following targets, ticks of {1e3 / RATE:g} ms (goal: median below {GOAL_US:g} us)")
    worst = 0.0
    for name in ARMS:
        planner = planner_of(load_arm(name))
        targets = reachable(planner, REACHES)
        ticks, plannings = alone(planner, targets)
        worst = max(worst, 1e6 * statistics.median(ticks))
        print(f"{name}, {planner.arm.rest.size} joints")
        print(line("a tick, alone", ticks))
        print(line("planning a target", plannings, 1e3, "ms"))
    planner = planner_of(load_arm(ARMS[0]))
    ticks, own, missed = inside(planner, reachable(planner, REACHES), options.seconds)
    worst = max(worst, 1e6 * statistics.median(ticks))
    print(f"{ARMS[0]}, in a stream of {options.seconds:g} s with ten targets a second")
    print(line("a tick, in the stream", ticks))
    print(line("its own processor time", own))
    if np.isfinite(missed):
        print(f"  {missed:.1%} of the ticks missed")
    return int(worst > GOAL_US)


if __name__ == "__main__":
    sys.exit(main())
