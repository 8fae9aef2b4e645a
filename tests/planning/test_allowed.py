"""What is tried in one compiled call is what pacing, judging and counting bells say apart."""

from __future__ import annotations

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.kernels.judging import ALLOWED
from armsyn.kernels.pacing import fill_beyond, hold_within
from armsyn.planning.allowed import SWING, tried
from armsyn.planning.bending import INSIDE
from tests.planning.apart import judge, pace, uneven_reaches

COUNT, RATE_HZ = 60, 200.0


@pytest.mark.parametrize("name", ["human7", "widowx_250s"])
def test_one_call_says_what_its_parts_say(name: str) -> None:
    arm = load_arm(name, calibrated=False)
    chain, rng = arm.chain, np.random.default_rng(0)
    ends = rng.uniform(chain.lower, chain.upper, (2, COUNT, 1, chain.dof))
    phase = np.linspace(0.0, 1.0, 101)[:, None]
    swing = rng.uniform(-0.5, 0.5, (COUNT, 1, chain.dof)) * rng.integers(0, 2, (COUNT, 1, 1))
    motions = ends[0] + phase * (ends[1] - ends[0]) + swing * np.sin(4.0 * np.pi * phase) ** 2
    durations = rng.uniform(0.3, 1.2, COUNT)
    found = tried(arm, motions, durations, RATE_HZ)

    beyond, swung = np.empty((2, COUNT), dtype=np.bool_)
    fill_beyond(chain.lower, chain.upper, INSIDE, motions, beyond)
    paced = pace(arm, motions, durations, RATE_HZ)
    hold_within(chain.lower, chain.upper, SWING, paced.first, paced.paths, swung)
    verdicts, uneven = judge(arm, paced), uneven_reaches(chain, paced)
    good = (verdicts.kinds == ALLOWED) & ~beyond & ~swung
    np.testing.assert_array_equal(found.paced.first, paced.first)
    np.testing.assert_allclose(found.paced.scales, paced.scales, rtol=1e-12)
    np.testing.assert_allclose(found.paced.paths, paced.paths, rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(found.beyond, beyond)
    np.testing.assert_array_equal(found.swung, swung)
    np.testing.assert_array_equal(found.verdicts.kinds, verdicts.kinds)
    np.testing.assert_array_equal(found.verdicts.frames, verdicts.frames)
    np.testing.assert_array_equal(found.verdicts.items, verdicts.items)
    np.testing.assert_allclose(found.verdicts.values, verdicts.values, rtol=1e-9)
    np.testing.assert_array_equal(found.allowed, good & ~uneven)
    np.testing.assert_array_equal(found.uneven, good & uneven)
    for kind in (found.allowed, found.uneven, found.beyond, verdicts.kinds != ALLOWED):
        assert 0 < np.count_nonzero(kind) < COUNT

    bells = tried(arm, motions, durations, RATE_HZ, in_bells=True)
    np.testing.assert_array_equal(bells.allowed, found.allowed)
    np.testing.assert_array_equal(bells.swung, found.swung)
