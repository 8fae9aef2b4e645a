"""Edits in the latent space: what is met, what stays, what is refused."""

import numpy as np
import pytest
from scipy.optimize import minimize

from armsyn.arm import load_arm
from armsyn.editing import (
    ChainFigure,
    Editor,
    Effector,
    Key,
    KeyFrame,
    KeyTrajectory,
    MotionModel,
    Orientation,
    Pin,
    SolverOptions,
    edit_motion,
    learn_model,
)
from armsyn.editing.pattern.timing import phases
from armsyn.editing.result import EditResult
from armsyn.errors import (
    ConstraintError,
    InputError,
    OutsidePatternError,
    PatternError,
    UnreachableError,
)
from armsyn.kinematics.rotation import from_expmap
from armsyn.motion.body import BodyMotion
from armsyn.motion.motion import Motion
from tests.editing.conftest import made_clip, made_skeleton

HAND, FOOT, CHEST = Effector("hand", (0.1, 0.0, 0.0)), Effector("left_foot"), Effector("chest")
WRIST = Effector("JtWristRt")


def place(result: EditResult, effector: Effector, frame: int) -> np.ndarray:
    """Where an effector is in the edited clip by the clip's own skeleton, m."""
    clip = result.clip
    assert isinstance(clip, BodyMotion)
    frames = clip.skeleton.frames(clip.root, clip.rotations, clip.translations)
    body = clip.skeleton.index(effector.body)
    turned = frames.orientations[frame, body] @ effector.point
    return np.asarray(frames.positions[frame, body] + turned)


def bits(clip: object) -> list[bytes]:
    assert isinstance(clip, BodyMotion)
    return [clip.rotations.tobytes(), clip.root.tobytes(), clip.time.tobytes()]


@pytest.mark.parametrize("constraints", [[], [Pin(FOOT)], [KeyFrame(HAND, 5, by=(0, 0, 0))]])
def test_a_null_edit_gives_the_clip_back_bit_for_bit(
    made_model: MotionModel, constraints: list[object]
) -> None:
    clip = made_clip(77, frames=33)
    # A branch beyond pi, and zeros with a sign
    turned = np.array(clip.rotations)
    turned[:, 4] = [0.0, -0.0, 3.5]
    clip = BodyMotion(clip.time, clip.skeleton, turned, clip.root)
    result = edit_motion(clip, made_model, constraints, force=True)  # type: ignore[arg-type]
    assert bits(result.clip) == bits(clip)
    assert result.iterations == 0
    assert result.success


@pytest.mark.parametrize("frame", [0, 13, -1])
def test_a_key_frame_is_met_in_the_clip_itself(made_model: MotionModel, frame: int) -> None:
    clip = made_clip(50, frames=31)
    before = place(edit_motion(clip, made_model, [], force=True), HAND, frame)
    goal = before + np.array([0.03, -0.02, 0.05])
    result = edit_motion(clip, made_model, [KeyFrame(HAND, frame, tuple(goal))], force=True)
    np.testing.assert_allclose(place(result, HAND, frame), goal, atol=1e-6)
    assert result.success
    assert result.residuals[0].worst < 1e-6
    assert np.ptp(result.coefficients, axis=0).max() == 0.0  # one change for the whole motion


def test_only_the_named_axes_count(made_model: MotionModel) -> None:
    clip = made_clip(51)
    keys = [KeyFrame(CHEST, 10, by=(9.0, 9.0, 0.04), axes="z")]
    result = edit_motion(clip, made_model, keys, force=True)
    there = edit_motion(clip, made_model, [], force=True)
    moved = place(result, CHEST, 10) - place(there, CHEST, 10)
    assert moved[2] == pytest.approx(0.04, abs=1e-6)
    assert np.abs(moved[:2]).max() < 0.1


def test_orientations_are_met(made_model: MotionModel) -> None:
    clip = made_clip(52)
    goal = clip.skeleton.frames(clip.root, clip.rotations).orientations[12, 4]
    goal = from_expmap([0.1, 0.05, -0.2]) @ goal
    result = edit_motion(clip, made_model, [Orientation(HAND, 12, goal)], force=True)
    edited = result.clip
    assert isinstance(edited, BodyMotion)
    found = edited.skeleton.frames(edited.root, edited.rotations).orientations[12, 4]
    np.testing.assert_allclose(found, goal, atol=2e-6)
    assert result.residuals[0].unit == "rad"
    by = edit_motion(clip, made_model, [Orientation(HAND, 12, by=(0.1, 0.05, -0.2))], force=True)
    np.testing.assert_allclose(by.after, result.after, atol=1e-9)


def test_in_a_conflict_the_first_level_is_held(made_model: MotionModel) -> None:
    clip = made_clip(53)
    ways = [
        KeyFrame(HAND, 15, by=(0.05, 0.0, 0.0), level=1),
        KeyFrame(HAND, 15, by=(-0.05, 0.0, 0.04), level=2),
        KeyFrame(FOOT, 15, by=(0.0, 0.02, 0.0), level=2),
    ]
    result = edit_motion(clip, made_model, ways, force=True)
    assert result.level_errors[1] < 1e-6
    assert not result.success
    assert result.level_errors[2] == pytest.approx(np.hypot(0.1, 0.04), abs=1e-3)
    alone = edit_motion(clip, made_model, ways[:1], force=True)
    foot = [place(r, FOOT, 15) for r in (result, alone, edit_motion(clip, made_model, []))]
    assert np.linalg.norm(foot[0] - foot[2] - [0, 0.02, 0]) < 1e-3


def test_a_conflict_on_a_captured_reach(
    reaches: list[BodyMotion], reach_model: MotionModel
) -> None:
    ways = [
        Pin(Effector("JtAnkleRt"), frames=(-1,), level=1),
        KeyFrame(WRIST, -1, by=(0.0, 0.05, 0.0), level=2),
        KeyFrame(WRIST, -1, by=(0.0, -0.05, 0.0), level=3),
    ]
    result = edit_motion(reaches[3], reach_model, ways)
    assert result.level_errors[1] < 1e-6
    assert result.level_errors[2] < 1e-6
    assert result.level_errors[3] == pytest.approx(0.1, abs=1e-5)


def test_a_captured_reach_goes_five_centimetres_aside(
    reaches: list[BodyMotion], reach_model: MotionModel
) -> None:
    for clip in reaches[::6]:
        result = edit_motion(clip, reach_model, [KeyFrame(WRIST, -1, by=(0.0, 0.05, 0.0))])
        assert result.success
        assert result.iterations <= 10
        assert result.start_drift_m < 0.02
        assert result.largest_coefficient is not None
        assert result.largest_coefficient < 4.0
        assert result.foot_slide_m is not None


def test_what_the_components_do_not_hold_of_the_clip_stays(
    reaches: list[BodyMotion], reach_model: MotionModel
) -> None:
    clip = reaches[8]
    result = edit_motion(clip, reach_model, [KeyFrame(WRIST, -1, by=(0.03, 0.0, 0.0))])
    change = result.after - result.before
    basis = reach_model.directions_at(phases(clip.time, 50))
    added = (result.coefficients - result.own_coefficients)[0]
    np.testing.assert_allclose(change, np.einsum("m,fmn->fn", added, basis), atol=1e-12)


def test_whitened_edits_stay_nearer_to_the_examples(
    reaches: list[BodyMotion],
) -> None:
    model = learn_model(reaches, frames=50, components=15)
    goal = [KeyFrame(WRIST, -1, by=(0.1, 0.1, 0.0))]
    white = edit_motion(reaches[3], model, goal, force=True)
    plain = edit_motion(reaches[3], model, goal, SolverOptions(whiten=False), force=True)
    added = [np.abs(r.coefficients - r.own_coefficients).max() for r in (white, plain)]
    assert white.success
    assert plain.success
    assert added[0] < added[1]


def test_the_papers_damping_converges_as_centimetres_only(
    reaches: list[BodyMotion], reach_model: MotionModel
) -> None:
    goal = [KeyFrame(WRIST, -1, by=(0.12, 0.1, 0.13))]
    missed = {}
    for unit in ("metre", "centimetre"):
        options = SolverOptions(100, 10.0, unit, whiten=False)  # type: ignore[arg-type]
        missed[unit] = edit_motion(reaches[3], reach_model, goal, options, force=True)
    wanted = np.linalg.norm(goal[0].by)
    assert missed["metre"].level_errors[1] > 0.9 * wanted
    assert missed["centimetre"].level_errors[1] < 1e-4
    same = edit_motion(reaches[3], reach_model, goal, SolverOptions.paper(), force=True)
    np.testing.assert_array_equal(same.after, missed["centimetre"].after)


def test_a_trajectory_passes_its_keys_and_returns_to_the_clip(
    reaches: list[BodyMotion], reach_model: MotionModel
) -> None:
    clip = reaches[3]
    keys = (Key(14, (0.0, 0.04, 0.0)), Key(18, (0.0, 0.04, 0.03)))
    path = KeyTrajectory(WRIST, keys, relative=True, ease_in=6, ease_out=6)
    result = edit_motion(clip, reach_model, [path])
    wrist = clip.skeleton.index("JtWristRt")
    before, after = (p[:, wrist] for p in result.positions)
    np.testing.assert_allclose(after[14] - before[14], [0, 0.04, 0], atol=1e-6)
    np.testing.assert_allclose(after[18] - before[18], [0, 0.04, 0.03], atol=1e-6)
    rising = (after - before)[8:14, 1] / 0.04
    u = np.arange(1, 7) / 7
    np.testing.assert_allclose(rising, 3 * u**2 - 2 * u**3, atol=1e-4)
    untouched = [*range(8), *range(25, clip.frames)]
    assert isinstance(result.clip, BodyMotion)
    np.testing.assert_array_equal(result.clip.rotations[untouched], clip.rotations[untouched])


def test_a_path_eases_back_to_what_a_key_frame_made(
    reaches: list[BodyMotion], reach_model: MotionModel
) -> None:
    key = KeyFrame(WRIST, -1, by=(0.0, 0.05, 0.0))
    path = KeyTrajectory(WRIST, (Key(12, (0.0, 0.0, 0.05)),), True, 5, 5)
    alone = edit_motion(reaches[3], reach_model, [key])
    both = edit_motion(reaches[3], reach_model, [path, key])
    np.testing.assert_allclose(both.after[[0, 6, 18, -1]], alone.after[[0, 6, 18, -1]], atol=1e-12)
    wrist = both.figure.tree.body("JtWristRt")
    moved = both.positions[1][:, wrist] - alone.positions[1][:, wrist]
    np.testing.assert_allclose(moved[12], [0, 0, 0.05], atol=1e-6)
    assert np.abs(np.diff(moved, axis=0)).max() < 0.02
    assert both.success
    assert [r.constraint for r in both.residuals] == [0, 1]


def test_easing_makes_smaller_steps(reaches: list[BodyMotion], reach_model: MotionModel) -> None:
    steps = []
    for window in (0, 4, 12):
        keys = (Key(14, (0.0, 0.0, 0.09)), Key(16, (0.0, 0.0, 0.09)))
        path = KeyTrajectory(WRIST, keys, relative=True, ease_in=window, ease_out=window)
        result = edit_motion(reaches[3], reach_model, [path], force=True)
        wrist = result.figure.tree.body("JtWristRt")
        before, after = (p[:, wrist] for p in result.positions)
        steps.append(np.linalg.norm(np.diff(after - before, axis=0), axis=1).max())
    assert steps[0] > 2 * steps[1] > 2 * steps[2]


def test_absolute_keys_are_places(made_model: MotionModel) -> None:
    clip = made_clip(54, frames=30)
    goal = made_model.figure.tree.positions(made_model.figure.poses(clip))[10, 4]
    goal = tuple(goal + np.array([0, 0, 0.02]))
    path = KeyTrajectory(Effector("hand"), (Key(10, goal),), ease_in=3)
    result = edit_motion(clip, made_model, [path], force=True)
    np.testing.assert_allclose(place(result, Effector("hand"), 10), goal, atol=1e-6)


def test_pins_hold_while_a_trajectory_moves(made_model: MotionModel) -> None:
    clip = made_clip(55)
    path = KeyTrajectory(HAND, (Key(12, (0.04, 0, 0)),), True, 5, 5, level=2)
    result = edit_motion(clip, made_model, [Pin(FOOT, level=1), path], force=True)
    before, after = (p[:, 1] for p in result.positions)
    np.testing.assert_allclose(after, before, atol=2e-6)
    assert result.level_errors[2] < 1e-6


def test_pins_that_take_all_freedom_leave_the_clip(
    reaches: list[BodyMotion], reach_model: MotionModel
) -> None:
    ankle = Effector("JtAnkleLf")
    ways = [Pin(WRIST), Pin(ankle), KeyFrame(WRIST, -1, by=(0, 0.05, 0), level=2)]
    with pytest.raises(UnreachableError, match="nothing changed"):
        edit_motion(reaches[3], reach_model, ways)
    result = edit_motion(reaches[3], reach_model, ways, force=True)
    assert result.level_errors[1] < 1e-6
    assert result.level_errors[2] == pytest.approx(0.05, abs=1e-6)


def test_free_coefficients_go_toward_a_style(made_model: MotionModel) -> None:
    clip, goal = made_clip(56), [KeyFrame(HAND, 20, by=(0.02, 0.0, 0.0))]
    style = tuple(made_model.examples[2].tolist())
    options = SolverOptions(toward_coefficients=style)
    result = edit_motion(clip, made_model, goal, options, force=True)
    plain = edit_motion(clip, made_model, goal, force=True)
    gaps = [np.linalg.norm(r.coefficients[0] - style) for r in (result, plain)]
    assert result.success
    assert gaps[0] < gaps[1]
    with pytest.raises(InputError, match="2 coefficients to go to; the pattern has 9"):
        edit_motion(clip, made_model, goal, SolverOptions(toward_coefficients=(1.0, 2.0)))


def test_a_goal_far_outside_is_refused_with_how_far(
    reaches: list[BodyMotion], reach_model: MotionModel
) -> None:
    far = [KeyFrame(WRIST, -1, by=(0.0, 0.0, 1.5))]
    with pytest.raises(OutsidePatternError, match="standard deviations") as refused:
        edit_motion(reaches[3], reach_model, far)
    assert refused.value.coefficient > refused.value.bound == 6.0
    forced = edit_motion(reaches[3], reach_model, far, force=True)
    assert forced.largest_coefficient == pytest.approx(refused.value.coefficient)


@pytest.mark.parametrize(
    ("constraint", "words"),
    [
        (KeyFrame(HAND, 30, by=(0, 0, 0.1)), r"frame 30 is outside the clip's 0\.\.29"),
        (KeyFrame(Effector("tail"), 3, by=(0, 0, 0.1)), "no body 'tail'"),
        (Pin(FOOT, frames=(-31,)), "frame -31 is outside"),
        (KeyFrame(HAND, 2.5, by=(0, 0, 0.1)), "frame 2.5 is outside"),  # type: ignore[arg-type]
        (KeyTrajectory(HAND, ((5, (0, 0, 0)), (4, (0, 0, 0)))), "increase"),
    ],
)
def test_constraints_that_do_not_fit_the_clip(
    made_model: MotionModel, constraint: KeyFrame, words: str
) -> None:
    with pytest.raises(ConstraintError, match=words):
        edit_motion(made_clip(57), made_model, [constraint])


def test_constraints_that_make_no_sense() -> None:
    for make in (
        lambda: KeyFrame(HAND, 3),
        lambda: KeyFrame(HAND, 3, (0, 0, 0), (0, 0, 0)),
        lambda: KeyFrame(HAND, 3, (0, 0, np.nan)),
        lambda: KeyFrame(HAND, 3, (0, 0, 1e30)),
        lambda: KeyFrame("hand", 3, (0, 0, 0)),  # type: ignore[arg-type]
        lambda: KeyFrame(HAND, 3, (0, 0, 0), axes="xw"),
        lambda: KeyFrame(HAND, 3, (0, 0, 0), level=0),
        lambda: Orientation(HAND, 3),
        lambda: Pin(HAND, frames=()),
        lambda: KeyTrajectory(HAND, ()),
        lambda: KeyTrajectory(HAND, ((3, (0, 0, 0)),), ease_in=-1),
        lambda: Effector("hand", (np.inf, 0, 0)),
    ):
        with pytest.raises(ConstraintError):
            make()


def test_a_clip_of_another_skeleton_is_refused(made_model: MotionModel) -> None:
    with pytest.raises(PatternError, match="made 60: joint"):
        edit_motion(made_clip(60, skeleton=made_skeleton(1.4)), made_model, [])


def arm_clips(name: str) -> tuple[ChainFigure, list[Motion]]:
    chain, rng, found = load_arm(name).chain, np.random.default_rng(8), []
    u = np.linspace(0.0, 1.0, 40)[:, None]
    middle, half = (chain.upper + chain.lower) / 2, (chain.upper - chain.lower) / 2
    for number in range(8):
        ends = middle + half * rng.uniform(-0.6, 0.6, (2, chain.dof))
        angles = ends[0] + (ends[1] - ends[0]) * u**2 * (3 - 2 * u)
        found.append(Motion(np.linspace(0, 1, 40), chain.names, angles, source=f"arm {number}"))
    return ChainFigure(chain, name), found


def test_an_arms_reach_is_bent_inside_its_limits() -> None:
    figure, clips = arm_clips("human7")
    model = learn_model(clips, figure=figure, frames=40, variance=1.0)
    tip, met = Effector("tip"), 0
    for clip, by in zip(
        clips, np.random.default_rng(1).normal(scale=0.25, size=(8, 3)), strict=True
    ):
        result = edit_motion(clip, model, [KeyFrame(tip, -1, by=tuple(by))], force=True)
        edited = result.clip
        assert isinstance(edited, Motion)
        assert edited.angles is not None
        assert (edited.angles >= figure.lower).all()
        assert (edited.angles <= figure.upper).all()
        end = figure.chain.forward(edited.angles[-1]).tip
        start = figure.chain.forward(clip.angles[-1]).tip  # type: ignore[index]
        met += bool(np.linalg.norm(end - start - by) < 1e-6)
        assert (np.linalg.norm(end - start - by) < 1e-6) == result.success
    assert met >= 4


def test_an_unreachable_goal_is_approached_as_far_as_limits_allow() -> None:
    figure, clips = arm_clips("koch")
    model = learn_model(clips, figure=figure, frames=40, variance=1.0)
    clip, by = clips[3], np.array([-0.04, 0.02, 0.02])
    result = edit_motion(clip, model, [KeyFrame(Effector("tip"), -1, by=tuple(by))], force=True)
    assert not result.success
    D = model.directions_at(np.arange(40.0))
    base = result.before
    goal = figure.chain.forward(base[-1]).tip + by

    def missed(x: np.ndarray) -> float:
        return 100.0 * float(np.sum((figure.chain.forward(base[-1] + x @ D[-1]).tip - goal) ** 2))

    def room(x: np.ndarray) -> np.ndarray:
        poses = base + np.einsum("m,fmn->fn", x, D)
        return np.concatenate([figure.upper - poses, poses - figure.lower]).ravel()

    zero = np.zeros(model.size)
    within = [{"type": "ineq", "fun": room}]
    best = minimize(missed, zero, constraints=within, method="SLSQP", options={"maxiter": 200})
    assert result.level_errors[1] <= np.sqrt(best.fun / 100.0) + 1e-4


def test_an_arms_path_is_bent_inside_its_limits() -> None:
    figure, clips = arm_clips("koch")
    model = learn_model(clips, figure=figure, frames=40, variance=1.0)
    for clip in clips:
        path = KeyTrajectory(Effector("tip"), (Key(25, (0.0, 0.1, 0.1)),), True, 15, 14)
        edited = edit_motion(clip, model, [path], force=True).clip
        assert isinstance(edited, Motion)
        assert edited.angles is not None
        assert (edited.angles >= figure.lower).all()
        assert (edited.angles <= figure.upper).all()
        np.testing.assert_array_equal(edited.angles[:10], clip.angles[:10])  # type: ignore[index]


def test_an_edit_adds_no_steps_of_speed_between_the_patterns_frames() -> None:
    figure, clips = arm_clips("koch")
    model = learn_model(clips, figure=figure, frames=12, variance=1.0)
    slow, first = np.linspace(0.0, 1.0, 401), clips[1]
    assert first.angles is not None
    fine = np.stack([np.interp(slow, first.time, column) for column in first.angles.T], axis=1)
    clip = Motion(slow, figure.chain.names, fine)
    result = edit_motion(clip, model, [KeyFrame(Effector("tip"), -1, by=(0, 0.01, 0))], force=True)
    change = result.after - result.before
    bends = np.abs(np.diff(change, 2, axis=0)).max(axis=1)
    coarse = np.abs(np.diff(change[::20], 2, axis=0)).max() / 20**2
    # Straight lines between the pattern's frames would bend 20 times as much at each of them
    assert 0.0 < bends.max() < 5.0 * coarse


def test_an_arms_null_edit_is_the_very_motion() -> None:
    figure, clips = arm_clips("koch")
    model = learn_model(clips, figure=figure, frames=40)
    assert edit_motion(clips[2], model, []).clip is clips[2]


def test_an_editor_serves_many_edits(made_model: MotionModel) -> None:
    clip = made_clip(58)
    editor = Editor(clip, made_model)
    for size in (0.01, 0.03, 0.02):
        keys = [KeyFrame(HAND, 9, by=(size, 0.0, 0.0))]
        once = edit_motion(clip, made_model, keys, force=True)
        np.testing.assert_array_equal(editor.edit(keys, force=True).after, once.after)
