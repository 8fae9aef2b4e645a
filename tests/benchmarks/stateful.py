"""The stateful test of `tests/driver/test_stateful.py`, for as long as one likes.

``python tests/benchmarks/stateful.py [--steps 10000] [--seed 0]`` lets a driver, an arm and an
operator go through so many steps while things go wrong, a fresh arm every fifty steps, and prints
how often what happened. It ends with the first rule that is not kept, and prints the way there.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from hypothesis import HealthCheck, Phase, seed, settings
from hypothesis.stateful import run_state_machine_as_test

from tests.driver.driven_arm import DrivenArm

STEPS, ARMS = 50, 10
"""Of one arm, and of one round."""


def main() -> int:
    """Run it and print what was seen."""
    parser = argparse.ArgumentParser(description="Driver, arm and operator while things go wrong")
    parser.add_argument("--steps", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    rules = settings(
        max_examples=ARMS,
        stateful_step_count=STEPS,
        deadline=None,
        database=None,
        report_multiple_bugs=False,
        phases=(Phase.generate,),
        suppress_health_check=list(HealthCheck),
    )
    started, number = time.perf_counter(), asked.seed
    seen = DrivenArm.seen
    while seen["steps"] < asked.steps:
        machine = seed(number)(DrivenArm)
        run_state_machine_as_test(machine, settings=rules)
        number += 1
        print(f"{seen['steps']} steps, {time.perf_counter() - started:.0f} s", flush=True)
    print(f"{seen.pop('steps')} steps, seeds {asked.seed} to {number - 1}: every rule was kept")
    for name, count in sorted(seen.items()):
        print(f"    {name:20} {count}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
