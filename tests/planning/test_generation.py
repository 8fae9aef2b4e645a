"""Generations: the same bytes however they are made, and nothing lost or half-written."""

from __future__ import annotations

import csv
import dataclasses
import errno
import fcntl
import json
import os
import shutil
import signal
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import armsyn
from armsyn.arm import load_arm
from armsyn.errors import ArmFaultError, FormatError, InputError, StopRequestedError
from armsyn.motion import Motion
from armsyn.motion.formats import files as motion_files
from armsyn.planning.generation import chunks, files
from armsyn.planning.generation.batch import Recipe, make_batch
from armsyn.planning.generation.order import NOTES, Order
from armsyn.planning.generation.running import digest_of, generate
from armsyn.planning.generation.targets import Asked, ListedTargets, RandomTargets
from armsyn.planning.generation.version import ROOMS, version
from armsyn.planning.minimum_jerk import MinimumJerkPredictor
from armsyn.safety import check_trajectory
from armsyn.synergy.parallel import each

FloatArray = NDArray[np.float64]

INPUTS = {"what": "a test"}
SIZE = 130
BOX = ([0.15, -0.45, -0.5], [0.6, 0.35, 0.3])
TABLES = ("refusals.csv", "changes.csv", "reaches.csv")
OUT_OF_REACH = (0.9, 0.9, 0.9)


def recipe(size: int = SIZE, **changed: object) -> Recipe:
    arm = load_arm("human7", calibrated=False)
    drawn, *_ = RandomTargets(size, 5, *BOX).some(0, size)
    drawn[size // 2] = OUT_OF_REACH
    made = Recipe(arm, MinimumJerkPredictor(arm.chain), ListedTargets(drawn), arm.rest, 100.0)
    return dataclasses.replace(made, **changed)


def order(folder: Path, kind: str = "npz", chunk: int = 30, **changed: object) -> Order:
    return Order(recipe(**changed), str(folder), kind, chunk, digest_of(INPUTS))


def content(folder: Path) -> dict[str, bytes]:
    """All files of a folder."""
    found = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in found}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A whole generation, made in this process."""
    folder = tmp_path_factory.mktemp("made") / "out"
    report = generate(order(folder), INPUTS, workers=1)
    assert report.complete
    assert report.asked == SIZE
    assert report.made + sum(report.refused.values()) == SIZE
    return folder


def test_every_reach_is_one_that_may_be_driven_and_ends_at_its_target(made: Path) -> None:
    asked, arm = recipe().targets.some(0, SIZE)[0], load_arm("human7", calibrated=False)
    seen = []
    for file in sorted(made.glob("reaches-*.npz")):
        batch = files.read_npz(file)
        seen += batch.index.tolist()
        for row, index in enumerate(batch.index.tolist()):
            path = batch.paced.path(row)
            motion = Motion(np.arange(len(path)) / 100.0, arm.joint_names, path)
            check_trajectory(motion, arm, arm.rest, start_tolerance=1e-12)
            hand = arm.chain.forward(path[-1]).tip
            np.testing.assert_allclose(hand, batch.hands[row], rtol=0.0, atol=1e-12)
            assert np.linalg.norm(hand - asked[index]) <= 1e-3
    with (made / "refusals.csv").open(newline="") as file:
        refused = list(csv.DictReader(file))
    assert sorted(seen + [int(row["index"]) for row in refused]) == list(range(SIZE))
    told = {int(row["index"]): row for row in refused}[SIZE // 2]
    assert told["kind"] == "unreachable"
    assert [float(told[f"{axis}_m"]) for axis in "xyz"] == list(OUT_OF_REACH)
    assert "the arm is 0.66 m long" in told["reason"]


def test_the_manifest_says_what_it_is_and_of_what(made: Path) -> None:
    manifest = json.loads((made / "manifest.json").read_text())
    assert manifest["complete"] is True
    assert manifest["inputs"] == INPUTS
    assert manifest["digest"] == digest_of(INPUTS)
    assert manifest["outside_captured_workspace"] is None  # of minimum jerk alone
    assert "not measured" in manifest["what"]
    assert sum(entry["reaches"] for entry in manifest["files"]) == manifest["reaches_made"]
    for entry in manifest["files"]:
        assert chunks.checksum(made / entry["file"]) == entry["sha256"]
    names = {entry["file"] for entry in manifest["files"]}
    assert {path.name for path in made.iterdir()} == names | {"manifest.json", *TABLES}


@pytest.mark.parametrize("kind", ["npz", "lerobot", "bvh"])
def test_the_table_of_reaches_has_every_ones_numbers(kind: str, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    assert generate(order(folder, kind, chunk=3, size=4, repeats=2), INPUTS, workers=1).complete
    wanted, arm = make_batch(recipe(4, repeats=2), 0, 8), load_arm("human7", calibrated=False)
    with (folder / "reaches.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["index"]) for row in rows] == wanted.index.tolist()
    asked = recipe(4).targets.some(0, 4)[0]
    for number, row in enumerate(rows):
        index, path = int(row["index"]), wanted.paced.path(number)
        target = [float(row[axis]) for axis in ("x_m", "y_m", "z_m")]
        np.testing.assert_array_equal(target, asked[index // 2])
        assert int(row["repeat"]) == index % 2
        assert float(row["duration_s"]) == (len(path) - 1) / 100.0
        assert float(row["predicted_time_s"]) == wanted.durations[number]
        assert float(row["time_scale"]) == wanted.paced.scales[number]
        miss = np.linalg.norm(arm.chain.forward(path[-1]).tip - target)
        np.testing.assert_allclose(float(row["planned_error_m"]), miss, rtol=0.0, atol=1e-12)
        assert row["outside_m"] == ""  # minimum jerk has no captured workspace
        assert (folder / row["file"]).exists()
        assert kind != "bvh" or row["file"].endswith(f"reach-{index:09d}.bvh")


def test_a_reach_is_the_same_whatever_chunk_it_is_in(made: Path) -> None:
    whole = make_batch(recipe(), 0, SIZE)
    part = files.read_npz(made / "reaches-000002.npz")
    for row, index in enumerate(part.index.tolist()):
        there = int(np.flatnonzero(whole.index == index)[0])
        np.testing.assert_allclose(
            part.paced.path(row), whole.paced.path(there), rtol=0.0, atol=1e-9
        )


def failing_at(number: int, error: BaseException) -> Callable[..., None]:
    """A writer that fails on one chunk, half-way through its file."""

    def write(path: Path, *rest: object) -> None:
        if path.name == f"reaches-{number:06d}.npz":
            with motion_files.replacing(path) as temporary:
                temporary.write_bytes(b"half")
                raise error
        files.write_npz(path, *rest)  # type: ignore[arg-type]

    return write


def test_a_full_disk_keeps_what_is_finished_and_the_rest_can_follow(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "out"
    full = OSError(errno.ENOSPC, "No space left on device")
    with monkeypatch.context() as patch:
        patch.setitem(chunks.FORMATS, "npz", (".npz", failing_at(3, full)))
        report = generate(order(folder), INPUTS, workers=1)
    assert not report.complete
    assert isinstance(report.error, InputError)
    assert "No space left" in str(report.error)
    assert "reaches-000003.npz" in str(report.error)
    there = {path.name for path in folder.iterdir() if path.is_file()}
    assert there == {*(f"reaches-00000{k}.npz" for k in range(3)), "manifest.json", *TABLES}
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["complete"] is False
    assert len(manifest["files"]) == 3
    with pytest.raises(InputError, match="--resume goes on"):
        generate(order(folder), INPUTS, workers=1)
    assert generate(order(folder), INPUTS, workers=1, resume=True).complete
    assert content(folder) == content(made)


def struck_in_a_kernel() -> SystemError:
    """What compiled code makes of an interrupt that strikes in what it calls."""
    unpickling, kernel = SystemError("unpickling"), SystemError("kernel")
    unpickling.__cause__, kernel.__cause__ = KeyboardInterrupt(), unpickling
    return kernel


@pytest.mark.parametrize("error", [KeyboardInterrupt(), struck_in_a_kernel()])
def test_an_interruption_keeps_what_is_finished(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    folder = tmp_path / "out"
    stop = failing_at(2, error)
    with monkeypatch.context() as patch:
        patch.setitem(chunks.FORMATS, "npz", (".npz", stop))
        report = generate(order(folder), INPUTS, workers=1)
    assert isinstance(report.error, StopRequestedError)
    assert report.done == 2
    (folder / "reaches-000003.npz").write_bytes(b"without a note")
    progress: list[tuple[str, int, int]] = []
    report = generate(
        order(folder),
        INPUTS,
        workers=1,
        resume=True,
        on_progress=lambda name, done, total, _said: progress.append((name, done, total)),
    )
    found, made_now = "chunks found", "chunks"
    assert progress == [*((found, k, 5) for k in (1, 2)), *((made_now, k, 5) for k in (3, 4, 5))]
    assert content(folder) == content(made)


def test_an_error_of_compiled_code_that_is_no_interruption_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(chunks.FORMATS, "npz", (".npz", failing_at(2, SystemError("broken"))))
    with pytest.raises(SystemError, match="broken"):
        generate(order(tmp_path / "out"), INPUTS, workers=1)


def test_what_was_killed_while_it_tidied_is_whole(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "out"

    def killed(_folder: Path) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(shutil, "rmtree", killed)
        with pytest.raises(KeyboardInterrupt):
            generate(order(folder), INPUTS, workers=1)
    assert (folder / NOTES).exists()
    report = generate(order(folder), INPUTS, workers=1, resume=True)
    assert report.complete
    assert report.found
    assert not (folder / NOTES).exists()
    assert content(folder) == content(made)


@dataclasses.dataclass(frozen=True)
class DeadlyTargets(ListedTargets):
    """Targets that kill a process, but the tests' own, which asks for those of the third chunk."""

    own: int = dataclasses.field(default_factory=os.getpid)

    def some(self, first: int, last: int) -> Asked:
        """See `Targets.some`."""
        if first == 60 and os.getpid() != self.own:
            os.kill(os.getpid(), signal.SIGKILL)
        return super().some(first, last)


@pytest.fixture(scope="module")
def spread() -> None:
    """What joblib starts once a process and keeps, the trackers of its resources, is there."""
    assert sorted(each(abs, [-1, -2], 2)) == [(0, 1), (1, 2)]


@pytest.mark.usefixtures("spread")
def test_a_killed_worker_leaves_a_manifest_and_what_it_had_not_made_can_follow(
    made: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    listed = recipe().targets
    assert isinstance(listed, ListedTargets)
    deadly = order(folder, targets=DeadlyTargets(listed.targets))
    report = generate(deadly, INPUTS, workers=2)
    assert isinstance(report.error, ArmFaultError)
    assert "a worker process died" in str(report.error)
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["complete"] is False
    assert generate(order(folder), INPUTS, workers=1, resume=True).complete
    assert content(folder) == content(made)


@pytest.mark.parametrize("kind", ["npz", "bvh"])
def test_a_finished_chunk_that_has_changed_since_is_made_again(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, folder = tmp_path / "whole", tmp_path / "out"
    assert generate(order(whole, kind), INPUTS, workers=1).complete
    suffix, write = chunks.FORMATS[kind]
    writes = 0

    def interrupted(path: Path, *given: object) -> None:
        nonlocal writes
        if writes == 2:
            raise KeyboardInterrupt
        writes += 1
        write(path, *given)  # type: ignore[arg-type]

    with monkeypatch.context() as patch:
        patch.setitem(chunks.FORMATS, kind, (suffix, interrupted))  # type: ignore[arg-type]
        generate(order(folder, kind), INPUTS, workers=1)
    first = next(path for path in sorted(folder.rglob("reach*0*")) if path.is_file())
    first.write_bytes(bytes(first.stat().st_size))
    report = generate(order(folder, kind), INPUTS, workers=1, resume=True)
    assert report.complete
    assert content(folder) == content(whole)


@pytest.mark.parametrize("kind", ["npz", "bvh", "lerobot"])
def test_a_whole_folder_of_which_a_file_is_damaged_is_not_taken_for_whole(
    kind: str, tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    asked = order(folder, kind, size=7, chunk=3)
    assert generate(asked, INPUTS, workers=1).complete
    assert generate(asked, INPUTS, workers=1, resume=True).found
    name = json.loads((folder / "manifest.json").read_text())["files"][-1]["file"]
    file = max(path for path in (folder / name, *(folder / name).rglob("*")) if path.is_file())
    whole = file.read_bytes()
    file.write_bytes(whole[:-1])
    with pytest.raises(InputError, match=f"{name} is damaged or was changed.*: name a new folder"):
        generate(asked, INPUTS, workers=1, resume=True)
    file.write_bytes(whole)
    assert generate(asked, INPUTS, workers=1, resume=True).found
    (folder / name).rename(folder / "elsewhere")
    with pytest.raises(InputError, match=f"{name} is missing"):
        generate(asked, INPUTS, workers=1, resume=True)


def test_a_part_made_by_another_armsyn_is_not_gone_on_with(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    old, now = ({**INPUTS, "armsyn": "0.0.1", "sources_sha256": "a"}, {**INPUTS, **version()})
    first = dataclasses.replace(order(folder), digest=digest_of(old))
    assert generate(first, old, workers=1).complete
    other = dataclasses.replace(order(folder), digest=digest_of(now))
    with pytest.raises(InputError, match=r"made from another armsyn \(0\.0\.1; this is"):
        generate(other, now, workers=1, resume=True)
    with pytest.raises(
        InputError, match=r"made from something else \(armsyn, sources_sha256, what"
    ):
        generate(other, {**now, "what": "else"}, workers=1, resume=True)


def test_the_sources_that_make_reaches_are_told_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for room in ROOMS:
        (tmp_path / room).mkdir()
        (tmp_path / room / "a.py").write_text("x = 1\n")
    monkeypatch.setattr(armsyn, "__file__", str(tmp_path / "__init__.py"))
    before = version()
    assert version() == before
    generated = tmp_path / ROOMS[0] / "__pycache__" / "generated"
    generated.mkdir(parents=True)
    (generated / "of_another_arm.py").write_text("x = 3\n")
    assert version() == before
    (tmp_path / ROOMS[2] / "a.py").write_text("x = 2\n")
    assert version() != before


def test_another_generation_or_other_files_are_not_mixed_in(made: Path, tmp_path: Path) -> None:
    other = dataclasses.replace(order(made), digest="another")
    with pytest.raises(InputError, match="something else"):
        generate(other, INPUTS, workers=1, resume=True)
    with pytest.raises(InputError, match="nothing to do"):
        generate(order(made), INPUTS, workers=1)
    found = generate(order(made), INPUTS, workers=1, resume=True)
    assert found.complete
    assert found.found
    assert found.made + sum(found.refused.values()) == SIZE
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(InputError, match="other things"):
        generate(order(tmp_path), INPUTS, workers=1)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


@pytest.mark.parametrize(
    ("kind", "missing"),
    [("parquet", "pyarrow"), ("mcap", "rosbags"), ("lerobot", "pyarrow")],
)
def test_a_format_whose_package_is_missing_is_refused_before_anything_is_made(
    kind: str, missing: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "out"
    for name in [name for name in sys.modules if name.split(".")[0] == missing]:
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setitem(sys.modules, missing, None)
    monkeypatch.delitem(sys.modules, "armsyn.motion.formats.lerobot_tables", raising=False)
    with pytest.raises(FormatError, match=rf"needs the package {missing}: .*armsyn\[formats\]"):
        generate(order(folder, kind), INPUTS, workers=1)
    assert not folder.exists()


@pytest.mark.parametrize("kind", ["npz", "lerobot"])
def test_what_a_killed_process_was_writing_is_removed_and_nothing_else(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "out"
    asked = order(folder, kind, size=7, chunk=3)
    with monkeypatch.context() as patch:
        patch.setattr(chunks, "make_chunk", interrupt)
        generate(asked, INPUTS, workers=1)
    mine = folder / ".mine.csv.abcdefgh"
    mine.write_text("mine")
    for complete in (False, True):
        names = ["reaches-000002.npz", "manifest.json", "manifest.run.json", *TABLES]
        killed: list[AbstractContextManager[Path]] = [
            *(motion_files.replacing(folder / name) for name in names),
            motion_files.folder_beside(folder / "dataset.lerobot"),
        ]
        for each_one in killed:
            left = each_one.__enter__()
            (left / "half" if left.is_dir() else left).write_text("half")
        assert len(list(folder.glob(".*.*"))) == len(killed) + 1
        report = generate(asked, INPUTS, workers=1, resume=True)
        assert report.complete
        assert report.found is complete
        assert list(folder.glob(".*")) == [mine]


def interrupt(*_: object) -> None:
    raise KeyboardInterrupt


def locked(folder: Path) -> int:
    """Lock a folder as another generation does; closing the descriptor ends that."""
    descriptor = os.open(folder, os.O_RDONLY)
    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    return descriptor


def test_a_folder_that_another_generation_writes_to_is_left_to_it(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, part = tmp_path / "out", tmp_path / "part"
    folder.mkdir()
    with monkeypatch.context() as patch:
        stop = failing_at(2, KeyboardInterrupt())
        patch.setitem(chunks.FORMATS, "npz", (".npz", stop))
        generate(order(part), INPUTS, workers=1)
    whole = Path(shutil.copytree(made, tmp_path / "whole"))
    for there in (folder, part, whole):
        before = content(there)
        descriptor = locked(there)
        for resume in (False, True):
            with pytest.raises(InputError, match="another armsyn generate writes there"):
                generate(order(there), INPUTS, workers=1, resume=resume)
        os.close(descriptor)
        assert content(there) == before
        assert generate(order(there), INPUTS, workers=1, resume=True).complete
        assert content(there) == content(made)


def test_a_generation_holds_its_folder_for_all_of_its_time(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    held = []

    def look(*_: object) -> None:
        with pytest.raises(BlockingIOError):
            os.close(locked(folder))
        held.append(True)

    assert generate(order(folder, size=7), INPUTS, workers=1, on_progress=look).complete
    assert held
    os.close(locked(folder))


@pytest.mark.parametrize("kind", ["csv", "parquet", "mcap", "bvh", "lerobot"])
def test_every_format_holds_the_same_reaches(kind: str, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    report = generate(order(folder, kind, chunk=3, size=7), INPUTS, workers=1)
    assert report.complete
    wanted = make_batch(recipe(7), 0, 7)
    found = {"csv": csv_paths, "parquet": parquet_paths, "mcap": mcap_paths, "bvh": bvh_paths}
    if kind == "lerobot":
        paths = lerobot_paths(folder / "dataset.lerobot")
        assert {path.name for path in folder.iterdir()} == {
            *("dataset.lerobot", "manifest.json", *TABLES)
        }
    else:
        paths = found[kind](folder)
    assert len(paths) == report.made == len(wanted.index)
    for row, path in enumerate(paths):
        np.testing.assert_allclose(path, wanted.paced.path(row), rtol=0.0, atol=1e-5)


def csv_paths(folder: Path) -> list[np.ndarray]:
    found = []
    for file in sorted(folder.glob("reaches-*.csv")):
        what, *_, header, _ = file.read_text().split("\n", maxsplit=4)
        assert "not measured" in what
        assert header.endswith(",target_x_m,target_y_m,target_z_m")
        table = np.loadtxt(file, delimiter=",", skiprows=4)
        found += [table[table[:, 0] == index, 2:-3] for index in np.unique(table[:, 0])]
    return found


def parquet_paths(folder: Path) -> list[np.ndarray]:
    import pyarrow.parquet as pq

    joints = load_arm("human7", calibrated=False).joint_names
    found = []
    for file in sorted(folder.glob("reaches-*.parquet")):
        table = pq.read_table(file)
        episodes = np.array(table["episode_index"])
        angles = np.stack([np.array(table[f"{name}:angle_rad"]) for name in joints], axis=1)
        found += [angles[episodes == episode] for episode in np.unique(episodes)]
    return found


def mcap_paths(folder: Path) -> list[np.ndarray]:
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    found = []
    for path in sorted(folder.glob("reaches-*.mcap")):
        with path.open("rb") as file:
            reader = make_reader(file, decoder_factories=[DecoderFactory()])
            for decoded in reader.iter_decoded_messages(topics=["/joint_trajectory"]):
                points = decoded.decoded_message.points
                found.append(np.array([list(point.positions) for point in points]))
    return found


def bvh_paths(folder: Path) -> list[np.ndarray]:
    """Angles of a skeleton whose joints turn by one angle each."""
    from armsyn.motion.formats import read_body

    arm = load_arm("human7", calibrated=False)
    wanted = make_batch(recipe(7), 0, 7)
    found = []
    for row, file in enumerate(sorted(folder.glob("reaches-*/reach-*.bvh"))):
        positions = read_body(file).as_motion().landmarks
        assert positions is not None
        path = wanted.paced.path(row)
        tips = arm.chain.positions(path)[:, -1]
        assert np.linalg.norm(positions - tips[:, None], axis=2).min(axis=1).max() < 1e-4
        found.append(path)
    return found


def lerobot_paths(folder: Path) -> list[np.ndarray]:
    import pyarrow.parquet as pq

    tables = [pq.read_table(file) for file in sorted(folder.glob("data/*/*.parquet"))]
    found = []
    for table in tables:
        states = np.radians(np.array(table["observation.state"].to_pylist()))
        episodes = np.array(table["episode_index"])
        found += [states[episodes == episode] for episode in np.unique(episodes)]
    return found
