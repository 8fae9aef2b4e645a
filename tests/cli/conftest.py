"""The command ``armsyn`` in this process, for what would only repeat imports in another."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from armsyn.arm import load_arm
from armsyn.cli.main import main
from armsyn.errors import RefusedMotionError
from armsyn.planning import PLANS, planner_for
from armsyn.planning.generation.batch import Recipe, make_batch
from armsyn.planning.generation.targets import RandomTargets
from armsyn.planning.minimum_jerk import MinimumJerkPredictor
from armsyn.planning.posing import Pointing
from armsyn.planning.tracking_plan import LawPlanner
from armsyn.planning.tracking_sources import sources_of
from tests.cli.commands import Outcome

CALIBRATION = Path(__file__).resolve().parents[2] / "calibration"


@pytest.fixture
def call(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Outcome]:
    """Run the command's entry point in this process."""

    def run(*arguments: object) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["armsyn", *map(str, arguments)])
        status = 0
        try:
            main()
        except SystemExit as end:
            status = int(end.code or 0)
        said = capsys.readouterr()
        return Outcome(status, said.out, said.err)

    return run


@pytest.fixture
def calibration(tmp_path: Path) -> Path:
    """A copy of the arms' files to damage."""
    return Path(shutil.copytree(CALIBRATION, tmp_path / "calibration"))


@pytest.fixture(scope="session")
def compiled() -> None:
    """What plans reaches is compiled already: commands say so only while they compile."""
    arm, stiff = load_arm("human7"), load_arm("openmanipulator_x")
    for plan in PLANS:
        planner_for(arm, plan).plan(arm.rest, [0.35, -0.1, -0.15])
    with suppress(RefusedMotionError):  # when all has been tried
        sideways = Pointing((0.0, 1.0, 0.0))
        planner_for(stiff, "minjerk").plan(stiff.rest, [0.2, 0.08, 0.15], orientation=sideways)
    LawPlanner(arm, sources_of(arm)).prepare()
    places = RandomTargets(4, 0, [0.2, -0.3, -0.3], [0.6, 0.1, 0.05])
    make_batch(Recipe(arm, MinimumJerkPredictor(arm.chain), places, arm.rest, 50.0), 0, 4)
