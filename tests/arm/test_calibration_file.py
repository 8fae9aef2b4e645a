"""The calibration file: strict to read, whole to write, and what it does to a description."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.arm import ArmDescription, load_arm
from armsyn.arm.calibration_file import (
    RANGE_MARGIN,
    ArmCalibration,
    ServoCalibration,
    file_stem,
    find_calibration,
    folder_for_writing,
    format_calibration,
    is_found_from_everywhere,
    parse_calibration,
    read_calibration,
    with_calibration,
)
from armsyn.arm.search import user_folder
from armsyn.errors import DescriptionError, InputError

CALIBRATION = Path(__file__).resolve().parents[2] / "calibration"
TICK = math.tau / 4096


def calibration_of(description: ArmDescription, **changes: Any) -> ArmCalibration:
    """A calibration that says what the description says."""
    servos = tuple(
        ServoCalibration(
            id=servo.id,
            joint=servo.joint,
            model=servo.model,
            model_number=1020,
            firmware=45,
            protocol=servo.protocol,
            zero_tick=servo.zero_tick,
            direction=servo.direction,
            homing_offset=0,
            drive_mode=servo.drive_mode,
            operating_mode=3,
        )
        for servo in description.servo
    )
    fields: dict[str, Any] = {
        "schema": "armsyn-calibration-1",
        "arm": description.name,
        "date": "2026-01-02T03:04:05+00:00",
        "method": "rest",
        "port": "/dev/ttyUSB0",
        "servo": servos,
    }
    return ArmCalibration(**(fields | changes))


def changed(calibration: ArmCalibration, row: int, **fields: Any) -> ArmCalibration:
    """The same with another servo in a row."""
    servos = list(calibration.servo)
    servos[row] = msgspec.structs.replace(servos[row], **fields)
    return msgspec.structs.replace(calibration, servo=tuple(servos))


@pytest.fixture(scope="module")
def omx() -> ArmDescription:
    return load_arm("openmanipulator_x", calibrated=False)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    shutil.copy(CALIBRATION / "openmanipulator_x.toml", tmp_path)
    return tmp_path


# what it does to a description


def test_what_the_description_says_changes_only_what_a_turn_ends(omx: ArmDescription) -> None:
    same = with_calibration(omx, calibration_of(omx))
    assert same.servo == omx.servo
    lower, upper = np.array([(j.lower, j.upper) for j in same.joint]).T
    # joint 1 goes from -pi to pi, but zero is tick 2048 and the last one 4095
    expected = [j.upper for j in omx.joint]
    expected[0] = min(expected[0], 2047 * TICK)
    assert upper == pytest.approx(expected)
    assert lower == pytest.approx([j.lower for j in omx.joint])


@pytest.mark.parametrize("direction", [1, -1])
def test_zero_and_direction_move_ticks_not_angles(omx: ArmDescription, direction: int) -> None:
    row = 1
    arm = with_calibration(
        omx, changed(calibration_of(omx), row, zero_tick=2100, direction=direction)
    )
    rest = arm.joint[row].rest
    assert rest == omx.joint[row].rest
    ticks = arm.calibration.to_ticks(arm.rest)
    assert ticks[row] == round(2100 + direction * rest / TICK)
    assert arm.servo[row].rest_tick == ticks[row]


def test_a_range_by_hand_tightens_limits_and_keeps_off_the_ends(omx: ArmDescription) -> None:
    row = 1
    ends = (1000, 3000)
    arm = with_calibration(omx, changed(calibration_of(omx), row, range_ticks=ends))
    lower, upper = ((tick - 2048) * TICK for tick in ends)
    rest = omx.joint[row].rest
    assert arm.joint[row].upper == pytest.approx(
        min(omx.joint[row].upper, max(upper - RANGE_MARGIN, rest))
    )
    assert arm.joint[row].lower == pytest.approx(
        max(omx.joint[row].lower, min(lower + RANGE_MARGIN, rest))
    )


@pytest.mark.parametrize("direction", [1, -1])
def test_limits_never_grow(omx: ArmDescription, direction: int) -> None:
    wide = changed(
        calibration_of(omx), 1, range_ticks=(-9000, 9000), direction=direction, operating_mode=4
    )
    arm = with_calibration(omx, wide)
    assert arm.joint[1].lower == omx.joint[1].lower
    assert arm.joint[1].upper == omx.joint[1].upper


def test_position_mode_ends_where_the_turn_does(omx: ArmDescription) -> None:
    row = 2
    crossing = changed(calibration_of(omx), row, zero_tick=3300)
    arm = with_calibration(omx, crossing)
    assert arm.joint[row].upper == pytest.approx((4095 - 3300) * TICK)
    extended = with_calibration(omx, changed(crossing, row, operating_mode=4))
    assert extended.joint[row].upper == omx.joint[row].upper


@pytest.mark.parametrize(("offset", "ends"), [(500, (500, 4095)), (-500, (0, 3595))])
@pytest.mark.parametrize("direction", [1, -1])
def test_a_homing_offset_narrows_the_turn(
    omx: ArmDescription, offset: int, ends: tuple[int, int], direction: int
) -> None:
    calibration = changed(
        calibration_of(omx), 0, homing_offset=offset, direction=direction, zero_tick=2048
    )
    joint = with_calibration(omx, calibration).joint[0]
    lower, upper = sorted(direction * (tick - 2048) * TICK for tick in ends)
    assert joint.lower == pytest.approx(max(omx.joint[0].lower, lower))
    assert joint.upper == pytest.approx(min(omx.joint[0].upper, upper))
    extended = with_calibration(omx, changed(calibration, 0, operating_mode=4)).joint[0]
    assert (extended.lower, extended.upper) == (omx.joint[0].lower, omx.joint[0].upper)


def test_the_second_servo_of_a_dual_joint_narrows_the_turn_too() -> None:
    arm = load_arm("widowx_250s", calibrated=False)
    rows = {servo.id: row for row, servo in enumerate(arm.servo)}
    ends = arm.joint[1].lower, arm.joint[1].upper
    near = round(2048 + max(ends) / TICK)
    narrow = changed(calibration_of(arm), rows[3], homing_offset=near - 100 - 4095)
    shoulder = with_calibration(arm, narrow).joint[1]
    assert shoulder.upper == pytest.approx((near - 100 - 2048) * TICK)
    assert shoulder.lower == ends[0]


def test_a_horn_that_puts_rest_beyond_the_turn_is_refused(omx: ArmDescription) -> None:
    with pytest.raises(InputError, match="screw the horn"):
        with_calibration(omx, changed(calibration_of(omx), 2, zero_tick=4000))


def test_a_range_without_the_rest_posture_is_refused(omx: ArmDescription) -> None:
    with pytest.raises(InputError, match="calibrate again"):
        with_calibration(omx, changed(calibration_of(omx), 1, range_ticks=(2100, 2500)))


@pytest.mark.parametrize(
    ("name", "direction"), [("koch", 1), ("koch", -1), ("openmanipulator_x", 1)]
)
def test_a_gripper_is_closed_and_open_at_the_ends_found_by_hand(name: str, direction: int) -> None:
    described = load_arm(name, calibrated=False)
    row = len(described.servo) - 1
    ends = {"range_ticks": (2048 - 700, 2048 + 400), "zero_tick": 2048, "direction": direction}
    gripper = with_calibration(described, changed(calibration_of(described), row, **ends)).gripper
    assert gripper is not None
    assert described.gripper is not None
    angles = sorted(direction * ticks * TICK for ticks in (-700, 400))
    opens_up = described.gripper.open > described.gripper.closed
    closed, opened = angles if opens_up else reversed(angles)
    assert (gripper.closed, gripper.open) == pytest.approx((closed, opened))
    assert gripper.width_open == described.gripper.width_open
    assert gripper.rest_angle == described.gripper.rest_angle


def test_a_gripper_that_rests_open_keeps_its_rest(omx: ArmDescription) -> None:
    assert omx.gripper is not None
    open_at_rest = msgspec.structs.replace(omx.gripper, rest=None)
    arm = msgspec.structs.replace(omx, gripper=open_at_rest)
    rest = open_at_rest.open / TICK
    calibration = changed(
        calibration_of(omx), -1, zero_tick=2048, range_ticks=(round(2048 + rest) - 40, 2400)
    )
    gripper = with_calibration(arm, calibration).gripper
    assert gripper is not None
    assert gripper.rest == open_at_rest.open
    assert gripper.open == pytest.approx(open_at_rest.open - 40 * TICK, abs=TICK)


def test_a_gripper_range_without_its_rest_is_refused(omx: ArmDescription) -> None:
    with pytest.raises(InputError, match=r"gripper.*calibrate again"):
        with_calibration(omx, changed(calibration_of(omx), -1, range_ticks=(2400, 2600)))


def test_both_servos_of_a_dual_joint_count() -> None:
    arm = load_arm("widowx_250s", calibrated=False)
    rows = {servo.id: row for row, servo in enumerate(arm.servo)}
    narrow = changed(calibration_of(arm), rows[3], range_ticks=(700, 2000))
    shoulder = with_calibration(arm, narrow).joint[1]
    assert shoulder.upper == pytest.approx((2000 - 2048) * TICK - RANGE_MARGIN)


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"joint": "elbow"}, "joint"),
        ({"model": "xl430-w250"}, "model"),
        ({"protocol": 1}, "protocol"),
        ({"drive_mode": 1}, "armsyn setup"),
        ({"id": 99}, "servos are"),
    ],
)
def test_another_arms_file_is_refused(
    omx: ArmDescription, fields: dict[str, Any], said: str
) -> None:
    with pytest.raises(InputError, match=said):
        with_calibration(omx, changed(calibration_of(omx), 0, **fields))


def test_another_kinds_file_is_refused(omx: ArmDescription) -> None:
    with pytest.raises(InputError, match="koch"):
        with_calibration(omx, calibration_of(omx, arm="koch"))


# where it is found


def written(folder: Path, stem: str, calibration: ArmCalibration) -> Path:
    path = folder / f"{stem}.calibration.json"
    path.write_bytes(format_calibration(calibration))
    return path


def test_an_arm_is_loaded_with_its_calibration(folder: Path, omx: ArmDescription) -> None:
    written(folder, omx.name, changed(calibration_of(omx), 0, zero_tick=2060))
    assert load_arm(omx.name, folder).servo[0].zero_tick == 2060
    assert load_arm(omx.name, folder, calibrated=False).servo[0].zero_tick == 2048


def test_arms_of_one_kind_are_told_apart_by_name(folder: Path, omx: ArmDescription) -> None:
    written(folder, f"{omx.name}.left", changed(calibration_of(omx), 0, zero_tick=2070))
    assert load_arm(omx.name, folder, unit="left").servo[0].zero_tick == 2070
    assert load_arm(omx.name, folder).servo[0].zero_tick == 2048
    with pytest.raises(DescriptionError, match=r"armsyn calibrate --arm \w+ --name right"):
        load_arm(omx.name, folder, unit="right")


def test_an_arm_of_a_kind_and_a_kind_of_that_name_do_not_share_a_file() -> None:
    assert file_stem("koch", "left") != file_stem("koch-left", None)


@pytest.mark.parametrize("name", ["", "../left", "a/b", "a-b", "x" * 33, "."])
def test_names_are_names_not_paths(name: str) -> None:
    with pytest.raises(InputError, match="--name"):
        file_stem("koch", name)


def test_a_file_that_does_not_fit_is_named(folder: Path, omx: ArmDescription) -> None:
    path = written(folder, omx.name, calibration_of(omx, arm="koch"))
    with pytest.raises(DescriptionError, match=path.name):
        load_arm(omx.name, folder)


def test_files_are_written_where_they_are_searched_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert folder_for_writing("koch", tmp_path) == tmp_path
    monkeypatch.setenv("ARMSYN_CALIBRATION", str(tmp_path / "mine"))
    assert folder_for_writing("koch") == tmp_path / "mine"
    monkeypatch.delenv("ARMSYN_CALIBRATION")
    monkeypatch.chdir(CALIBRATION.parent)
    assert folder_for_writing("koch") == Path("calibration")


def test_without_a_description_here_files_go_where_every_folder_finds_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, omx: ArmDescription
) -> None:
    monkeypatch.delenv("ARMSYN_CALIBRATION", raising=False)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.chdir(tmp_path)
    folder = folder_for_writing(omx.name)
    assert folder == tmp_path / "config/armsyn/calibration"
    folder.mkdir(parents=True)
    path = written(folder, omx.name, calibration_of(omx))
    assert is_found_from_everywhere(path)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert find_calibration(omx.name, None) == path
    assert not is_found_from_everywhere(tmp_path / "calibration" / path.name)


def test_a_relative_configuration_folder_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", "somewhere")
    monkeypatch.setenv("HOME", "/home/nobody")
    assert user_folder() == Path("/home/nobody/.config/armsyn/calibration")


# reading


def test_written_and_read_back(omx: ArmDescription) -> None:
    calibration = changed(calibration_of(omx, name="left"), 2, range_ticks=(-5, 4100))
    assert parse_calibration(format_calibration(calibration), "x") == calibration


ticks = st.integers(-(2**31), 2**31 - 1)


@given(
    zero=ticks,
    ends=st.none() | st.lists(ticks, min_size=2, max_size=2, unique=True).map(sorted),
    direction=st.sampled_from([1, -1]),
    name=st.none() | st.text(max_size=5),
)
def test_whatever_can_be_written_reads_back(
    zero: int, ends: list[int] | None, direction: int, name: str | None
) -> None:
    arm = load_arm("openmanipulator_x", CALIBRATION, calibrated=False)
    fields = {"zero_tick": zero, "direction": direction}
    fields |= {"range_ticks": None if ends is None else tuple(ends)}  # type: ignore[dict-item]
    calibration = changed(calibration_of(arm, name=name), 1, **fields)
    assert parse_calibration(format_calibration(calibration), "x") == calibration


@given(st.binary(max_size=300))
def test_garbage_is_refused_by_name(data: bytes) -> None:
    with pytest.raises(DescriptionError, match=r"^some\.file: "):
        parse_calibration(data, "some.file")


values = st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=8)


@given(
    place=st.sampled_from(["file", "servo"]),
    field=st.sampled_from([*ArmCalibration.__struct_fields__, *ServoCalibration.__struct_fields__]),
    value=values | st.lists(values, max_size=3) | st.dictionaries(st.text(max_size=3), values),
)
def test_a_field_of_another_kind_never_comes_through(place: str, field: str, value: Any) -> None:
    arm = load_arm("openmanipulator_x", CALIBRATION, calibrated=False)
    document = json.loads(format_calibration(calibration_of(arm)))
    target = document if place == "file" else document["servo"][1]
    target[field] = value
    try:
        read = parse_calibration(json.dumps(document).encode(), "f.json")
    except DescriptionError as error:
        assert str(error).startswith("f.json: ")  # noqa: PT017 - it need not be raised
        return
    assert json.loads(format_calibration(read)) == document


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        ("schema", "armsyn-calibration-2", "schema"),
        ("date", "yesterday", "date"),
        ("date", "2026-01-02T03:04:05", "UTC"),
        ("servo", [], "servo"),
        ("extra", 1, "extra"),
        ("method", "luck", "method"),
    ],
)
def test_wrong_fields_are_named(omx: ArmDescription, field: str, value: Any, said: str) -> None:
    document = json.loads(format_calibration(calibration_of(omx))) | {field: value}
    with pytest.raises(DescriptionError, match=said):
        parse_calibration(json.dumps(document).encode(), "f.json")


def test_an_id_twice_and_an_empty_range_are_refused(omx: ArmDescription) -> None:
    for broken in (
        changed(calibration_of(omx), 1, id=11),
        changed(calibration_of(omx), 1, range_ticks=(5, 5)),
    ):
        with pytest.raises(DescriptionError):
            parse_calibration(format_calibration(broken), "f.json")


def test_huge_and_missing_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "huge.calibration.json"
    path.write_bytes(b" " * 1_000_001)
    with pytest.raises(DescriptionError, match="larger"):
        read_calibration(path)
    with pytest.raises(DescriptionError, match="nothing"):
        read_calibration(tmp_path / "nothing")
