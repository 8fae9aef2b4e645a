"""Lines of targets, however they come."""

import os
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.cli.track_feed import NOT_TURNED
from armsyn.cli.track_lines import LONGEST_LINE, LineReader, parse_target, turned
from armsyn.errors import FormatError, InputError
from armsyn.planning import Pointing, Turned


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


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b'{"target": [1e7, 0, 0]}', "within 1000000 m"),
        (b'{"target": [1e999, 0, 0]}', "out of range"),
        (b'{"target": [NaN, 0, 0]}', "a target is"),
        (b'{"target": ["1", 0, 0]}', "Expected `float`"),
        (b'{"target": [0, 0, 0], "t": "now"}', "Expected `float | null`"),
        (b'{"target": [0, 0, 0], "t": 60}', "tracking ends at 60 s"),
        (b'{"target": [0, 0, 0], "t": 1e300}', "tracking ends at 60 s"),
        (b'\x00\xff\xfe{"target": [0, 0, 0]}', "a target is"),
        (b"{" * (LONGEST_LINE - 1), "a target is"),
    ],
)
def test_what_is_no_target_says_why(text: bytes, said: str) -> None:
    with pytest.raises(FormatError) as refused:
        parse_target(text, 60.0)
    assert said in str(refused.value)


def test_a_time_that_is_over_is_one() -> None:
    assert parse_target(b'{"target": [0, 0, 0], "t": -1e300}', 60.0).t == -1e300


def test_a_line_says_how_the_hand_is_turned_or_else_the_options_do() -> None:
    options = {"pointing": (0.0, 1.0, 0.0), "orientation": None, "orientation_tolerance": 5.0}
    plain = turned(parse_target(b'{"target": [0, 0, 0]}'), options)
    assert isinstance(plain, Pointing)
    assert np.asarray(plain.direction).tolist() == [0.0, 1.0, 0.0]
    own = turned(parse_target(b'{"target": [0, 0, 0], "orientation": [0, 0, 90]}'), options)
    assert isinstance(own, Turned)
    assert np.asarray(own.rotation) == pytest.approx(np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]))
    assert plain.tolerance == own.tolerance == pytest.approx(np.radians(5.0))
    assert turned(parse_target(b'{"target": [0, 0, 0]}'), NOT_TURNED) is None


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        (b'"pointing": [1, 0, 0], "orientation": [0, 0, 0]', "pointing or orientation"),
        (b'"pointing": [0, 0, 0]', "pointing: a direction is 3 finite numbers, not all 0"),
        (b'"orientation": [1e308, 0, 0]', "orientation must be three finite angles within"),
    ],
)
def test_a_line_that_turns_the_hand_in_no_way_is_refused(keys: bytes, said: str) -> None:
    with pytest.raises(FormatError, match=said):
        turned(parse_target(b'{"target": [0, 0, 0], ' + keys + b"}"), NOT_TURNED)


def test_what_cannot_be_read_is_refused() -> None:
    ours, theirs = os.pipe()
    try:
        with pytest.raises(InputError, match="for writing only"):
            LineReader(theirs)
        reader = LineReader(ours)
    finally:
        os.close(theirs)
        os.close(ours)
    with pytest.raises(InputError, match="Bad file descriptor"):
        LineReader(ours)
    assert not reader.ended
