"""Which writes are refused, and with which error number."""

from collections.abc import Callable

import pytest

from firmware_sim.firmware.codes import StatusError
from firmware_sim.firmware.world import build_world
from firmware_sim.rig.settings import ServoSettings
from firmware_sim.tables import MODEL_NAMES, find_model

from .conftest import Bench

MakeBench = Callable[..., Bench]


@pytest.mark.parametrize("address", [0, 6, 69, 70, 120, 122, 126, 132, 144, 146, 147])
def test_read_only_registers_refuse_writes(bench: MakeBench, address: int) -> None:
    rig = bench()
    register = rig.servos[0].model.table.by_address[address]
    before = rig.read(address, register.size)
    assert rig.write(address, 1, register.size) == StatusError.ACCESS
    assert rig.read(address, register.size) == before or address == 120


def test_undefined_addresses_refuse_writes(bench: MakeBench) -> None:
    rig = bench()
    assert rig.write(14, 1) == StatusError.ACCESS
    assert rig.write(1000, 1) == StatusError.ACCESS
    assert rig.write(70, 0, 8) == StatusError.ACCESS


def test_eeprom_is_locked_while_torque_is_on(bench: MakeBench) -> None:
    rig = bench()
    rig.write(64, 1)
    assert rig.write(9, 5) == StatusError.ACCESS
    assert rig.read(9) == 0
    rig.write(64, 0)
    assert rig.write(9, 5) == 0


def test_part_of_a_register_is_a_length_error(bench: MakeBench) -> None:
    rig = bench()
    assert rig.write(116, 100, 2) == StatusError.DATA_LENGTH
    assert rig.write(118, 0, 2) == StatusError.DATA_LENGTH
    assert rig.write(112, 100, 6) == StatusError.DATA_LENGTH
    assert rig.read(116, 4) == 2048


@pytest.mark.parametrize(
    ("address", "size", "value"),
    [
        (7, 1, 253),
        (8, 1, 8),
        (9, 1, 255),
        (20, 4, 1_044_480),
        (32, 2, 161),
        (36, 2, 886),
        (52, 4, -1),
        (64, 1, 2),
        (68, 1, 3),
        (84, 2, 16_384),
        (98, 1, 128),
        (112, 4, 32_768),
    ],
)
def test_a_value_outside_the_registers_range_is_a_range_error(
    bench: MakeBench, address: int, size: int, value: int
) -> None:
    rig = bench()
    before = rig.read(address, size)
    assert rig.write(address, value, size) == StatusError.DATA_RANGE
    assert rig.read(address, size) == before


@pytest.mark.parametrize(
    ("name", "address", "value"),
    [
        ("xl430-w250", 11, 0),  # no current mode
        ("xl430-w250", 11, 5),
        ("xm430-w350", 11, 2),  # no such mode
        ("xl330-m288", 13, 20),  # remote controls
        ("xl330-m288", 13, 1),
        ("xm540-w270", 10, 2),  # the slave of a dual joint
        ("xm540-w270", 13, 20),
        ("xl330-m288", 8, 7),  # 4.5 Mbaud
    ],
)
def test_settings_that_a_model_has_not_are_refused(
    bench: MakeBench, name: str, address: int, value: int
) -> None:
    assert bench(f"{name}:1").write(address, value) == StatusError.DATA_RANGE


@pytest.mark.parametrize(
    ("name", "firmware", "bit"), [("xm430-w350", 41, 4), ("xm430-w350", 44, 8)]
)
def test_drive_modes_that_came_with_a_later_firmware_are_refused(
    name: str, firmware: int, bit: int
) -> None:
    for version, error in ((firmware, StatusError.DATA_RANGE), (firmware + 1, StatusError.NONE)):
        world = build_world([ServoSettings(find_model(name, version), 1)])
        assert world.servos[0].write(10, bytes((bit,))) == error
        assert world.servos[0].read(6, 1)[1] == bytes((version,))


def test_a_value_outside_a_limit_register_is_a_limit_error(bench: MakeBench) -> None:
    rig = bench()
    for address, size, limit_address, limit in (
        (100, 2, 36, 400),
        (102, 2, 38, 500),
        (104, 4, 44, 60),
    ):
        assert rig.write(limit_address, limit, size) == 0
        assert rig.write(address, limit, size) == 0
        assert rig.write(address, -limit, size) == 0
        assert rig.write(address, limit + 1, size) == StatusError.DATA_LIMIT


def test_position_limits_hold_in_position_mode_only(bench: MakeBench) -> None:
    rig = bench()
    assert rig.write(52, 1000, 4) == rig.write(48, 3000, 4) == 0
    for goal in (999, 3001, -1, 4096):
        assert rig.write(116, goal, 4) == StatusError.DATA_LIMIT
    assert rig.write(116, 1000, 4) == rig.write(116, 3000, 4) == 0
    assert rig.write(11, 4) == 0
    assert rig.write(116, -1_048_575, 4) == 0
    assert rig.write(116, 1_048_576, 4) == StatusError.DATA_RANGE


def test_a_write_of_several_registers_is_done_whole_or_not_at_all(bench: MakeBench) -> None:
    rig = bench()
    profile = (5).to_bytes(4, "little") + (7).to_bytes(4, "little")
    good = (108).to_bytes(2, "little") + profile + (1500).to_bytes(4, "little")
    assert rig.ask(1, 0x03, good) == [(1, 0)]
    assert [rig.read(address, 4) for address in (108, 112, 116)] == [5, 7, 1500]
    bad = (108).to_bytes(2, "little") + bytes(8) + (5000).to_bytes(4, "little")
    assert rig.ask(1, 0x03, bad) == [(1, StatusError.DATA_LIMIT)]
    assert [rig.read(address, 4) for address in (108, 112, 116)] == [5, 7, 1500]


def test_a_registered_write_is_checked_when_it_comes(bench: MakeBench) -> None:
    rig = bench()
    params = (116).to_bytes(2, "little") + (5000).to_bytes(4, "little")
    assert rig.ask(1, 0x04, params) == [(1, StatusError.DATA_LIMIT)]
    assert rig.read(69) == 0


def test_a_new_operating_mode_resets_gains_profile_and_goals(bench: MakeBench) -> None:
    rig = bench()
    for address, value, size in ((84, 100, 2), (82, 9, 2), (112, 50, 4), (108, 7, 4), (100, 3, 2)):
        assert rig.write(address, value, size) == 0
    assert rig.write(11, 4) == 0
    assert [rig.read(a, s) for a, s in ((84, 2), (82, 2), (112, 4), (108, 4), (100, 2))] == [
        800,
        0,
        0,
        0,
        885,
    ]
    rig.write(84, 100, 2)
    rig.write(11, 4)  # the same mode again changes nothing
    assert rig.read(84, 2) == 100


@pytest.mark.parametrize("name", MODEL_NAMES)
def test_every_default_is_within_its_own_range(name: str) -> None:
    for register in find_model(name).table.registers:
        assert register.minimum <= register.default <= register.maximum, register


def test_every_model_boots_healthy(bench: MakeBench) -> None:
    for name in MODEL_NAMES:
        if find_model(name).family != "x":
            continue
        rig = bench(f"{name}:1")
        assert rig.read(70) == 0
        assert rig.write(64, 1) == 0
        assert rig.read(116, 4) == rig.read(132, 4) == 2048


def test_a_supply_outside_its_limits_is_a_hardware_error(bench: MakeBench) -> None:
    rig = bench()
    rig.write(34, 125, 2)  # minimum 12.5 V, on a supply of 12.0 V
    rig.ask(1, 0x08)
    rig.wait(0.2)
    assert rig.read(70) == 0x01
    assert rig.read(144, 2) == 120
    assert rig.write(64, 1) == 0x80  # Shutdown(63) does not name it on this model
