"""The simulator's control tables against those that two others have written down.

Oracles: the ``.model`` files that dynamixel-sdk installs, and rustypot's register lists. Access,
defaults and ranges are in neither; where a second source of them exists it is a test of its own.
"""

import math
from dataclasses import dataclass
from importlib.resources import files

import pytest
import rustypot

from firmware_sim.control_table import Access, Area, ControlTable, row
from firmware_sim.model import TICKS_PER_TURN, VELOCITY_UNIT, ServoModel
from firmware_sim.tables import MODEL_NAMES, find_model

SDK_FILES = {
    "xl330-m288": "xl330_m288_fw52.model",
    "xl430-w250": "xl430_w250.model",
    "xm430-w350": "xm430_w350.model",
    "xm540-w270": "xm540_w270.model",
}
# In the e-Manual since firmware 45, and in no .model file of the SDK.
NEWER_REGISTERS = {"Startup Configuration", "Backup Ready"}
INDIRECT_BLOCKS = ("Write", "Read")  # the SDK's own use of indirect registers, not rows


@dataclass
class SdkModel:
    """A ``.model`` file: values by name, units by register, registers as (address, size, name)."""

    info: dict[str, str]
    units: dict[str, tuple[float, str, bool]]
    registers: set[tuple[int, int, str]]
    indirect: set[tuple[int, int, str]]


def read_sdk(name: str) -> SdkModel:
    text = (files("dynamixel_easy_sdk") / "control_table" / name).read_text()
    sections: dict[str, list[list[str]]] = {}
    for line in text.splitlines():
        if line.startswith("["):
            rows = sections[line.strip()] = []
        elif line.strip():
            rows.append(line.strip().split("\t"))
    table = {(int(r[0]), int(r[1]), r[2]) for r in sections["[control table]"][1:]}
    indirect = {r for r in table if r[2].startswith("Indirect") and r[2].endswith(INDIRECT_BLOCKS)}
    return SdkModel(
        {r[0]: r[1] for r in sections["[type info]"][1:]},
        {r[0]: (float(r[1]), r[2], r[3] == "signed") for r in sections["[unit info]"][1:]},
        table - indirect,
        indirect,
    )


@pytest.fixture(params=MODEL_NAMES)
def model(request: pytest.FixtureRequest) -> ServoModel:
    return find_model(request.param)


@pytest.fixture
def sdk(model: ServoModel) -> SdkModel:
    return read_sdk(SDK_FILES[model.name])


def test_every_register_of_the_sdk_is_there(model: ServoModel, sdk: SdkModel) -> None:
    ours = {(r.address, r.size, r.name) for r in model.table.registers}
    assert sdk.registers <= ours
    assert len(sdk.registers) > 40


def test_no_register_is_there_that_the_sdk_does_not_have(model: ServoModel, sdk: SdkModel) -> None:
    known = {name for _, _, name in sdk.registers} | NEWER_REGISTERS
    extra = {
        r.name
        for r in model.table.registers
        if r.name not in known and not r.name.startswith(("Indirect Address ", "Indirect Data "))
    }
    assert extra == set()


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


def test_model_numbers(model: ServoModel) -> None:
    text = (files("dynamixel_easy_sdk") / "control_table" / "dynamixel.model").read_text()
    rows = dict(line.split("\t") for line in text.splitlines()[1:] if line.strip())
    assert rows[str(model.number)] == f"{model.name.replace('-', '_')}.model"
    number, _definition = rustypot.find_model(model.name)
    assert number == model.number


def test_units_and_signs(model: ServoModel, sdk: SdkModel) -> None:
    for name, (value, unit, signed) in sdk.units.items():
        assert model.table[name].signed == signed, name
        if unit == "rad/s":
            assert VELOCITY_UNIT * 2.0 * math.pi / TICKS_PER_TURN == pytest.approx(value, rel=1e-3)
    turn = int(sdk.info["value_of_max_radian_position"]) + 1
    assert turn - int(sdk.info["value_of_min_radian_position"]) == TICKS_PER_TURN


def test_addresses_sizes_and_read_only_registers_of_rustypot(model: ServoModel) -> None:
    _number, definition = rustypot.find_model(model.name)
    ours = {r.name.lower().replace(" ", "_"): r for r in model.table.registers}
    controller = {"XL330": rustypot.Xl330PyController, "XL430": rustypot.Xl430PyController}
    registers = controller[definition.name].registers()
    compared = [theirs for theirs in registers if theirs.name in ours]
    # rustypot knows the indirect data of XL330s with newer firmware only.
    compared = [r for r in compared if not r.name.startswith("indirect_data")]
    assert len(compared) > 40
    for theirs in compared:
        register = ours[theirs.name]
        assert (register.address, register.size) == (theirs.addr, theirs.size), theirs.name
        if theirs.access == rustypot.RegisterAccess.Read:
            assert register.access is Access.READ, theirs.name


def test_every_model_has_what_a_driver_needs_where_it_expects_it(model: ServoModel) -> None:
    wanted = {
        0: "Model Number",
        6: "Firmware Version",
        7: "ID",
        8: "Baud Rate",
        9: "Return Delay Time",
        10: "Drive Mode",
        11: "Operating Mode",
        20: "Homing Offset",
        48: "Max Position Limit",
        52: "Min Position Limit",
        64: "Torque Enable",
        70: "Hardware Error Status",
        98: "Bus Watchdog",
        108: "Profile Acceleration",
        112: "Profile Velocity",
        116: "Goal Position",
        122: "Moving",
        128: "Present Velocity",
        132: "Present Position",
        144: "Present Input Voltage",
        146: "Present Temperature",
    }
    assert {a: model.table.by_address[a].name for a in wanted} == wanted
    eeprom = {r.address for r in model.table.registers if r.area is Area.EEPROM}
    assert max(eeprom) == 63
    assert model.table.by_address[64].area is Area.RAM


def test_a_table_with_overlapping_or_repeated_registers_is_refused() -> None:
    with pytest.raises(ValueError, match="overlaps"):
        ControlTable([row(0, 2, "A", "R", 0), row(1, 1, "B", "R", 0)])
    with pytest.raises(ValueError, match="share a name"):
        ControlTable([row(0, 2, "A", "R", 0), row(2, 1, "A", "R", 0)])
