"""What a simulator says when all is well is told from what it says when it ends."""

import argparse

import pytest

import firmware_sim.command.run
from armsyn.cli.simulator import _ANNOUNCEMENTS


def test_all_announcements_are_known(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(firmware_sim.command.run, "_QUIET_START", 0.0)
    arguments = argparse.Namespace(servo=["xm430-w350:1"], protocol=None, baud=None)
    arguments.return_delay = None
    rig = firmware_sim.command.run.choose_rig(arguments)
    with firmware_sim.command.run._explained():
        said = ""
        while "\n" not in said:
            said += capsys.readouterr().err
    firmware_sim.command.run._announce("/dev/pts/1", rig.servos)
    lines = (said + capsys.readouterr().err).splitlines()
    assert len(lines) == 2
    assert all(line.startswith(_ANNOUNCEMENTS) for line in lines)
