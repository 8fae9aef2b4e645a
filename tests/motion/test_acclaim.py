"""ASF/AMC by hand: positions of a body of two bones, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

from armsyn.errors import FormatError
from armsyn.motion.formats import ReadOptions, read_body, read_file
from tests.motion.seeds import AMC, ASF

UNIT = 0.0254 / 0.5


def placed(folder: Path, amc: str = AMC, asf: str = ASF) -> Path:
    (folder / "01.asf").write_text(asf)
    (folder / "01_02.amc").write_text(amc)
    return folder / "01_02.amc"


def frames(*bones: str) -> str:
    """An AMC of two equal frames."""
    return ":DEGREES\n" + "".join(f"{n}\n" + "\n".join(bones) + "\n" for n in (1, 2))


def at(path: Path, name: str) -> list[float]:
    """Where a joint is in the first frame, in the file's units and axes."""
    motion = read_file(path, ReadOptions(up="z", unit="m")).motion
    assert motion.landmarks is not None
    return (motion.landmarks[0, motion.landmark_names.index(name)]).tolist()


def test_rest_is_the_directions_times_the_lengths(tmp_path: Path) -> None:
    path = placed(tmp_path, frames("root 1 2 3 0 0 0", "arm 0 0 0", "hand 0 0"))
    assert at(path, "root") == at(path, "arm") == [1, 2, 3]
    assert at(path, "hand") == [11, 2, 3]
    assert at(path, "hand_end") == [11, 7, 3]


def test_turns_are_about_the_bones_own_axes(tmp_path: Path) -> None:
    # about z, the 20 degrees of the arm's axes change nothing
    path = placed(tmp_path, frames("root 0 0 0 0 0 0", "arm 0 0 90", "hand 90 0"))
    np.testing.assert_allclose(at(path, "hand"), [0, 10, 0], atol=1e-12)
    np.testing.assert_allclose(at(path, "hand_end"), [0, 5, 0], atol=1e-12)  # +y, twice by 90
    # about its own x, the axis (cos 20, sin 20, 0) of the body: half a turn mirrors about it
    path = placed(tmp_path, frames("root 0 0 0 0 0 0", "arm 180 0 0", "hand 0 0"))
    forty = np.deg2rad(40)
    there = [10 * np.cos(forty), 10 * np.sin(forty), 0]
    np.testing.assert_allclose(at(path, "hand"), there, atol=1e-12)


def test_rx_comes_before_rz(tmp_path: Path) -> None:
    path = placed(tmp_path, frames("root 0 0 0 90 0 90", "arm 0 0 0", "hand 0 0"))
    np.testing.assert_allclose(at(path, "hand"), [0, 10, 0], atol=1e-12)
    # y to z by rx, which rz leaves
    np.testing.assert_allclose(at(path, "hand_end"), [0, 10, 5], atol=1e-12)


def test_a_bone_may_be_moved_along_its_axes(tmp_path: Path) -> None:
    path = placed(tmp_path, frames("root 0 0 0 0 0 0", "arm 0 0 0", "hand 0 3"))
    assert at(path, "hand") == [13, 0, 0]


def test_radians_and_what_was_assumed(tmp_path: Path) -> None:
    amc = frames("root 0 0 0 0 0 1.5707963267948966", "arm 0 0 0", "hand 0 0")
    path = placed(tmp_path, amc.replace(":DEGREES", ":RADIANS"))
    np.testing.assert_allclose(at(path, "hand"), [0, 10, 0], atol=1e-12)
    reading = read_file(path)
    assert reading.facts == {
        "skeleton": str(tmp_path / "01.asf"),
        "unit": "0.0508 m (of 01.asf)",
        "up": "y (assumed)",
        "rate": "120 Hz (assumed)",
    }
    body = read_body(path)
    np.testing.assert_allclose(np.linalg.norm(body.skeleton.offsets[2]), 10 * UNIT)
    assert body.time[1] == 1 / 120


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("arm 1 20 30", "arm 1 20", "amc: line 5: 'arm' has 3 degrees"),
        ("arm 1 20 30", "arm 1 20 x", "amc: line 5: 'x' is not a finite"),
        ("arm 1 20 30", "leg 1 20 30", "amc: line 5: bone 'leg' is unknown"),
        ("arm 1 20 30\n", "", "amc: line 6: frame 1 has no 'arm'"),
        ("arm 1 20 30\n", "arm 1 20 30\narm 1 20 30\n", "line 6: bone 'arm' .* twice"),
        ("2\nroot", "3\nroot", "amc: line 7: frame 3 follows frame 1"),
        ("1\nroot 0 1", "root 0 1", "amc: line 3: a frame's number, 1, expected"),
    ],
)
def test_faults_of_amc_files_are_named(tmp_path: Path, old: str, new: str, match: str) -> None:
    assert old in AMC
    path = placed(tmp_path, AMC.replace(old, new, 1))
    with pytest.raises(FormatError, match=match):
        read_file(path)


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("length 0.5", "length 0", "line 6: the unit of length"),
        ("angle deg", "angle gon", "line 7: the unit of angle"),
        ("orientation 0 0 0", "orientation 0 9 0", "line 12: .*turned at rest"),
        ("direction 1 0 0", "direction 1 0", "line 17: three numbers"),
        ("axis 0 0 20 XYZ", "axis 0 0 20", "line 19: an axis is three angles"),
        ("axis 0 0 20 XYZ", "axis 0 0 20 XXZ", "line 19: an axis is three angles"),
        ("dof rx ry rz", "dof rx rx", "line 20: degrees of freedom"),
        ("dof rz tx", "dof rz l", "line 31: degrees of freedom 'rz l'"),
        ("name hand", "name arm", "line 32: .*a name that two bones have"),
        ("arm hand\n", "arm leg\n", "line 36: no bone 'leg'"),
        ("arm hand\n", "hand arm\n", "line 36: a bone that hangs from two"),
        ("    arm hand\n", "", "bone 'hand' hangs from nothing"),
        (":hierarchy", ":skin", "no :hierarchy"),
    ],
)
def test_faults_of_asf_files_are_named(tmp_path: Path, old: str, new: str, match: str) -> None:
    assert old in ASF
    path = placed(tmp_path, asf=ASF.replace(old, new, 1))
    with pytest.raises(FormatError, match=match) as caught:
        read_file(path)
    assert str(caught.value).startswith(f"{tmp_path / '01.asf'}: ")


def test_a_missing_skeleton_says_where_it_was_looked_for(tmp_path: Path) -> None:
    (tmp_path / "01_02.amc").write_text(AMC)
    with pytest.raises(FormatError, match=r"no skeleton .*01_02\.asf nor .*01\.asf: name its"):
        read_file(tmp_path / "01_02.amc")
