"""Backups of EEPROM: the way back, and what is refused."""

from pathlib import Path

import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.driver.eeprom import eeprom_rows, read_eeprom
from armsyn.driver.eeprom_file import BackupFile, Reach, read_backup
from armsyn.driver.models import MODELS, servo_model
from armsyn.driver.scan import FoundServo
from armsyn.driver.setup_restore import plan_restore
from armsyn.driver.setup_write import write_changes
from armsyn.errors import (
    FormatError,
    ServoMismatchError,
    ServoMissingError,
)
from firmware_sim.tables import find_model
from tests.driver.set_up_bench import bench, carried_out, names, planned


@pytest.fixture(scope="module")
def widowx() -> ArmDescription:
    return load_arm("widowx_250s", calibrated=False)


@pytest.mark.parametrize("model", ["xm430-w350", "ax-12a", "xl-320", "mx-28"])
def test_a_backup_restores_every_register(tmp_path: Path, model: str) -> None:
    protocol = find_model(model).protocol
    bus = bench(f"{model}:5")
    baud = int(bus.port.baud_rate)
    number = servo_model(model, protocol).number
    image = read_eeprom(bus, FoundServo(baud, protocol, 5, number, 0))
    backup = BackupFile(tmp_path, "some_arm", "port")
    backup.add(image, Reach(5, 1 if protocol == 1 else 2, baud))
    old = dict(image.registers)
    servo = bus.port.bus.servos[0]
    limit = next(row for row in eeprom_rows(image.model.layout) if row.name == "Temperature Limit")
    servo.write(limit.address, b"\x2a")
    (plan,) = plan_restore(bus, read_backup(backup.path), backup.path)
    assert names(plan) == ["Temperature Limit"]
    now = write_changes(bus, plan.image, plan.changes, plan.title)
    assert now.registers == old


def test_a_set_up_is_undone_at_its_new_place(tmp_path: Path, widowx: ArmDescription) -> None:
    bus = bench("xm430-w350:1")
    old = bytes(bus.port.bus.servos[0].memory.data[:64])
    plan = planned(bus, widowx, 3)
    backup = BackupFile(tmp_path / "new" / "folder", widowx.name, "port")
    target = plan.target
    backup.add(plan.image, Reach(target.servo_id, 2, target.baud))
    carried_out(bus, plan)
    assert bytes(bus.port.bus.servos[0].memory.data[:64]) != old
    (restore,) = plan_restore(bus, read_backup(backup.path), backup.path)
    assert names(restore)[-2:] == ["ID", "Baud Rate"]
    write_changes(bus, restore.image, restore.changes, restore.title)
    assert bytes(bus.port.bus.servos[0].memory.data[:64]) == old
    (nothing,) = plan_restore(bus, read_backup(backup.path), backup.path)
    assert not nothing.changes


@pytest.mark.parametrize("model", ["ax-12a", "mx-28"])
def test_a_classic_servo_goes_back_to_its_old_rate(tmp_path: Path, model: str) -> None:
    bus = bench(f"{model}:5", baud=115_200)
    image = read_eeprom(bus, FoundServo(115_200, 1, 5, servo_model(model, 1).number, 0))
    backup = BackupFile(tmp_path, "some_arm", "port")
    backup.add(image, Reach(5, 1, 1_000_000))
    bus.port.bus.servos[0].write(4, b"\x01")
    bus.setBaudRate(1_000_000)
    (plan,) = plan_restore(bus, read_backup(backup.path), backup.path)
    assert names(plan) == ["Baud Rate"]
    now = write_changes(bus, plan.image, plan.changes, plan.title)
    assert (now.registers, bus.baudrate) == (image.registers, 115_200)


def test_backups_never_replace_each_other(tmp_path: Path, widowx: ArmDescription) -> None:
    bus = bench("xm430-w350:1")
    image = planned(bus, widowx, 3).image
    paths = set()
    for _ in range(3):
        backup = BackupFile(tmp_path, widowx.name, "port")
        backup.add(image, Reach(3, 2, 1_000_000))
        paths.add(backup.path)
    assert len(paths) == len(list(tmp_path.iterdir())) == 3


def backup_of(tmp_path: Path, *models: str) -> Path:
    """A backup of servos that all had ID 1, and became 1, 2, ..."""
    backup = BackupFile(tmp_path, "some_arm", "port")
    for number, model in enumerate(models, 1):
        bus = bench(f"{model}:1")
        found = FoundServo(57_600, 2, 1, MODELS[model, 2].number, 45)
        backup.add(read_eeprom(bus, found), Reach(number, 2, 1_000_000))
    return backup.path


def test_another_model_is_not_restored(tmp_path: Path) -> None:
    path = backup_of(tmp_path, "xl430-w250")
    bus = bench("xm430-w350:1")
    with pytest.raises(ServoMismatchError, match="is an xm430-w350"):
        plan_restore(bus, read_backup(path), path)


def test_servos_that_would_get_one_id_are_restored_one_at_a_time(tmp_path: Path) -> None:
    path = backup_of(tmp_path, "xm430-w350", "xm430-w350")
    bus = bench("xm430-w350:1", "xm430-w350:2", baud=1_000_000)
    backup = read_backup(path)
    with pytest.raises(ServoMismatchError, match="one at a time"):
        plan_restore(bus, backup, path)
    with pytest.raises(ServoMissingError):
        plan_restore(bench("xl430-w250:9"), backup, path, 2)
    (plan,) = plan_restore(bench("xm430-w350:2", baud=1_000_000), backup, path, 2)
    assert set(names(plan)) == {"ID", "Baud Rate"}


@pytest.mark.fault(36)
@pytest.mark.parametrize(
    "damage",
    [
        ('"armsyn-eeprom-1"', '"armsyn-eeprom-9"'),
        ('"ID": 1', '"ID": 999'),
        ('"Homing Offset"', '"Somewhere Else"'),
        ('"model_number": 1060', '"model_number": 61'),
        ('"was"', '"wis"'),
        ('"Shutdown": 52', '"Shutdown": NaN'),
    ],
)
def test_damaged_backups_are_refused_with_their_name(
    tmp_path: Path, damage: tuple[str, str]
) -> None:
    path = backup_of(tmp_path, "xl430-w250")
    text = path.read_text()
    assert damage[0] in text
    path.write_text(text.replace(*damage))
    bus = bench("xl430-w250:1")
    with pytest.raises(FormatError, match=path.name):
        plan_restore(bus, read_backup(path), path)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("# Notes", "or a damaged one: JSON is malformed"),
        ("", "or a damaged one"),
        ('{"schema": "armsyn-calibration-1"}', "its schema is 'armsyn-calibration-1'"),
        ("[1, 2]", "or a damaged one: Expected `object`"),
    ],
)
def test_another_file_is_told_from_a_backup(tmp_path: Path, content: str, said: str) -> None:
    path = tmp_path / "other.json"
    path.write_text(content)
    with pytest.raises(FormatError) as caught:
        read_backup(path)
    message = str(caught.value)
    assert message.startswith(f"{path} is no backup of servos' EEPROM (ARM-DATE.eeprom.json")
    assert said in message
