"""What planning one reach takes in a running program, by every plan of an arm.

Seeded targets before human7, from rest and from seeded postures anywhere within the joints' ranges
that touch nothing; each planned, slowed, checked for limits, collision and one peak of the hand's
speed. The least and the median, with what stays as predicted and what had to be changed apart, and
how; processor time of this process, so that a busy machine matters less (though not nothing: what
runs beside it takes the caches).
"""

from __future__ import annotations

import time
from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription, load_arm
from armsyn.errors import InputError, RefusedMotionError
from armsyn.planning import PLANS, PlannedReach, Planner, planner_for
from armsyn.safety import check_collision

FloatArray = NDArray[np.float64]

TARGETS = 200
LOWEST, HIGHEST = (0.2, -0.35, -0.30), (0.45, 0.10, 0.05)
GOAL_MS = 1.0
PREDICTED, EVENED, TURNED, REFUSED = "as predicted", "evened", "other swivel", "refused"
OUTCOMES = (PREDICTED, EVENED, TURNED, REFUSED)


def main() -> None:
    """Print the tables."""
    arm = load_arm("human7")
    targets = np.random.default_rng(0).uniform(LOWEST, HIGHEST, (TARGETS, 3))
    starts = {"rest": np.tile(arm.rest, (TARGETS, 1)), "anywhere": free_postures(arm, TARGETS)}
    print(
        f"planning one reach of human7, {TARGETS} seeded targets; goal: under {GOAL_MS:g} ms"
        "\nhow many, least and median us:"
    )
    print(f"{'':10}{'from':10}" + "".join(f"{outcome:>22}" for outcome in OUTCOMES))
    for plan in PLANS:
        try:
            planner = planner_for(arm, plan)
        except InputError as error:
            print(f"{plan:10}{error}")
            continue
        planner.plan(arm.rest, targets[0])  # compiled before it is timed
        for name, postures in starts.items():
            spent = timed(planner, postures, targets)
            print(f"{plan:10}{name:10}" + "".join(f"{row(spent[kind]):>22}" for kind in OUTCOMES))


def free_postures(arm: ArmDescription, count: int) -> FloatArray:
    """Return seeded postures within the joints' ranges that touch nothing, shape (count, n)."""
    drawn = np.random.default_rng(1).uniform(
        arm.chain.lower, arm.chain.upper, (10 * count, arm.chain.dof)
    )
    return np.array([posture for posture in drawn if not check_collision([posture], arm)][:count])


def timed(planner: Planner, starts: FloatArray, targets: FloatArray) -> dict[str, list[float]]:
    """Return microseconds of every plan, by what came of it."""
    spent = defaultdict(list)
    for start, target in zip(starts, targets, strict=True):
        began = time.process_time()
        try:
            outcome = outcome_of(planner.plan(start, target))
        except RefusedMotionError:
            outcome = REFUSED
        spent[outcome].append((time.process_time() - began) * 1e6)
    return spent


def outcome_of(planned: PlannedReach) -> str:
    """Return what was done to the motion as it was predicted."""
    if planned.swivel_m is not None:
        return TURNED
    return EVENED if planned.evened else PREDICTED


def row(values: list[float]) -> str:
    """How many, the least and the median; nothing of none."""
    return f"{len(values)}: {min(values):,.0f} {np.median(values):,.0f}" if values else "0"


if __name__ == "__main__":
    main()
