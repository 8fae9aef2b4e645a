"""The tables behind set-up and backup: EEPROM rows and baud codes."""

import pytest

from armsyn.driver.eeprom import eeprom_rows
from armsyn.driver.models import MODELS, a_model, model_name, servo_model
from armsyn.driver.registers import LAYOUTS
from armsyn.driver.setup_plan import baud_code
from armsyn.errors import (
    DescriptionError,
)
from firmware_sim.tables import find_model


@pytest.mark.parametrize("layout", LAYOUTS, ids=lambda layout: layout.name)
def test_eeprom_rows_agree_with_the_simulators_tables(layout: object) -> None:
    """The simulator's tables are written apart, and themselves compared with the maker's."""
    models = [model for model in MODELS.values() if model.layout is layout]
    others = {
        "Secondary ID": "Secondary(Shadow) ID",
        "Operating Mode": "Control Mode",
        "Min Position Limit": "CW Angle Limit",
        "Max Position Limit": "CCW Angle Limit",
    }
    seen = set()
    for model in models:
        table = find_model(model.name, protocol=model.protocol).table
        rows = {row.name: row for row in table.registers}
        for row in eeprom_rows(model.layout):
            other = rows.get(row.name) or rows.get(others.get(row.name, ""))
            if other is not None:
                assert (row.address, row.size) == (other.address, other.size), row
                assert (row.coding == "signed") == other.signed, row
                seen.add(row.name)
        area = {r.name for r in table.registers if r.area.name == "EEPROM"}
        known = {row.address for row in eeprom_rows(model.layout)}
        assert {rows[name].address for name in area} <= known, model.name
    assert seen


@pytest.mark.parametrize(
    ("model", "protocol", "baud", "code"),
    [
        ("xm430-w350", 2, 4_500_000, 7),
        ("xm430-w350", 2, 57_600, 1),
        ("xl-320", 2, 1_000_000, 3),
        ("ax-12a", 1, 1_000_000, 1),
        ("ax-12a", 1, 57_600, 34),
        ("ax-12a", 1, 9_600, 207),
        ("mx-28", 1, 2_250_000, 250),
        ("mx-28", 1, 3_000_000, 252),
    ],
)
def test_baud_codes_of_the_manual(model: str, protocol: int, baud: int, code: int) -> None:
    assert baud_code(servo_model(model, protocol), baud) == code


@pytest.mark.parametrize(
    ("model", "protocol", "baud"),
    [
        ("xm430-w350", 2, 500_000),
        ("xl-320", 2, 2_000_000),
        ("ax-12a", 1, 3_000_000),
        ("ax-12a", 1, 4_500_000),
        ("mx-28", 1, 4_500_000),
    ],
)
def test_rates_that_a_model_lacks_are_refused(model: str, protocol: int, baud: int) -> None:
    with pytest.raises(DescriptionError, match="no baud rate"):
        baud_code(servo_model(model, protocol), baud)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("xm430-w350", "an xm430-w350"),
        ("ax-12a", "an ax-12a"),
        ("mx-28", "an mx-28"),
        ("2xl430-w250", "a 2xl430-w250"),
        ("unknown", "an unknown model"),
        (model_name(4711), "model number 4711"),
    ],
)
def test_models_have_their_article(name: str, said: str) -> None:
    assert a_model(name) == said
