"""Tables: the numbers that go in come out, in SI for programs and in centimetres for people."""

import json
from pathlib import Path

import pytest

from armsyn.errors import InputError
from armsyn.experiments.tables import Column, Report, Table, centimetres, percent, write

TABLE = Table(
    "Made up",
    (Column("model", "model"), centimetres("mean", "mean"), percent("change", "change")),
    [("S_A", 0.03791, None), ("S_C", 0.0136, -0.6413)],
    ["A note."],
)
REPORT = Report("made", "A report", {"seed": 3, "lambda_per_s": {"svd": 6.0}}, [TABLE], ["a.png"])


def test_programs_get_metres_and_shares_unrounded(tmp_path: Path) -> None:
    write(REPORT, tmp_path)
    document = json.loads((tmp_path / "made.json").read_text())
    assert document["schema"] == "armsyn-experiment-1"
    assert document["made_with"] == {"seed": 3, "lambda_per_s": {"svd": 6.0}}
    assert document["tables"][0]["rows"] == [
        {"model": "S_A", "mean_m": 0.03791, "change": None},
        {"model": "S_C", "mean_m": 0.0136, "change": -0.6413},
    ]


def test_people_get_centimetres_and_per_cent(tmp_path: Path) -> None:
    write(REPORT, tmp_path)
    assert (tmp_path / "made.md").read_text() == (
        "# A report\n\n"
        "## Made up\n\n"
        "| model | mean, cm | change |\n"
        "|-------|---------:|-------:|\n"
        "| S_A   |     3.79 |      - |\n"
        "| S_C   |     1.36 |   -64% |\n\n"
        "A note.\n\n"
        "![a.png](a.png)\n\n"
        "Made with: seed 3, lambda_per_s svd 6.0.\n"
    )


def test_a_row_without_a_value_a_column_is_a_slip() -> None:
    with pytest.raises(ValueError, match="zip"):
        Table("t", TABLE.columns, [("S_A", 1.0)]).as_dict()


def test_a_value_that_is_no_number_is_never_written(tmp_path: Path) -> None:
    table = Table("t", TABLE.columns, [("S_A", float("nan"), 0.0)])
    with pytest.raises(ValueError, match="JSON"):
        write(Report("made", "A report", {}, [table], []), tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot write it"):
        write(REPORT, tmp_path / "absent")
