"""The simulator's access, initial values and ranges against those that the maker's pages print.

Oracle: ``tests/data/manual_control_tables.csv``, the rows of the e-Manual's control tables, copied
from the pages (ROBOTIS-GIT/emanual at the commit that each row names, docs/en/dxl; XH430-V350 and
XH540-V270: docs/kr/dxl, whose states are fuller) without looking at the simulator's. An empty cell
is one that the page leaves empty or prints as a dash; ``@44`` stands for what register 44 has, as
in "-Velocity Limit(44) ~ Velocity Limit(44)". Where a page has two ranges for two kinds of profile,
the first is there. Of indirect registers the pages print some. The pages of AX and MX print no
ranges. X330 pages are those of firmware 52 and below.
"""

import csv
from collections import Counter
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

from firmware_sim.firmware.control_table import Register
from firmware_sim.firmware.model import ServoModel
from firmware_sim.tables import MODEL_NAMES, find_model

DATA = Path(__file__).parents[1] / "data" / "manual_control_tables.csv"
FIELDS = ("access", "default", "minimum", "maximum")
X330_FIRMWARE = 52


class Difference(NamedTuple):
    """What a page prints and the simulator has otherwise."""

    register: str
    field: str
    page: str | int
    ours: str | int


# Where the simulator does not do as a page's table says: how many models, and why.
DIFFERENCES = {
    Difference("Bus Watchdog", "minimum", 1, 0): (
        31,
        'Initial value and off: 0 (section "Bus Watchdog(98)")',
    ),
    Difference("Secondary(Shadow) ID", "maximum", 252, 255): (
        31,
        'The initial value is 255: off (section "Secondary(Shadow) ID(12)": 253 and above)',
    ),
    Difference("Goal Position", "minimum", 0, -1_048_575): (
        31,
        'In extended position mode (section "Goal Position(116)"); the limits count in the other',
    ),
    Difference("Goal Position", "maximum", 4095, 1_048_575): (31, "The same"),
    Difference("Drive Mode", "maximum", 5, 13): (
        15,
        'Bit 3, torque on by goal update (section "Drive Mode(10)"); newer pages print 13',
    ),
    Difference("Drive Mode", "maximum", 5, 15): (
        5,
        "The same, and bit 1, slave of a dual joint; newer pages print 15",
    ),
    Difference("Model Number", "default", 1000, 1001): (
        1,
        "XD430-T350: the page has the number of XH430-W350; the SDK 1001",
    ),
    Difference("Protocol Type", "default", 1, 2): (
        2,
        'XW430: the page\'s own section "Protocol Type(13)" has 2, as all other pages',
    ),
    Difference("Indirect Data 19", "maximum", 225, 255): (
        4,
        "XC330: a slip, the other rows have 255",
    ),
    Difference("Indirect Data 20", "maximum", 225, 255): (4, "The same"),
}


@cache
def rows() -> list[dict[str, str]]:
    with DATA.open(newline="") as file:
        return list(csv.DictReader(file))


@cache
def model_of(name: str, protocol: int) -> ServoModel:
    if name.startswith("mx-"):
        return find_model(name, protocol=protocol)
    return find_model(name, X330_FIRMWARE if name[2:5] == "330" else None)


def printed(row: dict[str, str], field: str, model: ServoModel) -> str | int | None:
    """Return what the page says of a register, None for nothing."""
    text = row[field]
    if field == "access" or not text:
        return text or None
    sign, _, address = text.partition("@")
    if not address:
        return int(text)
    other = model.table.by_address[int(address)]
    # Either end of a goal's range is the limit's largest value; of a position's, that of its own.
    bound = field if other.name.endswith("Position Limit") or field == "default" else "maximum"
    return int(f"{sign}{value(other, bound)}")


def value(register: Register, field: str) -> str | int:
    found: str | int = register.access.value if field == "access" else getattr(register, field)
    return found


def differences(name: str, protocol: int) -> list[Difference]:
    model = model_of(name, protocol)
    found = []
    for row in rows():
        if (row["model"], int(row["protocol"])) == (name, protocol):
            register = model.table.by_address[int(row["address"])]
            for field in FIELDS:
                page, ours = printed(row, field, model), value(register, field)
                if page is not None and page != ours:
                    found.append(Difference(register.name, field, page, ours))
    return found


PAGES = sorted({(row["model"], int(row["protocol"])) for row in rows()})


@pytest.mark.parametrize(("name", "protocol"), PAGES)
def test_access_initial_values_and_ranges_are_those_of_the_page(name: str, protocol: int) -> None:
    assert [found for found in differences(name, protocol) if found not in DIFFERENCES] == []


def test_each_difference_is_there_and_has_a_reason() -> None:
    counted = Counter(found for page in PAGES for found in differences(*page))
    assert counted == {found: count for found, (count, _reason) in DIFFERENCES.items()}


def test_every_model_has_its_page_and_every_register_its_row() -> None:
    assert {name for name, _ in PAGES} == set(MODEL_NAMES)
    for name, protocol in PAGES:
        addresses = {
            int(r["address"])
            for r in rows()
            if (r["model"], int(r["protocol"])) == (name, protocol)
        }
        model = model_of(name, protocol)
        unseen = {
            r.name
            for r in model.table.registers
            if r.address not in addresses and not r.name.startswith("Indirect ")
        }
        assert not unseen, name
