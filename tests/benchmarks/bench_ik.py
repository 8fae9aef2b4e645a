"""How often each optimiser finds a reachable target from a random posture, and how fast.

1,000 seeded pairs of random postures of human7 within its limits: one gives the target (so it
can be reached), the other the start. Once with a single descent, once with restarts.
"""

from __future__ import annotations

import time

import numpy as np

from armsyn.arm import load_arm
from armsyn.ik import OPTIMISERS, solve_ik

PAIRS = 1_000
RESTARTS = 20
MAX_STEPS = 2_000


def main() -> None:
    """Print the table."""
    chain = load_arm("human7").chain
    pairs = np.random.default_rng(0).uniform(chain.lower, chain.upper, (PAIRS, 2, chain.dof))
    solve_ik(chain, chain.forward(pairs[0, 0]).tip, pairs[0, 1])  # compiled before it is timed
    print(f"{PAIRS} seeded random postures of human7, to 0.1 mm (and 0.1 mrad), {MAX_STEPS} steps")
    print(f"{'':16}{'one descent':>14}{'steps':>8}{'us':>9}{f'{RESTARTS} restarts':>16}{'us':>9}")
    for task in ("position", "pose"):
        for optimiser in OPTIMISERS:
            cells = []
            for restarts in (0, RESTARTS):
                began = time.perf_counter()
                found = [
                    solve_ik(
                        chain,
                        (goal := chain.forward(wanted)).tip,
                        start,
                        orientation=goal.orientations[-1] if task == "pose" else None,
                        optimiser=optimiser,
                        restarts=restarts,
                        max_steps=MAX_STEPS,
                    )
                    for wanted, start in pairs
                ]
                mean_us = (time.perf_counter() - began) / PAIRS * 1e6
                rate = sum(result.success for result in found) / PAIRS
                steps = float(np.median([result.steps for result in found]))
                cells.append((rate, steps, mean_us))
            (one, steps, one_us), (many, _, many_us) = cells
            print(
                f"{task + ' ' + optimiser:16}{one:14.3f}{steps:8.0f}{one_us:9.0f}"
                f"{many:16.3f}{many_us:9.0f}"
            )


if __name__ == "__main__":
    main()
