"""Edits that do not bring the first level to its goals, and how soon solvers see it."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from armsyn.editing import (
    Constraint,
    Effector,
    KeyFrame,
    MotionModel,
    Orientation,
    Pin,
    SkeletonFigure,
    SolverOptions,
    edit_motion,
    learn_model,
    load_clips,
)
from armsyn.editing.sampling import at_frames
from armsyn.errors import ConstraintError, OutsidePatternError, UnreachableError
from armsyn.motion.body import BodyMotion
from tests.editing.conftest import made_clip

HAND, WRIST = Effector("hand"), Effector("JtWristRt")


def test_a_goal_that_the_components_do_not_reach_is_refused_with_how_far(
    made: list[BodyMotion],
) -> None:
    model = learn_model(made, frames=25, components=1)
    keys = [KeyFrame(HAND, 12, by=(0.02, 0.02, 0.02))]
    forced = edit_motion(made[0], model, keys, force=True)
    with pytest.raises(UnreachableError, match=r"1 component within .* force it") as refused:
        edit_motion(made[0], model, keys)
    assert refused.value.miss_m == forced.level_errors[1] > 1e-3
    assert f"{100 * refused.value.miss_m:.4f} cm at frame 12" in str(refused.value)
    wide = SolverOptions(allowed_miss=0.05)
    np.testing.assert_array_equal(edit_motion(made[0], model, keys, wide).after, forced.after)


def test_only_the_first_level_has_to_be_met(made_model: MotionModel) -> None:
    ways = [
        KeyFrame(HAND, 15, by=(0.01, 0.0, 0.0), level=2),
        KeyFrame(HAND, 15, by=(-0.01, 0.0, 0.0), level=3),
    ]
    options = SolverOptions(coefficient_bound=100.0)
    result = edit_motion(made_clip(53), made_model, ways, options)
    assert result.level_errors[2] < 1e-6
    assert result.level_errors[3] == pytest.approx(0.02, abs=1e-5)


def test_a_refusal_never_says_that_the_bound_is_beyond_the_bound(
    reaches: list[BodyMotion], reach_model: MotionModel
) -> None:
    keys = [KeyFrame(WRIST, -1, by=(0.0, 0.0, 1.5))]
    needed = edit_motion(reaches[3], reach_model, keys, force=True).largest_coefficient
    assert needed is not None
    options = SolverOptions(coefficient_bound=needed - 1e-4)
    with pytest.raises(OutsidePatternError) as refused:
        edit_motion(reaches[3], reach_model, keys, options)
    said = str(refused.value)
    assert f"coefficient of {needed:.6g} " in said
    assert f"beyond the {options.coefficient_bound:.6g} allowed" in said
    assert f"{needed:.6g}" != f"{options.coefficient_bound:.6g}"


def test_pins_beside_a_goal_do_not_use_up_all_iterations(
    reaches: list[BodyMotion], reach_model: MotionModel
) -> None:
    toes = [Pin(Effector(f"JtToe{side}")) for side in ("Rt", "Lf")]
    ways: list[Constraint] = [*toes, KeyFrame(WRIST, -1, by=(0.0, 0.05, 0.0))]
    found = [
        edit_motion(reaches[3], reach_model, ways, SolverOptions(count), force=True)
        for count in (100, 1000)
    ]
    assert found[0].iterations < 50
    np.testing.assert_array_equal(found[0].after, found[1].after)


def test_the_weight_of_turns_decides_what_gives_way(made: list[BodyMotion]) -> None:
    model, clip = learn_model(made, frames=25, components=3), made_clip(54)
    turn = Orientation(HAND, 15, by=(0.0, 0.5, 0.0))
    ways: list[Constraint] = [KeyFrame(HAND, 15, by=(0.05, 0.0, 0.0)), turn]
    missed = []
    for weight in (0.02, 0.5, 10.0):
        result = edit_motion(clip, model, ways, SolverOptions(metres_per_radian=weight), force=True)
        missed.append({r.unit: r.worst for r in result.residuals})
    assert missed[0]["m"] < missed[1]["m"] < missed[2]["m"]
    assert missed[0]["rad"] > missed[1]["rad"] > missed[2]["rad"]


@pytest.mark.parametrize("weight", [0.05, 5.0])
def test_a_turn_that_can_be_met_is_whatever_its_weight(
    made_model: MotionModel, weight: float
) -> None:
    turn = Orientation(HAND, 12, by=(0.0, 0.05, 0.0))
    ways: list[Constraint] = [KeyFrame(HAND, 12, by=(0.01, 0, 0)), turn]
    options = SolverOptions(metres_per_radian=weight)
    result = edit_motion(made_clip(52), made_model, ways, options, force=True)
    assert result.success


def test_a_held_start_does_not_keep_a_lower_level_from_a_goal_it_can_reach(
    captures: Path,  # noqa: ARG001 - skips where they are absent
) -> None:
    swings = load_clips("golf")
    model = learn_model(swings[:2] + swings[3:], frames=132)
    figure = model.figure
    assert isinstance(figure, SkeletonFigure)
    clip = at_frames(swings[2], figure, 132)
    wrist = Effector("left_wrist")
    ways: list[Constraint] = [
        *(Pin(Effector(f"{side}_ankle"), frames=(94,), axes="z") for side in ("left", "right")),
        Pin(wrist, frames=(0,)),
        KeyFrame(Effector("left_wrist", (0.855, 0.323, 0.029)), 94, by=(0.0, 0.0, 0.03), level=2),
    ]
    result = edit_motion(clip, model, ways, SolverOptions(tolerance=1e-5), force=True)
    assert result.iterations > 0
    assert result.level_errors[1] < 1e-5
    assert result.level_errors[2] < 1e-5


def test_a_pin_that_uses_all_components_is_named_and_nothing_is_given(
    made: list[BodyMotion], made_model: MotionModel
) -> None:
    held, key = Pin(Effector("left_foot")), KeyFrame(HAND, 12, by=(0.0, 0.0, 0.03), level=2)
    with pytest.raises(UnreachableError, match="nothing changed, as the levels before") as refused:
        edit_motion(made[0], made_model, [held, key])
    frames = made[0].frames
    assert "key-frame hand @ 12 is missed by 3.0000 cm" in str(refused.value)
    assert f"beside pin left_foot, which asks for {3 * frames} numbers of 9" in str(refused.value)
    forced = edit_motion(made[0], made_model, [held, key], force=True)
    np.testing.assert_allclose(forced.after, forced.before, atol=1e-6)
    # One height at a few frames leaves freedom, as the message says
    few = Pin(Effector("left_foot"), (0, 12), axes="z")
    assert edit_motion(made[0], made_model, [few, key], force=True).success


def test_pins_on_a_goals_own_level_are_named(
    made: list[BodyMotion], made_model: MotionModel
) -> None:
    asked = [KeyFrame(HAND, -1, by=(0, 0, 0.1)), Pin(Effector("left_foot")), Pin(Effector("root"))]
    with pytest.raises(UnreachableError, match="beside pin left_foot and pin root, which ask for"):
        edit_motion(made[0], made_model, asked, SolverOptions(coefficient_bound=100.0))


def test_a_component_of_no_size_is_said_where_it_misleads(made: list[BodyMotion]) -> None:
    rng = np.random.default_rng(1)
    main, noise = rng.normal(size=(2, 30, 5, 3))
    clips = [
        dataclasses.replace(
            made_clip(0), rotations=made_clip(0).rotations + 0.1 * a * main + 1e-5 * b * noise
        )
        for a, b in rng.normal(size=(6, 2))
    ]
    model = learn_model(clips, variance=1.0)
    assert any("component 2 moves no joint by more than" in doubt for doubt in model.doubts)
    with pytest.raises(OutsidePatternError, match="of component 2, by which they differ next to"):
        edit_motion(clips[0], model, [KeyFrame(HAND, -1, by=(0.0, 0.02, 0.02))])
    assert learn_model(made, components=3).doubts == []
    assert "cannot lead a point to any place" in learn_model(made, components=2).doubts[0]


def test_a_body_that_is_not_there_gets_near_names(
    reaches: list[BodyMotion], reach_model: MotionModel
) -> None:
    goal = KeyFrame(Effector("wristrt"), -1, by=(0.0, 0.0, 0.0))
    with pytest.raises(ConstraintError, match=r"did you mean JtWristRt") as refused:
        edit_motion(reaches[0], reach_model, [goal])
    assert len(str(refused.value)) < 160
