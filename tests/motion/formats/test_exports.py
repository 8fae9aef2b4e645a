"""What holds for every format of several motions: whole or not at all, and what is refused."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from armsyn.errors import FormatError, InputError
from armsyn.motion import Motion
from armsyn.motion.formats import EXPORTS, Episode, write_episodes, write_motion
from armsyn.motion.motion import LONGEST_STEP, SHORTEST_STEP
from tests.motion.formats.samples import contents, full_disk, motion, plan, recording

SUFFIXES = sorted(EXPORTS)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_motion_is_an_episode(tmp_path: Path, suffix: str) -> None:
    for folder in ("motion", "episode"):
        (tmp_path / folder).mkdir()
    write_motion(tmp_path / "motion" / f"a{suffix}", motion())
    write_episodes(tmp_path / "episode" / f"a{suffix}", [Episode(motion())])
    first, second = (contents(tmp_path / name / f"a{suffix}") for name in ("motion", "episode"))
    assert first == second
    assert first


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_full_disk_leaves_nothing(tmp_path: Path, suffix: str) -> None:
    out = tmp_path / f"a{suffix}"
    with (
        full_disk(20_000),
        pytest.raises(InputError, match=r"cannot write it: .*(large|space)"),
    ):
        write_episodes(out, (plan(number, 500) for number in range(40)))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_source_that_fails_leaves_nothing_and_spoils_nothing(tmp_path: Path, suffix: str) -> None:
    out = tmp_path / f"a{suffix}"

    def broken() -> Iterator[Motion]:
        yield motion()
        raise FormatError("third.npz: damaged")

    with pytest.raises(FormatError, match=r"^third\.npz: damaged$"):
        write_episodes(out, broken())
    assert not list(tmp_path.iterdir())
    if suffix != ".lerobot":
        out.write_bytes(b"what was there")
        with pytest.raises(FormatError):
            write_episodes(out, broken())
        assert out.read_bytes() == b"what was there"
        assert list(tmp_path.iterdir()) == [out]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_episodes_are_taken_one_by_one(tmp_path: Path, suffix: str) -> None:
    alive: set[int] = set()

    class Counted(Episode):
        def __del__(self) -> None:
            alive.discard(id(self))

    most = 0

    def many() -> Iterator[Episode]:
        nonlocal most
        for number in range(40):
            episode = Counted(motion(number, 5))
            alive.add(id(episode))
            most = max(most, len(alive))
            yield episode

    write_episodes(tmp_path / f"a{suffix}", many())
    assert most <= 4


@pytest.mark.parametrize(
    ("suffix", "package"),
    [(".lerobot", "pyarrow"), (".mcap", "rosbags.rosbag2"), (".parquet", "pyarrow")],
)
def test_a_missing_package_is_named_with_its_extra(
    tmp_path: Path, suffix: str, package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    monkeypatch.delitem(sys.modules, "armsyn.motion.formats.lerobot_tables", raising=False)
    with pytest.raises(FormatError, match=r"pip install 'armsyn\[formats\]'") as caught:
        write_motion(tmp_path / f"a{suffix}", motion())
    assert str(caught.value).startswith(f"{tmp_path / f'a{suffix}'}: ")
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_what_does_not_fit_together_is_refused(tmp_path: Path, suffix: str) -> None:
    out = tmp_path / f"a{suffix}"
    with pytest.raises(FormatError, match="no motion to write"):
        write_episodes(out, [])
    other = Motion(np.arange(3.0), ("knee",), np.zeros((3, 1)), source="a leg")
    with pytest.raises(
        FormatError, match=r"episode 1 \(a leg\) has the joints knee; the first has"
    ):
        write_episodes(out, [plan(), other])
    torn = Motion(np.arange(3.0), ("kn\nee",), np.zeros((3, 1)))
    with pytest.raises(FormatError, match=r"cannot write the name 'kn\\nee': rename it"):
        write_episodes(out, torn)
    with pytest.raises(InputError, match="cannot write it"):
        write_episodes(tmp_path / "absent" / f"a{suffix}", plan())
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", [".mcap", ".lerobot"])
def test_unknown_angles_are_refused(tmp_path: Path, suffix: str) -> None:
    angles = np.zeros((3, 2))
    angles[1, 1] = np.nan
    with pytest.raises(FormatError, match="gappy: angles of 'b' are not all known"):
        write_motion(
            tmp_path / f"a{suffix}", Motion(np.arange(3.0), ("a", "b"), angles, source="gappy")
        )
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_any_words_can_be_said(tmp_path: Path, suffix: str) -> None:
    """Those of a file whose name is no text, too."""
    base = motion()
    odd = Motion(base.time, base.joint_names, base.angles, source="caf\udce9 \0 \n 手.npz")
    episode = Episode(odd, "planned", 'say "hi" \ud800', facts={"é": "\udcff"})
    write_episodes(tmp_path / f"a{suffix}", episode)
    assert "caf? \0 \n 手.npz".encode() in b"".join(contents(tmp_path / f"a{suffix}").values()) or (
        suffix == ".mcap"
    )


@pytest.mark.parametrize("suffix", SUFFIXES)
@settings(deadline=None, max_examples=25)
@given(
    steps=st.lists(st.floats(SHORTEST_STEP, LONGEST_STEP), min_size=1, max_size=4),
    start=st.floats(-1e9, 1e9),
    angles=st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=5, max_size=5),
    kind=st.sampled_from(["planned", "recorded", "observed", "motion"]),
)
def test_any_motion_is_written_or_refused_in_one_line(
    tmp_path_factory: pytest.TempPathFactory,
    suffix: str,
    steps: list[float],
    start: float,
    angles: list[float],
    kind: Any,
) -> None:
    folder = tmp_path_factory.mktemp("any")
    time = start + np.concatenate([[0.0], np.cumsum(steps)])
    try:
        odd = Motion(time, ("a",), np.array(angles[: time.size])[:, None], source="odd")
    except FormatError:
        assume(False)
    commanded = np.full((time.size, 1), np.nan) if kind == "recorded" else None
    refusal = ""
    try:
        write_episodes(folder / f"a{suffix}", Episode(odd, kind, commanded=commanded))
    except FormatError as error:
        refusal = str(error)
    assert "\n" not in refusal
    assert [path.name for path in folder.iterdir()] == ([] if refusal else [f"a{suffix}"])


def test_no_optional_package_is_imported_before_it_is_needed() -> None:
    code = (
        "import sys, armsyn.motion.formats, armsyn.cli.motion_convert;"
        "print([name for name in ('pyarrow', 'rosbags', 'pandas', 'c3d') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_other_suffixes_hold_one_motion(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"use one of \.lerobot, \.mcap, \.parquet"):
        write_episodes(tmp_path / "a.csv", [plan()])


def test_an_episode_checks_its_parts() -> None:
    with pytest.raises(FormatError, match="kind 'dreamt'"):
        Episode(motion(), "dreamt")  # type: ignore[arg-type]
    with pytest.raises(FormatError, match="goes with kind 'recorded'"):
        Episode(motion(), "planned", commanded=np.zeros((30, 3)))
    with pytest.raises(FormatError, match="goes with kind 'recorded'"):
        Episode(motion(), "recorded")
    with pytest.raises(FormatError, match=r"velocity has shape \(30, 2\), expected \(30, 3\)"):
        Episode(motion(), velocity=np.zeros((30, 2)))
    assert recording().description()["simulated"] == "yes"
