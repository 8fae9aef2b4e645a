"""Scenarios: faults with their times, in a TOML file.

::

    seed = 7

    [[fault]]
    name = "crc-error"
    at = 2.0            # s since the simulator's start
    for = 1.5
    id = 3
    probability = 0.01
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, replace
from pathlib import Path

from firmware_sim.errors import FaultError
from firmware_sim.faults.argument import ArgumentError
from firmware_sim.faults.parsing import check_fault
from firmware_sim.faults.spec import FaultSpec
from firmware_sim.files import read_capped

FILE_SIZE_CAP = 1_000_000
"""Largest scenario, bytes."""

FAULT_CAP = 1000
"""Most faults in one scenario."""

SEED_CAP = 2**63 - 1
"""Largest seed: TOML's largest integer."""


class ScenarioError(FaultError):
    """A scenario is not one.

    Parameters
    ----------
    message : str
        One line.
    file : str
        The file.
    table : int
        Which ``[[fault]]`` table, counted from 1; 0 for the file as a whole.
    field : str
        Which field of it; empty for the table as a whole.
    """

    def __init__(self, message: str, file: str, table: int = 0, field: str = "") -> None:
        super().__init__(message, file)
        self.table = table
        self.field = field


@dataclass(frozen=True, slots=True)
class Scenario:
    """What a scenario file says.

    Parameters
    ----------
    faults : tuple of FaultSpec
        In the file's order.
    seed : int or None
        Of their chance; None where the file does not say.
    """

    faults: tuple[FaultSpec, ...]
    seed: int | None = None


def read_scenario(path: Path) -> Scenario:
    """Read a scenario file.

    Raises
    ------
    ScenarioError
        If it cannot be read, is too large, is no TOML, or a field is missing, unknown or
        impossible.
    """
    try:
        content = read_capped(path, FILE_SIZE_CAP)
    except OSError as error:
        raise ScenarioError(f"{path} cannot be read: {error.strerror}", str(path)) from error
    if len(content) > FILE_SIZE_CAP:
        raise ScenarioError(f"{path} is larger than {FILE_SIZE_CAP} bytes", str(path))
    return parse_scenario(content, str(path))


def parse_scenario(content: bytes, file: str) -> Scenario:
    """Return what the content of a scenario file says.

    Raises
    ------
    ScenarioError
        As `read_scenario`.
    """
    try:
        document = tomllib.loads(content.decode("utf-8"))
    except (ValueError, RecursionError) as error:  # bad TOML, bad UTF-8, a number too long
        reason = " ".join(str(error).split())[:200]
        raise ScenarioError(f"{file} is not TOML: {reason}", file) from error
    for field in document:
        if field not in ("seed", "fault"):
            raise ScenarioError(
                f"{file}: unknown field {field[:40]!r}; known are seed, fault", file, 0, field
            )
    tables = document.get("fault", [])
    if not isinstance(tables, list) or len(tables) > FAULT_CAP:
        raise ScenarioError(
            f"{file}: needs [[fault]] tables, at most {FAULT_CAP}", file, 0, "fault"
        )
    faults = tuple(_read_table(table, file, number) for number, table in enumerate(tables, 1))
    return Scenario(faults, _read_seed(document.get("seed"), file))


def check_seed(seed: int) -> int:
    """Return a seed.

    Raises
    ------
    FaultError
        If it is negative or too large.
    """
    if type(seed) is not int or not 0 <= seed <= SEED_CAP:
        raise FaultError(f"a seed goes from 0 to {SEED_CAP}, in whole numbers")
    return seed


def _read_seed(seed: object, file: str) -> int | None:
    if seed is None:
        return None
    if type(seed) is not int or not 0 <= seed <= SEED_CAP:
        raise ScenarioError(
            f"{file}: seed is not a whole number from 0 to {SEED_CAP}", file, 0, "seed"
        )
    return seed


def _read_table(table: object, file: str, number: int) -> FaultSpec:
    where = f"{file}: [[fault]] table {number}"
    if not isinstance(table, dict):
        raise ScenarioError(f"{where}: is not a table", file, number)
    arguments = {str(field): value for field, value in table.items()}
    name = arguments.pop("name", None)
    if not isinstance(name, str):
        raise ScenarioError(f"{where}: needs the field 'name', a text", file, number, "name")
    try:
        return replace(check_fault(name, arguments), source=where)
    except ArgumentError as error:
        raise ScenarioError(f"{where}: {error}", file, number, error.field) from None
