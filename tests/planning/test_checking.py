"""Targets and postures that are no numbers, or none that an arm has to do with."""

from typing import Any

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.errors import InputError, UnreachableError
from armsyn.planning.checking import FARTHEST, checked_start, checked_target
from armsyn.planning.planner import planner_for
from armsyn.planning.prediction import checked_reaches

WRONG: dict[str, Any] = {
    "text": ["a", 0, 0],
    "complex": [1j, 0, 0],
    "complex array": np.array([1j, 0, 0]),
    "different lengths": [[1, 2], [3], 0],
    "an integer beyond floats": [10**400, 0, 0],
    "nothing": [None, 0, 0],
    "not finite": [np.inf, 0, 0],
    "two": [1, 0],
}
FAR = ([1e300, 0, 0], [-1e200, 0, 0], [0, 0, 2 * FARTHEST])


def is_short(error: BaseException) -> bool:
    return "\n" not in str(error) and len(str(error)) < 120


@pytest.mark.parametrize("wrong", WRONG)
def test_what_is_no_target_is_refused_in_one_line(wrong: str) -> None:
    with pytest.raises(InputError, match="a target is") as caught:
        checked_target(WRONG[wrong])
    assert is_short(caught.value)


@pytest.mark.parametrize("far", FAR)
@pytest.mark.filterwarnings("error")
def test_a_target_that_would_overflow_is_refused_in_one_line(far: list[float]) -> None:
    arm = load_arm("human7", calibrated=False)
    with pytest.raises(InputError, match="a target lies within 1e\\+06 m of the base") as caught:
        planner_for(arm, "minjerk").plan(arm.rest, far)
    assert is_short(caught.value)


def test_millimetres_are_told_as_before() -> None:
    arm = load_arm("human7", calibrated=False)
    with pytest.raises(UnreachableError, match="targets are in metres"):
        planner_for(arm, "minjerk").plan(arm.rest, [300.0, 100.0, 0.0])


@pytest.mark.parametrize("wrong", WRONG)
def test_what_is_no_posture_is_refused(wrong: str) -> None:
    arm = load_arm("human7", calibrated=False)
    with pytest.raises(InputError, match="a posture"):
        checked_start(arm, WRONG[wrong])


@pytest.mark.parametrize("wrong", ["text", "complex", "complex array", "different lengths"])
def test_predictors_refuse_what_is_no_number(wrong: str) -> None:
    chain = load_arm("human7", calibrated=False).chain
    with pytest.raises(InputError, match="a target is made of real numbers"):
        checked_reaches(chain, np.zeros((1, chain.dof)), [WRONG[wrong]])
