"""Every plan on every arm: what is accepted ends at its target, holds limits, and is one bell."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from armsyn.arm import ArmDescription, arm_names, find_file, load_arm
from armsyn.errors import DescriptionError, RefusedMotionError
from armsyn.planning import PLANS, Planner, planner_for
from armsyn.planning.planner import ATLAS
from armsyn.safety import check_trajectory
from armsyn.scoring import measure
from tests.kinematics.oracle import Oracle

ARMS = [name for name in arm_names() if load_arm(name).servo]
BEFORE = 0.45
"""Share of the joints' ranges about their middles from which targets and starts are drawn."""


def planner_of(name: str, plan: str) -> Planner:
    if plan in ("latent", "linear"):
        try:
            find_file(name, ATLAS)
        except DescriptionError:
            pytest.skip(f"{name} has no atlas")
    return planner_for(load_arm(name), plan)


def posture(arm: ArmDescription, shares: list[float]) -> np.ndarray:
    """Between limits, by shares from -1 to 1."""
    middle, half = (arm.chain.upper + arm.chain.lower) / 2, (arm.chain.upper - arm.chain.lower) / 2
    return np.asarray(middle + BEFORE * np.array(shares[: arm.chain.dof]) * half)


@pytest.mark.parametrize("plan", PLANS)
@pytest.mark.parametrize("name", ARMS)
def test_what_is_accepted_keeps_every_promise(name: str, plan: str) -> None:
    planner, accepted, asked = planner_of(name, plan), [], []
    arm = planner.arm
    oracle, shares = Oracle(arm.chain), st.lists(st.floats(-1, 1), min_size=7, max_size=7)

    @settings(
        max_examples=5,
        deadline=None,
        derandomize=True,
        database=None,
        suppress_health_check=[HealthCheck.too_slow],
    )
    @given(end=shares, start=shares, from_rest=st.booleans())
    def judged(end: list[float], start: list[float], *, from_rest: bool) -> None:
        target = oracle.frames(posture(arm, end))[0][-1]
        first = arm.rest if from_rest else 0.7 * arm.rest + 0.3 * posture(arm, start)
        asked.append(target)
        try:
            planned = planner.plan(first, target)
        except RefusedMotionError:  # below a table, through the trunk: it is said
            return
        accepted.append(target)
        check_trajectory(planned.trajectory, arm, first)
        assert np.linalg.norm(oracle.frames(planned.angles[-1])[0][-1] - target) <= 1e-3
        assert planned.error_m <= 1e-3
        assert planned.time_scale >= 1.0
        assert planned.plan == plan
        assert bool(planned.refused) == (planned.evened > 0 or planned.swivel_m is not None)
        if np.linalg.norm(target - oracle.frames(first)[0][-1]) > 0.03:
            assert measure(planned.trajectory).speed_peaks == 1

    judged()
    assert len(accepted) >= len(asked) // 4
