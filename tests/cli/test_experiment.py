"""`armsyn experiment`: what it writes and says, and what it refuses before it learns."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from armsyn.experiments import EXPERIMENTS, fig3
from armsyn.experiments.tables import Column, Report, Table
from tests.cli.commands import Outcome

Call = Callable[..., Outcome]
TABLE = Table("Made up", (Column("model", "model"), Column("mean_m", "mean", ".1f")), [("S_A", 1)])
LONG = Table("Long", TABLE.columns, 50 * [("S_B", 2.0)])


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """Fig3 that learns nothing; what it was asked for."""
    asked: list[object] = []

    def run(settings: object, folder: Path, on_progress: Callable[..., None]) -> Report:
        asked.append(settings)
        on_progress("learning", 1, 1, "")
        (folder / "fig3.png").write_bytes(b"drawn")
        return Report("fig3", "A figure", {"seed": 7}, [TABLE, LONG], ["fig3.png"], ["A **note**."])

    monkeypatch.setattr(fig3, "run", run)
    return asked


def test_it_writes_tables_for_programs_and_people_and_says_where(
    call: Call, quick: list[object], tmp_path: Path
) -> None:
    out = tmp_path / "made" / "here"
    said = call(
        *("experiment", "fig3", "--out", out, "--seed", 7, "--budget", "small", "--workers", 1)
    )
    assert said.status == 0, said.err
    assert [vars(settings) for settings in quick] == [{"budget": "small", "seed": 7, "workers": 1}]
    files = ["fig3.json", "fig3.md", "fig3.png", "fig3.run.json"]
    assert sorted(file.name for file in out.iterdir()) == files
    for text in ("A note.", "Made up", "S_A", "1.0", "Long: 50 rows", "fig3.png"):
        assert text in said.out
    assert "S_B" not in said.out
    assert "S_B" in (out / "fig3.md").read_text()
    run = json.loads((out / "fig3.run.json").read_text())
    assert run["command"][:3] == ["armsyn", "experiment", "fig3"]


@pytest.mark.usefixtures("quick")
def test_json_is_one_document_the_same_as_the_file(call: Call, tmp_path: Path) -> None:
    said = call("experiment", "fig3", "--out", tmp_path, "--json")
    assert said.status == 0
    assert said.document == json.loads((tmp_path / "fig3.json").read_text())
    assert said.document["tables"][0]["rows"] == [{"model": "S_A", "mean_m": 1}]


def test_help_names_every_experiment(call: Call) -> None:
    said = call("experiment", "--help")
    for name, what in EXPERIMENTS.items():
        assert f"{name}: {what}" in " ".join(said.out.split())


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("fig7",), "is not one of 'fig3'"),
        (("fig3", "--budget", "huge"), "is not one of 'small', 'full'"),
        (("fig3", "--seed", "-1"), "is not in the range"),
        (("fig3", "--workers", "0"), "is not in the range"),
        (("fig3", "--out", "/proc/here"), "/proc/here: cannot write there"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_bad_input_is_refused(
    call: Call, tmp_path: Path, arguments: tuple[str, ...], said: str
) -> None:
    call("experiment", "--out", tmp_path, *arguments).refused(2, said)
    assert list(tmp_path.iterdir()) == []


def test_a_file_is_no_folder(call: Call, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    call("experiment", "fig3", "--out", tmp_path / "file").refused(2, "is a file")
    call("experiment", "fig3", "--out", tmp_path / "file" / "in").refused(2, "cannot write there")


def test_a_missing_place_to_write_is_asked_for(call: Call) -> None:
    call("experiment", "fig3").refused(2, "Missing option '--out'")


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_missing_captures_are_one_line(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setenv("ARMSYN_CAPTURES", str(tmp_path / "nowhere"))
    call("experiment", name, "--out", tmp_path).refused(2, "set ARMSYN_CAPTURES")
