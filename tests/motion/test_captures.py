"""Captured reaches by name: the table of selections, the cuts, and what is refused."""

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest

from armsyn.errors import CaptureError, FormatError
from armsyn.motion.captures import captures_folder, is_selection, load_captures


def rows(captures: Path, name: str) -> list[dict[str, str]]:
    with (captures / "segments" / name).open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize(
    ("selection", "count", "first"),
    [
        ("garza", 35, "garza:BackFloor"),
        ("garza:return", 35, "garza:BackFloor:return"),
        ("garza:all", 70, "garza:BackFloor"),
        ("garza:ForwardHigh", 1, "garza:ForwardHigh"),
        ("garza:ForwardHigh:return", 1, "garza:ForwardHigh:return"),
        ("garza:ForwardHigh:all", 2, "garza:ForwardHigh"),
        ("hug_mp:S01", 14, "hug_mp:S01:1.1.1:R-1"),
        ("hug_mp:S01:2.4.5:R-9", 1, "hug_mp:S01:2.4.5:R-9"),
        (" garza:Left30Low , hug_mp:S02 ", 15, "garza:Left30Low"),
    ],
)
@pytest.mark.usefixtures("captures")
def test_selections(selection: str, count: int, first: str) -> None:
    found = load_captures(selection)
    assert len(found) == len({capture.name for capture in found}) == count
    assert found[0].name == first
    for capture in found:
        assert capture.kind == ("return" if capture.name.endswith(":return") else "reach")
        assert [again.name for again in load_captures(capture.name)] == [capture.name]


def test_the_papers_two_sets(captures: Path) -> None:
    """Two repetitions of 7 targets; and 200 usable reaches of two persons."""
    found = load_captures("hug_mp:S01")
    targets = [capture.name.rsplit("-", 1)[1] for capture in found]
    assert sorted(targets) == sorted(2 * sorted(set(targets)))
    assert len(set(targets)) == 7
    usable = [
        row
        for row in rows(captures, "hug_mp.csv")
        if row["subject"] in ("S01", "S02") and row["frm"] == "R" and row["usable"] == "True"
    ]
    both = load_captures("hug_mp:S01:all,hug_mp:S02:all")
    assert len(both) == len(usable) == 200
    keys = [
        f"hug_mp:{r['subject']}:{r['rep']}.{r['task']}.{r['motion']}:R-{r['to']}" for r in usable
    ]
    assert [capture.name for capture in both] == keys
    assert [c.name for c in found] == [
        name
        for name in keys[:100]
        if [k for k in keys[:100] if k.endswith(name[name.rindex("R-") :])].index(name) < 2
    ]


@pytest.mark.parametrize("name", ["garza", "hug_mp"])
def test_cuts_are_those_of_the_table(captures: Path, name: str) -> None:
    """Frames, duration and how far the hand goes, as the table's own columns have them."""
    table = {}
    for row in rows(captures, f"{name}.csv"):
        if name == "garza":
            returns = row["to"] == "rest"
            place = row["frm" if returns else "to"].removesuffix("01")
            table[f"garza:{place}" + (":return" if returns else "")] = row
        else:
            key = f"{row['rep']}.{row['task']}.{row['motion']}:{row['frm']}-{row['to']}"
            table[f"hug_mp:{row['subject']}:{key}"] = row
    for capture in load_captures("garza:all" if name == "garza" else "hug_mp:S03:all"):
        row = table[capture.name]
        frames = int(row["end_frame"]) - int(row["start_frame"]) + 1
        assert capture.motion.frames == frames
        assert capture.motion.time[0] == 0
        assert capture.motion.duration == pytest.approx(float(row["duration_s"]), abs=2e-3)
        assert f"frames {row['start_frame']}-{row['end_frame']}" in capture.source
        if name == "hug_mp":  # garza's table has the hand in the world, ours is in the chest
            moved = np.linalg.norm(capture.motion.hand[-1] - capture.motion.hand[0])
            assert moved == pytest.approx(float(row["displacement_m"]), abs=2e-3)


@pytest.mark.usefixtures("captures")
def test_what_is_named_twice_is_loaded_once() -> None:
    names = [capture.name for capture in load_captures("garza,garza:ForwardHigh")]
    assert names == [capture.name for capture in load_captures("garza")]


def test_a_selection_is_known_by_its_set() -> None:
    assert is_selection("garza:ForwardHigh")
    assert is_selection("hug_mp")
    assert not is_selection("some/file.npz")


@pytest.mark.parametrize(
    ("selection", "said"),
    [
        ("", "no such set of captures; known: garza, hug_mp"),
        ("garza,", "no such set of captures"),
        ("mocap:1", "'mocap:1': no such set of captures"),
        ("garza:Nowhere", "'garza:Nowhere' selects no capture of garza"),
        ("garza:", "'garza:' selects no capture"),
        ("garza:ForwardHigh:retrun", "at most a target, then 'return' or 'all'"),
        ("garza:ForwardHigh:return:x", "at most a target, then"),
        ("garza:return:ForwardHigh", "at most a target, then"),
        ("hug_mp", "say whose reaches, such as hug_mp:S01"),
        ("hug_mp:S09", "selects no capture of hug_mp"),
        ("hug_mp:../S01", "selects no capture of hug_mp"),
        ("hug_mp:S01:some", "'all', or a repetition and R-TARGET"),
        ("hug_mp:S01:99:R-9", "selects no capture"),
        ("hug_mp:S01:2:R-99", "selects no capture"),
        ("hug_mp:S01:1:R-1:x", "say whose reaches"),
    ],
)
@pytest.mark.usefixtures("captures")
def test_what_selects_nothing_is_refused(selection: str, said: str) -> None:
    with pytest.raises(CaptureError, match=said) as caught:
        load_captures(selection)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_status == 2


def test_missing_captures_are_said_with_what_to_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ARMSYN_CAPTURES", str(tmp_path))
    for selection in ("garza", "hug_mp:S01"):
        with pytest.raises(CaptureError, match=f"{tmp_path}: set ARMSYN_CAPTURES"):
            load_captures(selection)


@pytest.fixture
def damaged(captures: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of captures to damage: the tables, and links to the motions."""
    shutil.copytree(captures / "segments", tmp_path / "segments")
    (tmp_path / "reach").symlink_to(captures / "reach")
    monkeypatch.setenv("ARMSYN_CAPTURES", str(tmp_path))
    assert captures_folder() == tmp_path
    return tmp_path


@pytest.mark.parametrize(
    ("name", "old", "new", "error", "said"),
    [
        ("garza", "BackFloor01,47,79,", "BackFloor01,47,,", FormatError, "no table of segments"),
        ("garza", "BackFloor01,47,79,", "BackFloor01,79,47,", CaptureError, "frames 79-47, not"),
        ("garza", "BackFloor01,47,79,", "BackFloor01,47,79000,", CaptureError, "not captured"),
        ("garza", "BackFloor01,47,79,", "BackFloor01,-4,79,", CaptureError, "not captured"),
        ("garza", "ReachBackFloor01.skm", "ReachMoon.skm", CaptureError, "not captured"),
        ("garza", "start_frame", "begin", FormatError, "no table of segments: 'start_frame'"),
        ("garza", "rest,BackFloor01,47", '"rest,BackFloor01,47', FormatError, "no table"),
        ("hug_mp", "S01,1,1,1,R", "S01,1,1,77,R", CaptureError, "not captured"),
        ("hug_mp", "S01,1,1,1,R", "S01,1,one,1,R", FormatError, "no table of segments"),
    ],
)
def test_tables_that_are_wrong_are_refused(
    damaged: Path, name: str, old: str, new: str, error: type[Exception], said: str
) -> None:
    path = damaged / "segments" / f"{name}.csv"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(error, match=said) as caught:
        load_captures("garza" if name == "garza" else "hug_mp:S01")
    assert "\n" not in str(caught.value)


def test_a_table_of_bytes_and_a_missing_one_are_refused(damaged: Path) -> None:
    path = damaged / "segments" / "garza.csv"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FormatError, match=r"garza\.csv: no table of segments"):
        load_captures("garza")
    path.unlink()
    with pytest.raises(FormatError, match=r"garza\.csv: no table of segments"):
        load_captures("garza")


def test_a_missing_file_of_motions_is_named(damaged: Path) -> None:
    (damaged / "reach").unlink()
    with pytest.raises(CaptureError, match=r"reach\.npz is missing from the captures"):
        load_captures("garza")
