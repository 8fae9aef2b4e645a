"""A signal ends a command in one line, also where Python throws its exception away."""

import signal
import subprocess
import sys

import pytest

CALLBACK = """
import ctypes, os, sys
from armsyn.cli import main as entry

def called():
    os.kill(os.getpid(), signal_number)

def work(**_):
    ctypes.CFUNCTYPE(None)(called)()  # the exception is lost here
    after()

signal_number = int(sys.argv[1])
"""


def ended(program: str, number: signal.Signals) -> subprocess.CompletedProcess[str]:
    program = f"{CALLBACK}{program}\nentry.cli.main = work\nentry.main()\n"
    return subprocess.run(
        [sys.executable, "-c", program, str(int(number))],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_what_fails_after_a_lost_interrupt_is_interrupted(number: signal.Signals) -> None:
    """As numba does, whose callback has not stored what was compiled."""
    done = ended("def after(): raise RuntimeError('no compiled object yet')", number)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "armsyn: interrupted\n")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_what_would_go_on_after_a_lost_interrupt_is_interrupted(number: signal.Signals) -> None:
    done = ended("def after(): sys.stdin.read() or __import__('time').sleep(50)", number)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "armsyn: interrupted\n")


def test_errors_without_an_interrupt_keep_their_traceback() -> None:
    program = "def after(): raise RuntimeError('a slip')\ndef called(): pass"
    done = ended(program, signal.SIGINT)
    assert done.returncode == 1
    assert done.stderr.endswith("RuntimeError: a slip\n")
