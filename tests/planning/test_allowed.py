"""What an arm may follow is the same whether all motions are judged or those in one bell only."""

from __future__ import annotations

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.kernels.judging import ALLOWED
from armsyn.planning.allowed import tried

COUNT, RATE_HZ = 300, 200.0


@pytest.mark.parametrize("name", ["human7", "widowx_250s"])
def test_what_is_judged_in_one_bell_only_is_judged_as_all_are(name: str) -> None:
    arm = load_arm(name, calibrated=False)
    chain, rng = arm.chain, np.random.default_rng(0)
    start, end = rng.uniform(chain.lower, chain.upper, (2, COUNT, 1, chain.dof))
    phase = np.linspace(0.0, 1.0, 101)[:, None]
    swing = rng.uniform(-0.5, 0.5, (COUNT, 1, chain.dof)) * rng.integers(0, 2, (COUNT, 1, 1))
    motions = start + phase * (end - start) + swing * np.sin(4.0 * np.pi * phase) ** 2
    durations = rng.uniform(0.3, 1.2, COUNT)
    whole = tried(arm, motions, durations, RATE_HZ)
    some = tried(arm, motions, durations, RATE_HZ, in_bells=True)
    for outcome in (whole.allowed, whole.uneven, whole.beyond, whole.verdicts.kinds != ALLOWED):
        assert 0 < np.count_nonzero(outcome) < COUNT
    np.testing.assert_array_equal(some.allowed, whole.allowed)
    np.testing.assert_array_equal(some.swung, whole.swung)
    np.testing.assert_array_equal(some.paced.paths, whole.paced.paths)
    judged = some.verdicts.kinds != ALLOWED
    assert judged.any()
    for part, all_of_it in zip(some.verdicts, whole.verdicts, strict=True):
        np.testing.assert_array_equal(part[judged], all_of_it[judged])
