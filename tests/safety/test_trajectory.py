"""The check of a whole trajectory: what it lets pass, and what it says of the rest."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.arm import ArmDescription, load_arm
from armsyn.errors import InputError, LimitError, RefusedMotionError
from armsyn.motion import Motion
from armsyn.safety import check_trajectory

RATE = 200.0
ELBOW = 3


@pytest.fixture(scope="module")
def arm() -> ArmDescription:
    return load_arm("human7")


def sine(arm: ArmDescription, amplitude: float, duration: float) -> np.ndarray:
    """Elbow out and back by a raised cosine; peak speed and acceleration have closed forms."""
    time = np.arange(int(duration * RATE) + 1) / RATE
    angles = np.tile(arm.rest, (time.size, 1))
    angles[:, ELBOW] += amplitude * 0.5 * (1.0 - np.cos(2.0 * np.pi * time / time[-1]))
    return angles


def motion(arm: ArmDescription, angles: np.ndarray, time: np.ndarray | None = None) -> Motion:
    return Motion(
        time=np.arange(len(angles)) / RATE if time is None else time,
        joint_names=arm.joint_names,
        angles=angles,
        source="test",
    )


def test_a_gentle_motion_passes(arm: ArmDescription) -> None:
    check_trajectory(motion(arm, sine(arm, 0.8, 2.0)), arm, arm.rest)


def test_speed_by_its_closed_form(arm: ArmDescription) -> None:
    # raised cosine of amplitude A over T: peak speed A pi / T, peak acceleration 2 A (pi / T)^2
    limit, amplitude = arm.max_velocity[ELBOW], 1.2
    duration = amplitude * np.pi / limit
    check_trajectory(motion(arm, sine(arm, amplitude, duration * 1.02)), arm)
    with pytest.raises(LimitError) as caught:
        check_trajectory(motion(arm, sine(arm, amplitude, duration * 0.95)), arm)
    assert caught.value.joint == "elbow_flexion"
    assert caught.value.limit == limit
    assert abs(caught.value.value) == pytest.approx(limit / 0.95, rel=0.02)
    assert "a speed of" in str(caught.value)


def test_acceleration_by_its_closed_form(arm: ArmDescription) -> None:
    limit, amplitude = arm.max_acceleration[ELBOW], 0.2
    duration = np.pi * np.sqrt(2.0 * amplitude / limit)
    check_trajectory(motion(arm, sine(arm, amplitude, duration * 1.05)), arm)
    with pytest.raises(LimitError, match="elbow_flexion would have an acceleration of") as caught:
        check_trajectory(motion(arm, sine(arm, amplitude, duration * 0.93)), arm)
    assert caught.value.limit == limit


@pytest.mark.parametrize("end", ["first", "last"])
def test_a_motion_that_does_not_start_or_end_at_rest(arm: ArmDescription, end: str) -> None:
    angles = sine(arm, 0.8, 2.0)
    cut = angles[100:] if end == "first" else angles[:100]
    with pytest.raises(LimitError, match="acceleration"):
        check_trajectory(motion(arm, cut), arm)


def test_a_joint_outside_its_range(arm: ArmDescription) -> None:
    angles = sine(arm, 2.2, 8.0)
    with pytest.raises(LimitError) as caught:
        check_trajectory(motion(arm, angles), arm)
    frame = int(np.argmax(angles[:, ELBOW] > arm.chain.upper[ELBOW] + 1e-6))
    assert caught.value.value == angles[frame, ELBOW]
    assert caught.value.limit == arm.chain.upper[ELBOW]
    assert f"at {frame / RATE:.3f} s" in str(caught.value)


def test_a_joint_exactly_at_its_limit_passes(arm: ArmDescription) -> None:
    angles = np.tile(arm.chain.upper, (50, 1))
    check_trajectory(motion(arm, angles), arm)


def test_a_start_elsewhere(arm: ArmDescription) -> None:
    angles = sine(arm, 0.8, 2.0)
    elsewhere = arm.rest.copy()
    elsewhere[ELBOW] += 0.06
    with pytest.raises(
        LimitError, match=r"elbow_flexion is at 0.622 rad but .* at 0.562"
    ) as caught:
        check_trajectory(motion(arm, angles), arm, elsewhere)
    assert caught.value.value == pytest.approx(0.06)
    check_trajectory(motion(arm, angles), arm, elsewhere, start_tolerance=0.07)


@given(st.integers(0, 99), st.integers(0, 6), st.sampled_from([np.nan, np.inf, -np.inf]))
def test_values_that_are_no_numbers(frame: int, joint: int, value: float) -> None:
    arm = load_arm("human7")
    angles = np.tile(arm.rest, (100, 1))
    angles[frame, joint] = value
    with pytest.raises(InputError, match=f"{arm.joint_names[joint]} is {value} at") as caught:
        check_trajectory(motion(arm, angles), arm)
    assert caught.value.exit_status == 2


def test_time_stamps_that_are_not_uniform(arm: ArmDescription) -> None:
    time = np.arange(100) / RATE
    time[60:] += 0.001
    with pytest.raises(RefusedMotionError, match=r"0\.006000 s at 0\.295 s"):
        check_trajectory(motion(arm, np.tile(arm.rest, (100, 1)), time), arm)


def test_motions_that_are_not_this_arms(arm: ArmDescription) -> None:
    landmarks = Motion(
        time=np.arange(3) / RATE, landmark_names=("hand",), landmarks=np.zeros((3, 1, 3))
    )
    with pytest.raises(InputError, match="no joint angles"):
        check_trajectory(landmarks, arm)
    other = Motion(time=np.arange(3) / RATE, joint_names=("a",), angles=np.zeros((3, 1)))
    with pytest.raises(InputError, match="joints are"):
        check_trajectory(other, arm)
    with pytest.raises(InputError, match="present posture"):
        check_trajectory(motion(arm, sine(arm, 0.1, 1.0)), arm, [0.0, 1.0])
