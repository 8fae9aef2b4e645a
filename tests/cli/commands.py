"""Running the command ``armsyn`` in a process of its own, and what came of it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from typing import Any

import click
from click.testing import CliRunner

from armsyn.errors import ArmsynError

PATIENCE = 120.0


@dataclass(frozen=True)
class Outcome:
    """How a command ended and what it said."""

    status: int
    out: str
    err: str

    @property
    def document(self) -> dict[str, Any]:
        """The JSON document: all of the standard output."""
        found = json.loads(self.out)
        assert isinstance(found, dict)
        return found

    def refused(self, status: int, *said: str) -> None:
        """One line on standard error, with this status, nothing else but the simulator's line."""
        assert self.status == status, self.err
        assert self.err.count("\n") == 1, self.err
        assert self.err.startswith("armsyn: ")
        assert "Traceback" not in self.err
        for text in said:
            assert text in self.err, self.err
        assert not self.out or self.out.startswith("simulated ")


def run(*arguments: object, **environment: str) -> Outcome:
    """Run the command to its end."""
    done = subprocess.run(
        [sys.executable, "-m", "armsyn", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE,
        env=os.environ | environment,
    )
    return Outcome(done.returncode, done.stdout, done.stderr)


def said_by(command: click.Command, *arguments: object) -> str:
    """Call a command within this process; return what it says."""
    result = CliRunner().invoke(command, list(map(str, arguments)))
    assert result.exit_code == 0, result.exception
    return result.output


def refused_by(command: click.Command, *arguments: object) -> str:
    """Call a command within this process; return the one line that it refuses its input by."""
    error = CliRunner().invoke(command, list(map(str, arguments))).exception
    assert isinstance(error, ArmsynError), error
    assert error.exit_status == 2
    assert "\n" not in str(error)
    return str(error)


def started(*arguments: object, hook: str = "") -> subprocess.Popen[str]:
    """Start the command with lines of Python run before it; its output is to be read."""
    program = f"{hook}\nfrom armsyn.cli.main import main\nmain()\n"
    return subprocess.Popen(
        [sys.executable, "-c", program, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def next_line(process: subprocess.Popen[str]) -> str:
    """Next line of the standard output."""
    assert process.stdout is not None
    return process.stdout.readline().strip()
