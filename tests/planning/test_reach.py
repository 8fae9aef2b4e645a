"""Reaches of the human-like arm, planned with the synergies that come with the project."""

import dataclasses

import msgspec
import numpy as np
import pytest

from armsyn.arm import ArmDescription, find_file, load_arm
from armsyn.arm.shapes import BoxDescription
from armsyn.errors import CollisionError, InputError, LimitError, UnreachableError
from armsyn.motion import Motion
from armsyn.planning import PlannedReach, SynergyPlanner, concatenated
from armsyn.planning.synergy_planner import ARRIVED_M
from armsyn.safety import check_trajectory
from armsyn.scoring import correlation, measure, normalised_speed
from armsyn.synergy import SynergyLibrary, load_library
from tests.kinematics.oracle import Oracle

RATE = 200.0


@pytest.fixture(scope="module")
def arm() -> ArmDescription:
    return load_arm("human7")


@pytest.fixture(scope="module")
def library() -> SynergyLibrary:
    return load_library(find_file("human7", ".synergies.json"))


@pytest.fixture(scope="module")
def planner(arm: ArmDescription, library: SynergyLibrary) -> SynergyPlanner:
    return SynergyPlanner(arm, library)


def targets(count: int = 20) -> np.ndarray:
    """Return seeded random targets in the box before the shoulder, within 95 % of the arm."""
    rng, found = np.random.default_rng(2), []
    while len(found) < count:
        target = rng.uniform([0.2, -0.35, -0.30], [0.45, 0.10, 0.05])
        if np.linalg.norm(target) <= 0.95 * 0.66:
            found.append(target)
    return np.array(found)


def angles_of(planned: PlannedReach) -> np.ndarray:
    assert planned.trajectory.angles is not None
    return planned.trajectory.angles


@pytest.fixture(scope="module")
def reaches(arm: ArmDescription, planner: SynergyPlanner) -> list[PlannedReach]:
    return [planner.plan(arm.rest, target, RATE) for target in targets()]


def test_they_start_at_the_posture_and_end_at_the_target(
    arm: ArmDescription, reaches: list[PlannedReach]
) -> None:
    oracle = Oracle(arm.chain)
    for planned, target in zip(reaches, targets(), strict=True):
        angles = angles_of(planned)
        np.testing.assert_array_equal(angles[0], arm.rest)
        assert np.linalg.norm(oracle.frames(angles[-1])[0][-1] - target) <= ARRIVED_M
        np.testing.assert_allclose(planned.trajectory.time, np.arange(len(angles)) / RATE)
        hand = np.array([oracle.frames(q)[0][-1] for q in angles[::20]])
        np.testing.assert_allclose(planned.trajectory.hand[::20], hand, atol=1e-9)
        assert planned.trajectory.landmark_names == tuple(arm.landmarks)


def test_they_keep_range_speed_and_acceleration(
    arm: ArmDescription, reaches: list[PlannedReach]
) -> None:
    """By plain differences, at rest before and after; and the safety room agrees."""
    slowed = 0
    for planned in reaches:
        angles = angles_of(planned)
        assert (angles >= arm.chain.lower).all()
        assert (angles <= arm.chain.upper).all()
        resting = np.vstack([angles[:1], angles[:1], angles, angles[-1:], angles[-1:]])
        velocity = (resting[2:] - resting[:-2]) * RATE / 2
        acceleration = (resting[2:] - 2 * resting[1:-1] + resting[:-2]) * RATE**2
        assert (np.abs(velocity) <= arm.max_velocity).all()
        assert (np.abs(acceleration) <= arm.max_acceleration).all()
        check_trajectory(planned.trajectory, arm, arm.rest)
        assert planned.time_scale >= 1.0
        slowed += planned.time_scale > 1.0
    assert slowed > 10  # people are faster than these servos


def test_the_arm_is_slowed_no_more_than_it_needs(
    arm: ArmDescription, reaches: list[PlannedReach]
) -> None:
    for planned in reaches:
        if planned.time_scale == 1.0:
            continue
        angles = angles_of(planned)
        velocity = np.diff(angles, axis=0) * RATE
        acceleration = np.diff(velocity, axis=0) * RATE
        used = max(
            (np.abs(velocity) / arm.max_velocity).max(),
            np.sqrt((np.abs(acceleration) / arm.max_acceleration).max()),
        )
        assert used > 0.9


def test_the_hands_speed_is_a_persons(reaches: list[PlannedReach]) -> None:
    likeness = []
    for planned in reaches:
        found = measure(planned.trajectory)
        assert found.speed_peaks == 1
        assert 0.25 < found.time_to_peak < 0.65
        assert found.min_jerk_r > 0.6
        speed = normalised_speed(planned.trajectory.time, planned.trajectory.hand)
        likeness.append(correlation(np.array(planned.learned.speed_profile), speed))
    assert np.median(likeness) > 0.85


def test_without_synergy_it_is_not(arm: ArmDescription, library: SynergyLibrary) -> None:
    raw, likeness = SynergyPlanner(arm, library, model="A"), []
    for target in targets():
        planned = raw.plan(arm.rest, target, RATE)
        speed = normalised_speed(planned.trajectory.time, planned.trajectory.hand)
        likeness.append(correlation(np.array(planned.learned.speed_profile), speed))
    assert np.median(likeness) < 0.4


def test_the_synergy_is_the_nearest_that_arrives(
    arm: ArmDescription, library: SynergyLibrary, reaches: list[PlannedReach]
) -> None:
    hand = Oracle(arm.chain).frames(arm.rest)[0][-1]
    for planned, target in zip(reaches, targets(), strict=True):
        candidates = library.nearest(hand, target, "svd", "C")
        learned, synergy = candidates[planned.rank]
        assert (planned.learned, planned.synergy) == (learned, synergy)
    assert sum(planned.rank == 0 for planned in reaches) >= 15


def test_the_way_back_ends_where_the_hand_was(
    arm: ArmDescription, planner: SynergyPlanner, reaches: list[PlannedReach]
) -> None:
    hand = arm.chain.forward(arm.rest).tip
    for planned in reaches[:8]:
        back = planner.plan(angles_of(planned)[-1], hand, RATE)
        assert np.linalg.norm(back.trajectory.hand[-1] - hand) <= ARRIVED_M
        assert back.learned.kind == "return"
        both = concatenated(planned.trajectory, back.trajectory)
        check_trajectory(both, arm, arm.rest)
        np.testing.assert_allclose(both.time, np.arange(both.frames) / RATE, atol=1e-9)
        assert both.frames == planned.trajectory.frames + back.trajectory.frames
        assert measure(back.trajectory).speed_peaks == 1


@pytest.mark.parametrize("rate", [50.0, 1000.0])
def test_the_path_does_not_depend_on_the_rate(
    arm: ArmDescription, planner: SynergyPlanner, reaches: list[PlannedReach], rate: float
) -> None:
    planned, usual = planner.plan(arm.rest, targets()[0], rate), reaches[0]
    check_trajectory(planned.trajectory, arm, arm.rest)
    assert planned.learned == usual.learned
    assert planned.trajectory.duration == pytest.approx(usual.trajectory.duration, rel=0.1)
    np.testing.assert_allclose(angles_of(planned)[-1], angles_of(usual)[-1], atol=0.03)


def test_a_slowed_arm_reaches_more_slowly(
    arm: ArmDescription, library: SynergyLibrary, reaches: list[PlannedReach]
) -> None:
    slowed, usual = arm.slowed(3.0), reaches[0]
    slow = SynergyPlanner(slowed, library).plan(arm.rest, targets()[0], RATE)
    assert slow.time_scale == pytest.approx(3.0 * usual.time_scale, rel=0.05)
    speeds = np.abs(np.diff(angles_of(slow), axis=0)) * RATE
    assert (speeds <= arm.max_velocity / 3.0).all()
    check_trajectory(slow.trajectory, slowed, arm.rest)
    for factor in (0.5, 0.0, np.nan, np.inf, 1e150):
        with pytest.raises(InputError, match="slowed by a factor of at least 1"):
            arm.slowed(factor)


def test_a_hand_that_is_there_already_stays(arm: ArmDescription, planner: SynergyPlanner) -> None:
    planned = planner.plan(arm.rest, arm.chain.forward(arm.rest).tip, RATE)
    assert (angles_of(planned) == arm.rest).all()
    assert planned.time_scale == 1.0
    check_trajectory(planned.trajectory, arm, arm.rest)


@pytest.mark.fault(32)
@pytest.mark.parametrize(
    ("target", "advice"),
    [
        ((0.9, 0.0, 0.0), "the arm is 0.66 m long, the target 0.90 m"),
        ((0.0, 0.0, 2.0), "the arm is 0.66 m long, the target 2.00 m"),
        ((0.67, 0.0, 0.0), "the arm is 0.66 m long, the target 0.67 m"),
        ((-0.5, 0.3, 0.2), "behind the arm"),
        ((0.0, 0.0, 0.0), "too near"),
        ((350.0, -100.0, -150.0), "targets are in metres"),
    ],
)
def test_out_of_reach_is_refused_with_how_near_it_comes(
    arm: ArmDescription, planner: SynergyPlanner, target: tuple[float, float, float], advice: str
) -> None:
    with pytest.raises(UnreachableError, match="cannot be reached by human7") as caught:
        planner.plan(arm.rest, target, RATE)
    assert caught.value.exit_status == 4
    assert caught.value.miss_m >= np.linalg.norm(target) - 0.66
    assert advice in str(caught.value)


def test_a_posture_outside_its_range_is_refused(
    arm: ArmDescription, planner: SynergyPlanner
) -> None:
    posture = arm.rest.copy()
    posture[3] = -0.2
    with pytest.raises(LimitError, match=r"elbow_flexion stands at -0\.200 rad") as caught:
        planner.plan(posture, targets()[0], RATE)
    assert (caught.value.joint, caught.value.value, caught.value.limit) == (
        "elbow_flexion",
        -0.2,
        0.0,
    )


def test_a_tick_outside_is_rounding(arm: ArmDescription, planner: SynergyPlanner) -> None:
    posture = arm.rest.copy()
    posture[3] = -1.5e-3
    planned = planner.plan(posture, targets()[0], RATE)
    assert angles_of(planned)[0, 3] == 0.0
    check_trajectory(planned.trajectory, arm, posture)


def test_a_library_of_another_arm_is_refused(arm: ArmDescription, library: SynergyLibrary) -> None:
    with pytest.raises(InputError, match=r"the synergies are those of human7 .* arm is koch"):
        SynergyPlanner(load_arm("koch"), library)
    other = msgspec.structs.replace(library, joint_names=("a", *library.joint_names[1:]))
    with pytest.raises(InputError, match="run armsyn learn --arm human7"):
        SynergyPlanner(arm, other)


def test_what_was_not_learned_is_refused(arm: ArmDescription, library: SynergyLibrary) -> None:
    with pytest.raises(InputError, match="human7 has learned nothing with --ik svd --model Z"):
        SynergyPlanner(arm, library, model="Z").plan(arm.rest, targets()[0], RATE)


@pytest.mark.parametrize(
    ("posture", "target", "rate"),
    [
        ([0.0] * 6, [0.3, -0.1, -0.1], RATE),
        ([np.nan] * 7, [0.3, -0.1, -0.1], RATE),
        (None, [0.3, -0.1], RATE),
        (None, [0.3, np.inf, -0.1], RATE),
        (None, [0.3, -0.1, -0.1], 0.0),
        (None, [0.3, -0.1, -0.1], -200.0),
        (None, [0.3, -0.1, -0.1], np.nan),
    ],
)
def test_numbers_that_are_none_are_refused(
    arm: ArmDescription,
    planner: SynergyPlanner,
    posture: list[float] | None,
    target: list[float],
    rate: float,
) -> None:
    with pytest.raises(InputError):
        planner.plan(arm.rest if posture is None else posture, target, rate)


def line(start: float, stop: float, name: str = "elbow", *, landmarks: bool = True) -> Motion:
    angles = np.linspace(start, stop, 11)[:, None]
    return Motion(
        np.arange(11) / 100,
        (name,),
        angles,
        ("hand",) if landmarks else (),
        angles[:, :, None] * [1, 2, 3] if landmarks else None,
        f"{start:g} to {stop:g}",
    )


def test_joined_motions_follow_each_other() -> None:
    both = concatenated(line(0.0, 1.0), line(1.0, 3.0))
    np.testing.assert_allclose(both.time, np.arange(22) / 100)
    assert both.angles is not None
    assert both.angles[[0, 10, 11, 21], 0].tolist() == [0.0, 1.0, 1.0, 3.0]
    assert both.hand[-1].tolist() == [3.0, 6.0, 9.0]
    assert both.source == "0 to 1, then 1 to 3"
    assert concatenated(line(0, 1, landmarks=False), line(1, 2, landmarks=False)).landmarks is None


def test_motions_that_do_not_follow_each_other_are_refused() -> None:
    with pytest.raises(InputError, match="2 to 3 does not start where 0 to 1 ends"):
        concatenated(line(0.0, 1.0), line(2.0, 3.0))
    with pytest.raises(InputError, match="has other joints than"):
        concatenated(line(0.0, 1.0), line(1.0, 2.0, "wrist"))
    hand = dataclasses.replace(line(1.0, 2.0), angles=None, joint_names=())
    with pytest.raises(InputError, match="only motions with joint angles"):
        concatenated(hand, hand)


def with_box(
    arm: ArmDescription, centre: np.ndarray, size: tuple[float, float, float]
) -> ArmDescription:
    box = BoxDescription(name="post", centre=tuple(centre.tolist()), size=size)
    return msgspec.structs.replace(arm, box=(box,))


def test_a_reach_takes_another_synergy_around_an_obstacle(
    arm: ArmDescription, library: SynergyLibrary
) -> None:
    target = [0.35, -0.10, -0.15]
    free = SynergyPlanner(arm, library).plan(arm.rest, target)
    assert free.trajectory.landmarks is not None
    hand = free.trajectory.landmarks[:, -1]
    halfway = hand[np.argmin(np.abs(np.linalg.norm(hand - hand[0], axis=1) - 0.15))]
    walled = with_box(arm, halfway, (0.01, 0.01, 0.01))
    around = SynergyPlanner(walled, library).plan(arm.rest, target)
    assert around.rank == free.rank + 1
    assert around.trajectory.landmarks is not None
    gap = np.linalg.norm(around.trajectory.landmarks[:, -1] - halfway, axis=1).min()
    assert gap > 0.02  # the hand has an extent


def test_a_target_within_an_obstacle_is_refused_by_its_name(
    arm: ArmDescription, library: SynergyLibrary
) -> None:
    target = np.array([0.35, -0.10, -0.15])
    walled = with_box(arm, target, (0.05, 0.05, 0.05))
    with pytest.raises(CollisionError, match="post"):
        SynergyPlanner(walled, library).plan(arm.rest, target)
