"""Many reaches paced and judged at once, against one at a time."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from armsyn.arm import ArmDescription, load_arm
from armsyn.errors import CollisionError, LimitError
from armsyn.kernels import judging
from armsyn.motion import Motion
from armsyn.planning import timing
from armsyn.planning.pacing import Paced
from armsyn.planning.verdicts import Verdicts
from armsyn.safety import check_trajectory
from tests.planning.apart import judge, pace

FloatArray = NDArray[np.float64]
ARMS = ["human7", "widowx_250s", "openmanipulator_x", "koch", "reachy_right"]
PHASE = np.linspace(0.0, 1.0, 101)


def random_motions(arm: ArmDescription, count: int, seed: int = 7) -> tuple[FloatArray, FloatArray]:
    """Bells of all kinds, from nearly at rest to cut at speed, some out of range or into things."""
    rng = np.random.default_rng(seed)
    minimum_jerk = PHASE**3 * (10.0 - 15.0 * PHASE + 6.0 * PHASE**2)
    share = rng.uniform(0.0, 0.3, count)[:, None]
    ease = share * PHASE + (1.0 - share) * minimum_jerk
    change = rng.normal(0.0, 0.7, (count, 1, arm.chain.dof))
    bow = rng.normal(0.0, 0.2, (count, 1, arm.chain.dof)) * np.sin(np.pi * PHASE)[None, :, None]
    return arm.rest + ease[..., None] * change + bow, rng.uniform(0.3, 1.2, count)


@pytest.mark.parametrize("rate_hz", [50.0, 200.0])
@pytest.mark.parametrize("name", ARMS)
def test_each_is_paced_as_one_alone(name: str, rate_hz: float) -> None:
    arm = load_arm(name, calibrated=False)
    angles, durations = random_motions(arm, 40)
    paced = pace(arm, angles, durations, rate_hz)
    assert (paced.scales > 1.0).any()
    for row in range(len(angles)):
        alone = timing.in_time(angles[row], float(durations[row]), arm, rate_hz)
        assert paced.scales[row] == pytest.approx(alone.time_scale, rel=1e-9)
        np.testing.assert_allclose(paced.path(row), alone.angles, rtol=0.0, atol=1e-11)


def test_a_motion_that_stays_is_two_frames_at_rest() -> None:
    arm = load_arm("human7", calibrated=False)
    still = np.tile(arm.rest, (1, 101, 1))
    paced = pace(arm, still, np.array([1.0]), 200.0)
    assert paced.lengths.tolist() == [201]
    assert paced.scales.tolist() == [1.0]
    assert (paced.path(0) == arm.rest).all()


def test_what_jumps_in_phase_is_not_slowed_for_ever() -> None:
    arm = load_arm("human7", calibrated=False)
    angles, durations = random_motions(arm, 3)
    angles[1, 50:] += 1e9
    paced = pace(arm, angles, durations, 200.0)
    assert paced.lengths[1] == 0
    assert (paced.lengths[[0, 2]] > 0).all()
    alone = pace(arm, angles[2:], durations[2:], 200.0)
    assert (alone.path(0) == paced.path(2)).all()


def faster(paced: Paced, rows: list[int], by: int) -> Paced:
    """The same paths, with some of them played faster than they may be."""
    paths = [paced.path(row)[:: by if row in rows else 1] for row in range(len(paced.scales))]
    first = np.concatenate([[0], np.cumsum([len(path) for path in paths])])
    return Paced(np.concatenate(paths), first, paced.scales, paced.rate_hz)


def told(arm: ArmDescription, paced: Paced, row: int) -> LimitError | CollisionError | None:
    """What safety says of one path."""
    path = paced.path(row)
    motion = Motion(np.arange(len(path)) / paced.rate_hz, arm.joint_names, path)
    try:
        check_trajectory(motion, arm)
    except (LimitError, CollisionError) as error:
        return error
    return None


def check_alike(arm: ArmDescription, paced: Paced, verdicts: Verdicts, row: int) -> None:
    kind, frame, item, value = (part[row] for part in verdicts)
    error = told(arm, paced, row)
    if error is None:
        assert kind == judging.ALLOWED
        return
    if isinstance(error, CollisionError):
        assert kind == judging.CONTACT
        assert arm.solids.names[item] == (error.first, error.second)
        assert frame == error.frame
        assert value == pytest.approx(-error.depth, abs=1e-9)
        return
    words = {1: " be at ", 2: " a speed of ", 3: " an acceleration of ", 4: " a jerk of "}
    assert words[int(kind)] in str(error)
    assert arm.joint_names[item] == error.joint
    assert value == pytest.approx(error.value, rel=1e-9)


@pytest.mark.parametrize("name", ARMS)
def test_each_is_judged_as_by_safety(name: str) -> None:
    arm = load_arm(name, calibrated=False)
    angles, durations = random_motions(arm, 300, seed=3)
    paced = faster(pace(arm, angles, durations, 200.0), list(range(0, 300, 9)), 3)
    verdicts = judge(arm, paced)
    for row in range(len(angles)):
        check_alike(arm, paced, verdicts, row)
    assert {judging.ALLOWED, judging.RANGE} < set(verdicts.kinds.tolist())


def test_contacts_are_found_with_capsules_planes_and_boxes() -> None:
    """Many ways through a scene that is in the way of nearly all of them."""
    import msgspec

    from armsyn.arm.shapes import BoxDescription, PlaneDescription

    arm = load_arm("human7", calibrated=False)
    hand = arm.chain.forward(arm.rest).tip
    arm = msgspec.structs.replace(
        arm,
        plane=(PlaneDescription("wall", (0.45, 0.0, 0.0), (-1.0, 0.0, 0.0)),),
        box=(BoxDescription("box", (hand[0] + 0.15, hand[1], hand[2] + 0.1), (0.08, 0.3, 0.05)),),
    )
    angles, durations = random_motions(arm, 400, seed=11)
    angles = np.clip(angles, arm.chain.lower, arm.chain.upper)
    paced = pace(arm, angles, durations, 100.0)
    verdicts = judge(arm, paced)
    touched = np.flatnonzero(verdicts.kinds == judging.CONTACT)
    others = {arm.solids.names[item][1] for item in verdicts.items[touched]}
    assert {"wall", "box"} < others
    for row in range(len(angles)):
        check_alike(arm, paced, verdicts, row)


def test_a_thin_obstacle_between_two_samples_is_found() -> None:
    import msgspec

    from armsyn.arm.shapes import BoxDescription

    arm = load_arm("human7", calibrated=False)
    paths = np.array([arm.rest, arm.rest])
    paths[1, 0] += 0.8
    between = arm.chain.forward(paths.mean(axis=0)).tip
    arm = msgspec.structs.replace(
        arm, box=(BoxDescription("wire", tuple(between.tolist()), (0.002, 0.002, 0.002)),)
    )
    slow = msgspec.structs.replace(
        arm,
        joint=tuple(
            msgspec.structs.replace(j, max_velocity=1e4, max_acceleration=1e8) for j in arm.joint
        ),
    )
    paced = Paced(paths, np.array([0, 2]), np.ones(1), 200.0)
    verdicts = judge(slow, paced)
    assert verdicts.kinds[0] == judging.CONTACT
    check_alike(slow, paced, verdicts, 0)
