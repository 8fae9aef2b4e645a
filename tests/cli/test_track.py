"""`armsyn track` on simulated arms, end to end, and its lines."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.arm import load_arm
from armsyn.cli.track_lines import LONGEST_LINE, LineReader, parse_target
from armsyn.driver import Ending, load_recording
from armsyn.errors import FormatError
from tests.cli.commands import Outcome

Call = Callable[..., Outcome]
Feed = Callable[..., None]
RATE = ("--rate", "50")
"""Slow enough for any machine that tests run on."""
RIGHT, LEFT = [0.42, -0.25, -0.05], [0.40, 0.15, 0.02]


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
    feed({"target": RIGHT, "id": "a"}, {"target": LEFT, "t": 1.0, "id": "b"})
    record, plot = tmp_path / "out.npz", tmp_path / "out.png"
    said = call("track", *RATE, "--json", "--record", record, "--plot", plot)
    assert said.status == 0, said.err
    assert said.err.startswith("simulated human7 on ")
    told = events(said)
    assert [(e["event"], e.get("line"), e.get("id")) for e in told] == [
        ("ready", None, None),
        ("accepted", 1, "a"),
        ("accepted", 2, "b"),
        ("replaced", 1, "a"),
        ("arrived", 2, "b"),
        ("ended", None, None),
    ]
    assert told[2]["t_s"] == pytest.approx(1.0, abs=0.05)
    assert told[4]["error_mm"] < 3.0
    assert told[5]["ending"] == Ending.COMPLETED.value
    recording = load_recording(record)
    hand = load_arm("human7").chain.forward(recording.measured_rad[-1]).tip
    assert np.linalg.norm(hand - LEFT) < 0.003
    assert plot.read_bytes().startswith(b"\x89PNG")


def test_lines_that_are_no_targets_are_answered_and_the_arm_goes_on(call: Call, feed: Feed) -> None:
    feed(
        {"target": RIGHT},
        "nonsense",
        '{"target": [1, 2]}',
        '{"traget": [1, 2, 3]}',
        '{"target": [1e999, 0, 0]}',
        "",
        {"target": [5.0, 0.0, 0.0], "t": 0.5},
        "x" * (LONGEST_LINE + 1),
    )
    said = call("track", *RATE)
    assert said.status == 0, said.err
    answered = [line for line in said.err.splitlines() if line.startswith("armsyn: line ")]
    assert [line.split(":")[1].split()[-1] for line in answered] == ["2", "3", "4", "5", "8", "7"]
    assert "Traceback" not in said.err
    assert "line 7: target (5.000, 0.000, 0.000) m cannot be reached by human7" in said.err
    assert "line 1: arrived" in said.out
    assert "1 accepted, 1 arrived, 5 malformed, 1 refused" in said.out


def test_the_newest_counts_unless_each_is_wanted(call: Call, feed: Feed) -> None:
    feed({"target": RIGHT}, {"target": LEFT})
    newest = events(call("track", *RATE, "--json"))
    assert [(e["event"], e.get("line")) for e in newest][1:3] == [
        ("passed_over", 1),
        ("accepted", 2),
    ]
    feed({"target": RIGHT}, {"target": [0.38, -0.2, -0.08]})
    each = events(call("track", *RATE, "--json", "--each", "--park"))
    assert [(e["event"], e.get("line")) for e in each] == [
        ("ready", None),
        ("accepted", 1),
        ("arrived", 1),
        ("accepted", 2),
        ("arrived", 2),
        ("ended", None),
    ]
    assert each[-1]["ending"] == Ending.PARKED.value


@pytest.mark.parametrize(
    ("lines", "status"),
    [((), 0), (("what?",), 2), (({"target": [5.0, 0.0, 0.0]}, "what?"), 4)],
    ids=["nothing", "no target", "out of reach"],
)
def test_without_any_good_target_it_holds_and_says_so(
    call: Call, feed: Feed, lines: tuple[object, ...], status: int
) -> None:
    feed(*lines)
    said = call("track", *RATE, "--json")
    assert said.status == status
    assert events(said)[-1]["ending"] == Ending.COMPLETED.value


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


def test_ctrl_c_stops_it_while_it_waits_for_targets() -> None:
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
        process.stdin.write(json.dumps({"target": RIGHT}) + "\n")
        process.stdin.flush()
        for event in ("ready", "accepted", "arrived"):
            assert json.loads(process.stdout.readline())["event"] == event
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    told = json.loads(out.splitlines()[-1])
    assert told["ending"] in (Ending.STOPPED_HOLDING.value, Ending.STOPPED_PARKED.value)


@given(st.binary(max_size=200))
def test_no_line_breaks_the_parser(text: bytes) -> None:
    try:
        line = parse_target(text)
    except FormatError:
        return
    assert len(line.target) == 3


@given(
    lines=st.lists(st.binary(max_size=30).map(lambda b: b.replace(b"\n", b"")), max_size=8),
    cuts=st.lists(st.integers(1, 20), min_size=1, max_size=8),
)
def test_lines_are_the_same_however_they_come(lines: list[bytes], cuts: list[int]) -> None:
    data, found = b"\n".join(lines), list[tuple[int, bytes]]()
    ours, theirs = os.pipe()
    try:
        reader = LineReader(ours)
        while data:
            size = cuts[len(found) % len(cuts)]
            os.write(theirs, data[:size])
            data = data[size:]
            found += reader.read(0.0)
        os.close(theirs)
        deadline = time.monotonic() + 10.0
        while not reader.ended and time.monotonic() < deadline:
            found += reader.read(0.0)
    finally:
        os.close(ours)
    expected = [(n, line.strip()) for n, line in enumerate(lines, 1) if line.strip()]
    assert found == expected


def test_a_line_without_end_does_not_fill_the_memory() -> None:
    ours, theirs = os.pipe()
    try:
        reader = LineReader(ours)
        for _ in range(50):
            os.write(theirs, b"x" * 4096)
            assert reader.read(0.0) == []
        os.write(theirs, b'\n{"target": [0, 0, 0]}\n')
        (one, text), (two, _) = reader.read(0.0)
        assert (one, two) == (1, 2)
        assert len(text) == LONGEST_LINE + 1
    finally:
        os.close(ours)
        os.close(theirs)
