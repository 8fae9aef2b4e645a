"""`armsyn motion convert` of chunks of `armsyn generate`: the same reaches from every format."""

import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from armsyn.arm import load_arm
from armsyn.cli.long_work import StageBars
from armsyn.cli.motion_convert import convert
from armsyn.motion.formats import read_body
from armsyn.planning.generation.batch import Batch
from armsyn.planning.generation.files import FORMATS
from armsyn.planning.pacing import Paced
from tests.cli.commands import refused_by, said_by

ARM, TASK = "koch", "touch the lamp"
KINDS = ("npz", "csv", "parquet")
CHANGED = {"evened", "swivel_m"}
"""Facts that a chunk in CSV has not."""
INDICES = (4, 5, 7)
FRAMES = (20, 30, 25)

said, refused = partial(said_by, convert), partial(refused_by, convert)


def batch() -> Batch:
    """Three reaches, the second of which was changed."""
    random, arm = np.random.default_rng(3), load_arm(ARM, calibrated=False)
    first = np.array([0, *np.cumsum(FRAMES)])
    paths = arm.rest + np.cumsum(random.normal(0, 1e-3, (first[-1], len(arm.rest))), axis=0)
    three = np.ones(3)
    return Batch(
        index=np.array(INDICES),
        targets=random.normal(0, 0.2, (3, 3)),
        hands=random.normal(0, 0.2, (3, 3)),
        durations=three,
        outside=0 * three,
        paced=Paced(paths, first, three, 100.0),
        evened=np.array([0.0, 0.25, 0.0]),
        swivels=np.array([0.0, 0.03, 0.0]),
        turned=np.nan * three,
        changed=(),
        refused=(),
    )


@pytest.fixture
def chunks(tmp_path: Path) -> dict[str, Path]:
    """The same reaches in every format that is read back."""
    arm = load_arm(ARM, calibrated=False)
    found = {}
    for kind in KINDS:
        suffix, write = FORMATS[kind]
        found[kind] = tmp_path / f"reaches{suffix}"
        write(found[kind], batch(), arm, TASK)
    return found


def bag(path: Path) -> list[tuple[dict[str, Any], np.ndarray]]:
    """What is said of every episode, and its trajectory."""
    facts, paths = [], []
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for decoded in reader.iter_decoded_messages(topics=["/episode", "/joint_trajectory"]):
            message = decoded.decoded_message
            if decoded.channel.topic == "/episode":
                facts.append(json.loads(message.data))
            else:
                paths.append(np.array([list(point.positions) for point in message.points]))
    return list(zip(facts, paths, strict=True))


@pytest.mark.parametrize("kind", KINDS)
def test_reaches_become_the_same_bag(chunks: dict[str, Path], kind: str, tmp_path: Path) -> None:
    assert "3 episodes (3 planned)" in said(chunks[kind], tmp_path / "a.mcap")
    made = batch()
    for row, (facts, path) in enumerate(bag(tmp_path / "a.mcap")):
        target = facts.pop("target_m")
        np.testing.assert_allclose(target, made.targets[row], rtol=1e-9)
        np.testing.assert_allclose(path, made.paced.path(row), rtol=1e-9)
        changed = {key: facts.pop(key) for key in CHANGED & facts.keys()}
        has = row == 1 and kind != "csv"
        assert changed == ({"evened": "0.25", "swivel_m": "0.0300"} if has else {})
        assert facts == {
            "episode": row,
            "frames": FRAMES[row],
            "kind": "planned",
            "action": "the plan: nothing was driven or measured",
            "source": f"reach {INDICES[row]}, planned for {ARM}",
            "arm": ARM,
            "reach": str(INDICES[row]),
            "task": TASK,
        }


@pytest.mark.parametrize(
    ("kinds", "shown"),
    [
        (
            ("npz", "parquet"),
            [(0, 2, "1 episode"), (0, 2, "2 episodes"), (0, 2, "3 episodes"), (1, 2, "3 episodes")]
            + [(1, 2, f"{count} episodes") for count in (4, 5, 6)]
            + [(2, 2, "6 episodes")],
        ),
        (("csv",), [(0, 1, "2 episodes"), (0, 1, "3 episodes"), (1, 1, "3 episodes")]),
    ],
)
def test_progress_counts_files_for_how_many_reaches_they_have_is_not_known(
    chunks: dict[str, Path],
    kinds: tuple[str, ...],
    shown: list[tuple[int, int, str]],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    updates = []
    monkeypatch.setattr(StageBars, "update", lambda _, *update: updates.append(update))
    for out in ("a.mcap", "a.lerobot"):
        updates.clear()
        said(*(chunks[kind] for kind in kinds), tmp_path / out)
        assert updates == [("files", *each) for each in shown]


@pytest.mark.parametrize("kind", KINDS)
def test_reaches_become_the_same_dataset(
    chunks: dict[str, Path], kind: str, tmp_path: Path
) -> None:
    out = tmp_path / "a.lerobot"
    assert "3 episodes (3 planned)" in said(chunks[kind], out)
    assert json.loads((out / "meta/info.json").read_text())["robot_type"] == ARM
    origin = json.loads((out / "meta/armsyn.json").read_text())
    assert origin["episodes_of_kind"] == {"planned": 3}
    assert origin["interpolated_episodes"] == 0
    episodes = pq.read_table(out / "meta/episodes/chunk-000/file-000.parquet")
    assert set(episodes["armsyn/kind"].to_pylist()) == {"planned"}
    assert episodes["tasks"].to_pylist() == [[TASK]] * 3
    made = batch()
    frames = pq.read_table(out / "data/chunk-000/file-000.parquet")
    states = np.radians(np.array(frames["observation.state"].to_pylist()))
    np.testing.assert_allclose(states, made.paced.paths, atol=1e-6)
    targets = np.array(frames["observation.environment_state"].to_pylist())
    np.testing.assert_allclose(targets, np.repeat(made.targets, FRAMES, axis=0), atol=1e-6)


def test_npz_and_parquet_become_the_same_bytes(chunks: dict[str, Path], tmp_path: Path) -> None:
    for kind in ("npz", "parquet"):
        (tmp_path / kind).mkdir()
        said(chunks[kind], tmp_path / kind / "a.mcap")
        said(chunks[kind], tmp_path / kind / "a.parquet")
    for name in ("a.mcap", "a.parquet"):
        assert (tmp_path / "npz" / name).read_bytes() == (tmp_path / "parquet" / name).read_bytes()
    assert (tmp_path / "npz/a.parquet").read_bytes() == chunks["parquet"].read_bytes()


@pytest.mark.parametrize("kind", KINDS)
def test_a_reach_knows_its_arm_and_says_what_it_loses(
    chunks: dict[str, Path], kind: str, tmp_path: Path
) -> None:
    take = chunks[kind].name + ("#0" if kind == "parquet" else f"#{INDICES[0]}")
    text = said(chunks[kind].with_name(take), tmp_path / "a.bvh")
    assert "left out: the target, the arm's name, the task" in text
    chain = load_arm(ARM, calibrated=False).chain
    expected = chain.positions(batch().paced.path(0))
    assert np.abs(read_body(tmp_path / "a.bvh").positions()[:, 1:-1] - expected).max() < 1e-6


def older(path: Path) -> Path:
    """The chunk as it was before it said arm, task and target."""
    if path.suffix == ".npz":
        with np.load(path) as archive:
            kept = {key: archive[key] for key in archive if key not in ("arm", "task", "target_m")}
        np.savez(path, **kept)
    else:
        lines = [
            line for line in path.read_text().splitlines() if line[:6] not in ("# arm:", "# task")
        ]
        path.write_text("".join(",".join(line.split(",")[: 2 + 5]) + "\n" for line in lines))
    return path


@pytest.mark.parametrize("kind", ["npz", "csv"])
def test_chunks_that_do_not_say_are_plans_all_the_same(
    chunks: dict[str, Path], kind: str, tmp_path: Path
) -> None:
    older(chunks[kind])
    assert "3 episodes (3 planned)" in said(chunks[kind], tmp_path / "a.mcap")
    facts, path = bag(tmp_path / "a.mcap")[0]
    assert not {"arm", "target_m"} & facts.keys()
    assert (facts["kind"], facts["task"]) == ("planned", "")
    assert facts["source"] == f"{chunks[kind].name}#{INDICES[0]}"
    np.testing.assert_allclose(path, batch().paced.path(0), rtol=1e-9)


@pytest.mark.parametrize("task", ["a\nb \t c", "say " * 1000])
@pytest.mark.parametrize("kind", KINDS)
def test_any_task_is_kept(kind: str, task: str, tmp_path: Path) -> None:
    suffix, write = FORMATS[kind]
    path = tmp_path / f"reaches{suffix}"
    write(path, batch(), load_arm(ARM, calibrated=False), task)
    said(path, tmp_path / "a.mcap")
    found = bag(tmp_path / "a.mcap")[0][0]["task"]
    assert found == (" ".join(task.split()) if kind == "csv" else task)


@pytest.mark.parametrize("value", ["nan", "inf", "", "here"])
def test_a_damaged_target_in_csv_is_one_line(
    chunks: dict[str, Path], value: str, tmp_path: Path
) -> None:
    path = chunks["csv"]
    lines = path.read_text().splitlines()
    path.write_text("".join(f"{line.rpartition(',')[0]},{value}\n" for line in lines[4:]))
    path.write_text("\n".join(lines[:4]) + "\n" + path.read_text())
    assert "reaches.csv: reach 4: " in refused(path, tmp_path / "a.mcap")


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("target_m", np.zeros((2, 3))),
        ("target_m", np.full((3, 3), np.nan)),
        ("evened", np.zeros(4)),
        ("swivel_m", np.array(["a", "b", "c"])),
        ("arm", np.zeros(3)),
        ("task", np.array(["a", "b"])),
    ],
)
def test_what_does_not_fit_in_npz_is_one_line(
    chunks: dict[str, Path], key: str, value: np.ndarray, tmp_path: Path
) -> None:
    path = chunks["npz"]
    with np.load(path) as archive:
        np.savez(path, **(dict(archive) | {key: value}))
    assert "reaches.npz: " in refused(path, tmp_path / "a.mcap")
