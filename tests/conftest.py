"""Fixtures that every room's tests share, and the check that no test leaves anything behind."""

import os
import shutil
import tempfile
import threading
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parent.parent
_PROCESS = Path("/proc/self")

REALTIME = frozenset(
    {
        "cli/test_find_port",
        "cli/test_generate",
        "cli/test_learn",
        "cli/test_operating",
        "cli/test_reach",
        "cli/test_reach_processes",
        "cli/test_reach_refusals",
        "cli/test_set_up",
        "cli/test_stream",
        "cli/test_track",
        "contract/test_easy_groups",
        "contract/test_easy_sdk",
        "contract/test_rustypot",
        "contract/test_sdk_groups",
        "contract/test_sdk_protocol1",
        "contract/test_sdk_protocol2",
        "driver/test_bus",
        "driver/test_exchange",
        "driver/test_find_port",
        "driver/test_indirect",
        "driver/test_killed",
        "driver/test_own_process",
        "driver/test_processes",
        "driver/test_serial_port",
        "driver/test_setpoint",
        "driver/test_spool",
        "driver/test_stateful",
        "firmware_sim/test_command",
        "firmware_sim/test_faults_process",
        "firmware_sim/test_hands",
        "firmware_sim/test_hang_up",
        "firmware_sim/test_live_table",
        "firmware_sim/test_pytest_plugin",
        "firmware_sim/test_state_file",
        "firmware_sim/test_trace",
        "firmware_sim/test_words",
        "hil/test_arm",
        "hil/test_host_killed",
        "test_hil",
        "hil/test_operating",
    }
)
"""Tests that keep to the clock of the wall together with other processes: they want the machine to
themselves, while all others may share it."""


SLOW = frozenset(
    {
        "cli/test_generate",
        "cli/test_learn",
        "driver/test_killed",
        "driver/test_stateful",
        "experiments/test_anytarget",
        "experiments/test_experiments",
        "experiments/test_neighbours",
        "hil/test_arm",
        "hil/test_host_killed",
        "hil/test_operating",
        "test_hil",
    }
)
"""Tests of minutes, whose subjects shorter ones look at, too: `make test-slow`."""

ENDING = 2.0
"""Seconds within which a thread that was told to end does."""

# A test's time is the machine's affair: compiled code is made on first use, others work beside
settings.register_profile("armsyn", deadline=None)
settings.load_profile("armsyn")


def pytest_configure(config: pytest.Config) -> None:
    """Keep the user's own arms out of tests, and tests out of them, also while tests are found.

    A real arm (``--port``) is used with its own calibration.
    """
    if config.getoption("--port", None) is not None:
        return
    home = tempfile.mkdtemp(prefix="armsyn-tests-")
    patch = pytest.MonkeyPatch()
    patch.setenv("XDG_CONFIG_HOME", home)
    patch.delenv("ARMSYN_CALIBRATION", raising=False)
    config.add_cleanup(lambda: shutil.rmtree(home))
    config.add_cleanup(patch.undo)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        file = str(item.path.relative_to(ROOT / "tests").with_suffix(""))
        if file in REALTIME:
            item.add_marker(pytest.mark.realtime)
        if file in SLOW:
            item.add_marker(pytest.mark.slow)


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
    threads, before = set(threading.enumerate()), held()
    yield
    for thread in set(threading.enumerate()) - threads:
        thread.join(ENDING)  # one of a progress display is told to end, and not waited for
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
