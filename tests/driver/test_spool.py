"""Rows on their way to disk: what comes back, and what a slow or full disk costs."""

import errno
import threading
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.driver import spool as spool_module
from armsyn.driver.joints import JointState
from armsyn.driver.spool import CHUNK, WAITING, Spool
from armsyn.errors import InputError

NO_ERROR = np.zeros(2, dtype=np.uint8)


def state(tick: int) -> JointState:
    values = np.array([tick, -tick], dtype=np.float64)
    return JointState(
        values, 2 * values, 3 * values, np.array([True, tick % 2 == 0]), np.zeros(2, dtype=np.bool_)
    )


def fill(spool: Spool, rows: int, start: int = 0) -> None:
    for tick in range(start, start + rows):
        spool.append(tick * 0.01, state(tick), NO_ERROR)


@given(st.integers(0, 3 * CHUNK))
def test_all_rows_come_back(tmp_path_factory: pytest.TempPathFactory, rows: int) -> None:
    folder = tmp_path_factory.getbasetemp()
    with Spool(folder, 2) as spool:
        fill(spool, rows)
        found = spool.read()
        assert (spool.rows, spool.dropped) == (rows, 0)
    assert found["time"] == pytest.approx(0.01 * np.arange(rows))
    assert np.array_equal(found["position"][:, 1], -np.arange(rows))
    assert np.array_equal(found["current"][:, 0], 3.0 * np.arange(rows))
    assert np.array_equal(found["fresh"][:, 1], np.arange(rows) % 2 == 0)


def test_nothing_is_left_in_the_folder(tmp_path: Path) -> None:
    with Spool(tmp_path, 2) as spool:
        fill(spool, 10)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.fault(29)
def test_a_full_disk_costs_rows_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    original, left = Spool._write_all, iter(range(2))

    def write(self: Spool, data: bytes) -> None:
        if next(left, None) is None:
            raise OSError(errno.ENOSPC, "No space left on device")
        original(self, data)

    monkeypatch.setattr(Spool, "_write_all", write)
    with Spool(tmp_path, 2) as spool:
        fill(spool, 5 * CHUNK)
        found = spool.read()
        assert spool.error is not None
        assert spool.error.errno == errno.ENOSPC
        assert (spool.rows, spool.dropped) == (2 * CHUNK, 3 * CHUNK)
    assert len(found) == 2 * CHUNK


@pytest.mark.fault(29)
def test_a_slow_disk_never_holds_up_who_appends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    original, disk = Spool._write_all, threading.Event()

    def write(self: Spool, data: bytes) -> None:
        disk.wait()
        original(self, data)

    monkeypatch.setattr(Spool, "_write_all", write)
    chunks = WAITING + 5
    with Spool(tmp_path, 2) as spool:
        fill(spool, chunks * CHUNK)  # would wait for ever if it waited
        waiting = spool.rows
        disk.set()
        found = spool.read()
        # one chunk is with the thread, the others are in the queue, the rest is lost
        assert waiting in (WAITING * CHUNK, (WAITING + 1) * CHUNK)
        assert spool.rows + spool.dropped == chunks * CHUNK
    assert len(found) == spool.rows


def test_memory_stays_the_same(tmp_path: Path) -> None:
    with Spool(tmp_path, 2) as spool:
        fill(spool, 10 * CHUNK)
        assert len(spool._chunk) == CHUNK
        assert spool._queue.maxsize == WAITING


def test_a_folder_that_takes_nothing_is_an_input_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(**_: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(spool_module.tempfile, "TemporaryFile", refuse)
    with pytest.raises(InputError, match="cannot write there: Permission denied"):
        Spool(tmp_path, 2)
