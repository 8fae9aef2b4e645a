"""Motion files: what is written reads back, what is damaged is refused in one line."""

import io
import os
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from armsyn.errors import FormatError, InputError
from armsyn.motion import Motion
from armsyn.motion.formats import csv_format, npz_format, read_motion, write_motion
from armsyn.motion.formats.files import check_size, replacing
from armsyn.motion.motion import FARTHEST

SUFFIXES = [".csv", ".npz"]
one_folder = settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=60
)
names = st.lists(
    st.text(st.characters(categories=("L", "N", "P", "Zs")), min_size=1, max_size=6).filter(
        str.isprintable
    ),
    max_size=3,
    unique=True,
)
finite = st.floats(allow_nan=False, allow_infinity=False, width=64)


@st.composite
def motions(draw: st.DrawFn) -> Motion:
    frames = draw(st.integers(2, 6))
    steps = st.floats(1e-6, 1e3)
    joints, landmarks = draw(names), draw(names)
    gaps = st.one_of(st.floats(-FARTHEST, FARTHEST), st.just(float("nan")))
    filled = draw(st.none() | arrays(np.bool_, (frames, len(landmarks))))
    if not joints and not landmarks:
        joints = ["elbow"]
    return Motion(
        time=np.cumsum(draw(arrays(np.float64, frames, elements=steps))),
        joint_names=tuple(joints),
        angles=draw(arrays(np.float64, (frames, len(joints)), elements=finite)) if joints else None,
        landmark_names=tuple(landmarks),
        landmarks=draw(arrays(np.float64, (frames, len(landmarks), 3), elements=gaps))
        if landmarks
        else None,
        source=" ".join(draw(st.text(st.characters(categories=("L", "P", "Zs")))).split()),
        filled=filled if landmarks else None,
    )


def small_motion() -> Motion:
    return Motion(
        time=np.array([0.0, 0.5, 1.0]),
        joint_names=("elbow",),
        angles=np.array([[0.1], [0.2], [0.3]]),
        landmark_names=("elbow", "hand"),
        landmarks=np.arange(18.0).reshape(3, 2, 3),
        source="small",
    )


def names_in(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def assert_same(first: Motion, second: Motion) -> None:
    np.testing.assert_array_equal(first.time, second.time)
    assert (first.joint_names, first.landmark_names) == (second.joint_names, second.landmark_names)
    for part in ("angles", "landmarks", "filled"):
        mine, other = getattr(first, part), getattr(second, part)
        assert (mine is None) == (other is None)
        if mine is not None:
            np.testing.assert_array_equal(mine, other)
    assert first.source == second.source


@pytest.mark.parametrize("suffix", SUFFIXES)
@one_folder
@given(motion=motions())
def test_round_trip_keeps_every_bit(suffix: str, tmp_path: Path, motion: Motion) -> None:
    path = tmp_path / f"motion{suffix}"
    write_motion(path, motion)
    assert_same(read_motion(path), motion)
    assert names_in(tmp_path) == [path.name]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_the_same_motion_is_the_same_bytes(suffix: str, tmp_path: Path) -> None:
    first, second = tmp_path / f"a{suffix}", tmp_path / f"b{suffix.upper()}"
    write_motion(first, small_motion())
    write_motion(second, read_motion(first))
    assert first.read_bytes() == second.read_bytes()


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_every_truncation_is_refused_in_one_line(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"motion{suffix}"
    write_motion(path, small_motion())
    whole = path.read_bytes()
    for size in range(0, len(whole), 7):
        path.write_bytes(whole[:size])
        assert_refused(path)


@pytest.mark.parametrize("suffix", SUFFIXES)
@one_folder
@given(data=st.data())
def test_damaged_bytes_are_read_or_refused_never_worse(
    suffix: str, tmp_path: Path, data: st.DataObject
) -> None:
    path = tmp_path / f"motion{suffix}"
    write_motion(path, small_motion())
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(content)
    message = f"{path}: whole"
    try:
        assert read_motion(path).frames >= 2
    except FormatError as error:
        message = str(error)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message


@pytest.mark.parametrize("suffix", SUFFIXES)
@one_folder
@given(content=st.binary(max_size=200))
def test_foreign_bytes_are_refused(suffix: str, tmp_path: Path, content: bytes) -> None:
    path = tmp_path / f"motion{suffix}"
    path.write_bytes(content)
    assert_refused(path)


def assert_refused(path: Path, match: str = ".") -> None:
    with pytest.raises(FormatError, match=match) as caught:
        read_motion(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_missing_files_folders_and_devices_are_refused(suffix: str, tmp_path: Path) -> None:
    assert_refused(tmp_path / f"absent{suffix}", "No such file")
    (tmp_path / f"folder{suffix}").mkdir()
    assert_refused(tmp_path / f"folder{suffix}", "not a file")
    os.mkfifo(tmp_path / f"pipe{suffix}")
    assert_refused(tmp_path / f"pipe{suffix}", "not a file")


def test_unknown_suffixes_name_the_known_ones(tmp_path: Path) -> None:
    known = r"\.amc, \.bvh, \.c3d, \.csv, \.mat, \.npz, \.parquet, \.trc"
    with pytest.raises(FormatError, match=rf"no motion format has the suffix '\.xlsx'.*{known}"):
        read_motion(tmp_path / "motion.xlsx")
    with pytest.raises(FormatError, match=rf"only written, not read: use one of {known}"):
        read_motion(tmp_path / "motion.mcap")
    written = r"use one of \.csv, \.lerobot, \.mcap, \.npz, \.parquet, \.trc"
    with pytest.raises(FormatError, match=rf"no motion format has the suffix ''.*{written}"):
        write_motion(tmp_path / "motion", small_motion())
    with pytest.raises(FormatError, match=rf"{written}, or, of a skeleton or an arm, \.bvh"):
        write_motion(tmp_path / "motion.xyz", small_motion())
    with pytest.raises(FormatError, match=rf"no landmarks or angles.*{written}"):
        write_motion(tmp_path / "motion.bvh", small_motion())


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_files_that_cannot_be_written_say_so(suffix: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot write"):
        write_motion(tmp_path / "absent" / f"motion{suffix}", small_motion())


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "motion.csv"
    path.write_text("old")

    def half() -> None:
        with replacing(path) as temporary:
            temporary.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        half()
    assert path.read_text() == "old"
    assert names_in(tmp_path) == ["motion.csv"]
    with replacing(path) as temporary:
        temporary.write_text("new")
    assert path.read_text() == "new"


def test_size_is_looked_at_before_reading(tmp_path: Path) -> None:
    path = tmp_path / "huge.csv"
    with path.open("wb") as file:
        file.truncate(csv_format.LARGEST_FILE + 1)  # sparse: it takes no room
    assert_refused(path, "cut the motion")
    assert check_size(path, csv_format.LARGEST_FILE + 1) == csv_format.LARGEST_FILE + 1


CSV_HEAD = "# armsyn-motion-1\ntime_s,elbow:angle_rad,hand:x_m,hand:y_m,hand:z_m\n"


@pytest.mark.parametrize(
    ("text", "match"),
    [
        (CSV_HEAD + "0,1,2,3,4\n0.1,1,2,3\n", "line 4: 4 cells, expected 5"),
        (CSV_HEAD + "0,1,2,3,4\nnan,1,2,3,4\n", "line 4: 'nan' is not a finite number"),
        (CSV_HEAD + "0,1,2,3,4\n0.1,inf,2,3,4\n", "line 4: 'inf'"),
        (CSV_HEAD + "0,1,2,3,4\n0.1,,2,3,4\n", "line 4: ''"),
        (CSV_HEAD + "0,1,2,3,4\n0.1,1_0,2,3,4\n", "line 4: '1_0'"),
        (CSV_HEAD + "0,1,2,3,4\n0.1,1,2,3,word\n", "line 4: 'word'"),
        (CSV_HEAD + "0,1,2,3,4\n0,1,2,3,4\n", "does not increase at frame 1"),
        (CSV_HEAD + "0,1,2,3,4\n", "two finite numbers"),
        (CSV_HEAD, "no rows"),
        (CSV_HEAD + "0,1,2,3,4\n0.1,1,2,3,4", "no end"),
        ("# armsyn-motion-2\ntime_s,a:angle_rad\n0,1\n1,1\n", "schema 'armsyn-motion-2'"),
        ("# frames: 3\n" + CSV_HEAD + "0,1,2,3,4\n1,1,2,3,4\n", "frames.*cut"),
        ("time,a:angle_rad\n0,1\n1,1\n", "no column 'time_s'"),
        ("time_s,a:commanded_rad\n0,1\n1,1\n", "no column 'NAME:angle_rad'"),
        ("time_s,hand:x_m,hand:z_m\n0,1,1\n", "no column 'hand:y_m'"),
        ("time_s,a:angle_rad,a:angle_rad\n0,1,1\n", "two columns 'a:angle_rad'"),
        ('time_s,"a:angle_rad\n0,1\n', "comma-separated"),
        ("time_s" + ",a" * csv_format.MOST_COLUMNS + "\n", "columns"),
    ],
)
def test_faults_of_csv_files_are_named(tmp_path: Path, text: str, match: str) -> None:
    path = tmp_path / "motion.csv"
    path.write_text(text)
    assert_refused(path, match)


def test_csv_written_by_a_spreadsheet_with_more_columns(tmp_path: Path) -> None:
    path = tmp_path / "sheet.csv"
    rows = "time_s,note,elbow:angle_rad,elbow:commanded_rad,hand:x_m,hand:y_m,hand:z_m\r\n"
    rows += '0.0,"a, b",1,9,1,2,3\r\n1e-1,,2,9,,nan,3\r\n'
    path.write_bytes(b"\xef\xbb\xbf" + rows.encode())
    motion = read_motion(path)
    assert (motion.joint_names, motion.landmark_names) == (("elbow",), ("hand",))
    assert motion.angles is not None
    assert motion.angles[:, 0].tolist() == [1, 2]
    assert np.isnan(motion.hand).tolist() == [[False] * 3, [True, True, False]]
    assert motion.source == "sheet.csv"


def test_csv_extra_columns_are_ignored_when_read(tmp_path: Path) -> None:
    path = tmp_path / "recording.csv"
    csv_format.write(path, small_motion(), {"elbow:commanded_rad": np.array([7.0, 8.0, 9.0])})
    assert "elbow:commanded_rad" in path.read_text()
    assert_same(read_motion(path), small_motion())


@pytest.mark.fault(38)
def test_too_many_rows_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "long.csv"
    write_motion(path, small_motion())
    monkeypatch.setattr(csv_format, "MOST_ROWS", 2)
    assert_refused(path, "more than 2 rows")


@pytest.mark.parametrize(
    ("limit", "most", "match"),
    [
        ("MOST_ROWS", 2, r"3 rows, more than 2: name an \.npz file"),
        ("MOST_COLUMNS", 7, "8 columns, more than 7"),
        ("LARGEST_FILE", 100, "more than 100 bytes"),
    ],
)
def test_what_could_not_be_read_again_is_not_written_as_csv(
    limit: str, most: int, match: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(csv_format, limit, most)
    with pytest.raises(FormatError, match=match):
        write_motion(tmp_path / "long.csv", small_motion())
    assert names_in(tmp_path) == []
    csv_format.write(tmp_path / "recording.csv", small_motion(), {"elbow:current_a": np.zeros(3)})
    assert names_in(tmp_path) == ["recording.csv"]  # a recording is not lost at its end


def test_names_that_are_not_printable_are_refused_by_csv(tmp_path: Path) -> None:
    motion = Motion(np.arange(2.0), ("a\nb",), np.zeros((2, 1)))
    with pytest.raises(FormatError, match="rename"):
        write_motion(tmp_path / "motion.csv", motion)
    assert names_in(tmp_path) == []


def npz_with(path: Path, **changes: object) -> Path:
    kept = {**npz_format.arrays_of(small_motion()), **changes}
    np.savez(path, **{key: value for key, value in kept.items() if value is not None})
    return path


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"schema": None}, "no key 'schema'"),
        ({"schema": np.array("armsyn-motion-9")}, "schema 'armsyn-motion-9'"),
        ({"time_s": None}, "no key 'time_s'"),
        ({"joint_names": None}, "no key 'joint_names'"),
        ({"angles_rad": None, "landmarks_m": None}, "neither"),
        ({"time_s": np.array([0.0, np.nan, 1.0])}, "finite"),
        ({"time_s": np.array(["0", "1", "2"])}, "expected numbers"),
        ({"time_s": np.zeros((3, 1))}, "time must be"),
        ({"angles_rad": np.zeros((2, 1))}, "angles have shape"),
        ({"angles_rad": np.full((3, 1), np.nan)}, "'angles_rad' are not all finite"),
        ({"landmarks_m": np.full((3, 2, 3), np.inf)}, "'landmarks_m' are not all finite"),
        ({"joint_names": np.array([1.0])}, "expected a row of names"),
        ({"joint_names": np.array("elbow")}, "expected a row of names"),
        ({"source": np.array(["a", "b"])}, "expected text"),
        ({"time_s": np.array([0.0, 1.0, 2.0], dtype=complex)}, "damaged"),
        ({"time_s": np.array([None, 1, 2])}, "damaged"),
    ],
)
def test_faults_of_npz_files_are_named(
    tmp_path: Path, changes: dict[str, object], match: str
) -> None:
    assert_refused(npz_with(tmp_path / "motion.npz", **changes), match)


def test_npz_extra_keys_are_ignored_even_when_they_hold_objects(tmp_path: Path) -> None:
    path = npz_with(tmp_path / "recording.npz", commanded_rad=np.ones(3), odd=np.array([{}]))
    assert_same(read_motion(path), small_motion())


def test_npz_members_that_claim_more_than_they_hold_take_no_memory(tmp_path: Path) -> None:
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<f8", "fortran_order": False, "shape": (10**13,)}
    )
    path = npz_with(tmp_path / "motion.npz", time_s=None)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("time_s.npy", header.getvalue() + b"\0" * 24)
    assert_refused(path, "'time_s' is damaged")


@pytest.mark.fault(38)
def test_npz_bombs_are_refused_by_their_claimed_size(tmp_path: Path) -> None:
    path = npz_with(tmp_path / "motion.npz", time_s=None)
    with (
        zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive,
        archive.open("time_s.npy", "w", force_zip64=True) as member,
    ):
        for _ in range(npz_format.LARGEST_ARRAY // 2**22 + 1):
            member.write(bytes(2**22))
    assert path.stat().st_size < 2**20
    assert_refused(path, "'time_s' has")


def test_npz_names_beyond_unicode_are_refused(tmp_path: Path) -> None:
    broken = np.array([0x7FFFFFFF], dtype=np.uint32).view("<U1")
    assert_refused(npz_with(tmp_path / "motion.npz", joint_names=broken), "not text")
