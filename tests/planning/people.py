"""Reaches of our own making, whose motions are exactly linear in the target."""

import numpy as np

from armsyn.arm import load_arm
from armsyn.planning.examples import PHASE, PHASES, Examples


def made_examples(count: int = 40, noise: float = 0.0, seed: int = 0) -> Examples:
    """Reaches of the HuG-MP arm between postures drawn at random, along minimum jerk."""
    arm, draw = load_arm("hug_mp4", calibrated=False), np.random.default_rng(seed)
    starts = arm.rest + draw.normal(0.0, 0.02, (count, 4))
    ends = np.array([-0.8, -0.7, -0.3, 0.9]) + draw.uniform(-0.25, 0.25, (count, 4))
    ease = (PHASE**3 * (10 - 15 * PHASE + 6 * PHASE**2))[:, None]
    angles = starts[:, None] + (ends - starts)[:, None] * ease
    angles += noise * draw.normal(0.0, 1.0, (count, 1, 4)) * np.sin(np.pi * PHASE)[:, None]
    targets = arm.chain.positions(angles[:, -1])[:, -1]
    assert angles.shape == (count, PHASES, 4)
    return Examples(
        arm.chain,
        tuple(f"made:{row}" for row in range(count)),
        ("made",) * count,
        tuple(f"place {row % 8}" for row in range(count)),
        angles,
        1.0 + 0.5 * np.linalg.norm(targets, axis=1),
        targets,
    )
