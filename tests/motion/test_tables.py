"""Tables with a declared map of columns, and logs of robots' joints."""

from pathlib import Path

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.errors import FormatError
from armsyn.motion.formats import ReadOptions, read_file, read_motion, split_take
from tests.motion.seeds import COLUMNS, LOG, TABLE, URDF


@pytest.fixture
def table(tmp_path: Path) -> tuple[Path, ReadOptions]:
    (tmp_path / "columns.toml").write_text(COLUMNS)
    (tmp_path / "table.txt").write_text(TABLE)
    return tmp_path / "table.txt", ReadOptions(columns=tmp_path / "columns.toml")


def test_a_map_says_what_the_columns_are(table: tuple[Path, ReadOptions]) -> None:
    motion = read_motion(*table)
    assert (motion.joint_names, motion.landmark_names) == (("elbow",), ("hand",))
    np.testing.assert_allclose(motion.time, [0, 0.001, 0.002, 0.003])
    assert motion.angles is not None
    np.testing.assert_allclose(motion.angles[:, 0], np.deg2rad([0, 10, 20, 30]))
    np.testing.assert_allclose(motion.hand[0], [0.03, 0.005, 0.02])  # y up: (x, y, z) -> (z, x, y)
    assert np.isnan(motion.hand[2]).tolist() == [False, False, True]


def test_headless_tables_with_blanks_and_a_rate(tmp_path: Path) -> None:
    (tmp_path / "c.toml").write_text(
        'delimiter = "space"\nskip_lines = 1\nheadings = false\nrate = 10\n'
        "[landmarks]\na = [1, 2, 3]\nb = [4, 5, 6]\n"
    )
    (tmp_path / "t.txt").write_text("remark\n 1  2 3\t4 5 6\n\n1 2 3 4 5 7 8\n")
    motion = read_motion(tmp_path / "t.txt", ReadOptions(columns=tmp_path / "c.toml"))
    assert motion.hand.tolist() == [[4, 5, 6], [4, 5, 7]]
    assert motion.time.tolist() == [0, 0.1]


def test_a_row_of_nothing_but_tabs_is_a_frame_of_gaps(tmp_path: Path) -> None:
    (tmp_path / "c.toml").write_text('delimiter = "tab"\nrate = 10\n[landmarks]\na = [1, 2, 3]\n')
    (tmp_path / "t.tsv").write_text("x\ty\tz\n1\t2\t3\n\t\t\n\n1\t2\t4\n")
    motion = read_motion(tmp_path / "t.tsv", ReadOptions(columns=tmp_path / "c.toml"))
    assert np.isnan(motion.hand).all(axis=1).tolist() == [False, True, False]


def test_a_rate_that_is_told_stands_in_for_the_maps(table: tuple[Path, ReadOptions]) -> None:
    path, options = table
    assert options.columns is not None
    options.columns.write_text(
        'delimiter = ";"\n[joints]\nelbow = "elbow"\n[landmarks]\n'
        'hand = ["hand x", "hand y", "hand z"]\n'
    )
    reading = read_file(path, ReadOptions(columns=options.columns, rate=5))
    assert reading.motion.time.tolist() == [0, 0.2, 0.4, 0.6]
    assert [reading.facts[key] for key in ("unit", "up", "angle unit")] == [
        *("m (assumed)", "z (assumed)", "rad (assumed)")
    ]
    told = read_file(path, ReadOptions(columns=options.columns, rate=5, unit="mm", up="y"))
    assert (told.facts["unit"], told.facts["up"]) == ("mm", "y")


def test_a_take_is_parted_from_a_file_in_a_folder_with_its_mark(tmp_path: Path) -> None:
    folder = tmp_path / "day#1"
    assert split_take(f"{folder}/a.npz#reach") == (folder / "a.npz", "reach")
    (tmp_path / "a.npz").touch()
    assert split_take(f"{tmp_path}/a.npz#reach#2") == (tmp_path / "a.npz", "reach#2")


def test_joints_alone_are_a_motion(table: tuple[Path, ReadOptions]) -> None:
    path, options = table
    assert options.columns is not None
    options.columns.write_text('delimiter = ";"\nrate = 10\n[joints]\nelbow = "elbow"\n')
    motion = read_motion(path, options)
    assert motion.landmarks is None
    assert motion.angles is not None
    assert motion.angles[:, 0].tolist() == [0, 10, 20, 30]
    assert motion.time.tolist() == [0, 0.1, 0.2, 0.3]


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("[landmarks]\n", "maps no column"),
        ('[landmarks]\nhand = ["a", "b"]\n', r"length 3.*hand|landmarks"),
        ('[joints]\na = "b"\n', "'time' or 'rate'"),
        ('time = "t"\nrate = 5\n[joints]\na = "b"\n', "'time' or 'rate'"),
        ('tme = "t"\n[joints]\na = "b"\n', "unknown field `tme`"),
        ('time = "t"\nlength_unit = "yard"\n[joints]\na = "b"\n', "'yard'.*length_unit"),
        ('time = 0\n[joints]\na = "b"\n', "time"),
        ('rate = -1\n[joints]\na = "b"\n', "rate"),
        ('rate = 5\nheadings = false\n[joints]\na = "b"\n', "by their numbers"),
        ("rate = ", "not a TOML file"),
        ('rate = 5\n[joints]\na = "none"\n', "no column 'none' among the headings: t, hand x"),
        ("rate = 5\n[joints]\na = 6\n", "line 2: 5 cells, but column 6"),
        ('time = "t"\n[joints]\na = "hand z"\nb = "hand y"\n', "line 4: '' is not a finite"),
    ],
)
def test_faults_of_maps_are_named(table: tuple[Path, ReadOptions], text: str, match: str) -> None:
    path, options = table
    assert options.columns is not None
    text = text if text.startswith("[landm") or "delimiter" in text else f'delimiter = ";"\n{text}'
    options.columns.write_text(text)
    with pytest.raises(FormatError, match=match):
        read_motion(path, options)


def test_a_log_of_joints_is_known_by_its_headings(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(URDF)
    (tmp_path / "log.csv").write_text(LOG)
    options = ReadOptions(joints=tmp_path / "r.urdf", unit="deg")
    reading = read_file(tmp_path / "log.csv", options)
    motion = reading.motion
    assert motion.angles is not None
    np.testing.assert_allclose(motion.angles[3], np.deg2rad([3, 1]))
    assert motion.landmark_names == ("shoulder_lift", "elbow", "tip")
    assert motion.landmarks is not None
    # the elbow is 0.3 m along x, turned about y by the shoulder's 3 degrees
    lift = np.deg2rad(3)
    np.testing.assert_allclose(motion.landmarks[3, 1], [0.3 * np.cos(lift), 0, -0.3 * np.sin(lift)])
    assert motion.time.tolist() == [0, 0.1, 0.2, 0.3]


def test_part_of_a_robot_has_angles_only(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(URDF)
    (tmp_path / "log.tsv").write_text("seconds\telbow\n0\t1\n1\t2\n")
    options = ReadOptions(joints=tmp_path / "r.urdf", rate=2)
    reading = read_file(tmp_path / "log.tsv", options)
    assert reading.motion.landmarks is None
    assert reading.motion.time.tolist() == [0, 0.5]
    assert reading.facts["not in it"] == "shoulder_lift"
    assert reading.facts["unit"] == "rad (assumed)"


def test_a_log_of_an_arm_that_is_described(tmp_path: Path) -> None:
    arm = load_arm("human7", calibrated=False)
    postures = np.stack([arm.rest, arm.rest + 0.1])
    rows = [",".join(["t", *arm.joint_names])]
    rows += [",".join(map(repr, [float(t), *row.tolist()])) for t, row in enumerate(postures)]
    (tmp_path / "log.csv").write_text("\n".join(rows) + "\n")
    motion = read_motion(tmp_path / "log.csv", ReadOptions(joints=Path("human7")))
    assert motion.landmarks is not None
    np.testing.assert_array_equal(motion.landmarks, arm.chain.positions(postures))


@pytest.mark.parametrize(
    ("headings", "joints", "match"),
    [
        ("time,a,b", "r.urdf", "no column is headed by a joint of .*: shoulder_lift, elbow"),
        ("when,shoulder_lift,elbow", "r.urdf", "0 columns of time.*say the rate"),
        ("time,t,elbow", "r.urdf", "2 columns of time"),
        ("time,elbow,elbow", "r.urdf", "two columns 'elbow'"),
        ("time,elbow,b", "no_such_arm", "no_such_arm"),
        ("time,elbow,b", "absent.urdf", "absent.urdf: cannot be read"),
    ],
)
def test_faults_of_logs_are_named(tmp_path: Path, headings: str, joints: str, match: str) -> None:
    (tmp_path / "r.urdf").write_text(URDF)
    path = tmp_path / "log.csv"
    path.write_text(LOG.replace("time,shoulder_lift,elbow", headings))
    robot = tmp_path / joints if joints.endswith(".urdf") else Path(joints)
    with pytest.raises(FormatError, match=match):
        read_motion(path, ReadOptions(joints=robot))


def test_options_that_a_format_does_not_hear_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time_s,a:angle_rad\n0,1\n1,1\n")
    with pytest.raises(FormatError, match="'unit' needs a map of columns"):
        read_motion(tmp_path / "a.csv", ReadOptions(unit="mm"))
    with pytest.raises(FormatError, match="takes no option 'columns'; it takes rate, unit, up"):
        read_motion(tmp_path / "a.bvh", ReadOptions(columns=tmp_path / "c.toml"))
    with pytest.raises(FormatError, match="no axis up"):
        read_motion(tmp_path / "a.csv", ReadOptions(joints=Path("human7"), up="z"))
    with pytest.raises(FormatError, match="not by both"):
        read_motion(tmp_path / "a.csv", ReadOptions(joints=Path("a"), columns=Path("b")))
    with pytest.raises(FormatError, match="say what its columns are"):
        read_motion(tmp_path / "a.txt")
    for wrong in ({"unit": "yard"}, {"unit": "-1"}, {"rate": 0.0}, {"up": "w"}):
        with pytest.raises(FormatError, match=next(iter(wrong))):
            ReadOptions(**wrong)  # type: ignore[arg-type]
