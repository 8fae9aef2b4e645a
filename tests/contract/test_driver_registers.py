"""The driver's registers and models against the tables that the vendor's SDK installs."""

from pathlib import Path

import dynamixel_easy_sdk
import pytest

from armsyn.driver import models
from armsyn.driver import registers as reg

TABLES = Path(dynamixel_easy_sdk.__path__[0]) / "control_table"
LOAD_INSTEAD_OF_CURRENT = {"Present Current": "Present Load"}
X_MODELS = [m.name for m in models.MODELS.values() if m.layout is reg.X and "mx" not in m.name]
REGISTERS = [
    reg.TORQUE_ENABLE,
    reg.GOAL_POSITION,
    reg.PRESENT_CURRENT,
    reg.PRESENT_VELOCITY,
    reg.PRESENT_POSITION,
    reg.BUS_WATCHDOG,
    reg.DRIVE_MODE,
]


def section(path: Path, title: str) -> list[list[str]]:
    """Rows of one section of a .model file, without its head."""
    lines = path.read_text().split(f"[{title}]", 1)[1].split("\n[", 1)[0].splitlines()
    return [line.split("\t") for line in lines[2:] if line.strip()]


def control_table(model: str) -> dict[str, tuple[int, int]]:
    rows = section(TABLES / f"{model.replace('-', '_')}.model", "control table")
    return {row[2].strip(): (int(row[0]), int(row[1])) for row in rows}


@pytest.mark.parametrize("model", X_MODELS)
@pytest.mark.parametrize("register", REGISTERS, ids=lambda register: register.name)
def test_address_and_size(model: str, register: reg.Register) -> None:
    table = control_table(model)
    name = register.name
    if models.servo_model(model).current_unit is None:
        name = LOAD_INSTEAD_OF_CURRENT.get(name, name)
    assert table[name] == (register.address, register.size)


@pytest.mark.parametrize(
    "model", [m for m in models.MODELS.values() if m.name in X_MODELS], ids=lambda model: model.name
)
def test_model_number(model: models.ServoModel) -> None:
    lines = (TABLES / "dynamixel.model").read_text().splitlines()[1:]
    files = {int(row[0]): row[1].strip() for row in map(str.split, filter(None, lines))}
    assert files[model.number] == f"{model.name.replace('-', '_')}.model"


@pytest.mark.parametrize("model", X_MODELS)
def test_velocity_unit_and_sign(model: str) -> None:
    rows = {r[0]: r[1:] for r in section(TABLES / f"{model.replace('-', '_')}.model", "unit info")}
    value, unit, sign = rows["Present Velocity"]
    assert float(value) == pytest.approx(models.VELOCITY_UNIT, rel=1e-3)
    assert (unit, sign.strip()) == ("rad/s", "signed")
    assert reg.PRESENT_VELOCITY.coding == "signed"


def test_one_read_holds_the_state_and_one_the_health() -> None:
    state = [reg.PRESENT_CURRENT, reg.PRESENT_VELOCITY, reg.PRESENT_POSITION]
    ends = [row.address + row.size for row in state]
    assert [row.address for row in state] == [reg.STATE_ADDRESS, *ends[:-1]]
    assert ends[-1] == reg.STATE_ADDRESS + reg.STATE_SIZE
    assert reg.HEALTH_ADDRESS + reg.HEALTH_SIZE == 71


@pytest.mark.parametrize(
    ("register", "value"),
    [(reg.GOAL_POSITION, -5), (reg.PRESENT_CURRENT, -1193), (reg.BUS_WATCHDOG, -1)],
)
def test_signed_values_survive(register: reg.Register, value: int) -> None:
    assert register.decode(register.encode(value)) == value


def test_a_value_that_does_not_fit_is_an_error() -> None:
    with pytest.raises(OverflowError):
        reg.TORQUE_ENABLE.encode(256)


def test_words_for_hardware_errors() -> None:
    assert reg.hardware_error_names(0x24) == "overheating, overload"
    assert reg.hardware_error_names(0x41) == "input voltage, unknown bits 0x40"
