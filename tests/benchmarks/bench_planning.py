"""What planning one reach takes in a running program, by every plan of an arm.

Seeded targets before human7, from rest, each planned, slowed, checked for limits, collision and one
peak of the hand's speed. The least and the median, with what stays as predicted and what had to be
changed apart; processor time of this process, so that a busy machine matters less (though not
nothing: what runs beside it takes the caches).
"""

from __future__ import annotations

import time

import numpy as np

from armsyn.arm import load_arm
from armsyn.errors import InputError, RefusedMotionError
from armsyn.planning import PLANS, Planner, planner_for

TARGETS = 200
LOWEST, HIGHEST = (0.2, -0.35, -0.30), (0.45, 0.10, 0.05)
GOAL_MS = 1.0


def main() -> None:
    """Print the table."""
    arm = load_arm("human7")
    targets = np.random.default_rng(0).uniform(LOWEST, HIGHEST, (TARGETS, 3))
    print(f"planning one reach of human7, {TARGETS} seeded targets; goal: under {GOAL_MS:g} ms")
    print(
        f"{'':10}{'as predicted':>14}{'least us':>10}{'median':>8}{'changed':>10}{'median':>8}"
        f"{'refused':>10}"
    )
    for plan in PLANS:
        try:
            planner = planner_for(arm, plan)
        except InputError as error:
            print(f"{plan:10}{error}")
            continue
        planner.plan(arm.rest, targets[0])  # compiled before it is timed
        free, changed, refused = timed(planner, targets)
        print(
            f"{plan:10}{len(free):14}{min(free):10.0f}{median(free):8.0f}{len(changed):10}{median(changed):8.0f}"
            f"{refused:10}"
        )


def timed(planner: Planner, targets: np.ndarray) -> tuple[list[float], list[float], int]:
    """Return microseconds of plans that stayed as predicted, of others, and how many refused."""
    free: list[float] = []
    changed: list[float] = []
    refused = 0
    for target in targets:
        began = time.process_time()
        try:
            planned = planner.plan(planner.arm.rest, target)
        except RefusedMotionError:
            refused += 1
            continue
        spent = (time.process_time() - began) * 1e6
        (changed if planned.refused or planned.rank else free).append(spent)
    return free, changed, refused


def median(values: list[float]) -> float:
    """Median, or NaN of none."""
    return float(np.median(values)) if values else float("nan")


if __name__ == "__main__":
    main()
