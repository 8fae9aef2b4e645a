"""What `armsyn reach` compiles, it compiles before it opens a port, and says so."""

import threading
from typing import ClassVar

import numba
import pytest

from armsyn.cli import compiling
from armsyn.cli.compiling import PATIENCE_S, WORDS, telling_of_compilation
from tests.cli.commands import PATIENCE, started

ORDER = """
from armsyn.driver import ArmSession
from armsyn.planning.motion_planner import MotionPlanner
plan, open_session = MotionPlanner.plan, ArmSession.open
def planned(*arguments, **options):
    print("planned", flush=True)
    return plan(*arguments, **options)
def opened(*arguments, **options):
    print("opened", flush=True)
    return open_session(*arguments, **options)
MotionPlanner.plan, ArmSession.open = planned, opened
"""


def test_it_plans_once_before_it_opens_the_port() -> None:
    asked = ("--target", "-0.2", "0", "0.2", "--arm", "koch", "--plan", "minjerk", "--rate", "50")
    with started("reach", *asked, hook=ORDER) as process:
        out, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, errors
    first, *rest = out.splitlines()
    assert first.startswith("simulated koch on ")
    assert rest[:3] == ["planned", "opened", "planned"]


class Waited(threading.Timer):
    """A timer that somebody else's clock fires."""

    made: ClassVar[list["Waited"]] = []

    def start(self) -> None:
        self.made.append(self)


@pytest.fixture
def timers(monkeypatch: pytest.MonkeyPatch) -> list[Waited]:
    monkeypatch.setattr(Waited, "made", [])
    monkeypatch.setattr(compiling.threading, "Timer", Waited)
    return Waited.made


def test_only_what_is_compiled_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(compiling, "PATIENCE_S", 0.0)
    twice = numba.njit(lambda number: 2 * number)
    for words in (f"{WORDS}\n", ""):
        with telling_of_compilation():
            assert twice(2) == 4
        assert capsys.readouterr().err == words


def test_what_goes_on_after_a_short_compilation_is_not_taken_for_one(
    timers: list[Waited],
) -> None:
    """Compilation after compilation is: each leaves the next less time."""
    with telling_of_compilation():
        for factor in (2, 3):
            assert numba.njit(lambda number, factor=factor: factor * number)(2) == 2 * factor
            assert all(timer.finished.is_set() for timer in timers)
    first, second = (timer.interval for timer in timers)
    assert second < first == PATIENCE_S
