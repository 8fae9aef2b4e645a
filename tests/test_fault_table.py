"""The table of faults against the tests that carry their numbers (``@pytest.mark.fault(12)``)."""

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

TESTS = Path(__file__).resolve().parent
TABLE = TESTS.parent / "armsyn" / "driver" / "faults.md"
ROWS = range(1, 44)
NOT_BUILT = {39}
"""The browser view."""


def marked() -> dict[int, set[str]]:
    """Row of the table to the tests that are marked with it, as ``path::name``."""
    found: dict[int, set[str]] = defaultdict(set)
    for path in TESTS.rglob("test_*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef):
                for row in fault_rows(node):
                    found[row].add(f"{path.relative_to(TESTS)}::{node.name}")
    return found


def fault_rows(node: ast.FunctionDef) -> Iterator[int]:
    for decorator in node.decorator_list:
        if isinstance(decorator, ast.Call) and ast.unparse(decorator.func) == "pytest.mark.fault":
            for argument in decorator.args:
                yield ast.literal_eval(argument)


def listed() -> dict[int, set[str]]:
    """Row of the table to the tests it names."""
    rows = re.findall(r"^\| (\d+) \|(.*)\|$", TABLE.read_text(encoding="utf-8"), re.MULTILINE)
    return {int(number): set(re.findall(r"`(\S+::\w+)`", text)) for number, text in rows}


def test_every_fault_has_a_row_and_every_row_that_is_built_a_test() -> None:
    table = listed()
    assert list(table) == list(ROWS)
    assert {row for row, tests in table.items() if not tests} == NOT_BUILT


def test_the_table_names_exactly_the_marked_tests() -> None:
    tests = marked()
    for row, named in listed().items():
        assert named == tests.get(row, set()), f"row {row}"
    assert set(tests) <= set(ROWS)
