"""What a person is told to do, and an arm compared with its calibration."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.driver.calibrating_check import check_calibration
from armsyn.driver.calibrating_words import positive_direction
from tests.driver.set_up_bench import (
    arm_bench,
    by_rest,
    calibrator_of,
    remounted,
)


@pytest.fixture(scope="module")
def omx() -> ArmDescription:
    return load_arm("openmanipulator_x", calibrated=False)


@pytest.fixture(scope="module")
def widowx() -> ArmDescription:
    return load_arm("widowx_250s", calibrated=False)


def test_positive_directions_move_the_hand_as_said() -> None:
    """The hand is moved by the joint and looked at, instead of differentiated."""
    ways = {"forward": (0, 1), "backward": (0, -1), "to its left": (1, 1), "to its right": (1, -1)}
    ways |= {"up": (2, 1), "down": (2, -1)}
    for name in ("human7", "koch", "widowx_250s", "openmanipulator_x"):
        arm = load_arm(name, calibrated=False)
        turn = np.array(
            [
                [math.cos(arm.facing), math.sin(arm.facing), 0.0],
                [-math.sin(arm.facing), math.cos(arm.facing), 0.0],
                [0.0, 0.0, 1.0],
            ]
        )
        for row, joint in enumerate(arm.joint_names):
            words = positive_direction(arm, joint)
            moved = arm.rest.copy()
            moved[row] += 0.05
            step = turn @ (arm.chain.forward(moved).tip - arm.chain.forward(arm.rest).tip)
            if not words.startswith("the hand goes "):
                assert np.linalg.norm(step) < 0.05 * 0.035
                continue
            for way in words.removeprefix("the hand goes ").split(" and "):
                axis, sign = ways[way]
                assert sign * step[axis] > 0.3 * np.abs(step).max(), (name, joint, words)


def test_an_arm_as_calibrated_has_no_problems(tmp_path: Path, omx: ArmDescription) -> None:
    real = remounted(omx, s11={"zero_tick": 2200})
    bus, calibrator = calibrator_of(tmp_path, real, omx)
    calibration = by_rest(calibrator)
    found = check_calibration(bus, omx, calibration, at_rest=True)
    assert found.problems == ()
    assert [servo.angle for servo in found.servos] == pytest.approx(
        [servo.rest for servo in found.servos], abs=0.002
    )


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"registers": {13: {"Homing Offset": 50}}}, "homing offset is 50, was 0"),
        ({"registers": {13: {"Operating Mode": 4}}}, "operating mode is 4, was 3"),
        ({"start": {11: 2400}}, "off rest"),
        ({"start": {12: 3900}}, "beyond its limits"),
    ],
)
def test_what_has_changed_is_a_problem(
    tmp_path: Path, omx: ArmDescription, settings: dict[str, Any], said: str
) -> None:
    _, calibrator = calibrator_of(tmp_path, omx, omx)
    calibration = by_rest(calibrator)
    bus = arm_bench(tmp_path, omx.servo, **settings)
    found = check_calibration(bus, omx, calibration, at_rest=True)
    assert any(said in problem for problem in found.problems), found.problems


def test_another_model_and_a_missing_servo_are_problems(
    tmp_path: Path, omx: ArmDescription
) -> None:
    _, calibrator = calibrator_of(tmp_path, omx, omx)
    calibration = by_rest(calibrator)
    others = [msgspec.structs.replace(omx.servo[0], model="xm430-w210"), *omx.servo[1:]]
    (problem,) = check_calibration(arm_bench(tmp_path, others), omx, calibration).problems
    assert "is an xm430-w210" in problem
    (problem,) = check_calibration(arm_bench(tmp_path, omx.servo[1:]), omx, calibration).problems
    assert "no answer from servo 11" in problem
    koch = load_arm("koch", calibrated=False)
    bus = arm_bench(tmp_path, omx.servo)
    (problem,) = check_calibration(bus, koch, calibration).problems
    assert "does not fit" in problem
