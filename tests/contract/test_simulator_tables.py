"""The simulator's control tables against those that two others have written down.

Oracles: the ``.model`` files that dynamixel-sdk installs, and rustypot's register lists. Access,
defaults and ranges are in neither: those of the e-Manual's pages are in ``test_manual_tables``, and
here figures of one page are held against each other. The older servos' tables have a file of their
own, ``test_classic_tables``.
"""

import math
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import pytest
import rustypot

from firmware_sim.firmware.control_table import Access, Area, ControlTable, row
from firmware_sim.firmware.model import PWM_FULL, TICKS_PER_TURN, ServoModel
from firmware_sim.tables import MODEL_NAMES, find_model

MX = ("mx-28", "mx-64", "mx-106")
X330 = tuple(name for name in MODEL_NAMES if name[2:5] == "330")
X = tuple(name for name in MODEL_NAMES if name.startswith(("x", "2x")) and name != "xl-320")
LAYOUTS = [
    *((name, 2, firmware) for name in X330 for firmware in (53, 52, 45)),
    *((name, 2, firmware) for name in X if name not in X330 for firmware in (45, 44, 41)),
    *((name, 2, firmware) for name in MX for firmware in (42, 41)),
]
"""Name, protocol and firmware of every layout."""

# In the e-Manual since firmware 45 (X330: 46), and in no .model file of the SDK.
NEWER_REGISTERS = {"Startup Configuration", "Backup Ready"}
INDIRECT_BLOCKS = ("Write", "Read")  # the SDK's own use of indirect registers, not rows
LACKING: set[tuple[str, str]] = set()  # (model, register) of the SDK that the tables lack: none

# Spelt otherwise in the SDK and on the pages of MX: SDK and page, here.
SPELLINGS = {"BUS Watchdog": "Bus Watchdog"}

# Model numbers: e-Manual's page, SDK's dynamixel.model (None: it has none); the tables' comes last.
NUMBERS_IN_DISPUTE = {
    "xd430-t350": (1000, 1001, 1001),
    "xw430-t200": (1280, None, 1280),
}

# Of X330: read-write in rustypot, R on every page of the e-Manual.
WRITABLE_IN_RUSTYPOT = {"firmware_version", "registered_instruction", "hardware_error_status"}

# Pages by which a motor gives more than it takes: stall torque x no-load speed > volts x amperes.
MORE_OUT_THAN_IN = {"xl330-m077", "xc430-w150"}


@dataclass
class SdkModel:
    """A ``.model`` file: values by name, units by register, registers as (address, size, name)."""

    info: dict[str, str]
    units: dict[str, tuple[float, str, bool]]
    registers: set[tuple[int, int, str]]
    indirect: set[tuple[int, int, str]]


@cache
def read_sdk(name: str) -> SdkModel:
    text = (files("dynamixel_easy_sdk") / "control_table" / name).read_text()
    sections: dict[str, list[list[str]]] = {}
    for line in text.splitlines():
        if line.startswith("["):
            rows = sections[line.strip()] = []
        elif line.strip():
            rows.append(line.strip().split("\t"))
    table = {
        (int(r[0]), int(r[1]), SPELLINGS.get(r[2], r[2])) for r in sections["[control table]"][1:]
    }
    indirect = {r for r in table if r[2].startswith("Indirect") and r[2].endswith(INDIRECT_BLOCKS)}
    return SdkModel(
        {r[0]: r[1] for r in sections["[type info]"][1:]},
        {r[0]: (float(r[1]), r[2], r[3] == "signed") for r in sections["[unit info]"][1:]},
        table - indirect,
        indirect,
    )


def sdk_numbers() -> dict[str, int]:
    text = (files("dynamixel_easy_sdk") / "control_table" / "dynamixel.model").read_text()
    rows = (line.split("\t") for line in text.splitlines()[1:] if line.strip())
    return {file: int(number) for number, file in rows}


@pytest.fixture(params=LAYOUTS, ids=lambda layout: f"{layout[0]}-fw{layout[2]}")
def model(request: pytest.FixtureRequest) -> ServoModel:
    name, protocol, firmware = request.param
    return find_model(name, firmware, protocol)


@pytest.fixture(params=[*X, *MX])
def newest(request: pytest.FixtureRequest) -> ServoModel:
    return find_model(request.param, protocol=2)


@pytest.fixture
def sdk(model: ServoModel) -> SdkModel:
    old = "_fw52" if model.name in X330 and model.firmware <= 52 else ""
    return read_sdk(f"{model.name.replace('-', '_')}{old}.model")


def test_every_register_of_the_sdk_is_there(model: ServoModel, sdk: SdkModel) -> None:
    ours = {(r.address, r.size, r.name) for r in model.table.registers}
    missing = {(model.name, name) for _, _, name in sdk.registers - ours}
    assert missing == {entry for entry in LACKING if entry[0] == model.name}
    assert len(sdk.registers) > 40


def test_no_register_is_there_that_the_sdk_does_not_have(model: ServoModel, sdk: SdkModel) -> None:
    known = {name for _, _, name in sdk.registers}
    extra = {r.name for r in model.table.registers if not r.name.startswith("Indirect ")} - known
    floor = 46 if model.name in X330 else 45
    newer = model.name not in MX and model.firmware >= floor
    assert extra == (NEWER_REGISTERS if newer else set())


def test_the_sdks_indirect_blocks_fall_on_pairs(model: ServoModel, sdk: SdkModel) -> None:
    for block in INDIRECT_BLOCKS:
        found = {
            kind: next(r for r in sdk.indirect if r[2] == f"Indirect {kind} {block}")
            for kind in ("Address", "Data")
        }
        names = []
        for kind, (address, size, _) in found.items():
            register = model.table.by_address[address]
            assert register.size == size
            names.append(register.name.removeprefix(f"Indirect {kind} "))
        assert names[0] == names[1]


def test_indirect_addresses_start_at_their_data(model: ServoModel) -> None:
    addresses = [r for r in model.table.registers if r.name.startswith("Indirect Address ")]
    old_x330 = model.name in X330 and model.firmware <= 52
    assert len(addresses) == (20 if old_x330 else 28 if model.name in X330 else 56)
    for register in addresses:
        datum = model.table[register.name.replace("Address", "Data")]
        assert (register.default, register.minimum) == (datum.address, 64)
        assert register.maximum == model.table.size - 1


def test_model_numbers(newest: ServoModel) -> None:
    file = f"{newest.name.replace('-', '_')}.model"
    page, sdk, chosen = NUMBERS_IN_DISPUTE.get(newest.name, (None, newest.number, newest.number))
    assert sdk_numbers().get(file) == sdk
    assert newest.number == newest.table["Model Number"].default == chosen
    assert page != sdk
    known = rustypot.find_model(newest.name)
    if known is not None and newest.name not in MX:  # its MX are those with protocol 1.0
        assert known[0] == newest.number


def test_rustypot_knows_numbers_of_some() -> None:
    known = {name for name in X if rustypot.find_model(name) is not None}
    assert known >= {"xl330-m077", "xl330-m288", "xl430-w250", "xc430-w150", "xm430-w350"}


def test_units_and_signs(model: ServoModel, sdk: SdkModel) -> None:
    for name, (value, unit, signed) in sdk.units.items():
        assert model.table[name].signed == signed, name
        if unit == "rad/s":
            assert model.units.velocity == pytest.approx(value, rel=1e-3)
    assert ("Present Current" in sdk.units) == (model.current_unit is not None)
    turn = int(sdk.info["value_of_max_radian_position"]) + 1
    assert turn - int(sdk.info["value_of_min_radian_position"]) == TICKS_PER_TURN


def test_addresses_sizes_and_access_are_those_of_rustypot(newest: ServoModel) -> None:
    ours = {r.name.lower().replace(" ", "_"): r for r in newest.table.registers}
    x330, x430 = rustypot.Xl330PyController, rustypot.Xl430PyController
    controller = x330 if newest.name in X330 else x430
    compared = [theirs for theirs in controller.registers() if theirs.name in ours]
    assert len(compared) > 40
    assert any(theirs.name == "indirect_data_1" for theirs in compared)
    for theirs in compared:
        register = ours[theirs.name]
        assert (register.address, register.size) == (theirs.addr, theirs.size), theirs.name
        written = theirs.access == rustypot.RegisterAccess.ReadWrite
        slip = newest.name in X330 and theirs.name in WRITABLE_IN_RUSTYPOT
        assert (register.access is Access.READ_WRITE) == (written and not slip), theirs.name


def test_every_initial_value_fits_its_range_and_area(model: ServoModel) -> None:
    for register in model.table.registers:
        assert register.minimum <= register.default <= register.maximum, register.name
        assert register.maximum - register.minimum < 256**register.size, register.name
        assert (register.area is Area.EEPROM) == (register.address < 64), register.name
    low, high = (model.table[f"{side} Voltage Limit"].default for side in ("Min", "Max"))
    assert low / 10 < model.motor.nominal_voltage < high / 10


def test_goals_start_at_their_limits_and_go_no_further(model: ServoModel) -> None:
    for name in {"PWM", "Velocity", "Current"} & {n.split()[-1] for n in model.table.by_name}:
        goal, limit = model.table[f"Goal {name}"], model.table[f"{name} Limit"]
        assert goal.default == limit.default, name
        assert (goal.minimum, goal.maximum) == (-limit.maximum, limit.maximum), name
    assert model.table["PWM Limit"].maximum == PWM_FULL


def test_what_a_model_says_of_itself_is_in_its_table(model: ServoModel) -> None:
    table = model.table
    assert table["Firmware Version"].default == model.firmware
    assert set(model.baud_rates) == set(range(table["Baud Rate"].maximum + 1))
    assert model.drive_mode_bits & ~table["Drive Mode"].maximum == 0
    senses = "Goal Current" in table.by_name
    assert senses == (model.current_unit is not None) == ({0, 5} <= model.operating_modes)
    assert {1, 3, 4, 16} <= model.operating_modes
    assert all(table["Protocol Type"].minimum <= p <= 2 for p in model.protocols)
    assert model.understands_backup == ("Backup Ready" in table.by_name)


def test_a_velocity_limit_is_near_the_motors_no_load_speed(newest: ServoModel) -> None:
    limit = newest.table["Velocity Limit"].default * newest.units.velocity
    speed = newest.motor.no_load_speed * 2.0 * math.pi / 60.0
    assert 0.85 < limit / speed < 1.15


def test_a_motors_figures_fit_each_other(newest: ServoModel) -> None:
    motor = newest.motor
    speed = motor.no_load_speed * 2.0 * math.pi / 60.0
    share = motor.stall_torque * speed / (motor.nominal_voltage * motor.stall_current)
    assert 0.55 < share < 1.2
    assert (share > 1.0) == (newest.name in MORE_OUT_THAN_IN)
    assert motor.inertia * speed / motor.stall_torque == pytest.approx(0.01, rel=0.05)
    if newest.current_unit is not None:
        limit = newest.table["Current Limit"].default * newest.current_unit
        assert limit >= motor.stall_current


def test_a_table_with_overlapping_or_repeated_registers_is_refused() -> None:
    with pytest.raises(ValueError, match="overlaps"):
        ControlTable([row(0, 2, "A", "R", 0), row(1, 1, "B", "R", 0)])
    with pytest.raises(ValueError, match="share a name"):
        ControlTable([row(0, 2, "A", "R", 0), row(2, 1, "A", "R", 0)])
