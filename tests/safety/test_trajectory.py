"""The check of a whole trajectory: what it lets pass, and what it says of the rest."""

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.arm import ArmDescription, load_arm
from armsyn.errors import CollisionError, InputError, LimitError, RefusedMotionError
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


@pytest.mark.fault(31)
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


@pytest.mark.fault(31)
def test_acceleration_by_its_closed_form(arm: ArmDescription) -> None:
    limit, amplitude = arm.max_acceleration[ELBOW], 0.2
    duration = np.pi * np.sqrt(2.0 * amplitude / limit)
    check_trajectory(motion(arm, sine(arm, amplitude, duration * 1.05)), arm)
    with pytest.raises(LimitError, match="elbow_flexion would have an acceleration of") as caught:
        check_trajectory(motion(arm, sine(arm, amplitude, duration * 0.93)), arm)
    assert caught.value.limit == limit


def with_jerk(arm: ArmDescription, limit: float) -> ArmDescription:
    joints = tuple(msgspec.structs.replace(joint, max_jerk=limit) for joint in arm.joint)
    return msgspec.structs.replace(arm, joint=joints)


def with_fast(arm: ArmDescription) -> ArmDescription:
    """Return an arm that may do anything but leave its ranges and touch."""
    joints = tuple(
        msgspec.structs.replace(joint, max_velocity=1e9, max_acceleration=1e9, max_jerk=1e12)
        for joint in arm.joint
    )
    return msgspec.structs.replace(arm, joint=joints)


def minimum_jerk(arm: ArmDescription, way: float, duration: float, rate: float) -> Motion:
    """Elbow from rest to rest: peak jerk 60 way / duration^3, at both ends."""
    time = np.arange(round(duration * rate) + 1) / rate
    u = (time / time[-1])[:, None]
    angles = np.tile(arm.rest, (time.size, 1))
    angles[:, [ELBOW]] += way * (10.0 * u**3 - 15.0 * u**4 + 6.0 * u**5)
    return motion(arm, angles, time)


@pytest.mark.fault(31)
@pytest.mark.parametrize("rate", [200.0, 1000.0])
def test_jerk_by_its_closed_form(arm: ArmDescription, rate: float) -> None:
    way, duration, fast = 2.0, 0.3, with_fast(arm)
    careful = with_jerk(fast, 60.0 * way / duration**3)
    check_trajectory(minimum_jerk(arm, way, duration * 1.01, rate), careful)
    with pytest.raises(LimitError, match="elbow_flexion would have a jerk of") as caught:
        check_trajectory(minimum_jerk(arm, way, duration * 0.85, rate), careful)
    assert caught.value.limit == 60.0 * way / duration**3
    assert abs(caught.value.value) == pytest.approx(60.0 * way / (0.85 * duration) ** 3, rel=0.2)
    check_trajectory(minimum_jerk(arm, way, duration * 0.85, rate), fast)


def test_where_no_jerk_is_given_it_comes_of_the_acceleration(arm: ArmDescription) -> None:
    """From no acceleration to the limit in 4 ms; slowed arms keep that time."""
    np.testing.assert_allclose(arm.max_jerk, arm.max_acceleration / 0.004)
    slowed = arm.slowed(2.0)
    np.testing.assert_allclose(slowed.max_jerk, slowed.max_acceleration / 0.004)
    np.testing.assert_allclose(with_jerk(arm, 80.0).slowed(2.0).max_jerk, 10.0)


@pytest.mark.parametrize("rate", [100.0, 200.0, 500.0, 1000.0])
def test_a_step_of_acceleration_is_judged_alike_at_any_rate(
    arm: ArmDescription, rate: float
) -> None:
    """A raised cosine begins with its greatest acceleration at once."""
    time = np.arange(round(rate) + 1) / rate
    amplitude = 0.95 * arm.max_acceleration[ELBOW] / (2.0 * np.pi**2)
    angles = np.tile(arm.rest, (time.size, 1))
    angles[:, ELBOW] += amplitude * 0.5 * (1.0 - np.cos(2.0 * np.pi * time))
    check_trajectory(motion(arm, angles, time), arm)
    with pytest.raises(LimitError, match="jerk"):
        check_trajectory(motion(arm, angles, time), with_jerk(arm, 0.4 * 0.95 * 15.0 / 0.01))


@pytest.mark.parametrize("rate", [200.0, 1000.0])
def test_rounding_breaks_no_limit(arm: ArmDescription, rate: float) -> None:
    gentle = minimum_jerk(arm, 0.5, 2.0, rate)
    assert gentle.angles is not None
    check_trajectory(motion(arm, gentle.angles.round(6), gentle.time), arm)
    single = gentle.angles.astype(np.float32).astype(np.float64)
    check_trajectory(motion(arm, single, gentle.time), arm)


@pytest.mark.fault(34)
def test_the_way_through_the_trunk_is_refused(arm: ArmDescription) -> None:
    """Both ends are free: the forearm swings through the trunk between them."""
    start, goal = arm.rest.copy(), arm.rest.copy()
    start[[0, 2, 3]], goal[[0, 2, 3]] = [0.9, 1.4, 1.5], [-0.9, 1.4, 1.5]
    time = np.arange(801) / 200.0
    u = (time / time[-1])[:, None]
    angles = start + (10.0 * u**3 - 15.0 * u**4 + 6.0 * u**5) * (goal - start)
    with pytest.raises(CollisionError, match=r"would be .* m inside .* from \d\.\d+ s") as caught:
        check_trajectory(motion(arm, angles), arm, start)
    assert caught.value.exit_status == 4
    assert "base" in (caught.value.first, caught.value.second)
    assert 0 < caught.value.frame < 800
    assert caught.value.depth > 0.0
    check_trajectory(motion(arm, angles[: caught.value.frame - 1]), with_fast(arm))


@pytest.mark.parametrize("end", ["first", "last"])
def test_a_motion_that_does_not_start_or_end_at_rest(arm: ArmDescription, end: str) -> None:
    angles = sine(arm, 0.8, 2.0)
    cut = angles[100:] if end == "first" else angles[:100]
    with pytest.raises(LimitError, match="acceleration"):
        check_trajectory(motion(arm, cut), arm)


@pytest.mark.fault(33)
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


@pytest.mark.fault(31)
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


@pytest.mark.fault(30)
@given(st.integers(0, 99), st.integers(0, 6), st.sampled_from([np.nan, np.inf, -np.inf]))
def test_values_that_are_no_numbers(frame: int, joint: int, value: float) -> None:
    arm = load_arm("human7")
    angles = np.tile(arm.rest, (100, 1))
    angles[frame, joint] = value
    name = arm.joint_names[joint]
    said = f"{name} is nan at" if np.isnan(value) else f"angles of '{name}' at frame {frame} are"
    with pytest.raises(InputError, match=said) as caught:  # no motion holds an infinite one
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
