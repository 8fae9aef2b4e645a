"""What `armsyn edit` takes for a motion: units, skeletons, archives of several, other kinds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from armsyn.editing import load_model
from armsyn.motion.formats import read_body, write_body
from tests.cli.commands import Outcome
from tests.editing.conftest import made_clip, made_skeleton

Call = Callable[..., Outcome]


@pytest.fixture
def clips(tmp_path: Path) -> list[Path]:
    files = [tmp_path / f"{seed}.npz" for seed in range(5)]
    for seed, file in enumerate(files):
        write_body(file, made_clip(seed, skeleton=made_skeleton()))
    return files


@pytest.fixture
def model(call: Call, clips: list[Path], tmp_path: Path) -> Path:
    path = tmp_path / "model.npz"
    assert call("edit", "learn", *clips, "--variance", 1, "--out", path).status == 0
    return path


def test_the_units_of_a_file_are_told_or_doubted(
    call: Call, clips: list[Path], model: Path, tmp_path: Path
) -> None:
    file, out = tmp_path / "body.bvh", tmp_path / "out.npz"
    body = read_body(clips[0])
    write_body(file, body)
    apply = ("edit", "apply", file, "--model", model, "--out", out, "--point", "hand")
    still = ("--by", 0, 0, 0)
    assert call(*apply, *still).err == ""
    small = call(*apply, *still, "--unit", "mm", "--retarget")
    assert "m tall by units mm: is it? see --unit" in small.err
    learned = call("edit", "learn", *[file] * 3, "--unit", "mm", "--out", tmp_path / "m.npz")
    assert learned.err.count("m tall by units mm") == 3
    assert call(*apply, *still, "--unit", "furlong").status == 2


def test_an_edits_bvh_is_edited_by_the_same_model(
    call: Call, clips: list[Path], model: Path, tmp_path: Path
) -> None:
    once, twice = tmp_path / "once.bvh", tmp_path / "twice.bvh"
    apply = ("--model", model, "--point", "hand", "--by", 0, 0.02, 0, "--out")
    assert call("edit", "apply", clips[1], *apply, once).status == 0
    again = call("edit", "apply", once, *apply, twice)
    assert again.status == 0, again.err
    ends = []
    for file in (clips[1], once, twice):
        body = read_body(file)
        ends.append(body.positions()[-1, body.skeleton.index("hand")])
    np.testing.assert_allclose(ends[2], ends[0] + [0, 0.04, 0], atol=1e-5)


def test_a_clip_of_another_size_is_retargeted_when_asked(
    call: Call, model: Path, tmp_path: Path
) -> None:
    large, out = tmp_path / "large.npz", tmp_path / "out.npz"
    write_body(large, made_clip(9, skeleton=made_skeleton(1.3)))
    apply = ("edit", "apply", large, "--model", model, "--out", out, "--point", "hand")
    call(*apply, "--by", 0, 0.01, 0).refused(2, "retarget it first (--retarget)")
    said = call(*apply, "--by", 0, 0.01, 0, "--retarget", "--force")
    assert said.status == 0, said.err
    np.testing.assert_allclose(read_body(out).skeleton.offsets, made_skeleton().offsets)


def test_joints_of_other_names_are_said_once_for_all(
    call: Call, captures: Path, tmp_path: Path
) -> None:
    folder, out = captures / "jump" / "cmu", tmp_path / "model.npz"
    learn = ("edit", "learn", *(folder / name for name in ("01_01.bvh", "01_01.amc", "02_04.amc")))
    for more in ((), ("--retarget",)):
        said = call(*learn, "--out", out, *more)
        assert said.status == 2
        assert "where the pattern has 'Hips'" in said.err
        assert "share their joints' names, retargeted ones, too" in said.err
    assert "retarget it first" not in said.err
    assert "0.26 m tall by units cm (assumed)" in said.err


def test_all_motions_of_an_archive_are_taken_by_a_star(
    call: Call, captures: Path, tmp_path: Path
) -> None:
    out = tmp_path / "model.npz"
    archive = captures / "reach" / "garza" / "reach.npz"
    call("edit", "learn", archive, "--out", out).refused(2, "motions: name one", "#*", "garza")
    learned = call("edit", "learn", f"{archive}#*", "--frames", 10, "--out", out)
    assert learned.status == 0, learned.err
    assert len(load_model(out).names) == 35
    assert "others (--json)" in learned.out


def test_motions_of_another_kind_are_said_to_be(
    call: Call, model: Path, captures: Path, tmp_path: Path
) -> None:
    del captures
    table, out = tmp_path / "arm.csv", tmp_path / "out.npz"
    table.write_text("time_s,elbow:angle_rad\n0,0\n1,1\n")
    apply = ("--model", model, "--out", out, "--point", "hand", "--by", 0, 0, 0)
    call("edit", "apply", table, *apply).refused(2, "arm.csv", "--arm NAME")
    call("edit", "apply", "jump:1", *apply).refused(2, "no motion of jump", "jump:")
