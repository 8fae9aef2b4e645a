"""What `armsyn reach` compiles, it compiles before it opens a port, and says so."""

import numba
import pytest

from armsyn.cli import compiling
from armsyn.cli.compiling import telling_of_compilation
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


def test_only_what_is_compiled_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(compiling, "PATIENCE_S", 0.0)
    twice = numba.njit(lambda number: 2 * number)
    for words in ("compiling what plans reaches (once; a minute or two)\n", ""):
        with telling_of_compilation():
            assert twice(2) == 4
        assert capsys.readouterr().err == words
