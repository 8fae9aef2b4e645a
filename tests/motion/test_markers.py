"""Marker files: C3D against ezc3d, TRC there and back."""

import sys
from pathlib import Path

import ezc3d
import numpy as np
import pytest

from armsyn.errors import FormatError
from armsyn.motion import Motion
from armsyn.motion.formats import ReadOptions, read_file, read_motion, write_motion
from armsyn.motion.gaps import find_gaps
from tests.motion.seeds import c3d, markers

C3D = ["reach/ulema/RF1.c3d", "reach/ulema/RF2.c3d", "reach/ulema/HTH1.c3d", "golf/tour_iron.c3d"]


@pytest.mark.parametrize("name", C3D)
def test_c3d_captures_are_what_ezc3d_reads(captures: Path, name: str) -> None:
    motion = read_motion(captures / name)
    other = ezc3d.c3d(str(captures / name))
    point = other["parameters"]["POINT"]
    labels = point["LABELS"]["value"]
    kept = [labels.index(label) for label in motion.landmark_names]
    assert set(labels) - set(motion.landmark_names) == set(point.get("ANGLES", {}).get("value", []))
    metres = {"mm": 0.001, "m": 1.0}[point["UNITS"]["value"][0]]
    positions = other["data"]["points"][:3, kept].transpose(2, 1, 0) * metres
    assert motion.landmarks is not None
    # single precision in the file, and a product in double precision on either side
    np.testing.assert_allclose(motion.landmarks, positions, rtol=0, atol=1e-9)
    assert motion.rate == pytest.approx(point["RATE"]["value"][0])


def test_c3d_gaps_units_up_and_angles(tmp_path: Path) -> None:
    path = tmp_path / "a.c3d"
    path.write_bytes(c3d())
    reading = read_file(path)
    motion = reading.motion
    assert motion.landmark_names == ("elbow", "hand")  # 'bend' is an angle
    assert reading.facts["left out"] == "no positions: bend"
    assert (reading.facts["unit"], reading.facts["up"], motion.rate) == ("cm", "y", 50)
    assert [gap[:3] for gap in find_gaps(motion)] == [("elbow", 1, 1)]
    file = np.arange(36).reshape(3, 3, 4)[:, 1, 2] / 100  # x, y, z of the hand in frame 2
    np.testing.assert_allclose(motion.hand[2], file[[2, 0, 1]])
    told = read_motion(path, ReadOptions(unit="mm", up="z", rate=25))
    np.testing.assert_allclose(told.hand[2], file / 10)
    assert told.time[1] == 0.04


def test_the_golf_captures_of_tour_players_have_y_up(captures: Path) -> None:
    # their POINT:Y_SCREEN says z, though the head is above the hips along y
    path = captures / "golf" / "tour_driver.c3d"
    assert read_file(path).facts["up"] == "z"
    motion = read_motion(path, ReadOptions(up="y"))
    assert motion.landmarks is not None
    head, hip = (motion.landmark_names.index(name) for name in ("HeadTop", "WaistLeft"))
    assert (motion.landmarks[:, head] - motion.landmarks[:, hip])[:, 2].min() > 0.3


def test_c3d_without_a_known_unit_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.c3d"
    path.write_bytes(c3d().replace(b"cm", b"zz"))
    with pytest.raises(FormatError, match=r"POINT:UNITS is 'zz'.*say the unit"):
        read_motion(path)
    assert read_motion(path, ReadOptions(unit="cm")).frames == 4


def test_c3d_without_its_package_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "c3d", None)
    with pytest.raises(FormatError, match=r"pip install 'armsyn\[formats\]'"):
        read_motion(tmp_path / "a.c3d")


def test_trc_there_and_back(tmp_path: Path) -> None:
    write_motion(tmp_path / "a.trc", markers())
    reading = read_file(tmp_path / "a.trc")
    again = reading.motion
    assert again.landmarks is not None
    assert again.landmark_names == markers().landmark_names
    # times 1000 and back again: two roundings of double precision
    np.testing.assert_allclose(again.landmarks, markers().landmarks, rtol=4e-16)
    np.testing.assert_array_equal(again.time, markers().time)
    assert reading.facts == {"unit": "mm", "up": "y (assumed)"}


TRC = (
    "PathFileType\t4\t(X/Y/Z)\ta.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n"
    "100\t100\t2\t2\tm\n"
    "Frame#\tTime\telbow\t\t\thand\t\t\n"
    "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n"
    "\n"
    "1\t0.00\t1\t2\t3\t4\t5\t6\t\n"
    "2\t0.01\t\t\t\t4\tnan\t6\n"
)


def test_trc_of_other_programs(tmp_path: Path) -> None:
    path = tmp_path / "a.trc"
    path.write_bytes(TRC.replace("\n", "\r\n").encode())
    motion = read_motion(path)
    assert motion.landmarks is not None
    np.testing.assert_array_equal(motion.landmarks[0], [[3, 1, 2], [6, 4, 5]])
    assert [gap[:3] for gap in find_gaps(motion)] == [("elbow", 1, 1), ("hand", 1, 1)]
    assert motion.time.tolist() == [0, 0.01]
    assert read_motion(path, ReadOptions(rate=50)).time.tolist() == [0, 0.02]


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("PathFileType", "PathType", "line 1: a TRC file begins"),
        ("NumFrames", "Frames", "line 3: no NumFrames"),
        ("2\t2\tm", "2\t0\tm", "line 3: NumMarkers is 0"),
        ("2\t2\tm", "2\t2\tyard", "line 3: unit 'yard'"),
        ("2\t2\tm", "2\t3\tm", "line 4: .*3 different names"),
        ("hand", "elbow", "line 4: .*2 different names"),
        ("2\t2\tm", "3\t2\tm", "line 9: the file was cut: 2 of 3"),
        ("2\t2\tm", "1\t2\tm", "line 8: more than the 1 frames"),
        ("4\tnan\t6", "4\t6", "line 8: 7 cells, expected 8"),
        ("4\tnan\t6", "4\tinf\t6", "line 8: 'inf' is not a finite"),
        ("2\t0.01", "2\t0.00", "does not increase"),
    ],
)
def test_faults_of_trc_files_are_named(tmp_path: Path, old: str, new: str, match: str) -> None:
    assert old in TRC
    path = tmp_path / "a.trc"
    path.write_text(TRC.replace(old, new, 1))
    with pytest.raises(FormatError, match=match) as caught:
        read_motion(path)
    assert str(caught.value).startswith(f"{path}: ")


def test_what_trc_cannot_say_is_refused(tmp_path: Path) -> None:
    angles = Motion(np.arange(2.0), ("elbow",), np.zeros((2, 1)))
    with pytest.raises(FormatError, match="only angles"):
        write_motion(tmp_path / "a.trc", angles)
    tabbed = Motion(np.arange(2.0), landmark_names=("a\tb",), landmarks=np.zeros((2, 1, 3)))
    with pytest.raises(FormatError, match="rename"):
        write_motion(tmp_path / "a.trc", tabbed)
    assert not list(tmp_path.iterdir())
