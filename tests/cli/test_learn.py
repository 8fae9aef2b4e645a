"""`armsyn learn` on captured reaches, and what it refuses before it learns."""

import json
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from armsyn.synergy import load_library
from tests.cli.commands import Outcome, next_line, run, started

Call = Callable[..., Outcome]
ONE = "hug_mp:S01:1.1.1:R-1"
TINY = ("--budget", "30")

LEARNING = """
from armsyn.cli.long_work import StageBars
update = StageBars.update
def told(self, name, done, total, said):
    update(self, name, done, total, said)
    if done == 3:
        print("learning", flush=True)
StageBars.update = told
"""


@pytest.mark.usefixtures("captures")
def test_it_writes_a_library_and_says_what_is_in_it(tmp_path: Path) -> None:
    out = tmp_path / "made.json"
    arguments = ("--model", "A", "--model", "C", "--ik", "svd", "--ik", "jt", "--workers", "1")
    said = run(
        "learn", "--captures", ONE, "--arm", "hug_mp4", *TINY, *arguments, "--out", out, "--json"
    )
    assert said.status == 0, said.err
    library, document = load_library(out), said.document
    assert document["complete"] is True
    assert document["arm"] == library.arm == "hug_mp4"
    assert document["out"] == str(out)
    rows = {(row["ik"], row["model"]): row for row in document["learned"]}
    assert set(rows) == {("svd", "A"), ("svd", "C"), ("jt", "A"), ("jt", "C")}
    assert [reach.name for reach in library.reaches] == [ONE]
    for (ik, model), row in rows.items():
        learned = library.reaches[0].set_for(ik, model)
        assert learned is not None
        assert row["mean_m"] == row["min_m"] == row["max_m"] == learned.distance_m
        assert row["lambda"] == {"svd": 6.0, "jt": 60.0}[ik]  # a model without servos
    assert not library.stable_gains
    made = json.loads((tmp_path / "made.run.json").read_text())
    assert made["command"][:2] == ["armsyn", "learn"]
    assert sorted(file.name for file in tmp_path.iterdir()) == ["made.json", "made.run.json"]


@pytest.mark.usefixtures("captures")
def test_workers_and_place_leave_no_trace_in_the_result(call: Call, tmp_path: Path) -> None:
    for workers in ("1", "2"):
        out = tmp_path / workers / "made.json"
        out.parent.mkdir()
        said = call(
            *("learn", "--captures", f"{ONE},garza:ForwardLow", "--arm", "hug_mp4"),
            *(*TINY, "--workers", workers, "--out", out),
        )
        assert said.status == 0, said.err
        assert "S_C" in said.out
        assert "not used: garza:ForwardLow: garza:ForwardLow has landmarks" in said.out.replace(
            "\n", " "
        )
    one, two = (tmp_path / workers / "made.json" for workers in "12")
    assert one.read_bytes() == two.read_bytes()


@pytest.mark.parametrize("workers", ["1", "2"])
@pytest.mark.usefixtures("captures")
def test_ctrl_c_keeps_what_is_finished_and_resume_learns_the_rest(
    call: Call, tmp_path: Path, workers: str
) -> None:
    out, whole = tmp_path / "made.json", tmp_path / "whole.json"
    usual = ("learn", "--captures", "hug_mp:S01", "--arm", "hug_mp4", "--budget", "1000")
    with started(*usual, "--workers", workers, "--out", out, "--json", hook=LEARNING) as process:
        assert next_line(process) == "learning"
        process.send_signal(signal.SIGINT)
        rest, errors = process.communicate(timeout=60)
    assert process.returncode == 0, errors
    assert json.loads(rest)["complete"] is False
    library = load_library(out)
    assert not library.complete
    assert 3 <= len(library.reaches) < 14
    assert call(*usual, "--out", out, "--resume").status == 0
    assert call(*usual, "--out", whole).status == 0
    assert out.read_bytes() == whole.read_bytes()


@pytest.mark.usefixtures("captures")
def test_convergence_is_plotted(call: Call, tmp_path: Path) -> None:
    usual = ("learn", "--captures", ONE, "--arm", "hug_mp4", *TINY, "--out", tmp_path / "made.json")
    plot = tmp_path / "convergence.png"
    assert call(*usual, "--plot-convergence", plot).status == 0
    assert plot.read_bytes().startswith(b"\x89PNG")
    call(*usual, "--resume", "--plot-convergence", plot).refused(2, "nothing was left to learn")


@pytest.mark.parametrize("learner", ["annealing", "cma", "evolution"])
@pytest.mark.usefixtures("captures")
def test_every_learner_can_be_chosen(call: Call, tmp_path: Path, learner: str) -> None:
    out = tmp_path / "made.json"
    arguments = ("--captures", ONE, "--arm", "hug_mp4", "--learner", learner, "--out", out)
    assert call("learn", *arguments, "--budget", "60").status == 0
    assert load_library(out).reaches[0].sets[0].distance_m < 0.2


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ("absent/made.json", "does not exist: make it first"),
        ("/proc/made.json", "the folder /proc cannot be written"),
        (".", "is a directory"),
    ],
)
def test_where_it_cannot_write_it_does_not_learn(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str, said: str
) -> None:
    """Said before even the captures, which are not there either, are looked for."""
    monkeypatch.setenv("ARMSYN_CAPTURES", str(tmp_path))
    call("learn", "--captures", ONE, "--arm", "hug_mp4", "--out", tmp_path / place).refused(2, said)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (("--arm", "human8"), "no human8.toml"),
        (("--arm", "../human7"), "is not the name of an arm"),
        (("--captures", "mocap"), "no such set of captures; known: garza, hug_mp"),
        (("--captures", "garza:Nowhere"), "selects no capture of garza"),
        (("--captures", "garza:ForwardLow"), "none of 1 captures can be used: garza:ForwardLow"),
        (("--lambda", "0"), "lambda must be a positive rate in 1/s, got 0"),
        (("--lambda", "nan"), "lambda must be a positive rate in 1/s, got nan"),
        (("--rate", "0"), "cannot resample at 0.0 Hz"),
        (("--rate", "nan"), "cannot resample at nan Hz"),
        (("--rate", "1e9"), "choose another rate"),
        (("--workers", "999"), "workers must be between 1 and"),
        (("--workers", "0"), "is not in the range"),
        (("--budget", "0"), "is not in the range"),
        (("--learner", "guessing"), "is not one of"),
        (("--population", "8"), "are for --learner annealing without --budget"),
        (("--plot-convergence", "made.pdf"), "a plot is written as .png"),
        (("--plot-convergence", "/nowhere/made.png"), "make it first"),
        (("--seed", "-1"), "is not in the range"),
        (("--calibration", "/nowhere"), "no hug_mp4.toml in /nowhere"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
@pytest.mark.usefixtures("captures")
def test_bad_input_is_refused(
    call: Call, tmp_path: Path, changed: tuple[str, str], said: str
) -> None:
    usual = {"--captures": ONE, "--arm": "hug_mp4", "--out": str(tmp_path / "made.json")}
    options = {**usual, changed[0]: changed[1]}
    pairs = [text for pair in options.items() for text in pair]
    call("learn", *TINY, *pairs).refused(2, said)
    assert list(tmp_path.iterdir()) == []


def test_nothing_to_resume_is_said(call: Call, tmp_path: Path) -> None:
    out = tmp_path / "made.json"
    usual = ("learn", "--captures", ONE, "--arm", "hug_mp4", "--resume", "--out", out)
    call(*usual).refused(2, "does not exist: there is nothing to resume")
    out.write_text("{}")
    call(*usual).refused(2, "learn it again")


def test_missing_captures_are_one_line(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ARMSYN_CAPTURES", str(tmp_path / "nowhere"))
    arguments = ("--captures", "garza", "--arm", "human7", "--out", tmp_path / "made.json")
    call("learn", *arguments).refused(2, "set ARMSYN_CAPTURES to the captures' folder")
