"""Which target is next, and the thread that says so; on a tracker that only listens."""

import json
import os
import select
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.cli.track_feed import TargetFeed
from armsyn.cli.track_lines import LineReader, NumberedTarget, TargetLine
from armsyn.cli.track_waiting import AHEAD_S, MOST_DUE, MOST_WAITING, WaitingTargets
from armsyn.errors import UnreachableError
from armsyn.planning.tracking_state import Aim, Arrival

GOOD, BAD = [0.4, 0.0, 0.0], [5.0, 0.0, 0.0]
PATIENCE = 30.0


class Listener:
    """A tracker whose time goes on each time that it is looked at; it refuses what is far."""

    def __init__(self, step: float = 0.004, begin: float = 0.004) -> None:
        self._now, self._step = begin, step
        self.at_rest = True
        self.turned: list[int] = []
        self.times: dict[int, list[float]] = {}
        self.finished = threading.Event()
        self.on_end: Callable[[Arrival], None] = lambda _: None
        self._last: Aim | None = None
        self.failing = False

    @property
    def now(self) -> float:
        self._now += self._step
        return self._now

    def aim(
        self, target: tuple[float, ...], at: float, tag: NumberedTarget, *, orientation: Any
    ) -> Aim:
        if self.failing:
            raise ZeroDivisionError
        if target[0] > 1.0:
            raise UnreachableError("too far", 4.0)
        assert at <= self._now + AHEAD_S
        assert orientation is None
        chosen = SimpleNamespace(learned="a", rank=0, outside=0.0, time_scale=1.0)
        planned: Any = SimpleNamespace(chosen=chosen, duration=1.0)
        aim = Aim(planned, max(at, self._now), tag)
        if self._last is not None:
            self.on_end(Arrival(self._last, self._now, 0.1, 0.0, "replaced"))
        self._last = aim
        self.turned.append(tag.number)
        return aim

    def finish(self) -> None:
        if self._last is not None:
            self.on_end(Arrival(self._last, self._now, 0.0, 0.0, "arrived"))
            self._last = None
        self.finished.set()


@contextmanager
def feeding(
    listener: Listener, *lines: dict[str, Any], **options: Any
) -> Iterator[tuple[TargetFeed, list[tuple[str, int | None]], int]]:
    """A feed with its lines, what it told, and where more can be written."""
    ours, theirs = os.pipe()
    told: list[tuple[str, int | None]] = []
    tracker: Any = listener

    def tell(event: dict[str, Any]) -> None:
        told.append((event["event"], event.get("line")))
        if "t_s" in event:
            listener.times.setdefault(event["line"], []).append(event["t_s"])

    feed = TargetFeed(tracker, LineReader(ours), tell, **options)
    listener.on_end = feed.ended
    os.write(theirs, "".join(json.dumps(line) + "\n" for line in lines).encode())
    try:
        with feed:
            yield feed, told, theirs
    finally:
        os.close(ours)


def fed(listener: Listener, *lines: dict[str, Any], **options: Any) -> list[tuple[str, int | None]]:
    """What is told of lines, up to the end of the input."""
    with feeding(listener, *lines, **options) as (_, told, theirs):
        os.close(theirs)
        assert listener.finished.wait(PATIENCE)
    return told


def test_a_reach_that_is_left_before_it_begins_is_so_no_earlier_than_it_would_have_begun() -> None:
    listener = Listener()
    told = fed(listener, {"target": GOOD, "t": 0.6}, {"target": GOOD, "t": 0.62})
    assert ("replaced", 1) in told
    begun, left = listener.times[1]
    assert left >= begun >= 0.6


def test_a_script_is_followed_in_its_order_whatever_is_refused() -> None:
    told = fed(
        Listener(),
        {"target": GOOD, "t": 0.0},
        {"target": GOOD, "t": 0.6},
        {"target": BAD, "t": 0.6},
        {"target": GOOD, "t": 0.63},
        {"target": BAD, "t": 0.64},
    )
    assert [e for e in told if e[0] in ("accepted", "passed_over")] == [
        ("accepted", 1), ("accepted", 2), ("accepted", 4),
    ]  # fmt: skip
    assert [e for e in told if e[0] == "refused"] == [("refused", 3), ("refused", 5)]


def test_the_newest_that_can_be_reached_counts() -> None:
    lines = [{"target": place} for place in (GOOD, GOOD, BAD, BAD)]
    told = fed(Listener(), *lines)
    assert told == [
        ("ready", None), ("refused", 4), ("refused", 3), ("passed_over", 1), ("accepted", 2),
        ("arrived", 2),
    ]  # fmt: skip


def test_one_with_a_time_holds_up_none_without() -> None:
    listener = Listener()
    told = fed(listener, {"target": GOOD, "t": 0.8}, {"target": GOOD})
    assert listener.turned == [2, 1]
    assert ("passed_over", 1) not in told


def test_each_is_gone_to_in_the_order_of_lines() -> None:
    listener = Listener()
    fed(listener, {"target": GOOD}, {"target": BAD}, {"target": GOOD, "t": 0.5}, {"target": GOOD},
        each=True)  # fmt: skip
    assert listener.turned == [1, 3, 4]


def test_what_comes_while_the_arm_stops_is_refused_and_what_waits_is_told() -> None:
    asked = threading.Event()
    listener = Listener()
    with feeding(listener, {"target": GOOD}, {"target": GOOD, "t": 1e5}, stopping=asked.is_set) as (
        _,
        told,
        theirs,
    ):
        wait_for(lambda: ("accepted", 1) in told)
        asked.set()
        os.write(theirs, b'{"target": [0.4, 0, 0]}\n')
        wait_for(lambda: ("refused", 3) in told)
        os.close(theirs)
    assert told == [
        ("ready", None), ("accepted", 1), ("refused", 3), ("unfinished", 1), ("unfinished", 2),
    ]  # fmt: skip


def test_what_goes_wrong_in_the_thread_lets_the_arm_finish_and_is_kept() -> None:
    listener = Listener()
    listener.failing = True
    with feeding(listener, {"target": GOOD}) as (feed, told, theirs):
        assert listener.finished.wait(PATIENCE)
        os.close(theirs)
    assert isinstance(feed.error, ZeroDivisionError)
    assert ("unfinished", 1) in told


def test_a_flood_of_lines_waits_in_the_pipe() -> None:
    listener = Listener(step=0.0)
    line = b'{"target": [0.4, 0, 0], "t": 1e5}\n'
    with feeding(listener) as (_, told, theirs):
        os.set_blocking(theirs, False)
        sent = 0
        while True:
            try:
                sent += os.write(theirs, 1000 * line)
            except BlockingIOError:
                if sent // len(line) > MOST_WAITING and not taken(theirs):
                    break
        os.close(theirs)
    assert len(told) <= MOST_WAITING + 70_000 // len(line)
    assert sent // len(line) > MOST_WAITING


def taken(descriptor: int) -> bool:
    """Whether a full pipe has room again within a short while."""
    return bool(select.select([], [descriptor], [], 0.5)[1])


def wait_for(happened: Callable[[], bool]) -> None:
    """Wait until something has happened in another thread."""
    over = threading.Event()
    for _ in range(round(PATIENCE / 0.01)):
        if happened():
            return
        over.wait(0.01)
    pytest.fail("it has not happened")


def waiting(number: int, t: float | None) -> NumberedTarget:
    return NumberedTarget(number, TargetLine((0.4, 0.0, 0.0), t))


@given(
    times=st.lists(st.none() | st.floats(-1.0, 3.0), max_size=12),
    bad=st.sets(st.integers(1, 12)),
    steps=st.lists(st.floats(0.001, 0.5), min_size=1, max_size=20),
)
def test_every_target_has_one_fate_and_none_is_early(
    times: list[float | None], bad: set[int], steps: list[float]
) -> None:
    targets = WaitingTargets()
    fates: dict[int, str] = {}
    now, turned = 0.0, list[NumberedTarget]()
    for number, t in enumerate(times, 1):
        assert targets.add(waiting(number, t), now) == []
    for step in [*steps, 5.0]:
        now += step
        while (target := targets.next(now)) is not None:
            assert target.number not in fates
            assert (target.line.t or 0.0) <= now + AHEAD_S
            if target.number in bad:
                targets.refused(target)
                fates[target.number] = "refused"
                continue
            for other in targets.accepted(target):
                assert (other.line.t or 0.0) <= now
                assert (max(other.line.t or 0.0, 0.0), other.number) < (
                    max(target.line.t or 0.0, 0.0), target.number,
                )  # fmt: skip
                fates[other.number] = "passed over"
            fates[target.number] = "accepted"
            turned.append(target)
    assert sorted(fates) == list(range(1, len(times) + 1))
    moments = [(max(target.line.t or 0.0, 0.0), target.number) for target in turned]
    assert moments == sorted(moments)


def test_memory_is_bounded_when_all_come_at_once() -> None:
    targets = WaitingTargets()
    given_up = [other for k in range(3 * MOST_DUE) for other in targets.add(waiting(k, None), 1.0)]
    assert len(targets) == MOST_DUE
    assert [other.number for other in given_up] == list(range(2 * MOST_DUE))
