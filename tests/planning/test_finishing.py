"""Why a motion is refused when nothing that is tried serves."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.arm.shapes import BoxDescription
from armsyn.errors import CollisionError, LimitError
from armsyn.motion import Motion
from armsyn.planning.allowed import checked
from armsyn.planning.ending import EASE
from armsyn.planning.evening import WHOLLY, evened
from armsyn.planning.evenness import UnevenError
from armsyn.planning.finishing import finished
from armsyn.planning.posing import HandTask
from armsyn.planning.timing import in_time
from armsyn.safety import check_trajectory

PHASE = np.linspace(0.0, 1.0, 101)
END = np.array([-0.642, 0.752, 0.972, 1.339, -0.453, 1.073, -0.196])
BOW = np.array([0.787, -0.216, -0.368, 0.125, 0.516, 0.081, -0.293])


def test_what_stands_in_the_way_of_a_bell_is_named() -> None:
    """The motion as it is goes round two boxes, in two bells; ways in one bell touch one of them:
    near minimum jerk of the joints the first, with the hand straight the other.
    """
    arm = load_arm("human7", calibrated=False)
    bowed = arm.rest + EASE[:, None] * (END - arm.rest) + BOW * np.sin(np.pi * PHASE)[:, None] ** 2
    bowed = np.clip(bowed, arm.chain.lower, arm.chain.upper)
    middle = arm.chain.forward(evened(bowed, WHOLLY)[50]).tip
    straight = arm.chain.positions(bowed[[0, -1]])[:, -1].mean(axis=0)
    box = BoxDescription("box", tuple(middle.tolist()), (0.03, 0.03, 0.03))
    other = BoxDescription("other box", tuple(straight.tolist()), (0.02, 0.02, 0.02))
    task = HandTask(arm.chain.forward(bowed[-1]).tip)
    assert finished(arm, bowed, 1.0, task, 200.0).evened > 0.0
    with_box = msgspec.structs.replace(arm, box=(box, other))
    with pytest.raises(UnevenError):
        checked(with_box, bowed, 1.0, 200.0)
    with pytest.raises(
        CollisionError, match=r"box.* as predicted, the hand would speed up"
    ) as told:
        finished(with_box, bowed, 1.0, task, 200.0)
    assert told.value.second in ("box", "other box")


def test_a_contact_is_told_as_the_driver_tells_it() -> None:
    """The hand goes through a box: found by the compiled judge, and by `check_trajectory`."""
    arm = load_arm("human7", calibrated=False)
    motion = arm.rest + EASE[:, None] * (END - arm.rest)
    middle = arm.chain.forward(motion[50]).tip
    free = checked(arm, motion, 1.0, 200.0).angles
    with_box = msgspec.structs.replace(
        arm, box=(BoxDescription("box", tuple(middle.tolist()), (0.03, 0.03, 0.03)),)
    )
    with pytest.raises(CollisionError) as told:
        checked(with_box, motion, 1.0, 200.0)
    with pytest.raises(CollisionError) as wanted:
        check_trajectory(Motion(np.arange(len(free)) / 200.0, arm.joint_names, free), with_box)
    mine, drivers = told.value, wanted.value
    assert (mine.first, mine.second, mine.frame) == (drivers.first, drivers.second, drivers.frame)
    assert mine.depth == pytest.approx(drivers.depth, abs=1e-9)
    assert str(mine).split(" from ")[0] == str(drivers).split(" from ")[0]


def test_a_joint_that_swings_past_its_limit_is_told_before_what_it_touches_there() -> None:
    """It stops at once at its limit: every sample is within, the spline through them is not."""
    arm = load_arm("human7", calibrated=False)
    start, end = arm.rest.copy(), END.copy()
    start[3], end[3] = arm.chain.upper[3] - 0.15, arm.chain.upper[3]
    start[0] = end[0] + 1.5  # which stops at once, too, and has to be slowed more
    motion = start + EASE[:, None] * (end - start)
    at_once = start + np.minimum(PHASE / 0.3, 1.0)[:, None] * (end - start)
    motion[:, [0, 3]] = at_once[:, [0, 3]]
    middle = arm.chain.forward(motion[15]).tip
    box = BoxDescription("box", tuple(middle.tolist()), (0.03, 0.03, 0.03))
    with_box = msgspec.structs.replace(arm, box=(box,))
    samples = in_time(motion, 1.0, arm, 200.0).angles
    with pytest.raises(LimitError) as wanted:
        check_trajectory(Motion(np.arange(len(samples)) / 200.0, arm.joint_names, samples), arm)
    for one in (arm, with_box):
        with pytest.raises(LimitError, match="elbow_flexion") as told:
            checked(one, motion, 1.0, 200.0)
        assert (told.value.joint, told.value.value) == (wanted.value.joint, wanted.value.value)
