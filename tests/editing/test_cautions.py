"""What is said of edits that came out but may not be what was wanted."""

import dataclasses
import warnings

import numpy as np
import pytest

from armsyn.editing import (
    EditResult,
    Effector,
    KeyFrame,
    MotionModel,
    Pin,
    SkeletonFigure,
    edit_in_joint_space,
    edit_motion,
)
from armsyn.editing.cautions import edit_cautions
from armsyn.editing.page import page
from armsyn.editing.pictures import draw_edit
from armsyn.editing.report import edit_as_dict, figure_rows, score_edit
from armsyn.motion.body import BodyMotion
from tests.editing.conftest import made_clip, made_skeleton


def raised(height: float) -> EditResult:
    """A body that stands still, its root raised by one step at every frame, m."""
    skeleton, frames = made_skeleton(), 12
    root = np.tile([0.0, 0.0, 1.0], (frames, 1))
    clip = BodyMotion(np.arange(frames) / 30.0, skeleton, np.zeros((frames, 5, 3)), root, None, "s")
    goals = [KeyFrame(Effector("root"), frame, by=(0.0, 0.0, height)) for frame in range(frames)]
    return edit_in_joint_space(clip, SkeletonFigure(skeleton), goals)


def test_feet_that_leave_the_floor_are_said_everywhere() -> None:
    result = raised(0.064)
    scored = score_edit(result)
    assert edit_as_dict(result, scored)["foot_lift_m"] == {"left_foot": pytest.approx(0.064)}
    assert "lifted or sunk by 6.40 cm" in dict(figure_rows(result))["slide of left_foot"]
    (caution,) = edit_cautions(result, 6.0)
    assert "left_foot by 6.4 cm" in caution
    assert "left_foot by 6.4 cm" in page(result, scored, 6.0)
    assert edit_cautions(raised(0.019), 6.0) == []


def test_what_is_forced_beyond_the_bound_is_said(
    made: list[BodyMotion], made_model: MotionModel
) -> None:
    goal = KeyFrame(Effector("hand"), -1, by=(0.0, 0.05, 0.0))
    result = edit_motion(made[0], made_model, [goal], force=True)
    largest = result.largest_coefficient
    assert largest is not None
    (caution,) = edit_cautions(dataclasses.replace(result), 0.5 * largest)
    assert f"{largest:.2f} sigma" in caution
    assert caution in page(result, score_edit(result), 0.5 * largest)


def test_a_goal_that_is_met_is_no_missed_target(
    made: list[BodyMotion], made_model: MotionModel
) -> None:
    result = edit_motion(made[0], made_model, [KeyFrame(Effector("hand"), -1, by=(0, 0.1, 0))])
    scored = score_edit(result)
    assert scored.score is not None
    assert scored.score.comparison.endpoint_error == pytest.approx(0.1, abs=1e-6)
    assert scored.score.comparison.refusal is None
    assert "verdict" not in page(result, scored, 6.0)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_pictures_are_drawn_without_a_warning(made_model: MotionModel, count: int) -> None:
    pins = [Pin(Effector(name)) for name in ("left_foot", "root")]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        drawing = draw_edit(edit_motion(made_clip(0), made_model, pins[:count]), 6.0)
        drawing.canvas.draw()
    legend = drawing.axes[0].get_legend()
    assert (0 if legend is None else len(legend.get_texts())) == (2 if count else 0)
