"""Fixtures that every room's tests share, and the check that no test leaves anything behind."""

import os
import threading
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
_PROCESS = Path("/proc/self")


@pytest.fixture(scope="session")
def captures() -> Path:
    """The folder of captured motion; tests that need it are skipped where it is absent."""
    folder = Path(os.environ.get("ARMSYN_CAPTURES") or ROOT.parent / "shared" / "captures")
    if not (folder / "README.md").is_file():
        pytest.skip(f"no captures: set ARMSYN_CAPTURES, or place them in {folder}")
    return folder


@pytest.fixture(autouse=True)
def nothing_left_behind() -> Iterator[None]:
    """Fail a test that leaves a child process, a thread or an open port.

    What fixtures of a wider scope started is there before the test, so it is not the test's.
    """
    before = held()
    yield
    left = held() - before
    assert not left, f"left behind: {', '.join(left)}"


def held() -> Counter[str]:
    """Child processes (ended ones too, until somebody waited for them), threads and ports."""
    threads = (f"thread {thread.name}" for thread in threading.enumerate())
    return Counter([*threads, *_children(), *_ports()])


def _children() -> Iterator[str]:
    for task in _PROCESS.glob("task/*/children"):
        for child in task.read_text().split():
            yield f"process {child}"


def _ports() -> Iterator[str]:
    for descriptor in (_PROCESS / "fd").iterdir():
        try:
            target = str(descriptor.readlink())
        except FileNotFoundError:  # the descriptor that lists this folder
            continue
        if target.startswith(("/dev/pts/", "/dev/ptmx", "/dev/tty")):
            yield f"port {target}"
