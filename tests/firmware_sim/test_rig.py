"""Which servos a rig file, an arm's description or a command line asks for."""

import math
from pathlib import Path

import pytest

from firmware_sim.errors import RigError
from firmware_sim.firmware.world import build_world
from firmware_sim.rig.arm_search import find_arm
from firmware_sim.rig.file import SET_UP, read_rig
from firmware_sim.rig.settings import (
    Mount,
    Supply,
    check_ids,
    parse_servo,
    with_baud_rate,
    with_protocol,
)
from firmware_sim.wire.line import same_rate

FULL = """
name = "an arm's own fields are none of the simulator's business"

[[servo]]
joint = "shoulder_flexion"
id = 1
model = "xm540-w270"
direction = 1
zero_tick = 2048
rest_tick = 2100
baud = 1000000
return_delay_us = 0
drive_mode = 4
supply_voltage = 12.5

[[servo]]
id = 2
model = "xm430-w350"
rest_tick = 1000
start_tick = 900
"""


def rig_file(folder: Path, text: str) -> Path:
    path = folder / "rig.toml"
    path.write_text(text)
    return path


def test_reads_every_field(tmp_path: Path) -> None:
    rig = read_rig(rig_file(tmp_path, FULL))
    first, second = rig.servos
    assert (first.model.name, first.servo_id, first.start_tick) == ("xm540-w270", 1, 2100)
    assert first.registers == {"Baud Rate": 3, "Return Delay Time": 0, "Drive Mode": 4}
    assert first.supply_voltage == 12.5
    assert first.mount == Mount("shoulder_flexion", 1, 2048)
    assert (second.start_tick, second.registers, second.mount) == (900, {}, None)
    assert (rig.supply, rig.mjcf) == (Supply(), None)
    servo = build_world(rig.servos).servos[0]
    assert (servo.baud_rate, servo.return_delay, servo.memory.value("Drive Mode")) == (
        1_000_000,
        0.0,
        4,
    )
    servo.read(132, 4)
    assert servo.memory.value("Present Position") == 2100


WIDE = """
[supply]
voltage = 11.1
resistance = 0.05

[plant]
mjcf = "<mujoco/>"

[[servo]]
id = 3
model = "xm430-w350"
joint = "elbow"
direction = -1
zero_tick = 1000
firmware = 44
protocol = 1
backlash = 0.25
registers = { "Min Position Limit" = 1024, "Operating Mode" = 4 }
"""


def test_reads_supply_plant_and_registers(tmp_path: Path) -> None:
    rig = read_rig(rig_file(tmp_path, WIDE))
    assert (rig.supply, rig.mjcf) == (Supply(11.1, 0.05), "<mujoco/>")
    (servo,) = rig.servos
    assert servo.mount == Mount("elbow", -1, 1000)
    assert servo.model.firmware == 44
    assert servo.model.motor.backlash == pytest.approx(math.radians(0.25))
    assert servo.registers == {"Min Position Limit": 1024, "Operating Mode": 4, "Protocol Type": 1}
    (tmp_path / "arm.xml").write_text("<mujoco/>")
    beside = WIDE.replace('mjcf = "<mujoco/>"', 'file = "arm.xml"')
    assert read_rig(rig_file(tmp_path, beside)).mjcf == "<mujoco/>"


@pytest.mark.parametrize(
    ("servo", "protocol", "spoken"),
    [("ax-12a:1", 2, "1.0"), ("xl330-m288:1", 1, "2.0"), ("xl-320:9", 1, "2.0")],
)
def test_a_protocol_a_servo_cannot_speak_is_refused(servo: str, protocol: int, spoken: str) -> None:
    with pytest.raises(RigError, match=f"{servo} speaks Protocol {spoken} only"):
        with_protocol(parse_servo(servo), protocol)


@pytest.mark.parametrize(
    ("servo", "protocol"),
    [("mx-28:1", 1), ("mx-28:1", 2), ("xm430-w350:1", 1), ("ax-12a:1", 1), ("xl-320:1", 2)],
)
def test_a_protocol_a_servo_can_speak_is_spoken(servo: str, protocol: int) -> None:
    settings = with_protocol(parse_servo(servo), protocol)
    assert build_world([settings]).servos[0].protocol == protocol


@pytest.mark.parametrize(
    ("servo", "asked", "has"),
    [
        ("ax-12a:1", 57_600, 57_142),
        ("ax-12a:1", 115_200, 117_647),
        ("xm430-w350:1", 57_142, 57_600),
    ],
)
def test_a_rate_that_is_near_enough_to_be_understood_will_do(
    servo: str, asked: int, has: int
) -> None:
    settings = with_baud_rate(parse_servo(servo), asked)
    rate = build_world([settings]).servos[0].baud_rate
    assert rate == pytest.approx(has, abs=1)
    assert same_rate(asked, rate)


def test_every_servo_begins_in_the_middle_of_its_range() -> None:
    assert [parse_servo(text).start_tick for text in ("xm430-w350:1", "ax-12a:1")] == [2048, 512]


SERVO = '[[servo]]\nid = 1\nmodel = "xm430-w350"\n'


def test_an_arms_servos_are_as_its_set_up_leaves_them(tmp_path: Path) -> None:
    servos = read_rig(rig_file(tmp_path, FULL), SET_UP).servos
    assert [servo.registers["Baud Rate"] for servo in servos] == [3, 3]
    assert [servo.registers["Return Delay Time"] for servo in servos] == [0, 0]


@pytest.mark.parametrize(
    ("text", "table", "field", "says"),
    [
        ("", 0, "servo", "no [[servo]] table"),
        ("servo = 3", 0, "servo", "no [[servo]] table"),
        ("servo = [3]", 1, "", "is not a table"),
        ("[[servo]\n", 0, "", "is not TOML"),
        (SERVO + "speed = 3", 1, "speed", "unknown field 'speed'"),
        ('[[servo]]\nmodel = "xm430-w350"', 1, "id", "needs the field 'id'"),
        ("[[servo]]\nid = 1", 1, "model", "needs the field 'model'"),
        (SERVO + SERVO.replace("= 1", "= 253"), 2, "id", "id = 253"),
        (SERVO.replace("= 1", "= true"), 1, "id", "id = True"),
        (SERVO.replace("= 1", '= "1"'), 1, "id", "id = '1'"),
        (SERVO.replace("xm430", "xm999"), 1, "model", "unknown servo model 'xm999-w350'"),
        (SERVO + "baud = 12345", 1, "baud", "none of xm430-w350's 9600"),
        (SERVO + "drive_mode = 2", 1, "Drive Mode", "Drive Mode = 2 is none that"),
        (SERVO + "rest_tick = 4096", 1, "rest_tick", "0 to 4095"),
        (SERVO + "backlash = 11", 1, "backlash", "not a number of degrees"),
        (SERVO + "protocol = 3", 1, "protocol", "1 to 2"),
        (SERVO + "firmware = 300", 1, "firmware", "0 to 255"),
        (SERVO + "joint = 3", 1, "joint", "is not a text"),
        (SERVO + 'joint = "a"\ndirection = 0', 1, "direction", "neither 1 nor -1"),
        (SERVO + "registers = 3", 1, "registers", "is not a table"),
        (SERVO + 'registers = {"Goal Position" = 3}', 1, "Goal Position", "no EEPROM register"),
        (SERVO + 'registers = {"Model Number" = 3}', 1, "Model Number", "no EEPROM register"),
        (SERVO + 'registers = {"ID" = 3}', 1, "ID", "given by id"),
        (SERVO + 'registers = {"Operating Mode" = 2}', 1, "Operating Mode", "none that"),
        (SERVO + 'registers = {"Shutdown" = true}', 1, "Shutdown", "not a whole number"),
        (SERVO + "[supply]\nresistance = -1", 0, "resistance", "not a number of ohms"),
        (SERVO + "[supply]\nvolts = 3", 0, "volts", "unknown field 'volts'"),
        ("supply = 3\n" + SERVO, 0, "supply", "supply is not a table"),
        (SERVO + "[plant]\nmjcf = 3", 0, "mjcf", "one text"),
        (SERVO + '[plant]\nfile = "none.xml"', 0, "", "none.xml cannot be read"),
        (SERVO + SERVO, 2, "id", "id = 1 is table 1's too"),
        (SERVO + "return_delay_us = 5", 1, "return_delay_us", "multiple of 2 us"),
        (SERVO + "return_delay_us = 510", 1, "return_delay_us", "0 to 508"),
        (SERVO + "supply_voltage = nan", 1, "supply_voltage", "not a number of volts"),
        (SERVO + "supply_voltage = -12", 1, "supply_voltage", "not a number of volts"),
        (SERVO + 'supply_voltage = "12"', 1, "supply_voltage", "not a number of volts"),
    ],
)
def test_refuses_with_file_table_and_field(
    tmp_path: Path, text: str, table: int, field: str, says: str
) -> None:
    path = rig_file(tmp_path, text)
    with pytest.raises(RigError) as caught:
        read_rig(path)
    error = caught.value
    assert (error.file, error.table, error.field) == (str(path), table, field)
    assert says in str(error)
    assert str(path) in str(error)
    assert "\n" not in str(error)


def test_refuses_files_that_are_not_there_not_text_or_far_too_large(tmp_path: Path) -> None:
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "large.toml").write_text("#" * 1_000_001)
    for name, says in (
        ("none.toml", "cannot be read"),
        ("binary.toml", "is not TOML"),
        ("large.toml", "larger than"),
    ):
        with pytest.raises(RigError, match=says):
            read_rig(tmp_path / name)
    with pytest.raises(RigError, match="cannot be read"):
        read_rig(tmp_path)


@pytest.mark.parametrize(
    "text",
    ["xm430-w350", "xm430-w350:", "xm430-w350:x", "xm430-w350:-1", "", "xm430-w350@:1", "a@x:1"],
)
def test_a_servo_is_written_as_model_and_id(text: str) -> None:
    with pytest.raises(RigError, match="MODEL:ID"):
        parse_servo(text)


def test_a_servo_on_the_command_line() -> None:
    servo = parse_servo("XM430-W350:252")
    assert (servo.model.name, servo.servo_id) == ("xm430-w350", 252)
    with pytest.raises(RigError, match="0 to 252"):
        parse_servo("xm430-w350:253")
    assert parse_servo("xm430-w350@42:1").model.firmware == 42
    with pytest.raises(RigError, match="unknown servo model"):
        parse_servo("ax-12b:1")


def test_duplicate_ids_are_refused() -> None:
    with pytest.raises(RigError, match="ID 3 is given twice"):
        check_ids([parse_servo("xm430-w350:3"), parse_servo("xl330-m288:3")])


def test_an_arm_is_looked_for_in_the_documented_order(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for folder in ("given", "environment", "work/calibration"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "thing.toml").write_text(SERVO)
    monkeypatch.chdir(tmp_path / "work")
    monkeypatch.delenv("ARMSYN_CALIBRATION", raising=False)
    assert find_arm("thing", None) == Path("calibration/thing.toml")
    monkeypatch.setenv("ARMSYN_CALIBRATION", str(tmp_path / "environment"))
    assert find_arm("thing", None) == tmp_path / "environment" / "thing.toml"
    assert find_arm("thing", tmp_path / "given") == tmp_path / "given" / "thing.toml"
    with pytest.raises(RigError, match="no arm 'other'"):
        find_arm("other", tmp_path / "given")


@pytest.mark.parametrize("name", ["../thing", "/etc/passwd", ".hidden", "", "a/b"])
def test_an_arms_name_is_no_path(tmp_path: Path, name: str) -> None:
    with pytest.raises(RigError, match="is a path, not a name"):
        find_arm(name, tmp_path)


@pytest.mark.parametrize("name", ["servos", "Servo", "suply", "Supply", "plants"])
def test_a_table_with_nearly_a_known_name_is_a_slip(tmp_path: Path, name: str) -> None:
    path = tmp_path / "rig.toml"
    path.write_text(f'[[servo]]\nid = 1\nmodel = "xm430-w350"\n[{name}]\nx = 1\n')
    with pytest.raises(RigError, match=f"unknown table '{name}'; did you mean"):
        read_rig(path)


@pytest.mark.parametrize("name", ["joint", "tip", "landmarks", "name", "base", "camera"])
def test_other_tables_are_left_to_whom_they_concern(tmp_path: Path, name: str) -> None:
    path = tmp_path / "rig.toml"
    path.write_text(f'[[servo]]\nid = 1\nmodel = "xm430-w350"\n[{name}]\nx = 1\n')
    assert len(read_rig(path).servos) == 1
