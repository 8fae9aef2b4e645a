"""`armsyn generate` as a user calls it, on processes and on a cluster, killed and resumed."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import armsyn
from armsyn.planning.generation.order import NOTES
from tests.cli.commands import PATIENCE, Outcome, run

pytestmark = pytest.mark.usefixtures("compiled")

Call = Callable[..., Outcome]
MINJERK = ("--arm", "human7", "--plan", "minjerk", "--rate", 50)
BOX = ("--box", "0.15:0.6", "-0.45:0.35", "-0.5:0.3")
HOOK = """
import time
from armsyn.planning.generation import chunks
from armsyn.planning.generation.files import write_npz as write
def slowly(path, *given):
    time.sleep({wait})
    write(path, *given)
chunks.FORMATS["npz"] = (".npz", slowly)
"""
STUCK_AT_THE_THIRD = "60.0 if '000002' in path.name else 0.0"


def generating(*more: object) -> tuple[object, ...]:
    return ("generate", *MINJERK, *more)


def content(folder: Path) -> dict[str, bytes]:
    """All files that say nothing of how and when they were made."""
    found = (path for path in folder.rglob("*") if path.is_file())
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in found
        if path.name != "manifest.run.json"
    }


RANDOM = ("--random", 120, *BOX, "--seed", 4, "--chunk", 20)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What comes of `RANDOM` when nothing goes wrong, in one process."""
    out = tmp_path_factory.mktemp("whole") / "out"
    done = run(*generating(*RANDOM, "--out", out, "--workers", 1, "--json"))
    assert done.status == 0, done.err
    document = done.document
    assert document["complete"] is True
    assert document["reaches_made"] + sum(document["reaches_refused"].values()) == 120
    assert document["reaches_made"] > 60
    assert json.loads((out / "manifest.run.json").read_text())["command"][1] == "generate"
    return out


def test_the_number_of_workers_leaves_no_trace(whole: Path, tmp_path: Path) -> None:
    done = run(*generating(*RANDOM, "--out", tmp_path / "two", "--workers", 2))
    assert done.status == 0, done.err
    assert "planned, not measured" in done.out
    assert content(tmp_path / "two") == content(whole)


@pytest.mark.parametrize(("arm", "plan"), [("human7", "latent"), ("widowx_250s", "synergy")])
def test_what_is_learned_leaves_the_same_bytes_in_any_number_of_processes(
    arm: str, plan: str, tmp_path: Path
) -> None:
    asked = ("generate", "--arm", arm, "--plan", plan, "--random", 30, "--rate", 100)
    more = ("--repeats", 2, "--variability", "--chunk", 15, "--seed", 3)
    for workers in (1, 2):
        out = tmp_path / str(workers)
        done = run(*asked, *more, "--out", out, "--workers", workers, "--json")
        assert done.status == 0, done.err
    assert done.document["reaches_made"] > 40
    assert done.document["reaches_evened"] > 0
    assert content(tmp_path / "1") == content(tmp_path / "2")
    changes = (tmp_path / "1" / "changes.csv").read_text().splitlines()
    assert changes[0] == "index,evened,swivel_m,reason"
    assert len(changes) > done.document["reaches_evened"]


def started_stuck(*arguments: object) -> subprocess.Popen[str]:
    """Start the command; its third chunk takes long enough to stop it there."""
    program = HOOK.format(wait=STUCK_AT_THE_THIRD) + "\nfrom armsyn.cli.main import main\nmain()\n"
    return subprocess.Popen(
        [sys.executable, "-c", program, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def wait_for_notes(out: Path, count: int, process: subprocess.Popen[str]) -> None:
    until = time.monotonic() + PATIENCE
    while len(list((out / NOTES).glob("0*.json"))) < count:
        assert process.poll() is None
        assert time.monotonic() < until
        time.sleep(0.01)


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_what_is_stopped_in_any_way_goes_on_where_it_was(
    how: signal.Signals, whole: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    arguments = generating(*RANDOM, "--out", out, "--workers", 1)
    process = started_stuck(*arguments)
    wait_for_notes(out, 2, process)
    process.send_signal(how)
    _, err = process.communicate(timeout=PATIENCE)
    if how is signal.SIGKILL:
        assert process.returncode == -signal.SIGKILL
    else:
        assert process.returncode == 130, err
        assert "interrupted" in err
        assert json.loads((out / "manifest.json").read_text())["complete"] is False
    for path in out.glob("reaches-*.npz"):
        assert path.read_bytes() == (whole / path.name).read_bytes()
    run(*arguments).refused(2, "--resume goes on with it")
    done = run(*arguments, "--resume")
    assert done.status == 0, done.err
    assert content(out) == content(whole)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--format", "cvs"), "no format 'cvs'; did you mean 'csv'?"),
        (
            ("--arm", "reachy_right", "--random", 5),
            "no captured workspace of reachy_right is known: give --box",
        ),
        (("--random", 5, "--grid", "0", "0", "0"), "give one of"),
        ((), "give one of"),
        (("--random", 5, *BOX, "--rate", "nan"), "not a finite number"),
        (("--grid", "0:1:100000", "0:1:100000", "0:1:100000"), "more than the 100000000"),
        (("--random", 5, *BOX, "--format", "lerobot", "--rate", 62.5), "not 62.5: give another"),
        (("--random", 10**12, *BOX), "more than the 100000000 of one generation"),
        (("--random", 1, *BOX, "--repeats", 10**11), "more than the 100000000"),
        (("--random", 10**6, *BOX, "--chunk", 1), "give a --chunk of 10 reaches or more"),
        (("--grid", "0:1", "0", "0"), "no FIRST:LAST:COUNT"),
        (("--random", 5, "--box", "1:0", "0:1", "0:1"), "no FIRST:LAST"),
        (("--grid", "0.3", "0", "0", "--box", "0:1", "0:1", "0:1"), "--box goes with --random"),
    ],
)
def test_bad_input_is_refused_in_a_line_and_makes_nothing(
    arguments: tuple[object, ...], said: str, call: Call, tmp_path: Path
) -> None:
    call(*generating(*arguments, "--out", tmp_path / "out")).refused(2, said)
    left = [path for path in (tmp_path / "out").rglob("*") if path.suffix == ".npz"]
    assert not left


@pytest.mark.parametrize(
    "address",
    ["foo", "", "foo:8786", "tcp://foo", "tcp://foo:", "tcp://:1", "tcp://a:0", "tcp://a:65536"],
)
def test_what_is_no_address_of_a_cluster_is_refused(
    address: str, call: Call, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    done = call(*generating(*RANDOM, "--out", out, "--cluster", address))
    done.refused(2, "is no tcp://HOST:PORT")
    assert not out.exists()


def test_a_cluster_that_does_not_answer_is_told(tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = run(*generating(*RANDOM, "--out", out, "--cluster", "tcp://127.0.0.1:1"))
    done.refused(2, "no scheduler")
    assert not out.exists()


def test_a_malformed_file_of_targets_is_refused_by_its_line(call: Call, tmp_path: Path) -> None:
    targets = tmp_path / "targets.csv"
    targets.write_text("x,y,z\n0.3,0,0\n0.3,0\n")
    done = call(*generating("--targets", targets, "--out", tmp_path / "out"))
    done.refused(2, f"{targets}, line 3: 2 numbers, expected 3")
    assert not (tmp_path / "out").exists()


def test_targets_out_of_reach_are_told_by_index(call: Call, tmp_path: Path) -> None:
    targets = tmp_path / "targets.csv"
    targets.write_text("0.35 -0.1 -0.15\n0.9 0.9 0.9\n0.3 -0.2 -0.3\n")
    out = tmp_path / "out"
    done = call(*generating("--targets", targets, "--out", out, "--repeats", 2))
    assert done.status == 0, done.err
    assert "4 of 6 reaches" in done.out
    assert "refused: 2 unreachable" in done.out
    rows = (out / "refusals.csv").read_text().splitlines()
    assert [row.split(",")[0] for row in rows] == ["index", "2", "3"]


@pytest.mark.parametrize("kind", ["npz", "lerobot"])
def test_when_every_reach_is_refused_it_ends_so(kind: str, call: Call, tmp_path: Path) -> None:
    beyond = ("--grid", "3", "3", "3", "--format", kind)
    done = call(*generating(*beyond, "--out", tmp_path / "out", "--json"))
    assert done.status == 4
    assert done.document["error"]["exit_status"] == 4
    assert "every reach was refused" in done.document["error"]["message"]
    assert done.document["reaches_refused"] == {"unreachable": 1}
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    assert manifest["complete"] is True
    assert manifest["files"] == []
    assert not (tmp_path / "out" / NOTES).exists()
    assert manifest["inputs"]["armsyn"] == armsyn.__version__
    assert len(manifest["inputs"]["sources_sha256"]) == 64


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A scheduler and two workers, processes of their own on loopback."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    local = ("--host", "127.0.0.1", "--no-dashboard")
    environment = os.environ | {"DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False"}
    log = (tmp_path / "cluster.log").open("wb")

    def start(*arguments: str) -> subprocess.Popen[bytes]:
        program = [sys.executable, "-m", "distributed.cli." + arguments[0], *arguments[1:]]
        return subprocess.Popen(program, stdout=log, stderr=log, env=environment, cwd=tmp_path)

    scheduler = start("dask_scheduler", *local, "--port", str(port))
    slow = tmp_path / "slow.py"
    slow.write_text(HOOK.format(wait=1.0))
    scratch = str(tmp_path / "scratch")
    worker = ("--no-nanny", "--nthreads", "1", "--local-directory", scratch, "--preload", str(slow))
    workers = [start("dask_worker", address, *local, *worker) for _ in range(2)]
    yield address, workers
    for process in (*workers, scheduler):  # killed, for they wait long for one another else
        process.kill()
        process.wait(timeout=PATIENCE)
    log.close()


def test_a_cluster_loses_nothing_when_a_worker_is_killed(
    cluster: tuple[str, list[subprocess.Popen[bytes]]], whole: Path, tmp_path: Path
) -> None:
    address, workers = cluster
    out = tmp_path / "out"
    arguments = generating(*RANDOM, "--out", out, "--cluster", address)
    process = subprocess.Popen(
        [sys.executable, "-m", "armsyn", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_for_notes(out, 1, process)
    workers[0].kill()
    said, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    assert "of 120 reaches" in said
    assert content(out) == content(whole)
