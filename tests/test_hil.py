"""The tests for real arms, run as on one: on a port, in a process that knows nothing else of it."""

import subprocess
import sys
from pathlib import Path

import pytest

from firmware_sim.testing import running

ROOT = Path(__file__).resolve().parent.parent


@pytest.mark.slow
@pytest.mark.fault(26)
@pytest.mark.parametrize("arm", ["viperx_300s", "reachy_right"])
def test_they_pass_on_an_arm_that_another_process_simulates(arm: str) -> None:
    consent = ["--accept-no-watchdog"] if arm == "reachy_right" else []
    with running(arguments=("--arm", arm)) as port:
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/hil"]
        done = subprocess.run(
            [*command, "--port", port, "--arm", arm, *consent],
            cwd=ROOT,
            capture_output=True,
            text=True,
            timeout=250,
            check=False,
        )
    assert done.returncode == 0, done.stdout[-3000:]
    assert " passed" in done.stdout
    assert "skipped" not in done.stdout
