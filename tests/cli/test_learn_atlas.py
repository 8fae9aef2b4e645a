"""`armsyn learn --atlas` on captured reaches, and what it refuses before it learns."""

import json
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from armsyn.arm import load_arm
from armsyn.planning.atlas_file import load_atlas
from tests.cli.commands import Outcome, next_line, run, started

Call = Callable[..., Outcome]
USUAL = ("learn", "--atlas", "--arm", "hug_mp4", "--captures", "hug_mp:S01")

PUTTING = """
from armsyn.cli.long_work import StageBars
update = StageBars.update
def told(self, name, done, total, said):
    update(self, name, done, total, said)
    if done == 2:
        print("learning", flush=True)
StageBars.update = told
"""


@pytest.mark.usefixtures("captures")
def test_it_writes_an_atlas_and_says_what_is_in_it(tmp_path: Path) -> None:
    out = tmp_path / "made.atlas.json"
    said = run(*USUAL, "--seed", 3, "--out", out, "--json")
    assert said.status == 0, said.err
    atlas, document = load_atlas(out, load_arm("hug_mp4", calibrated=False)), said.document
    assert document["kinds"] == ["linear", "latent", "synergy"] == list(atlas.kinds)
    assert (document["arm"], document["seed"], document["out"]) == ("hug_mp4", 3, str(out))
    assert (document["reaches"], document["places"]) == (14, 7)
    assert document["subjects"] == ["S01"]
    assert document["sources"] == ["hug_mp: S01_trajs.mat"]
    assert document["likeness"]["residual_m"] < 1e-3  # its own chain expresses it wholly
    assert document["likeness"]["upper_arm_deg"] < 0.5
    assert document["repeats"] == "hug_mp:S01"
    assert out.stat().st_size < 300_000
    assert "put on the arm" in said.err
    made = json.loads((tmp_path / "made.atlas.run.json").read_text())
    assert made["command"][:2] == ["armsyn", "learn"]
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.usefixtures("captures")
def test_ctrl_c_leaves_what_was_there(tmp_path: Path) -> None:
    out = tmp_path / "made.atlas.json"
    out.write_text("what was there")
    with started(*USUAL, "--out", out, hook=PUTTING) as process:
        assert next_line(process) == "learning"
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
    assert process.returncode not in (0, 1)
    assert "Traceback" not in err
    assert out.read_text() == "what was there"
    assert [file.name for file in tmp_path.iterdir()] == [out.name]


def test_options_of_synergies_alone_are_refused(call: Call, tmp_path: Path) -> None:
    out = tmp_path / "made.atlas.json"
    call(*USUAL, "--model", "C", "--out", out).refused(2, "--model is not for --atlas")
    call(*USUAL, "--resume", "--out", out).refused(2, "--resume is not for --atlas")
    said = call("learn", "--arm", "hug_mp4", "--captures", "hug_mp:S01", "--repeats", "garza")
    assert said.status == 2
    assert "'--repeats' is for --atlas" in said.err


@pytest.mark.usefixtures("captures")
def test_too_few_captures_and_places_that_cannot_be_written_are_refused(
    call: Call, tmp_path: Path
) -> None:
    out = tmp_path / "made.atlas.json"
    few = ("learn", "--atlas", "--arm", "hug_mp4", "--captures", "hug_mp:S01:1:R-1", "--out", out)
    said = call(*few)
    assert said.status == 2
    assert "learning needs 8 at least" in said.err
    nowhere = tmp_path / "none" / "made.atlas.json"
    call(*USUAL, "--out", nowhere).refused(2, "does not exist: make it first")
    assert not list(tmp_path.iterdir())
