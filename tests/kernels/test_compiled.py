"""Generated code is compiled once, kept on disk by its source, and does without a disk."""

import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from armsyn.ik import optimiser_settings
from armsyn.kernels import compiled as room
from armsyn.kernels.generator import Plan
from armsyn.kinematics import Joint, SerialChain

CALL = """
import numpy as np
from armsyn.ik import optimiser_settings
from armsyn.kernels.compiled import compiled
from armsyn.kernels.generator import Plan
from armsyn.kinematics import Joint, SerialChain
chain = SerialChain((Joint("one"),), tip_xyz=(LENGTH, 0.0, 0.0))
play = compiled(Plan(chain.arrays, optimiser_settings("jt"), True, False, "paths", ()))
print(sum(play.stats.cache_hits.values()), sum(play.stats.cache_misses.values()))
"""


def plan_of(length: float) -> Plan:
    chain = SerialChain((Joint("one"),), tip_xyz=(length, 0.0, 0.0))
    return Plan(chain.arrays, optimiser_settings("jt"), True, False, "paths", ())


def hits_and_misses(place: Path, length: float) -> list[int]:
    done = subprocess.run(
        [sys.executable, "-c", CALL.replace("LENGTH", str(length))],
        env={**os.environ, "NUMBA_CACHE_DIR": str(place)},
        capture_output=True,
        text=True,
        check=True,
    )
    return [int(word) for word in done.stdout.split()]


def test_another_process_takes_it_from_disk_and_another_chain_does_not(tmp_path: Path) -> None:
    assert hits_and_misses(tmp_path, 0.5) == [0, 1]
    assert hits_and_misses(tmp_path, 0.5) == [1, 0]
    assert hits_and_misses(tmp_path, 0.6) == [0, 1]
    assert len(list(tmp_path.rglob("generated/*.py"))) == 2


@pytest.mark.parametrize("place", [None, "a file"])
def test_without_a_place_it_is_compiled_all_the_same(
    place: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a file").touch()
    monkeypatch.setattr(room, "cache_place", lambda _: place and tmp_path / place)
    play = room.load(room.generate(plan_of(0.7)).text)
    out, states = np.zeros((1, 3, 1)), np.zeros((1, 64))
    frames, motions = np.array([3]), np.array([0])
    play(states, frames, motions, 0, 1, np.ones(3), 1.0, np.empty((1, 1, 1, 3)), out)
    np.testing.assert_array_equal(out, np.zeros((1, 3, 1)))


def test_threads_that_ask_at_once_get_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "_played", {})
    made: list[str] = []
    monkeypatch.setattr(room, "load", lambda text: made.append(text) or object())
    barrier = threading.Barrier(8)
    got: list[object] = []

    def ask() -> None:
        barrier.wait()
        got.append(room.compiled(plan_of(0.8)))

    threads = [threading.Thread(target=ask) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(made) == 1
    assert len(got) == 8
    assert len(set(map(id, got))) == 1
