"""`armsyn track` on simulated arms, end to end."""

import errno
import json
import os
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.cli.track_lines import LONGEST_LINE
from armsyn.cli.track_report import status_of_lines
from armsyn.cli.track_teller import Teller
from armsyn.cli.track_words import printable
from armsyn.driver import Ending, load_recording
from tests.cli.commands import Outcome

pytestmark = pytest.mark.usefixtures("compiled")

Call = Callable[..., Outcome]
Feed = Callable[..., None]
RATE = ("--rate", "50")
"""Slow enough for any machine that tests run on."""
RIGHT, LEFT, AWAY = [0.42, -0.25, -0.05], [0.40, 0.15, 0.02], [5.0, 0.0, 0.0]
NEAR = [0.38, -0.2, -0.08]


@pytest.fixture
def feed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Feed]:
    """Give lines to the standard input: objects as JSON, texts as they are."""
    files = []

    def give(*lines: object) -> None:
        texts = [line if isinstance(line, str) else json.dumps(line) for line in lines]
        (tmp_path / "lines").write_text("".join(f"{text}\n" for text in texts))
        files.append((tmp_path / "lines").open())
        monkeypatch.setattr(sys, "stdin", files[-1])

    yield give
    for file in files:
        file.close()


def events(said: Outcome) -> list[dict[str, Any]]:
    """Standard output, a JSON document a line."""
    return [json.loads(line) for line in said.out.splitlines()]


def test_a_double_step_is_followed_recorded_and_drawn(
    call: Call, feed: Feed, tmp_path: Path
) -> None:
    """And nothing that is no target, or out of reach, takes the place of one."""
    feed(
        {"target": RIGHT, "id": "a"},
        {"target": LEFT, "t": 0.6, "id": "b"},
        {"target": AWAY, "t": 0.62},
        {"target": AWAY},
        "nonsense",
        "",
        {"traget": RIGHT},
        "x" * (LONGEST_LINE + 1),
    )
    record, plot = tmp_path / "out.npz", tmp_path / "out.png"
    said = call("track", *RATE, "--json", "--record", record, "--plot", plot)
    assert said.status == 0, said.err
    assert said.err.startswith("simulated human7 on ")
    assert "line 3: target (5.000, 0.000, 0.000) m cannot be reached by human7" in said.err
    told = events(said)
    assert [(e["event"], e.get("line"), e.get("id")) for e in told] == [
        ("malformed", 5, None),
        ("malformed", 7, None),
        ("malformed", 8, None),
        ("ready", None, None),
        ("refused", 4, None),
        ("accepted", 1, "a"),
        ("accepted", 2, "b"),
        ("refused", 3, None),
        ("replaced", 1, "a"),
        ("arrived", 2, "b"),
        ("ended", None, None),
    ]
    assert told[6]["t_s"] == pytest.approx(0.6, abs=0.2)
    assert told[9]["hand_error_m"] < 3e-3
    times = [e["t_s"] for e in told if "t_s" in e and e["line"] == 1]
    assert times == sorted(times)
    assert told[-1]["ending"].startswith("at rest, torque on, holding")
    recording = load_recording(record)
    hand = load_arm("human7").chain.forward(recording.measured_rad[-1]).tip
    assert np.linalg.norm(hand - LEFT) < 0.003
    assert plot.read_bytes().startswith(b"\x89PNG")


def test_each_is_gone_to_in_turn_and_told_to_people(call: Call, feed: Feed) -> None:
    feed({"target": NEAR, "id": "a\x1b[2J"}, {"target": AWAY}, {"target": RIGHT})
    said = call("track", *RATE, "--each", "--park")
    assert said.status == 0, said.err
    lines = [line for line in said.out.splitlines()[1:] if "the host stalled" not in line]
    told = [line.split(": ")[0].split("  ")[-1] for line in lines]
    names = ["line 1 (a\\x1b[2J)"] * 2 + ["line 3"] * 2
    assert told == ["ready", *names, "targets", "stream", "ended"]
    assert "2 accepted, 2 arrived, 1 refused" in said.out
    assert Ending.PARKED.value in said.out


def test_a_hand_is_turned_as_its_line_says(call: Call, feed: Feed) -> None:
    """Told in the names and units of `armsyn reach --json`."""
    feed(
        {"target": NEAR, "pointing": [0, 0, -1], "orientation": [0, 0, 0]},
        {"target": (0.35, -0.10, -0.15), "pointing": [0, 0, -2]},
    )
    said = call("track", *RATE, "--json")
    assert said.status == 0, said.err
    assert "line 1: a hand points somewhere or is turned some way" in said.err
    malformed, _, accepted, arrived, _ = events(said)
    assert malformed["event"] == "malformed"
    assert accepted["orientation"] == {"pointing": [0.0, 0.0, -1.0]}
    assert accepted["captured"] is None  # by the atlas
    assert accepted["outside_m"] < 0.05
    assert arrived["event"] == "arrived"
    assert arrived["hand_error_m"] < 3e-3
    assert arrived["orientation_error_rad"] < np.radians(2.0)


def test_without_any_good_target_it_holds_and_says_so(call: Call, feed: Feed) -> None:
    feed({"target": AWAY}, "what?")
    said = call("track", *RATE, "--json")
    assert said.status == 4
    assert events(said)[-1]["ending"].startswith("at rest, torque on, holding")


@pytest.mark.parametrize(
    ("counts", "status"),
    [
        ({}, 0),
        ({"malformed": 1}, 2),
        ({"malformed": 1, "refused": 1}, 4),
        ({"malformed": 1, "refused": 1, "accepted": 1}, 0),
    ],
)
def test_the_exit_status_says_whether_any_target_was_good(
    counts: dict[str, int], status: int
) -> None:
    assert status_of_lines(Counter(counts)) == status


def test_a_full_standard_output_is_told_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    with Path("/dev/full").open("w") as full:
        monkeypatch.setattr(sys, "stdout", full)
        teller = Teller(as_json=True, keeping=False)
        teller.tell({"event": "ready"})
        assert teller.lost is not None
        assert teller.lost.errno == errno.ENOSPC
        teller.tell({"event": "ready"})
        monkeypatch.undo()
    assert teller.counts["ready"] == 2


def test_a_full_standard_error_does_not_end_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with Path("/dev/full").open("w", buffering=1) as full:
        monkeypatch.setattr(sys, "stderr", full)
        Teller(as_json=True, keeping=False).tell(
            {"event": "malformed", "line": 1, "id": None, "reason": "what?"}
        )
        monkeypatch.undo()
        with Path(os.devnull).open("w") as silence:
            os.dup2(silence.fileno(), full.fileno())  # what is left to flush
    assert json.loads(capsys.readouterr().out)["reason"] == "what?"


def test_words_cannot_trick_a_terminal() -> None:
    assert printable("a\x1b[2J\nb\u202e\ud800é", "ascii") == "a\\x1b[2J\\nb\\u202e\\ud800\\xe9"
    assert printable("é", "utf-8") == "é"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--plot", "no/where.png"), "in a folder that exists"),
        (("--record", "out.txt"), "recordings are written as .npz or .csv"),
        (("--port", "/dev/none"), "--port needs --arm"),
        (("--slower", "0.5"), "--slower must be at least 1"),
        (("--arm", "nobody"), "nobody"),
    ],
)
def test_what_is_refused(call: Call, feed: Feed, arguments: tuple[str, ...], said: str) -> None:
    feed()
    call("track", *arguments).refused(2, said)


def test_a_fault_is_one_line_of_json_too(call: Call, feed: Feed) -> None:
    feed()
    said = call("track", "--json", "--arm", "human7", "--port", "/dev/none")
    assert said.status == 3
    (told,) = events(said)
    assert told["event"] == "failed"
    assert told["error"]["exit_status"] == 3


def test_ctrl_c_on_the_way_stops_it_and_says_what_is_unfinished() -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "armsyn", "track", *RATE, "--json"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    with process:
        assert process.stdin is not None
        assert process.stdout is not None
        for line in ({"target": RIGHT}, {"target": LEFT, "t": 500.0}):
            process.stdin.write(json.dumps(line) + "\n")
        process.stdin.flush()
        for event in ("ready", "accepted"):
            assert json.loads(process.stdout.readline())["event"] == event
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    *before, told = map(json.loads, out.splitlines())
    assert [(e["event"], e["line"]) for e in before] == [("unfinished", 1), ("unfinished", 2)]
    assert told["ending"] in (Ending.STOPPED_HOLDING.value, Ending.STOPPED_PARKED.value)
