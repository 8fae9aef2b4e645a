"""Hostile files: whatever the bytes, a reader gives a motion or one line, within bounded memory."""

from __future__ import annotations

import io
import json
import struct
import tracemalloc
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from armsyn.cli.motion_info import describe
from armsyn.errors import FormatError
from armsyn.motion.formats import ReadOptions, archive, hug_mp, read_file, takes_in
from tests.motion.seeds import BVH_OF, FRAMES, seeds

NAMES = sorted(seeds())
COMPANIONS = {
    "a.amc": ["skeleton.asf"],
    "skeleton.asf": ["a.amc"],
    "table.txt": ["columns.toml"],
    "columns.toml": ["table.txt"],
    "log.csv": ["robot.urdf"],
    "robot.urdf": ["log.csv"],
}
BOUND = 64 * 2**20
"""Bytes that a small file may make a reader take."""
one_folder = settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=40
)


def placed(folder: Path, name: str, content: bytes) -> tuple[Path, ReadOptions]:
    """Write a seed's damaged content among whole ones; what to read, and how, to meet it."""
    for other in COMPANIONS.get(name, ()):
        (folder / other).write_bytes(seeds()[other])
    (folder / name).write_bytes(content)
    if name in ("a.amc", "skeleton.asf"):
        return folder / "a.amc", ReadOptions(skeleton=folder / "skeleton.asf")
    if name in ("table.txt", "columns.toml"):
        return folder / "table.txt", ReadOptions(columns=folder / "columns.toml")
    if name in ("log.csv", "robot.urdf"):
        return folder / "log.csv", ReadOptions(joints=folder / "robot.urdf")
    return folder / name, ReadOptions(take="1.1.2" if name == "a.mat" else None)


def read_or_refused(path: Path, options: ReadOptions) -> str:
    """Return the refusal, one line that begins with a file of the folder, or nothing."""
    try:
        reading = read_file(path, options)
    except FormatError as error:
        message = str(error)
        assert message.startswith(str(path.parent)), message
        assert "\n" not in message
        assert len(message) < 600
        return message
    assert reading.motion.frames >= 2
    json.dumps(describe(reading), allow_nan=False)
    return ""


@pytest.mark.parametrize("name", NAMES)
def test_seeds_are_whole(name: str, tmp_path: Path) -> None:
    path, options = placed(tmp_path, name, seeds()[name])
    assert read_or_refused(path, options) == ""
    assert read_file(path, options).motion.frames == FRAMES


@pytest.mark.parametrize("name", NAMES)
def test_every_truncation_is_read_or_refused_in_one_line(name: str, tmp_path: Path) -> None:
    whole = seeds()[name]
    step = max(1, len(whole) // 30)
    refused = 0
    for size in range(0, len(whole), step):
        refused += bool(read_or_refused(*placed(tmp_path, name, whole[:size])))
    assert refused > 5


@pytest.mark.parametrize("name", NAMES)
@one_folder
@given(data=st.data())
def test_damaged_bytes_are_read_or_refused_in_one_line(
    name: str, tmp_path: Path, data: st.DataObject
) -> None:
    content = bytearray(seeds()[name])
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(content) - 1))
        kind = data.draw(st.sampled_from(["byte", "digit", "cut", "twice"]))
        if kind == "byte":
            content[place] = data.draw(st.integers(0, 255))
        elif kind == "digit":
            content[place] = data.draw(st.sampled_from(b"0123456789-.e \t\n,;"))
        elif kind == "cut":
            del content[place : place + data.draw(st.integers(1, 20))]
        else:
            content[place:place] = content[place : place + data.draw(st.integers(1, 200))]
        content = content or bytearray(b"\n")
    read_or_refused(*placed(tmp_path, name, bytes(content)))


@pytest.mark.parametrize(
    ("times", "far", "match"),
    [
        (("0", "0.1"), "1e200", "landmarks of 'hand' at frame 1 are 1e\\+200"),
        (("0", "0.1"), "-1000001", "1e\\+06 m at most"),
        (("0", "5e-324"), "0", "time increases by 4.94066e-324 s at frame 1"),
        (("-1e308", "1e308"), "0", "time increases by inf s at frame 1"),
    ],
)
def test_numbers_out_of_range_are_refused(
    times: tuple[str, str], far: str, match: str, tmp_path: Path
) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"time_s,hand:x_m,hand:y_m,hand:z_m\n{times[0]},0,0,0\n{times[1]},0,{far},\n")
    with pytest.raises(FormatError, match=match):
        read_file(path)


@pytest.mark.parametrize("name", NAMES)
@settings(one_folder, max_examples=10)
@given(content=st.binary(max_size=300))
def test_foreign_bytes_are_refused(name: str, tmp_path: Path, content: bytes) -> None:
    assert read_or_refused(*placed(tmp_path, name, content))


def assert_bounded(path: Path, options: ReadOptions, match: str) -> None:
    """Refused in one line, with little memory taken on the way."""
    tracemalloc.start()
    try:
        with pytest.raises(FormatError, match=match):
            read_file(path, options)
        assert tracemalloc.get_traced_memory()[1] < BOUND
    finally:
        tracemalloc.stop()


def many_joints(count: int) -> bytes:
    open_joints = "".join(
        f"JOINT j{joint}\n{{\nOFFSET 0 0 0\nCHANNELS 0\n" for joint in range(count)
    )
    return (BVH_OF + open_joints + "}\n" * (count + 1) + "MOTION\n").encode()


HUGE = [
    ("a.bvh", many_joints(2000), "more than 1000 joints"),
    ("a.bvh", many_joints(500) + b"Frames: 9999999\nFrame Time: 0.1\n", "whole number up to"),
    ("a.bvh", b"HIERARCHY\n" + b"1 " * 2**20, "line 2: longer than"),
    ("a.trc", b"PathFileType\n" + b"x" * 2**21, "line 2: longer than"),
    (
        "a.trc",
        b"PathFileType\nNumFrames NumMarkers Units\n999999999 1 mm\n",
        "line 3: '999999999' is not a whole number up to",
    ),
    ("a.amc", b"1" + b"0" * 300 + b"\n", "line 1: '10*' is not a whole number"),
    ("table.txt", b"t;" * 2**19, "line 1: "),
    ("columns.toml", b"#" * 2**21, "more than the"),
]


@pytest.mark.parametrize(("name", "content", "match"), HUGE)
def test_enormous_claims_take_little_memory(
    name: str, content: bytes, match: str, tmp_path: Path
) -> None:
    path, options = placed(tmp_path, name, content)
    assert_bounded(path, options, match)


def test_c3d_counts_are_compared_with_the_size_of_the_file(tmp_path: Path) -> None:
    last_frame, used = 8, seeds()["a.c3d"].index(b"USED") + 8  # name, offset, type, dimensions
    for places in ([last_frame], [used, 2]):  # the points are counted twice
        content = bytearray(seeds()["a.c3d"])
        for place in places:
            struct.pack_into("<H", content, place, 30_000)
        path, options = placed(tmp_path, "a.c3d", bytes(content))
        assert_bounded(path, options, rf"the frames end at byte \d+, the file at {len(content)}")


@pytest.mark.parametrize("suffix", [".amc", ".bvh", ".c3d", ".csv", ".mat", ".npz", ".trc", ".txt"])
def test_files_beyond_every_limit_are_not_opened(suffix: str, tmp_path: Path) -> None:
    (tmp_path / "a.asf").write_bytes(seeds()["skeleton.asf"])
    path = tmp_path / f"a{suffix}"
    with path.open("wb") as file:
        file.truncate(2**33)  # sparse: it takes no room
    options = ReadOptions(columns=tmp_path / "columns.toml") if suffix == ".txt" else ReadOptions()
    (tmp_path / "columns.toml").write_bytes(seeds()["columns.toml"])
    assert_bounded(path, options, "cut the motion")


def test_a_matlab_file_that_inflates_to_more_than_it_may_is_refused(tmp_path: Path) -> None:
    deflated = zlib.compress(bytes(hug_mp.LARGEST_INSIDE + 2**20), 9)
    head = seeds()["a.mat"][:128]
    path = tmp_path / "a.mat"
    path.write_bytes(head + struct.pack("<II", 15, len(deflated)) + deflated)
    assert_bounded(path, ReadOptions(take="1.1.1"), "holds more than 16777216 bytes")


@pytest.mark.parametrize(
    ("key", "value", "match"),
    [
        ("parent", np.array([5, 0, 1, 2]), "-1 for its first"),
        ("parent", np.array([-1, 1, 1, 2]), "must be a joint before it"),
        ("parent", np.array([-1.0, np.nan, 1, 2]), "row of numbers"),
        ("joint", np.array(["a", "a", "b", "c"]), "unique names"),
        ("offset", np.zeros((3, 3)), "'offset' has shape"),
        ("prerot_xyzw", np.zeros((4, 4)), "unit length"),
        ("motion|expmap", np.full((FRAMES, 4, 3), np.inf), "expected finite frames x 4 x 3"),
        ("motion|root", np.zeros((2, 3)), "root of shape"),
        ("motion|t", np.zeros(FRAMES), "does not increase"),
        ("up", np.array("w"), "'up' is 'w'"),
        ("motions", np.array(["other"]), "no key 'other"),
        ("motions", np.array(["motion", "motion"]), "'motions' names a motion twice"),
    ],
)
def test_archives_that_do_not_fit_are_refused(
    key: str, value: np.ndarray, match: str, tmp_path: Path
) -> None:
    with np.load(io.BytesIO(seeds()["body.npz"])) as whole:
        arrays = {**whole, key: value}
    path = tmp_path / "body.npz"
    np.savez(path, **arrays)
    with pytest.raises(FormatError, match=match):
        read_file(path)


def test_an_archive_with_a_bomb_is_refused_by_its_claimed_size(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(archive, "LARGEST_ARRAY", 2**20)
    path = tmp_path / "body.npz"
    path.write_bytes(seeds()["body.npz"])
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as file:
        file.writestr("motion|translation.npy", bytes(2**23))
    assert_bounded(path, ReadOptions(), r"'motion\|translation' has 8388608 bytes")
    assert takes_in(path) == ("motion",)
