"""The tables of AX, MX with protocol 1.0 and XL-320 against those that others have written down.

Oracles: rustypot's register lists for AX and MX (its XL-320 too), the SDK's ``xl320.model``, and
for the registers of MX-64 and MX-106 that rustypot lacks, ROBOTIS-GIT/dynamixel-workbench,
dynamixel_item.cpp, "EXTMX". Figures are those of the e-Manual's pages.
"""

from importlib.resources import files

import pytest
import rustypot

from firmware_sim.errors import RigError
from firmware_sim.firmware.control_table import Area
from firmware_sim.firmware.model import ServoModel
from firmware_sim.tables import find_model

AX = ("ax-12a", "ax-18a")
MX = ("mx-28", "mx-64", "mx-106")
ALL = (*AX, *MX, "xl-320")
CONTROLLERS = {
    **dict.fromkeys(AX, rustypot.AxPyController),
    **dict.fromkeys(MX, rustypot.MxPyController),
    "xl-320": rustypot.Xl320PyController,
}
OUR_NAMES = {"baudrate": "baud_rate", "registered": "registered_instruction"}
TORQUE_CONTROL = {
    (68, 2, "current"),
    (70, 1, "torque_control_mode_enable"),
    (71, 2, "goal_torque"),
}
DRIVE_MODE = {(10, 1, "drive_mode")}  # the e-Manual's page alone


def models(name: str) -> tuple[ServoModel, ...]:
    newest = find_model(name)
    if newest.first_firmware == 0:
        return (newest,)
    return newest, find_model(name, firmware=newest.first_firmware - 1)


def registers(model: ServoModel) -> set[tuple[int, int, str]]:
    return {(r.address, r.size, r.name.lower().replace(" ", "_")) for r in model.table.registers}


@pytest.mark.parametrize("name", ALL)
def test_registers_are_those_of_rustypot(name: str) -> None:
    theirs = {
        (r.addr, r.size, OUR_NAMES.get(r.name, r.name)) for r in CONTROLLERS[name].registers()
    }
    extra = {"mx-64": TORQUE_CONTROL, "mx-106": TORQUE_CONTROL | DRIVE_MODE}.get(name, set())
    assert registers(models(name)[0]) == theirs | extra


@pytest.mark.parametrize("name", ALL)
def test_access_is_that_of_rustypot(name: str) -> None:
    table = models(name)[0].table
    theirs = {r.addr: r.access for r in CONTROLLERS[name].registers()}
    ours = {r.address: r.access.value for r in table.registers if r.address in theirs}
    letters = {rustypot.RegisterAccess.Read: "R", rustypot.RegisterAccess.ReadWrite: "RW"}
    assert ours == {address: letters[access] for address, access in theirs.items()}


@pytest.mark.parametrize("name", MX)
def test_registers_below_zero_are_those_that_rustypot_signs(name: str) -> None:
    theirs = {r.addr for r in rustypot.MxPyController.registers() if r.encoding != "unsigned"}
    ours = {r.address for r in models(name)[0].table.registers if r.signed}
    angle_limits = {6, 8}  # 0 to 4095 in the manual; rustypot shares one conversion
    assert ours == theirs - angle_limits


@pytest.mark.parametrize("name", [*AX[1:], *MX])
def test_model_numbers_are_those_of_rustypot(name: str) -> None:
    known = rustypot.find_model(name)
    assert known is not None
    assert models(name)[0].number == known[0]


def test_ax_12a_has_the_number_of_an_ax_12() -> None:
    assert models("ax-12a")[0].number == rustypot.AxPyController.definition().models["AX12"] == 12


def test_xl_320_is_as_in_the_sdk() -> None:
    text = (files("dynamixel_easy_sdk") / "control_table" / "xl320.model").read_text()
    lines = text.split("[control table]")[1].split("\n")[2:]
    theirs = {
        (int(address), int(size), name)
        for address, size, name in (line.split("\t") for line in lines if line)
    }
    model = models("xl-320")[0]
    assert {(r.address, r.size, r.name) for r in model.table.registers} == theirs
    assert len(theirs) == 31
    numbers = (files("dynamixel_easy_sdk") / "control_table" / "dynamixel.model").read_text()
    assert f"{model.number}\txl320.model" in numbers


@pytest.mark.parametrize("name", ALL)
def test_every_initial_value_fits_its_range_and_area(name: str) -> None:
    for model in models(name):
        for register in model.table.registers:
            assert register.minimum <= register.default <= register.maximum, register.name
            assert (register.area is Area.EEPROM) == (register.address < 24), register.name


@pytest.mark.parametrize("name", MX)
def test_realtime_tick_came_with_firmware_40(name: str) -> None:
    new, old = models(name)
    assert (new.first_firmware, old.last_firmware) == (40, 39)
    assert new.firmware >= 40 > old.firmware
    assert registers(new) - registers(old) == {(50, 2, "realtime_tick")}
    assert registers(old) < registers(new)


@pytest.mark.parametrize("name", [*AX, *MX])
def test_older_servos_speak_protocol_1_only(name: str) -> None:
    for model in models(name):
        assert (model.protocol, model.protocols) == (1, frozenset((1,)))
    if name in AX:
        with pytest.raises(RigError, match="protocol"):
            find_model(name, protocol=2)


@pytest.mark.parametrize(("name", "numbers"), [("mx-28", (29, 30)), ("mx-64", (310, 311))])
def test_an_mx_is_sold_with_protocol_1_and_can_have_the_other(
    name: str, numbers: tuple[int, int]
) -> None:
    # e-Manual, mx-28, "Note": protocol 2.0 needs a recovery with another firmware.
    assert find_model(name).number == find_model(name, protocol=1).number == numbers[0]
    assert find_model(name, protocol=2).number == numbers[1]


# e-Manual, "Baud Rate(4)": value, rate, and margin of error in percent.
MANUAL_RATES = [
    (1, 1_000_000, 0.000),
    (3, 500_000, 0.000),
    (4, 400_000, 0.000),
    (7, 250_000, 0.000),
    (9, 200_000, 0.000),
    (16, 115_200, -2.124),
    (34, 57_600, 0.794),
    (103, 19_200, -0.160),
    (207, 9_600, -0.160),
]


@pytest.mark.parametrize(("code", "rate", "margin"), MANUAL_RATES)
@pytest.mark.parametrize("name", [*AX, *MX])
def test_baud_rates_err_as_much_as_the_manual_says(
    name: str, code: int, rate: int, margin: float
) -> None:
    true = models(name)[0].baud_rates[code]  # rounded to 1 bit/s
    assert 100.0 * (rate - true) / rate == pytest.approx(margin, abs=6e-4 + 50.0 / rate)


def test_baud_rates_at_the_ends() -> None:
    # "Specifications": AX 7843 bit/s to 1 Mbit/s; MX from 8000 bit/s; "For BPS over 250 values".
    ax, mx = models("ax-12a")[0].baud_rates, models("mx-28")[0].baud_rates
    assert (min(ax.values()), max(ax.values())) == (7843, 1_000_000)
    assert min(mx.values()) == 8000
    assert [mx[code] for code in (250, 251, 252)] == [2_250_000, 2_500_000, 3_000_000]
    assert models("xl-320")[0].baud_rates == {0: 9_600, 1: 57_600, 2: 115_200, 3: 1_000_000}


@pytest.mark.parametrize("name", ALL)
def test_every_baud_rate_code_has_a_rate(name: str) -> None:
    model = models(name)[0]
    code = model.table["Baud Rate"]
    assert set(range(code.minimum, code.maximum + 1)) == set(model.baud_rates)


@pytest.mark.parametrize(
    ("name", "count", "rpm"),
    [("ax-12a", 1023, 114.0), ("ax-12a", 300, 33.3), ("mx-28", 1023, 116.62), ("mx-28", 300, 34.2)],
)
def test_speed_counts_are_worth_what_the_manual_says(name: str, count: int, rpm: float) -> None:
    speed = count * models(name)[0].units.velocity  # rad/s
    assert speed * 60.0 / 6.283185307 == pytest.approx(rpm, rel=5e-3)


def test_acceleration_counts_are_worth_what_the_manual_says() -> None:
    # "Goal Acceleration(73)": 254 is 2180 deg/s^2; at 10, 14.3 rev/min after one second.
    unit = models("mx-64")[0].units.acceleration * 180.0 / 3.141592654
    assert 254 * unit == pytest.approx(2180.0, rel=1e-3)
    assert 10 * unit / 6.0 == pytest.approx(14.3, rel=1e-3)


def test_angle_counts_are_worth_what_the_manual_says() -> None:
    # "Present Position(36)": 0.29 degrees over 300; "Resolution": 0.088 degrees.
    assert models("ax-12a")[0].units.angle * 180.0 / 3.141592654 == pytest.approx(0.293, abs=5e-4)
    assert models("mx-28")[0].units.angle * 180.0 / 3.141592654 == pytest.approx(0.0879, abs=5e-5)
