"""The command ``armsyn`` in this process, for what would only repeat imports in another."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from armsyn.arm import load_arm
from armsyn.cli.main import main
from armsyn.planning import PLANS, planner_for
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
    arm = load_arm("human7")
    for plan in PLANS:
        planner_for(arm, plan).plan(arm.rest, [0.35, -0.1, -0.15])
