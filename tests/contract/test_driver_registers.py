"""The driver's registers and models against tables that others have written down.

Oracles: for the X series, MX with Protocol 2.0 and XL-320 the ``.model`` files that the vendor's
SDK installs; for AX and MX with Protocol 1.0 rustypot's register lists; for all of them the pages'
rows in ``tests/data/manual_control_tables.csv``. None of them says which registers are signed:
that is rustypot's, too, and the simulator's, which is written apart.
"""

import csv
from functools import cache
from pathlib import Path

import dynamixel_easy_sdk
import pytest
import rustypot

from armsyn.arm import calibration_of, load_arm
from armsyn.arm.calibration import radians_per_tick
from armsyn.driver import models
from armsyn.driver import registers as reg
from armsyn.driver.models import ServoModel
from firmware_sim.firmware.control_table import Area
from firmware_sim.tables import MODEL_NAMES, find_model

TABLES = Path(dynamixel_easy_sdk.__path__[0]) / "control_table"
MANUAL = Path(__file__).parents[1] / "data" / "manual_control_tables.csv"
NEW = [m for m in models.MODELS.values() if m.protocol == 2]
OLD = [m for m in models.MODELS.values() if m.protocol == 1]
NOT_LISTED = {"xw430-t200"}
"""Models whose number the SDK does not know."""

SDK_NAMES = {
    "Secondary ID": "Secondary(Shadow) ID",
    "Protocol Type": "Protocol Type",
    "Goal PWM": "Goal PWM",
}
XL320_NAMES = {
    "Min Position Limit": "CW Angle Limit",
    "Max Position Limit": "CCW Angle Limit",
    "Operating Mode": "Control Mode",
    "Temperature Limit": "Temperature Limit",
    "Position D Gain": "D Gain",
    "Position I Gain": "I Gain",
    "Position P Gain": "P Gain",
    "Present Velocity": "Present Speed",
    "Present Input Voltage": "Present Voltage",
}
CLASSIC_NAMES = XL320_NAMES | {
    "Min Position Limit": "cw_angle_limit",
    "Max Position Limit": "ccw_angle_limit",
    "Baud Rate": "baudrate",
}
LOAD_INSTEAD_OF_CURRENT = {"Present Current": "Present Load"}
NO_CURRENT = {"Current Limit", "Goal Current", "Present Current"}


def names(rows: list[ServoModel]) -> list[str]:
    return [f"{model.name} {model.protocol}.0" for model in rows]


def section(path: Path, title: str) -> list[list[str]]:
    """Rows of one section of a .model file, without its head."""
    lines = path.read_text().split(f"[{title}]", 1)[1].split("\n[", 1)[0].splitlines()
    return [line.split("\t") for line in lines[2:] if line.strip()]


def model_file(model: str) -> Path:
    name = "xl320" if model == "xl-320" else model.replace("-", "_")
    return TABLES / f"{name}.model"


@cache
def sdk_table(model: str) -> dict[str, tuple[int, int]]:
    rows = section(model_file(model), "control table")
    return {row[2].strip().lower(): (int(row[0]), int(row[1])) for row in rows}


@cache
def rustypot_table(model: str) -> dict[str, tuple[int, int]]:
    controller = rustypot.AxPyController if model.startswith("ax") else rustypot.MxPyController
    return {r.name: (r.addr, r.size) for r in controller.registers()}


@pytest.mark.parametrize("model", NEW, ids=names(NEW))
def test_registers_are_where_the_sdk_has_them(model: ServoModel) -> None:
    table = sdk_table(model.name)
    for row in model.layout.rows.values():
        name = (XL320_NAMES if model.layout is reg.XL320 else SDK_NAMES).get(row.name, row.name)
        if model.current_unit is None and row.name in NO_CURRENT:
            if row.name != "Present Current":
                continue  # models without a current sensor have no such register
            name = "Present Load"
        if name.lower() not in table and name == "Secondary(Shadow) ID":
            name = "Secondary ID"
        assert table[name.lower()] == (row.address, row.size), row.name


@pytest.mark.parametrize("model", OLD, ids=names(OLD))
def test_registers_are_where_rustypot_has_them(model: ServoModel) -> None:
    table = rustypot_table(model.name)
    for row in model.layout.rows.values():
        name = CLASSIC_NAMES.get(row.name, row.name).lower().replace(" ", "_")
        assert table[name] == (row.address, row.size), row.name


@cache
def manual() -> dict[tuple[str, int], dict[int, str]]:
    found: dict[tuple[str, int], dict[int, str]] = {}
    for row in csv.DictReader(MANUAL.read_text().splitlines()):
        table = found.setdefault((row["model"], int(row["protocol"])), {})
        table[int(row["address"])] = row["access"]
    return found


ALL = [*NEW, *OLD]


@pytest.mark.parametrize("model", ALL, ids=names(ALL))
def test_addresses_are_those_of_the_manuals_rows(model: ServoModel) -> None:
    table = manual()[model.name, model.protocol]
    for row in model.layout.rows.values():
        if model.current_unit is None and row.name in NO_CURRENT - {"Present Current"}:
            continue
        assert row.address in table, row.name


@pytest.mark.parametrize("model", ALL, ids=names(ALL))
def test_signs_and_areas_are_the_simulators(model: ServoModel) -> None:
    table = find_model(model.name, protocol=model.protocol).table
    rows = {row.address: row for row in table.registers}
    for row in model.layout.rows.values():
        theirs = rows.get(row.address)
        if theirs is None:
            assert model.current_unit is None, row.name
            continue
        assert theirs.size == row.size
        # Bus Watchdog reads 255 after an expiry, which the manual calls -1
        signed = row.coding == "signed" and row.name != "Bus Watchdog"
        assert theirs.signed is signed, row.name
        assert (theirs.area is Area.EEPROM) is model.layout.in_eeprom(row.name), row.name


@pytest.mark.parametrize("model", NEW, ids=names(NEW))
def test_model_numbers_are_the_sdks(model: ServoModel) -> None:
    lines = (TABLES / "dynamixel.model").read_text().splitlines()[1:]
    files = {int(row[0]): row[1].strip() for row in map(str.split, filter(None, lines))}
    if model.name in NOT_LISTED:
        assert model.number not in files
    else:
        assert files[model.number] == model_file(model.name).name


@pytest.mark.parametrize("model", ALL, ids=names(ALL))
def test_numbers_and_units_are_the_simulators(model: ServoModel) -> None:
    theirs = find_model(model.name, protocol=model.protocol)
    assert theirs.number == model.number
    assert theirs.units.velocity == pytest.approx(model.velocity_unit, rel=1e-3)
    # 300 degrees are 1023 steps for one of us and 1024 for the other: the pages say 0.29 degrees
    assert theirs.units.angle == pytest.approx(radians_per_tick(model.name), rel=1e-3)
    if model.current_unit is not None:
        assert theirs.current_unit == pytest.approx(model.current_unit)
    assert models.find_number(model.number) is model


@pytest.mark.parametrize(
    "model", [m for m in NEW if m.name != "xw430-t200"], ids=lambda m: str(m.name)
)
def test_velocity_unit_and_sign(model: ServoModel) -> None:
    rows = {r[0]: r[1:] for r in section(model_file(model.name), "unit info")}
    value, unit, sign = rows["Present Velocity"]
    assert float(value) == pytest.approx(model.velocity_unit, rel=1e-3)
    assert unit == "rad/s"
    if model.layout is reg.X:
        assert sign.strip() == "signed"
        assert reg.PRESENT_VELOCITY.coding == "signed"


def test_every_model_of_the_simulator_is_known() -> None:
    assert {name for name, _ in models.MODELS} == set(MODEL_NAMES)


def test_fast_reads_begin_with_the_manuals_firmware() -> None:
    """Protocol 2.0 page, "Fast Sync Read": X430, X540 from 45, X330 from 46; not 2XL, 2XC, MX."""
    for model in models.MODELS.values():
        if model.name.startswith(("2x", "mx", "ax", "xl-320")):
            assert model.fast_firmware is None
        else:
            assert model.fast_firmware == (46 if "330" in model.name else 45)


def test_one_read_holds_the_state_and_one_the_health() -> None:
    state = [reg.PRESENT_CURRENT, reg.PRESENT_VELOCITY, reg.PRESENT_POSITION]
    ends = [row.address + row.size for row in state]
    assert [row.address for row in state] == [reg.STATE_ADDRESS, *ends[:-1]]
    assert ends[-1] == reg.STATE_ADDRESS + reg.STATE_SIZE
    assert reg.HEALTH_ADDRESS + reg.HEALTH_SIZE == 71


@pytest.mark.parametrize(
    ("register", "value"),
    [
        (reg.GOAL_POSITION, -5),
        (reg.PRESENT_CURRENT, -1193),
        (reg.BUS_WATCHDOG, -1),
        (reg.AX["Present Velocity"], -300),
        (reg.AX["Present Velocity"], 300),
        (reg.MX1["Present Position"], -12),
    ],
)
def test_signed_values_survive(register: reg.Register, value: int) -> None:
    assert register.decode(register.encode(value)) == value


@pytest.mark.parametrize(
    ("register", "value"), [(reg.TORQUE_ENABLE, 256), (reg.AX["Present Velocity"], 1024)]
)
def test_a_value_that_does_not_fit_is_an_error(register: reg.Register, value: int) -> None:
    with pytest.raises(OverflowError):
        register.encode(value)


def test_words_for_hardware_errors() -> None:
    assert reg.hardware_error_names(0x24) == "overheating, overload"
    assert reg.hardware_error_names(0x41) == "input voltage, unknown bits 0x40"


def test_an_xl320s_errors_are_numbered_otherwise() -> None:
    """Its page, "Hardware Error Status(50)": overload, overheating, input voltage."""
    in_words = [reg.hardware_error_names(reg.XL320.hardware_error(1 << bit)) for bit in range(4)]
    assert in_words == ["overload", "overheating", "input voltage", "unknown bits 0x40"]
    assert reg.X.hardware_error(0x24) == 0x24


@pytest.mark.parametrize("name", ["reachy_right", "viperx_300s"])
def test_arms_are_of_known_models(name: str) -> None:
    arm = load_arm(name)
    for servo in arm.servo:
        assert models.servo_model(servo.model, servo.protocol).protocol == servo.protocol
    assert calibration_of(arm.servo).zero_tick.size == len(arm.servo)
