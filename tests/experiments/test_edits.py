"""The second paper's cases: what their tables say is what the edits are."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from armsyn.editing import (
    Effector,
    Key,
    KeyFrame,
    KeyTrajectory,
    SkeletonFigure,
    learn_model,
    load_clips,
)
from armsyn.editing.sampling import at_frames
from armsyn.experiments import golf, golf_ground, jump, reach_edit
from armsyn.experiments.edit_tables import mean_table, method_tables
from armsyn.experiments.edits import (
    JOINT_PATH,
    KEY_FRAME,
    LATENT_PATH,
    Method,
    compare,
    likeness,
)
from armsyn.experiments.golf_ground import CLUB, FEET, HIT, Slope
from armsyn.experiments.settings import Settings
from armsyn.experiments.tables import write
from tests.editing.conftest import made_clip, made_skeleton
from tests.experiments.conftest import silent

BY = (0.0, 0.02, 0.0)


@pytest.fixture(scope="module")
def methods() -> list[Method]:
    skeleton = made_skeleton()
    clips = [made_clip(seed, skeleton=skeleton) for seed in range(8)]
    model = learn_model(clips[1:], frames=30)
    assert isinstance(model.figure, SkeletonFigure)
    hand = Effector("hand")
    path = KeyTrajectory(hand, (Key(29, BY),), True, ease_in=29)
    clip = at_frames(clips[0], model.figure, 30)
    return compare(clip, model, [KeyFrame(hand, 29, by=BY)], [path], 1)


def test_every_method_meets_the_same_goal(methods: list[Method]) -> None:
    assert [method.name for method in methods] == [KEY_FRAME, LATENT_PATH, JOINT_PATH]
    for method in methods:
        before, after = method.result.positions
        np.testing.assert_allclose(after[-1, -1] - before[-1, -1], BY, atol=2e-5)
        assert method.seconds > 0.0


def test_only_the_joint_space_leaves_the_pattern_further(methods: list[Method]) -> None:
    key_frame, _, joint = methods
    assert key_frame.after.outside_m == pytest.approx(key_frame.before.outside_m, rel=0.05)
    assert joint.after.outside_m > key_frame.after.outside_m


def test_tables_repeat_what_the_methods_found(methods: list[Method]) -> None:
    cost, looks = (table.as_dict()["rows"] for table in method_tables("made", methods, 1))
    assert [row["method"] for row in cost] == [method.name for method in methods]
    assert cost[-1]["time_ratio"] == 1.0
    assert cost[0]["time_ratio"] == pytest.approx(methods[-1].seconds / methods[0].seconds)
    assert looks[0]["method"] == "before the edit"
    assert looks[1]["outside_m"] == methods[0].after.outside_m
    before, mean, *_ = mean_table("all", [methods, methods]).as_dict()["rows"]
    assert before["outside_m"] == pytest.approx(methods[0].before.outside_m)
    assert (mean["clips"], mean["error_m"]) == (2, cost[0]["error_m"])


def test_a_clip_at_its_own_frames_is_itself(captures: Path) -> None:
    del captures
    clips = load_clips("golf")[:3]
    model = learn_model(clips, frames=clips[0].frames)
    assert isinstance(model.figure, SkeletonFigure)
    same = at_frames(clips[0], model.figure, clips[0].frames)
    np.testing.assert_allclose(same.positions(), clips[0].positions(), atol=1e-3)
    # But for joints that shift by less than a millimetre, which count as rigid. Three motions
    # have two components, which hold all of each.
    assert likeness(same, learn_model(clips, frames=same.frames, variance=1.0)).outside_m < 1e-6


def test_a_reach_is_edited_from_16_and_34_examples(captures: Path, tmp_path: Path) -> None:
    del captures
    report = reach_edit.run(Settings("small", 0, 1), tmp_path, silent)
    write(report, tmp_path)
    tables: list[Any] = json.loads((tmp_path / "reach-edit.json").read_text())["tables"]
    assert [row["examples"] for row in tables[0]["rows"]] == [16, 34]
    assert all(row["variance"] >= 0.98 for row in tables[0]["rows"])
    for cost in (tables[1], tables[3], tables[5]):
        assert all(row["error_m"] < 2e-5 for row in cost["rows"][::2])
    assert "the paper's xi" in tables[5]["title"]
    for means in tables[-2:]:
        before, key_frame, _, joint = means["rows"]
        assert joint["time_ratio"] == 1.0
        assert before["foot_slide_m"] < min(key_frame["foot_slide_m"], joint["foot_slide_m"])
        assert "slide" in means["notes"][1]
    assert (tmp_path / "reach-edit.png").read_bytes().startswith(b"\x89PNG")


def test_the_16_examples_are_those_that_end_nearest_to_the_goal(captures: Path) -> None:
    del captures
    clips = load_clips("garza")
    shown = next(clip for clip in clips if clip.source == reach_edit.SHOWN)
    ends = {clip.source: clip.positions()[-1, clip.skeleton.index("JtWristRt")] for clip in clips}
    goal = ends[shown.source] + reach_edit.BY
    learned = reach_edit.learned(clips, shown, 16).names
    gaps = [np.linalg.norm(ends[name] - goal) for name in ends if name != shown.source]
    assert max(np.linalg.norm(ends[name] - goal) for name in learned) == sorted(gaps)[15]


def test_the_mean_of_reaches_to_all_sides_slides_its_feet_and_examples_do_not(
    captures: Path,
) -> None:
    del captures
    model = learn_model(load_clips("garza"), frames=50, variance=1.0)
    tree = model.figure.tree
    toes = [tree.body(name) for name in ("JtToeRt", "JtToeLf")]

    def slide(poses: np.ndarray) -> float:
        places = tree.positions(poses)[:, toes, :2]
        return float(np.linalg.norm(places - places[0], axis=-1).max())

    own = [slide(model.poses(coefficients)) for coefficients in model.examples]
    assert np.median(own) < 0.01
    assert slide(model.mean) > 0.03


def test_a_jump_is_raised_at_its_apex(captures: Path, tmp_path: Path) -> None:
    del captures
    report = jump.run(Settings("small", 0, 1), tmp_path, silent).as_dict()
    json.dumps(report, allow_nan=False)
    patterns, cost, _, paper, _, of_jump, means = (table["rows"] for table in report["tables"])
    assert (patterns[0]["examples"], patterns[0]["variance"] >= 0.95) == (23, True)
    assert all(row["error_m"] < 2e-5 for row in (*cost, *paper[::2]))
    before, key_frame, _, joint = of_jump
    # The shown jump's own crouch, by the heights of its root
    shown = next(clip for clip in load_clips("jump") if clip.source == jump.SHOWN)
    height = shown.positions()[:31, 0, 2]
    assert before["crouch_m"] == pytest.approx(height[0] - height.min(), abs=0.005)
    assert key_frame["crouch_m"] > joint["crouch_m"]
    assert [row["clips"] for row in means] == [2, 2, 2, 2]
    assert (tmp_path / "jump.png").read_bytes().startswith(b"\x89PNG")


def test_a_slope_rises_by_its_tangent() -> None:
    slope = Slope(0.5, np.radians(7.0))
    np.testing.assert_allclose(slope.height([0.5, 1.5]), [0.0, 0.122785], atol=1e-6)


def test_the_club_is_where_its_marker_was_captured(captures: Path) -> None:
    # Marker 1 of the club, in the archive's own axes (y up), against the left wrist's frame
    swing = load_clips("golf:3")[0]
    model = learn_model(load_clips("golf:1,golf:2,golf:3"), frames=132)
    places = golf_ground.points_of(model.figure.tree, model.figure.poses(swing))[CLUB]
    with np.load(captures / "golf" / "gears.npz") as archive:
        marker = archive["swing03|club_and_grip_markers"][:, 1, [2, 0, 1]]
    first = 37  # the takeaway, in the captures' table of segments
    away = np.linalg.norm(places[:60] - marker[first : first + 60], axis=1)
    assert np.nanmedian(away) < 0.04


def test_a_swing_is_brought_to_a_slope(captures: Path, tmp_path: Path) -> None:
    del captures
    report = golf.run(Settings("small", 0, 1), tmp_path, silent).as_dict()
    json.dumps(report, allow_nan=False)
    patterns, hit, looks, paper, _, cost, _, ground, slopes, _ = (
        table["rows"] for table in report["tables"]
    )
    assert patterns[0]["examples"] == 11
    assert all(row["error_m"] < 2e-5 for row in (*hit[::2], *paper[::2], cost[0], cost[2]))
    assert looks[1]["largest_coefficient"] < 6.0
    assert cost[0]["time_ratio"] > cost[1]["time_ratio"]
    assert [row["method"] for row in ground] == [
        "before the edit",
        KEY_FRAME,
        LATENT_PATH,
        JOINT_PATH,
    ]
    # The steeper the slope, the farther from flat swings, and the edit of 7 deg is the table's
    assert (np.diff([row["largest_coefficient"] for row in slopes]) > 0).all()
    assert slopes[-1]["hands_gap_change_m"] == pytest.approx(ground[1]["hands_gap_change_m"])


def test_the_goals_lift_one_foot_as_much_as_they_lower_the_other(captures: Path) -> None:
    del captures
    clips = load_clips("golf:1,golf:2,golf:3")
    model = learn_model(clips, frames=golf.FRAMES)
    assert isinstance(model.figure, SkeletonFigure)
    swing = at_frames(clips[0], model.figure, golf.FRAMES)
    left, right, club = golf.goals(swing, model, golf.SLOPE)[0]
    assert isinstance(left, KeyFrame)
    assert isinstance(right, KeyFrame)
    assert isinstance(club, KeyFrame)
    assert left.frame == right.frame == club.frame == HIT
    assert (left.effector, right.effector, club.effector) == (*FEET, CLUB)
    apart = np.diff([swing.positions()[HIT, model.figure.tree.body(f.body), 0] for f in FEET])
    assert left.by is not None
    assert right.by is not None
    assert left.by[2] == pytest.approx(-right.by[2])
    assert left.by[2] - right.by[2] == pytest.approx(-np.tan(np.radians(7)) * apart[0], rel=1e-3)
