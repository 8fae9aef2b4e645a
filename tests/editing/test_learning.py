"""Patterns learned from motions: what PCA promises, what is refused, and files."""

import dataclasses
from pathlib import Path

import msgspec
import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.editing import (
    ChainFigure,
    MotionModel,
    figure_of,
    learn_model,
    load_clips,
    load_model,
    retargeted,
    save_model,
)
from armsyn.editing.pattern.learning import example_poses
from armsyn.errors import CaptureError, FormatError, InputError, PatternError, SkeletonMismatchError
from armsyn.kinematics import quaternion
from armsyn.kinematics.rotation import from_expmap
from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion.body import BodyMotion
from armsyn.motion.motion import Motion
from tests.editing.conftest import made_clip, made_skeleton


def test_all_components_rebuild_every_example(
    made: list[BodyMotion], made_model: MotionModel
) -> None:
    assert made_model.size == 9
    motions = example_poses(made, made_model.figure, 25)
    for motion, coefficients in zip(motions, made_model.examples, strict=True):
        np.testing.assert_allclose(made_model.poses(coefficients), motion, atol=1e-10)


def test_components_are_orthonormal_and_coefficients_white(made_model: MotionModel) -> None:
    E = made_model.components.reshape(made_model.size, -1)
    np.testing.assert_allclose(E @ E.T, np.eye(made_model.size), atol=1e-10)
    np.testing.assert_allclose(np.cov(made_model.examples.T), np.eye(made_model.size), atol=1e-9)
    assert (np.diff(made_model.sigma) < 0).all()


def test_a_share_of_variance_chooses_the_fewest_components(made: list[BodyMotion]) -> None:
    for variance in (0.5, 0.9, 0.98):
        model = learn_model(made, frames=25, variance=variance)
        assert model.variance >= variance > float(model.shares[: model.size - 1].sum())
    assert learn_model(made, frames=25, components=4).size == 4


def test_the_weight_of_lengths_changes_what_is_kept(made: list[BodyMotion]) -> None:
    def missed(radians_per_metre: float) -> float:
        model = learn_model(made, frames=25, components=3, radians_per_metre=radians_per_metre)
        motions = example_poses(made, model.figure, 25)
        rebuilt = np.array([model.poses(row) for row in model.examples])
        return float(np.abs(rebuilt - motions)[..., :3].mean())

    assert missed(20.0) < 0.5 * missed(0.2)


def test_leave_one_out_is_what_learning_without_it_gives(made: list[BodyMotion]) -> None:
    model = learn_model(made, frames=25, components=3)
    motions = example_poses(made, model.figure, 25)
    for out in (0, 4, 9):
        others = learn_model([*made[:out], *made[out + 1 :]], frames=25, components=3)
        away = ((motions[out] - others.mean) * others.weights).ravel()
        alpha = others.components.reshape(3, -1) @ away / others.sigma
        tree = model.figure.tree
        gaps = tree.positions(others.poses(alpha)) - tree.positions(motions[out])
        wanted = np.linalg.norm(gaps, axis=-1).mean()
        assert model.left_out_m[out] == pytest.approx(wanted, rel=1e-6)


def test_a_clips_coefficients_are_its_own(made: list[BodyMotion], made_model: MotionModel) -> None:
    for clip, wanted in zip(made, made_model.examples, strict=True):
        np.testing.assert_allclose(made_model.coefficients(clip), wanted, atol=1e-9)
    assert made_model.nearest_example(made_model.examples[3])[0] == "made 3"


def test_motions_on_different_branches_are_one_pattern() -> None:
    rng, clips = np.random.default_rng(4), []
    for seed in range(6):
        clip = made_clip(seed, skeleton=made_skeleton())
        turned = np.array(clip.rotations)
        angle = np.pi + rng.uniform(-0.2, 0.2)  # some just below pi, some just above
        turned[:, 4] = [0.0, 0.0, angle if angle <= np.pi else angle - 2 * np.pi]
        clips.append(BodyMotion(clip.time, clip.skeleton, turned, clip.root))
    model = learn_model(clips, frames=20)
    column = model.figure.tree.columns.index("hand.rz")
    assert abs(abs(model.mean[0, column]) - np.pi) < 0.2


def test_captured_reaches_are_a_low_dimensional_pattern(reach_model: MotionModel) -> None:
    assert 3 <= reach_model.size <= 15
    assert reach_model.mean.shape == (50, 153)
    assert reach_model.left_out_m.mean() < 0.06
    assert set(reach_model.names) >= {"garza:ForwardHigh"}


def test_swings_carry_translations(captures: Path) -> None:  # noqa: ARG001
    swings = load_clips("golf")
    model = learn_model(swings, frames=132)
    bodies = model.figure.tree.bodies
    assert {"spine", "chest", "neck"} <= {bodies[joint] for joint in figure_of(swings).moving}
    assert model.left_out_m.mean() < 0.05
    own = example_poses(swings, model.figure, 132)[4]
    there = model.figure.tree.positions(own[[0, -1]])
    np.testing.assert_allclose(there, swings[4].positions()[[0, -1]], atol=5e-3)


def test_jumps_have_their_apex_at_frame_15_of_26(captures: Path) -> None:  # noqa: ARG001
    model = learn_model(load_clips("jump"), frames=26, variance=0.95)
    assert abs(int(model.mean[:, 2].argmax()) - 15) <= 1


@pytest.mark.parametrize(
    ("selection", "words"),
    [("polo", "no such set"), ("garza:Moon", "selects no motion"), ("golf:11", "left arm flips")],
)
def test_what_is_not_captured_is_refused(
    captures: Path,  # noqa: ARG001
    selection: str,
    words: str,
) -> None:
    with pytest.raises(CaptureError, match=words):
        load_clips(selection)


def test_too_few_or_equal_motions_are_refused(made: list[BodyMotion]) -> None:
    with pytest.raises(PatternError, match="2 motions: a pattern needs at least 3"):
        learn_model(made[:2])
    with pytest.raises(PatternError, match="all the same"):
        learn_model([made[0]] * 5)
    with pytest.raises(PatternError, match="12 components: these motions have 9"):
        learn_model(made, components=12)
    with pytest.raises(PatternError, match="variance"):
        learn_model(made, variance=1.2)


def test_rank_deficient_sets_keep_what_they_have(made: list[BodyMotion]) -> None:
    model = learn_model([*made[:3], *made[:3]], frames=25, variance=1.0)
    assert model.size == 2


def test_another_skeleton_is_refused_by_name(made: list[BodyMotion]) -> None:
    other = made_clip(3, skeleton=made_skeleton(1.3))
    with pytest.raises(SkeletonMismatchError, match="made 3: joint 'left_foot' lies") as refused:
        learn_model([*made, other])
    assert (refused.value.clip, refused.value.joint) == ("made 3", "left_foot")
    renamed = Skeleton(("a", "b", "c", "d", "e"), (-1, 0, 0, 2, 3), made_skeleton().offsets)
    with pytest.raises(SkeletonMismatchError, match="'a' where the pattern has 'root'"):
        learn_model([*made, made_clip(4, skeleton=renamed)])


def test_a_retargeted_motion_turns_its_bodies_alike(made: list[BodyMotion]) -> None:
    other = Skeleton(made_skeleton().names, (-1, 0, 0, 2, 3), 1.3 * made_skeleton().offsets)
    clip = made_clip(3, skeleton=other)
    fitted = retargeted(clip, made[0].skeleton)
    before = clip.skeleton.frames(clip.root, clip.rotations).orientations
    after = fitted.skeleton.frames(fitted.root, fitted.rotations).orientations
    np.testing.assert_allclose(after, before, atol=1e-12)
    np.testing.assert_allclose(fitted.root, clip.root / 1.3)
    asked = learn_model([*made, clip], frames=25, retarget=True)
    by_hand = learn_model([*made, fitted], frames=25)
    np.testing.assert_array_equal(asked.mean, by_hand.mean)


def test_other_rests_and_another_order_of_joints_are_the_same_motion(
    made: list[BodyMotion], made_model: MotionModel
) -> None:
    own, order = made[3].skeleton, [0, 2, 3, 4, 1]
    other = Skeleton(tuple(own.names[j] for j in order), (-1, 0, 1, 2, 0), own.offsets[order])
    turned = np.asarray(own.prerotations) @ from_expmap(made[3].rotations)
    rotations = quaternion.to_expmap(quaternion.from_matrix(turned))[:, order]
    clip = dataclasses.replace(made[3], skeleton=other, rotations=rotations)
    np.testing.assert_allclose(clip.positions(), made[3].positions()[:, order], atol=1e-12)
    wanted = made_model.coefficients(made[3])
    np.testing.assert_allclose(made_model.coefficients(clip), wanted, atol=1e-9)
    both = learn_model([clip, *made], frames=25, components=3)
    assert both.left_out_m[0] == pytest.approx(both.left_out_m[4], abs=1e-9)


def test_joints_that_hang_elsewhere_are_refused(made: list[BodyMotion]) -> None:
    own = made[3].skeleton
    clip = dataclasses.replace(
        made[3], skeleton=Skeleton(own.names, (-1, 0, 0, 2, 2), own.offsets, own.prerotations)
    )
    for retarget in (False, True):
        with pytest.raises(SkeletonMismatchError, match="'hand' hangs on 'chest', in the pattern"):
            learn_model([*made, clip], retarget=retarget)


@pytest.mark.parametrize("suffix", [".npz", ".json"])
def test_models_come_back_from_files(made_model: MotionModel, tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"model{suffix}"
    save_model(path, made_model)
    loaded = load_model(path)
    for part in ("mean", "components", "sigma", "examples", "shares", "left_out_m"):
        assert getattr(loaded, part).tobytes() == getattr(made_model, part).tobytes()
    assert loaded.names == made_model.names
    assert loaded.inputs_sha256 == made_model.inputs_sha256
    clip = made_clip(2, frames=24)
    np.testing.assert_array_equal(loaded.coefficients(clip), made_model.coefficients(clip))
    once = path.read_bytes()
    save_model(path, loaded)
    assert path.read_bytes() == once


def test_an_arms_pattern_keeps_its_chain(tmp_path: Path) -> None:
    model = learn_model(arm_motions(), figure=ChainFigure(load_arm("koch").chain, "koch"))
    save_model(tmp_path / "koch.npz", model)
    loaded = load_model(tmp_path / "koch.npz")
    np.testing.assert_array_equal(loaded.figure.lower, model.figure.lower)
    np.testing.assert_array_equal(
        loaded.figure.tree.positions(model.mean), model.figure.tree.positions(model.mean)
    )


def arm_motions() -> list[Motion]:
    chain, rng, found = load_arm("koch").chain, np.random.default_rng(8), []
    u = np.linspace(0.0, 1.0, 40)[:, None] ** 2
    for _ in range(6):
        ends = rng.uniform(0.3 * chain.lower, 0.3 * chain.upper, (2, chain.dof))
        found.append(Motion(np.linspace(0, 1, 40), chain.names, (1 - u) * ends[0] + u * ends[1]))
    return found


def test_an_arms_motions_need_its_chain() -> None:
    with pytest.raises(PatternError, match="of which arm"):
        learn_model(arm_motions())
    with pytest.raises(PatternError, match="no joint"):
        learn_model(arm_motions(), figure=ChainFigure(load_arm("human7").chain, "human7"))


def test_damaged_models_are_refused(made_model: MotionModel, tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    save_model(path, made_model)
    header = msgspec.json.decode(path.read_bytes())
    for change, words in (
        ({"schema": "armsyn-motion-model-2"}, "schema"),
        ({"frames": 24}, "not a motion model"),
        ({"sigma": [1.0]}, "not a motion model"),
        ({"names": ["a"]}, "examples"),
        ({"surplus": 1}, "surplus"),
    ):
        path.write_bytes(msgspec.json.encode(header | change))
        with pytest.raises(FormatError, match=words):
            load_model(path)
    path.write_bytes(msgspec.json.encode(header))
    table = tmp_path / "model.components.csv"
    whole = table.read_text()
    lines = whole.splitlines(keepends=True)
    for damaged in (whole[:-4000], "".join([lines[0], lines[2], lines[1], *lines[3:]]), "\n"):
        table.write_text(damaged)
        with pytest.raises(FormatError, match="in order"):
            load_model(path)
    table.write_text(whole.replace(lines[1].split(",")[2], "nan", 1))
    with pytest.raises(FormatError, match="finite"):
        load_model(path)
    table.unlink()
    with pytest.raises(FormatError, match=r"components\.csv"):
        load_model(path)
    with pytest.raises(InputError, match=r"\.npz or \.json"):
        save_model(tmp_path / "model.txt", made_model)
