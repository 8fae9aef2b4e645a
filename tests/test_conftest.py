"""The check that no test leaves anything behind does find what is left behind."""

import os
import subprocess
import sys
import threading
from pathlib import Path

from tests.conftest import held


def test_a_child_process_is_found_until_it_is_waited_for() -> None:
    before = held()
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as child:
        assert set(held() - before) == {f"process {child.pid}"}
        assert child.stdin is not None
        child.stdin.close()
        os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOWAIT)  # ended, but not waited for
        assert set(held() - before) == {f"process {child.pid}"}
    assert not held() - before


def test_threads_and_ports_are_found() -> None:
    before = held()
    release = threading.Event()
    thread = threading.Thread(target=release.wait, name="left over")
    thread.start()
    ours, theirs = os.openpty()
    try:
        found = held() - before
        assert found["thread left over"] == 1
        assert found[f"port {os.ttyname(theirs)}"] == 1
        assert found["port /dev/ptmx"] + found["port /dev/pts/ptmx"] == 1
    finally:
        os.close(ours)
        os.close(theirs)
        release.set()
        thread.join()
    assert not held() - before


FOUND_WITH = os.environ.get("XDG_CONFIG_HOME")


def test_the_users_own_arms_are_out_of_reach_also_while_tests_are_found() -> None:
    assert FOUND_WITH is not None
    assert os.environ["XDG_CONFIG_HOME"] == FOUND_WITH
    assert not Path(FOUND_WITH).is_relative_to(Path.home() / ".config")
    assert "ARMSYN_CALIBRATION" not in os.environ
