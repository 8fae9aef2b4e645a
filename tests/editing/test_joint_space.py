"""The joint-space comparison: same goals, same tolerance, its own continuity."""

import numpy as np

from armsyn.arm import load_arm
from armsyn.editing import (
    ChainFigure,
    Effector,
    Key,
    KeyFrame,
    KeyTrajectory,
    MotionModel,
    Pin,
    SkeletonFigure,
    edit_in_joint_space,
    edit_motion,
)
from armsyn.editing.feet import standing_feet
from armsyn.motion.body import BodyMotion
from armsyn.motion.motion import Motion
from tests.editing.conftest import made_clip

HAND = Effector("hand")


def path(level: int = 1) -> KeyTrajectory:
    return KeyTrajectory(HAND, (Key(15, (0.0, 0.05, 0.03)),), True, 10, 10, level=level)


def test_a_trajectory_is_followed_without_jumps() -> None:
    clip = made_clip(70)
    figure = SkeletonFigure(clip.skeleton)
    result = edit_in_joint_space(clip, figure, [path()])
    assert result.success
    before, after = (p[:, 4] for p in result.positions)
    np.testing.assert_allclose(after[15] - before[15], [0, 0.05, 0.03], atol=1e-6)
    change = result.after - result.before
    assert np.abs(np.diff(change, axis=0)).max() < 0.05
    assert isinstance(result.clip, BodyMotion)
    still = [*range(5), *range(26, 30)]
    assert result.clip.rotations[still].tobytes() == clip.rotations[still].tobytes()


def test_a_key_frame_alone_changes_one_frame() -> None:
    clip = made_clip(71)
    key = KeyFrame(HAND, 12, by=(0.0, 0.0, 0.05))
    result = edit_in_joint_space(clip, SkeletonFigure(clip.skeleton), [key])
    assert result.success
    moved = np.flatnonzero((result.after != result.before).any(axis=1))
    assert moved.tolist() == [12]


def test_its_first_level_comes_first_too() -> None:
    clip = made_clip(72)
    against = KeyTrajectory(HAND, (Key(15, (0.0, -0.05, 0.0)),), True, 10, 10, level=2)
    ways = [path(), against, Pin(Effector("left_foot"), level=1)]
    result = edit_in_joint_space(clip, SkeletonFigure(clip.skeleton), ways)
    assert result.level_errors[1] < 1e-6
    assert result.level_errors[2] > 0.05


def test_both_solvers_meet_the_same_goals(made_model: MotionModel) -> None:
    clip = made_clip(73)
    latent = edit_motion(clip, made_model, [path()], force=True)
    joints = edit_in_joint_space(clip, made_model.figure, [path()])
    assert latent.success
    assert joints.success
    hands = [p.positions[1][:, 4] for p in (latent, joints)]
    np.testing.assert_allclose(hands[0], hands[1], atol=2e-6)


def test_an_arm_stays_inside_its_limits() -> None:
    figure = ChainFigure(load_arm("human7").chain, "human7")
    chain = figure.chain
    ends = chain.lower + (chain.upper - chain.lower) * np.array([[0.02], [0.98]])
    u = np.linspace(0, 1, 21)[:, None]
    clip = Motion(u[:, 0], chain.names, (1 - u) * ends[0] + u * ends[1])
    away = KeyTrajectory(Effector("tip"), (Key(20, (0.3, 0.3, 0.3)),), True, 20)
    result = edit_in_joint_space(clip, figure, [away])
    assert isinstance(result.clip, Motion)
    assert result.clip.angles is not None
    assert (result.clip.angles <= chain.upper).all()
    assert (result.clip.angles >= chain.lower).all()


def test_feet_that_slide_are_measured_where_they_stood() -> None:
    time = np.linspace(0.0, 1.0, 31)
    before = np.zeros((31, 2, 3))
    before[10:21, 0, 2] = 0.3 * np.sin(np.linspace(0, np.pi, 11))  # a step up and down
    before[:, 1] = [0, 0, 1.5]
    after = before + np.array([[[0.2, 0.0, 0.0]]])  # moved as a whole: no slide
    after[25:, 0] += [0.0, 0.03, -0.01]  # and slides aside and sinks while it stands again
    after[15, 0, 2] += 0.2  # higher in the air: no lift
    found = standing_feet(("left_toe", "head"), time, before, after)
    assert list(found) == ["left_toe"]
    np.testing.assert_allclose(found["left_toe"], [0.0, 0.03, 0.01], atol=1e-12)
