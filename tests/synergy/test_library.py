"""The synergies file: what comes back, what is refused, and what is looked up in it."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.errors import DescriptionError, InputError
from armsyn.synergy import LearnedReach, SynergyLibrary, SynergySet, load_library
from armsyn.synergy import library as room
from armsyn.synergy.library import save_library

JOINTS = ("shoulder", "elbow")
SIZES = {"A": 1, "B": 2, "C": 4, "D": 6}


def learned(model: str = "C", misfit: str = "", ik: str = "svd", value: float = 1.5) -> SynergySet:
    return SynergySet(ik, model, (value,) * SIZES[model], 0.02, 0.9, misfit)


def reach(
    name: str,
    *sets: SynergySet,
    target: tuple[float, float, float] = (0.3, 0.0, 0.0),
    start: tuple[float, float, float] = (0.0, 0.0, -0.5),
) -> LearnedReach:
    profile = tuple(np.round(np.sin(np.linspace(0, np.pi, 101)), 4).tolist())
    return LearnedReach(name, "reach", "made", start, target, 1.2, 0.001, profile, sets)


def library(*reaches: LearnedReach, **changed: Any) -> SynergyLibrary:
    fields: dict[str, Any] = {
        "schema": "armsyn-synergies-1",
        "arm": "planar",
        "joint_names": JOINTS,
        "captures": "made:all",
        "inputs_sha256": "0" * 64,
        "seed": 3,
        "rate_hz": 120.0,
        "lambdas": {"svd": 10.0},
        "stable_gains": True,
        "complete": True,
        "reaches": reaches,
        "left_out": {"made:bad": "a gap"},
    }
    return SynergyLibrary(**fields | changed)


@pytest.mark.parametrize("count", [0, 1, 3])
def test_what_is_saved_comes_back(tmp_path: Path, count: int) -> None:
    made = library(*(reach(f"made:{i}", learned(), learned("A")) for i in range(count)))
    path = tmp_path / "planar.synergies.json"
    save_library(path, made)
    assert load_library(path) == made
    assert [child.name for child in tmp_path.iterdir()] == [path.name]
    assert json.loads(path.read_text())["schema"] == "armsyn-synergies-1"
    lines = path.read_text().splitlines()
    assert sum('"name"' in line for line in lines) == count  # a reach a line


@given(text=st.text(max_size=40), number=st.floats(-1e6, 1e6))
def test_any_text_and_number_comes_back(text: str, number: float) -> None:
    made = library(reach(text, learned(value=number)), captures=text + '"reaches": []')
    raw = saved_bytes(made)
    assert msgspec.json.decode(raw, type=SynergyLibrary) == made


def saved_bytes(made: SynergyLibrary) -> bytes:
    """Return what `save_library` writes."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "made.json"
        save_library(path, made)
        return path.read_bytes()


def refused(path: Path, said: str) -> None:
    with pytest.raises(DescriptionError, match=said) as caught:
        load_library(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)
    assert caught.value.exit_status == 2


def test_a_half_written_file_is_refused_at_every_length(tmp_path: Path) -> None:
    whole = saved_bytes(library(reach("made:one", learned())))
    path = tmp_path / "half.json"
    end = len(whole.rstrip())
    for length in [*range(0, 200), *range(200, end, 37), end - 1]:
        path.write_bytes(whole[:length])
        refused(path, "learn it again with armsyn learn")


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"[]",
        b"null",
        b"\x89PNG\r\n\x1a\n\x00\xff",
        b"[" * 100_000,
        b'{"schema": ' + b"[" * 100_000,
        b'{"schema": "armsyn-synergies-2"}',
        b'{"schema": "armsyn-arm-1", "name": "human7"}',
        b"schema = 'toml'",
        b'{"arm": "\xff\xfe"}',
    ],
    ids=lambda content: repr(content[:24]),
)
def test_foreign_files_are_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "foreign.json"
    path.write_bytes(content)
    refused(path, "learn it again with armsyn learn")


def _set(document: dict[str, Any], **values: Any) -> None:
    document["reaches"][0]["sets"][0].update(values)


EDITS: dict[str, tuple[Callable[[dict[str, Any]], object], str]] = {
    "unknown field": (lambda d: d.update(extra=1), "unknown field `extra`"),
    "missing field": (lambda d: d.pop("seed"), "missing required field `seed`"),
    "wrong type": (lambda d: d.update(seed="3"), r"Expected `int`.*\$\.seed"),
    "NaN as null": (lambda d: _set(d, speed_r=None), "Expected `float`"),
    "too many parameters": (
        lambda d: _set(d, parameters=[1.0] * 5),
        "has 5 parameters, expected 4",
    ),
    "another model's": (lambda d: _set(d, model="A"), "svd/A has 4 parameters, expected 1"),
    "unknown model": (lambda d: _set(d, model="Z"), "no synergy model 'Z'"),
    "a short profile": (lambda d: d["reaches"][0].update(speed_profile=[1.0]), "101 numbers"),
    "no lambda": (lambda d: d.update(lambdas={"jt": 60.0}), "no positive rate for svd"),
    "lambda 0": (lambda d: d.update(lambdas={"svd": 0.0}), "no positive rate for svd"),
    "kind": (lambda d: d["reaches"][0].update(kind="jump"), "Invalid enum value 'jump'"),
}


@pytest.mark.parametrize("edit", EDITS)
def test_wrong_fields_are_named(tmp_path: Path, edit: str) -> None:
    change, said = EDITS[edit]
    document = json.loads(saved_bytes(library(reach("made:one", learned()))))
    change(document)
    path = tmp_path / "edited.json"
    path.write_text(json.dumps(document))
    refused(path, said)


def test_a_number_too_great_is_refused(tmp_path: Path) -> None:
    text = saved_bytes(library(reach("made:one", learned()))).decode()
    path = tmp_path / "great.json"
    path.write_text(text.replace("1.5", "1e999", 1))
    refused(path, "learn it again")


def test_absent_huge_and_unreadable_files_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    refused(tmp_path / "absent.json", "No such file")
    refused(tmp_path, "Is a directory")
    path = tmp_path / "huge.json"
    path.write_bytes(b" " * 2000)
    monkeypatch.setattr(room, "MAXIMUM_BYTES", 1000)
    refused(path, "larger than 1000 bytes")


def test_a_file_is_replaced_whole_or_not_at_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "planar.synergies.json"
    first = library(reach("made:first", learned()))
    save_library(path, first)

    def full(*_: object) -> int:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", full)
        with pytest.raises(InputError, match="No space left on device"):
            save_library(path, library())
    assert load_library(path) == first
    with pytest.raises(TypeError):
        save_library(path, library(left_out={"bad": object()}))
    assert load_library(path) == first
    assert [child.name for child in tmp_path.iterdir()] == [path.name]


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent/x\.json"):
        save_library(tmp_path / "absent" / "x.json", library())


@given(seed=st.integers(0, 999))
def test_the_nearest_comes_first(seed: int) -> None:
    """Near is the distance of targets and starts together, added in squares."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(12, 6)).tolist()
    made = library(
        *(
            reach(str(i), learned(), start=tuple(point[:3]), target=tuple(point[3:]))
            for i, point in enumerate(points)
        )
    )
    start, target = rng.normal(size=(2, 3))
    found = [int(near.name) for near, _ in made.nearest(start, target, "svd", "C")]
    gaps = np.linalg.norm(np.array(points) - np.concatenate([start, target]), axis=1)
    assert found == np.argsort(gaps).tolist()


START, TARGET = np.array([0.0, 0.0, -0.5]), np.array([0.3, 0.0, 0.0])


def names(made: SynergyLibrary, model: str) -> list[str]:
    found = made.nearest(START, TARGET, "svd", model)
    assert all((s.ik, s.model) == ("svd", model) for _, s in found)
    return [near.name for near, _ in found]


def test_only_sets_that_fit_are_used() -> None:
    good, bad = learned(), learned(misfit="2 peaks of hand speed")
    made = library(reach("good", good), reach("bad", bad), reach("none"))
    assert names(made, "C") == ["good"]


def test_sets_that_never_follow_speed_go_by_their_reachs_s_c() -> None:
    poor = "speed correlation -0.20"
    made = library(
        reach("good C", learned(), learned("A", poor), learned("B", poor)),
        reach("bad C", learned(misfit=poor), learned("A")),
        reach("no C", learned("A")),
        reach("no C, poor", learned("A", poor)),
    )
    assert names(made, "A") == ["good C", "no C"]
    assert names(made, "B") == ["good C"]


def test_s_d_is_judged_by_itself() -> None:
    made = library(
        reach("good D", learned(misfit="slow"), learned("D")),
        reach("bad D", learned(), learned("D", "2 peaks of hand speed")),
    )
    assert names(made, "D") == ["good D"]


@pytest.mark.parametrize(("ik", "model"), [("jt", "C"), ("svd", "D")])
def test_what_was_not_learned_is_said_with_what_was(ik: str, model: str) -> None:
    made = library(reach("one", learned(), learned("A")))
    with pytest.raises(InputError, match=f"--ik {ik} --model {model}, only svd/A, svd/C"):
        made.nearest(START, TARGET, ik, model)
    with pytest.raises(InputError, match=r"has learned nothing with .*: run armsyn learn"):
        library().nearest(START, TARGET, ik, model)


def test_what_was_learned_in_vain_is_said_so() -> None:
    made = library(reach("one", learned(misfit="slow")), reach("two", learned(misfit="slow")))
    with pytest.raises(InputError, match="none of the 2 reaches that planar learned with svd/C"):
        made.nearest(START, TARGET, "svd", "C")


def test_a_set_becomes_gains_and_sigmoid() -> None:
    made = library(reach("one", learned()))
    synergy = made.synergy(SynergySet("svd", "C", (1.0, 2.0, 3.0, 4.0), 0.1, 0.9))
    assert [part.tolist() for part in synergy] == [[[1.0, 2.0]], [[4.0]], [[3.0]]]
