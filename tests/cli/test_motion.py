"""`armsyn motion info` and `convert`, as a user meets them."""

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from armsyn.cli.motion import _COMMANDS, motion
from armsyn.motion.formats import read_body, read_motion, write_body, write_motion
from tests.cli.commands import refused_by, said_by
from tests.motion.seeds import body, markers, seeds

said, refused = partial(said_by, motion), partial(refused_by, motion)


@pytest.fixture
def files(tmp_path: Path) -> Path:
    write_body(tmp_path / "a.bvh", body())
    write_motion(tmp_path / "markers.npz", markers())
    for name, content in seeds().items():
        if name != "a.bvh":
            (tmp_path / name).write_bytes(content)
    return tmp_path


def test_help_lists_the_commands_with_their_own_words() -> None:
    for name, words in _COMMANDS.items():
        assert words in " ".join(said(name, "--help").split())
        assert words in " ".join(said("--help").split())


def test_info_says_what_is_in_a_file_and_what_was_assumed(files: Path) -> None:
    text = said("info", files / "a.bvh")
    for words in ("BVH", "unit: cm (assumed)", "up: y (assumed)", "4 frames", "50 Hz", "no gaps"):
        assert words in text
    assert "4 landmarks: hips, arm, hand, hand_end" in text
    text = said("info", files / "markers.npz")
    assert "1 gap:" in text
    assert "elbow: 1 frames in 1: 1-1, longest 0.020 s" in text


def test_info_as_json_is_one_document(files: Path) -> None:
    found = json.loads(said("info", files / "markers.npz", "--json"))
    assert found["format"] == "numpy archive"
    assert (found["frames"], found["landmarks"]) == (4, ["elbow", "hand"])
    assert found["rate_hz"] == pytest.approx(100)
    (gap,) = found["gaps"]
    assert gap == {"landmark": "elbow", "first": 1, "last": 1, "seconds": pytest.approx(0.02)}


def test_info_lists_the_motions_of_a_file_and_shows_one(files: Path) -> None:
    text = said("info", files / "a.mat")
    assert "2 motions" in text
    assert "1.1.2" in text
    assert json.loads(said("info", files / "a.mat", "--json"))["takes"] == ["1.1.1", "1.1.2"]
    for arguments in ((files / "a.mat", "--take", "1.1.2"), (f"{files / 'a.mat'}#1.1.2",)):
        assert "4 joints: shoulder_abduction" in said("info", *arguments)
    assert "no motion '9.9.9'" in refused("info", f"{files / 'a.mat'}#9.9.9")


def test_info_reads_tables_by_their_map(files: Path) -> None:
    text = said("info", files / "table.txt", "--columns", files / "columns.toml", "--up", "x")
    assert "1 joints: elbow" in text
    assert "up: x" in text


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_info_plots_speeds(files: Path, suffix: str) -> None:
    plot = files / f"speeds.{suffix}"
    said("info", files / "markers.npz", "--plot", plot, "--landmark", "hand")
    assert plot.stat().st_size > 2000
    assert "no 'tail' to plot" in refused(
        "info", files / "markers.npz", "--plot", plot, "--landmark", "tail"
    )


def test_plots_that_cannot_be_written_are_one_line(files: Path) -> None:
    assert "cannot write the plot" in refused(
        "info", files / "markers.npz", "--plot", files / "absent" / "a.png"
    )
    assert "cannot write the plot" in refused("info", files / "a.bvh", "--plot", files / "a.xyz")


def test_convert_fills_gaps_and_says_so(files: Path) -> None:
    out = files / "out.csv"
    document = json.loads(
        said("convert", files / "a.c3d", out, "--json", "--landmarks", "hand,elbow")
    )
    assert (document["gaps"], document["filled_positions"]) == (1, 0)
    assert read_motion(out).landmark_names == ("hand", "elbow")
    long = np.linspace(0, 1, 30)
    path = np.stack([long, long, long], axis=1)[:, None].copy()
    path[10] = np.nan
    write_motion(files / "long.npz", type(markers())(long, landmark_names=("a",), landmarks=path))
    text = said("convert", files / "long.npz", out, "--fill-gaps", 0.2)
    assert "1 positions filled in, 0 gaps" in text
    filled = read_motion(out)
    assert filled.filled is not None
    assert np.flatnonzero(filled.filled[:, 0]).tolist() == [10]
    np.testing.assert_allclose(filled.hand[10], long[10])
    assert "left out: marks of what was filled in" in said("convert", out, files / "out.trc")


def test_convert_resamples(files: Path) -> None:
    said("convert", files / "a.bvh", files / "out.csv", "--resample", 100)
    assert read_motion(files / "out.csv").rate == pytest.approx(100)


def test_convert_keeps_a_skeleton_when_asked(files: Path) -> None:
    said("convert", files / "a.amc", files / "out.bvh", "--skeleton", files / "skeleton.asf")
    again = read_body(files / "out.bvh")
    assert again.skeleton.names == ("root", "arm", "hand", "hand_end")
    said("convert", files / "out.bvh", files / "out.npz", "--body")
    np.testing.assert_allclose(
        read_body(files / "out.npz").positions(), again.positions(), atol=1e-9
    )
    text = said("convert", files / "out.bvh", files / "positions.npz")
    assert "left out: the skeleton's rotations (--body)" in text
    assert read_motion(files / "positions.npz").landmark_names == again.skeleton.names


def test_convert_says_which_markers_a_skeleton_leaves_out(files: Path) -> None:
    assert "left out: 1 markers" in said("convert", files / "golf.npz", files / "out.bvh")


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        (("info", "absent.bvh"), "absent.bvh: cannot read it"),
        (("info", "a.xlsx"), "no motion format has the suffix '.xlsx'"),
        (("info", "a.amc"), "a.amc: no skeleton"),
        (("info", "a.bvh", "--unit", "yard"), "unit 'yard'"),
        (("info", "a.bvh", "--rate", "-5"), "rate -5"),
        (("info", "a.bvh", "--landmark", "hand"), "give --plot"),
        (("info", "a.mat", "--plot", "a.png"), "holds 2 motions: name one"),
        (("info", "markers.npz", "--up", "z"), "give no options"),
        (("info", "body.npz", "--rate", "9"), "takes no option 'rate'"),
        (("convert", "markers.npz", "a.bvh"), "no skeleton in it"),
        (("convert", "a.bvh", "b.bvh", "--resample", "9"), "written as it is"),
        (("convert", "a.bvh", "b.bvh", "--fill-gaps", "0"), "written as it is"),
        (("convert", "a.bvh", "b.csv", "--body"), "no skeleton is written as this"),
        (("convert", "a.bvh", "b.c3d"), "use one of .csv, .lerobot, .mcap, .npz, "),
        (("convert", "a.bvh", "absent/b.csv"), "cannot write it"),
        (("convert", "a.bvh", "b.csv", "--landmarks", "hips,tail"), "no landmark 'tail'"),
        (("convert", "a.bvh", "b.csv", "--landmarks", "hips,hips"), "not unique"),
        (("convert", "a.bvh", "b.csv", "--fill-gaps", "-1"), "positive number of seconds"),
        (("convert", "a.bvh", "b.csv", "--resample", "0"), "positive rate"),
    ],
)
def test_bad_input_is_one_line(
    files: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], match: str
) -> None:
    monkeypatch.chdir(files)
    assert match in refused(*arguments)
