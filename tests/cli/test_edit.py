"""`armsyn edit learn`, `apply` and `template`, as a user meets them."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.editing import SkeletonFigure, load_model
from armsyn.editing.scene import TEMPLATE
from armsyn.motion import Motion
from armsyn.motion.body import BodyMotion
from armsyn.motion.captures import load_captures
from armsyn.motion.formats import read_body, read_motion, write_body, write_motion
from armsyn.planning.examples import examples_on_arm
from armsyn.planning.timing import Timed, in_time
from armsyn.safety import check_trajectory
from tests.cli.commands import Outcome
from tests.editing.conftest import made_clip, made_skeleton

Call = Callable[..., Outcome]
HAND = ("--point", "hand")


@pytest.fixture(scope="module")
def clips(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Files of one skeleton's motions."""
    folder = tmp_path_factory.mktemp("clips")
    skeleton, files = made_skeleton(), []
    for seed in range(6):
        files.append(folder / f"{seed}.npz")
        write_body(files[-1], made_clip(seed, skeleton=skeleton))
    return files


@pytest.fixture
def model(call: Call, clips: list[Path], tmp_path: Path) -> Path:
    path = tmp_path / "model.npz"
    assert call("edit", "learn", *clips, "--variance", 1, "--out", path).status == 0
    return path


def hand_of(path: Path) -> np.ndarray:
    return np.asarray(read_body(path).positions()[:, -1])


def test_learning_says_what_was_learned(call: Call, clips: list[Path], tmp_path: Path) -> None:
    out = tmp_path / "model.json"
    said = call("edit", "learn", *clips, "--components", 3, "--frames", 20, "--out", out, "--json")
    model = load_model(out)
    document = said.document
    assert (document["components"], document["motions"], document["frames"]) == (3, 6, 20)
    assert document["variance"] == pytest.approx(model.variance)
    assert list(document["left_out_m"].values()) == model.left_out_m.tolist()
    assert (tmp_path / "model.components.csv").is_file()
    text = call("edit", "learn", *clips, "--components", 3, "--out", out).out
    assert "6 motions of 30 frames" in text
    assert "bodies to constrain: root, left_foot, chest, elbow, hand" in text


@pytest.mark.parametrize("suffix", [".bvh", ".npz", ".csv"])
def test_a_clip_is_moved_and_written(
    call: Call, clips: list[Path], model: Path, tmp_path: Path, suffix: str
) -> None:
    out = tmp_path / f"edited{suffix}"
    said = call(
        *("edit", "apply", clips[0], "--model", model, *HAND, "--by", 0, 0.03, 0, "--out", out),
        "--json",
    )
    assert said.status == 0, said.err
    assert said.document["success"]
    written = read_motion(out)
    assert written.landmarks is not None
    place = written.landmark_names.index("hand")
    there = written.landmarks[-1, place]
    np.testing.assert_allclose(there, hand_of(clips[0])[-1] + [0, 0.03, 0], atol=2e-5)


def test_scenes_and_options_are_met_together(
    call: Call, clips: list[Path], model: Path, tmp_path: Path
) -> None:
    scene, out = tmp_path / "scene.toml", tmp_path / "out.npz"
    scene.write_text(
        'schema = "armsyn-scene-1"\n'
        '[[key_frame]]\nbody = "hand"\nframe = -1\nby = [0.0, 0.0, 0.02]\naxes = "z"\n'
    )
    apply = ("edit", "apply", clips[1], "--model", model, "--scene", scene, "--out", out, "--json")
    elbow = call(*apply, "--point", "elbow", "--frame", 12, "--by", 0.01, 0, 0, "--level", 2)
    assert [(c["level"], c["frame"]) for c in elbow.document["constraints"]] == [(1, 29), (2, 12)]
    assert hand_of(out)[-1, 2] == pytest.approx(hand_of(clips[1])[-1, 2] + 0.02, abs=1e-6)
    where = (1.5, -0.25, 0.125)
    point = call(*apply, "--point", "hand:0.1,0,0", "--to", *where, "--level", 2, "--force")
    assert point.document["constraints"][1]["label"] == "key-frame hand(0.1, 0, 0) @ 29"


def test_a_page_a_picture_and_latent_variables_come_beside(
    call: Call, clips: list[Path], model: Path, tmp_path: Path
) -> None:
    files = [tmp_path / name for name in ("o.npz", "page.html", "p.png", "latent.json")]
    pairs = zip(("--out", "--report", "--plot", "--latent"), files, strict=True)
    options = [part for pair in pairs for part in pair]
    said = call("edit", "apply", clips[0], "--model", model, *HAND, "--by", 0, 0.03, 0, *options)
    assert said.status == 0, said.err
    for text in ("misses 0.0000 cm", "largest coefficient", "held distance", "start drift"):
        assert text in said.out
    page = files[1].read_text()
    assert "0.npz motion, edited</h1>" in page
    assert "<th>after</th>" in page
    assert not re.findall(r"(?:src|href)=\"(?!data:)", page)
    assert files[2].read_bytes().startswith(b"\x89PNG")
    latent = json.loads(files[3].read_text())
    learned = load_model(model)
    assert latent["model_inputs_sha256"] == learned.inputs_sha256
    assert np.shape(latent["edited"]) == (1, learned.size)
    np.testing.assert_allclose(latent["own"], learned.examples[0], atol=1e-6)
    # What the coefficients say is where the hand is, as all components are kept
    rebuilt = learned.figure.tree.positions(learned.poses(np.array(latent["edited"][0])))
    np.testing.assert_allclose(rebuilt[-1, -1], hand_of(files[0])[-1], atol=1e-6)


def test_a_constraint_that_is_met_changes_nothing(
    call: Call, clips: list[Path], model: Path, tmp_path: Path
) -> None:
    out = tmp_path / "same.npz"
    call("edit", "apply", clips[2], "--model", model, *HAND, "--by", 0, 0, 0, "--out", out)
    before, after = read_body(clips[2]), read_body(out)
    assert before.rotations.tobytes() == after.rotations.tobytes()
    assert before.root.tobytes() == after.root.tobytes()


def test_what_is_far_is_refused_unless_forced(
    call: Call, clips: list[Path], model: Path, tmp_path: Path
) -> None:
    out = tmp_path / "far.npz"
    apply = ("edit", "apply", clips[0], "--model", model, *HAND, "--by", 0, 1.2, 0, "--out", out)
    call(*apply).refused(4, "standard deviations", "force")
    assert not out.exists()
    assert call(*apply, "--force").status == 0
    assert out.exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "nothing is asked for"),
        (("--frame", 3), "give --point"),
        ((*HAND,), "--to a place or is moved --by something: give one"),
        ((*HAND, "--by", 0, "x", 0), "not a valid float"),
        ((*HAND, "--by", 0, "nan", 0), "three finite numbers"),
        (("--point", "hand:1,2", "--by", 0, 0, 0), "BODY:X,Y,Z"),
        (("--point", "nose", "--by", 0, 0, 0), "no body 'nose'"),
        ((*HAND, "--by", 0, 0, 0, "--frame", 30), "outside the clip's 0..29"),
        (("--scene", "none.toml"), "none.toml"),
        ((*HAND, "--by", 0, 0, 0, "--out", "here.txt"), "written as .bvh, .npz, .csv"),
        ((*HAND, "--by", 0, 0, 0, "--out", "nowhere/here.bvh"), "no folder"),
        ((*HAND, "--by", 0, 0, 0, "--plot", "p.gif"), ".png"),
        ((*HAND, "--by", 0, 0, 0, "--model", "none.npz"), "none.npz"),
        ((*HAND, "--by", 0, 0, 0, "--latent", "here.npz"), "files of their own"),
    ],
)
def test_bad_input_is_one_line_and_writes_nothing(
    call: Call,
    clips: list[Path],
    model: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[object, ...],
    words: str,
) -> None:
    folder = tmp_path / "work"
    folder.mkdir()
    monkeypatch.chdir(folder)
    said = call("edit", "apply", clips[0], "--model", model, "--out", "here.npz", *arguments)
    said.refused(2, words)
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (lambda files: files[:2], "2 motions: a pattern needs at least 3"),
        (lambda files: [*files, "--variance", 2], "give a share"),
        (lambda files: [*files, "--components", 9], "9 components"),
        (lambda files: [*files, "--components", 2, "--variance", 0.5], "either"),
        (lambda files: ["polo", *files], "neither a motion file"),
        (lambda files: [*files, "--arm", "koch"], "landmark positions only"),
        (lambda files: [*files, "--out", "model.txt"], ".npz or .json"),
    ],
)
def test_what_cannot_be_learned_is_one_line(
    call: Call,
    clips: list[Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: Callable[[list[Path]], list[object]],
    words: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    call("edit", "learn", "--out", "model.npz", *arguments(clips)).refused(2, words)
    assert list(tmp_path.iterdir()) == []


def test_another_skeleton_is_refused_by_name_or_retargeted(
    call: Call, clips: list[Path], tmp_path: Path
) -> None:
    other, out = tmp_path / "other.npz", tmp_path / "model.npz"
    write_body(other, made_clip(9, skeleton=made_skeleton(1.3)))
    learn = ("edit", "learn", *clips, other, "--out", out)
    call(*learn).refused(2, "other.npz", "left_foot", "retarget it first")
    assert not out.exists()
    assert call(*learn, "--retarget").status == 0
    assert len(load_model(out).names) == len(clips) + 1


def test_the_template_is_printed(call: Call) -> None:
    assert call("edit", "template").out == TEMPLATE


def test_a_captured_reach_is_moved(call: Call, captures: Path, tmp_path: Path) -> None:
    del captures
    model, out = tmp_path / "garza.npz", tmp_path / "out.bvh"
    call("edit", "learn", "garza", "--frames", 50, "--out", model)
    assert isinstance(load_model(model).figure, SkeletonFigure)
    apply = ("edit", "apply", "garza:ForwardHigh", "--model", model, "--out", out, "--json")
    document = call(*apply, "--point", "JtWristRt", "--by", 0, 0.05, 0).document
    assert document["success"]
    assert document["largest_coefficient"] < 6
    assert document["score"]["held_distance_m"] < 0.05
    assert document["foot_slide_m"]["JtAnkleRt"]["after"] < 0.02
    several = call("edit", "apply", "garza", *apply[3:-1], *HAND, "--by", 0, 0, 0)
    several.refused(2, "selects 35 motions")


def test_what_is_read_is_never_written_over(
    call: Call, clips: list[Path], model: Path, tmp_path: Path
) -> None:
    own = tmp_path / "own.npz"
    own.write_bytes(clips[0].read_bytes())
    scene = tmp_path / "scene.toml"
    scene.write_text(TEMPLATE)
    apply = ("edit", "apply", own, "--model", model, *HAND, "--by", 0, 0.01, 0)
    for out in ((own,), (model,), (tmp_path / "o.npz", "--latent", scene, "--scene", scene)):
        call(*apply, "--out", *out).refused(2, "is read by this command")
    learn = ("edit", "learn", *clips, own, "--out")
    call(*learn, own).refused(2, "is read by this command")
    assert own.read_bytes() == clips[0].read_bytes()
    assert not (tmp_path / "o.npz").exists()


def test_a_goal_that_is_missed_is_not_written(
    call: Call, clips: list[Path], tmp_path: Path
) -> None:
    model, out = tmp_path / "model.npz", tmp_path / "near.npz"
    call("edit", "learn", *clips, "--components", 1, "--out", model)
    apply = ("edit", "apply", clips[0], "--model", model, *HAND, "--by", 0, 0.03, 0, "--out", out)
    said = call(*apply, "--json")
    assert said.status == 4
    assert said.document["error"]["type"] == "UnreachableError"
    assert said.document["error"]["miss_m"] > 1e-3
    assert not out.exists()
    assert "not every constraint is met" in call(*apply, "--force").err
    assert out.exists()


def test_only_arms_are_slowed(call: Call, clips: list[Path], model: Path, tmp_path: Path) -> None:
    apply = ("edit", "apply", clips[0], "--model", model, *HAND, "--by", 0, 0, 0)
    call(*apply, "--out", tmp_path / "o.npz", "--slower", 2).refused(2, "--slower is for arms")


def test_a_clip_with_frames_left_out_is_written_as_bvh(call: Call, tmp_path: Path) -> None:
    skeleton, files = made_skeleton(), [tmp_path / f"{seed}.npz" for seed in range(4)]
    for seed, file in enumerate(files):
        write_body(file, made_clip(seed, skeleton=skeleton))
    whole = made_clip(0, skeleton=skeleton)
    kept = np.delete(np.arange(30), [12, 13])
    gap = BodyMotion(whole.time[kept], skeleton, whole.rotations[kept], whole.root[kept])
    write_body(files[0], gap)
    model, out = tmp_path / "model.npz", tmp_path / "out.bvh"
    call("edit", "learn", *files, "--frames", 30, "--out", model)
    apply = ("edit", "apply", files[0], "--model", model, *HAND, "--frame", 0, "--by", 0, 0, 0)
    said = call(*apply, "--out", out)
    assert "28 frames became 30 even ones" in said.out, said.err
    written, straight = read_body(out).positions(), whole.positions()
    apart = np.linalg.norm(written - straight, axis=-1).max(axis=1)
    assert apart[[*range(12), *range(14, 30)]].max() < 1e-5
    assert apart[12:14].max() < 0.02


def reach(number: int, rate: float = 200.0) -> Motion:
    """A minimum-jerk reach of the koch from rest, with rest before and after."""
    arm = load_arm("koch", calibrated=False)
    rng = np.random.default_rng(number)
    lifted = rng.uniform([-0.5, 0.0, 0.3, -0.3, -0.3], [0.5, 0.25, 0.7, 0.3, 0.3])
    goal = np.array(arm.rest) + lifted
    time = np.arange(0.0, 2.0, 1.0 / rate)
    u = np.clip((time - 0.3) / 1.2, 0.0, 1.0)[:, None]
    share = 10 * u**3 - 15 * u**4 + 6 * u**5
    angles = np.array(arm.rest) + share * (goal - np.array(arm.rest))
    return Motion(time, arm.joint_names, angles, source=f"reach {number}")


@pytest.fixture(scope="module")
def episodes(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("episodes")
    for number in range(8):
        write_motion(folder / f"{number}.csv", reach(number))
    return sorted(folder.iterdir())


def test_an_arms_episode_is_edited_within_its_limits(
    call: Call, episodes: list[Path], tmp_path: Path
) -> None:
    model, out = tmp_path / "koch.json", tmp_path / "edited.csv"
    learned = call("edit", "learn", *episodes, "--arm", "koch", "--out", model)
    assert learned.status == 0, learned.err
    apply = ("edit", "apply", episodes[0], "--model", model, "--out", out, "--json")
    said = call(*apply, "--point", "tip", "--by", 0, 0.02, 0)
    assert said.status == 0, said.err
    assert "Safe for koch" in said.document["notes"][0]
    assert said.document["score"]["held_distance_m"] > 0.0
    arm = load_arm("koch", calibrated=False)
    edited, before = read_motion(out), reach(0)
    check_trajectory(edited, arm)
    assert edited.angles is not None
    assert before.angles is not None
    ends = arm.chain.positions(np.stack([before.angles[-1], edited.angles[-1]]))
    moved = ends[1, -1] - ends[0, -1]
    np.testing.assert_allclose(moved, [0, 0.02, 0], atol=1e-4)
    streamed = call("stream", out, "--arm", "koch", "--dry-run")
    assert streamed.status == 0, streamed.err


def hand(path: Path) -> np.ndarray:
    """Where the koch's hand ends in a motion file, m."""
    angles = read_motion(path).angles
    assert angles is not None
    return np.asarray(load_arm("koch", calibrated=False).chain.forward(angles[-1]).tip)


@pytest.mark.realtime
def test_a_recorded_episode_goes_five_centimetres_left_and_is_streamed(
    call: Call, tmp_path: Path
) -> None:
    targets = ((-0.20, 0.05, 0.16), (-0.20, 0.0, 0.18), (-0.18, 0.1, 0.18), (-0.22, -0.05, 0.14))
    files = [tmp_path / f"{number}.npz" for number in range(len(targets))]
    for target, file in zip(targets, files, strict=True):
        said = call("reach", "--arm", "koch", "--target", *target, "--rate", 50, "--record", file)
        assert said.status == 0, said.err
    model, out, again = (tmp_path / name for name in ("koch.npz", "left.npz", "again.npz"))
    learned = call("edit", "learn", *files, "--arm", "koch", "--variance", 1, "--out", model)
    assert learned.status == 0, learned.err
    apply = ("edit", "apply", files[0], "--model", model, "--point", "tip", "--by", 0, 0.05, 0)
    edited = call(*apply, "--out", out, "--json")
    assert edited.status == 0, edited.err
    assert edited.document["largest_coefficient"] < 6.0
    assert 0.0 < edited.document["score"]["held_distance_m"] < 0.05
    wanted = np.array([0.0, 0.05, 0.0]) + targets[0]
    np.testing.assert_allclose(hand(out), wanted, atol=1.5e-3)  # a plan ends within 0.5 mm
    streamed = call("stream", out, "--arm", "koch", "--rate", 50, "--record", again, "--json")
    assert streamed.status == 0, streamed.err
    np.testing.assert_allclose(hand(again), wanted, atol=5e-3)


def test_captured_reaches_are_learned_on_an_arm(call: Call, captures: Path, tmp_path: Path) -> None:
    del captures
    model, out = tmp_path / "koch.npz", tmp_path / "left.npz"
    places = ("Low", "MediumMid")
    names = [f"garza:{way}{place}" for way in ("Forward", "Left30", "Right30") for place in places]
    learned = call("edit", "learn", *names, "--arm", "koch", "--variance", 1, "--out", model)
    assert learned.status == 0, learned.err
    assert load_model(model).names == tuple(names)
    apply = ("edit", "apply", names[0], "--model", model, "--point", "tip", "--by", 0, 0.02, 0)
    too_fast = call(*apply, "--out", out)
    too_fast.refused(4, "acceleration", "; with --slower ", "passes all checks")
    needed = too_fast.err.split("--slower ")[1].split(" ")[0]
    edited = call(*apply, "--out", out, "--slower", needed, "--json")
    assert edited.status == 0, edited.err
    arm = load_arm("koch", calibrated=False)
    check_trajectory(read_motion(out), arm)
    dry = call("stream", out, "--arm", "koch", "--dry-run")
    assert dry.status == 0, dry.err
    call("edit", "learn", "golf", "--arm", "koch", "--out", model).refused(2, "golf")


def test_captures_that_the_arm_cannot_follow_are_left_out_by_name(
    call: Call, captures: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    del captures

    def too_fast(angles: np.ndarray, duration: float, arm: ArmDescription, rate: float) -> Timed:
        timed = in_time(angles, duration, arm, rate)
        return timed._replace(time_scale=30.0) if duration == longest else timed

    # As if the arm's postures jumped in one of them
    names = tuple(f"garza:{name}" for name in ("ForwardLow", "Left30Low", "Right30Low", "BackLow"))
    arm = load_arm("koch", calibrated=False)
    examples = examples_on_arm(arm, load_captures(",".join(names)))
    longest = examples.durations.max()
    slow = examples.names[int(examples.durations.argmax())]
    monkeypatch.setattr("armsyn.planning.timing.in_time", too_fast)
    model = tmp_path / "koch.npz"
    said = call("edit", "learn", *names, "--arm", "koch", "--out", model)
    said.refused(2, slow, "jump")
    assert not model.exists()
    said = call("edit", "learn", ",".join(names), "--arm", "koch", "--out", model)
    assert said.status == 0, said.err
    assert f"left out, as postures of koch jump: {slow}" in said.err
    assert set(load_model(model).names) == set(names) - {slow}
