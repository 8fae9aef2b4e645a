"""The checks at each tick, alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.arm import load_arm
from armsyn.errors import FollowingError, LimitError
from armsyn.safety import CommandLimits, check_command, check_following

LIMITS = CommandLimits(
    names=("a", "b"),
    lower=np.array([-1.0, -1.0]),
    upper=np.array([1.0, 1.0]),
    max_step=np.array([0.01, 0.01]),
)
ZERO = np.zeros(2)
ALL = np.array([True, True])


def test_limits_of_an_arm() -> None:
    arm = load_arm("human7")
    limits = CommandLimits.of(arm, 0.005)
    assert limits.names == arm.joint_names
    assert limits.max_step == pytest.approx(1.05 * 0.005 * arm.max_velocity)


@given(st.floats(), st.floats(-1.0, 1.0))
def test_only_near_commands_inside_the_range_pass(wanted: float, previous: float) -> None:
    fault = check_command(np.array([0.0, wanted]), np.array([0.0, previous]), LIMITS)
    allowed = abs(wanted) <= 1.0 + 1e-6 and abs(wanted - previous) <= 0.01  # false for NaN
    assert (fault is None) == allowed
    if fault is not None:
        assert fault.joint == "b"


@pytest.mark.parametrize(
    ("wanted", "text"),
    [
        (np.nan, "joint b: the command is nan"),
        (np.inf, "joint b: the command is inf"),
        (1.2, "joint b: the command 1.200 rad is outside its limit 1.000 rad"),
        (-1.2, "outside its limit -1.000 rad"),
        (0.5, "joint b: the command jumps by 0.5000 rad, 0.0100 rad are allowed a tick"),
    ],
)
def test_what_a_refused_command_says(wanted: float, text: str) -> None:
    fault = check_command(np.array([0.0, wanted]), ZERO, LIMITS)
    assert isinstance(fault, LimitError)
    assert text in str(fault)


@pytest.mark.fault(35)
@given(st.floats(-2.0, 2.0), st.floats(0.0, 5.0), st.booleans())
def test_the_following_error_allowed_grows_with_speed(
    error: float, speed: float, fresh: bool
) -> None:
    fault = check_following(
        ZERO, np.array([0.0, error]), np.array([0.0, speed]), np.array([True, fresh]), LIMITS
    )
    allowed = LIMITS.following_at_rest + LIMITS.following_per_speed * speed
    assert (fault is not None) == (fresh and abs(error) > allowed)


def test_the_joint_farthest_beyond_its_allowance_is_named() -> None:
    fault = check_following(ZERO, np.array([0.5, -0.6]), np.array([2.0, 0.0]), ALL, LIMITS)
    assert isinstance(fault, FollowingError)
    assert fault.joint == "b"
    assert fault.error_rad == pytest.approx(-0.6)
    assert "joint b is -0.600 rad off its goal, 0.150 rad are allowed" in str(fault)
