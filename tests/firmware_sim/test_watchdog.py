"""The bus watchdog: what keeps it quiet, what it does, and how it is cleared."""

from collections.abc import Callable

import pytest

from firmware_sim.firmware.codes import StatusError

from .conftest import Bench

MakeBench = Callable[..., Bench]
WATCHDOG, GOAL = 98, 116
EXPIRED = 255  # -1 in one byte


def armed(bench: MakeBench, *names: str) -> Bench:
    rig = bench(*(names or ("xm430-w350:1",)))
    for servo in rig.servos:
        servo_id = servo.servo_id
        assert rig.write(64, 1, servo_id=servo_id) == 0
        assert rig.write(WATCHDOG, 5, servo_id=servo_id) == 0  # 100 ms
    return rig


def test_it_expires_when_nothing_is_heard_for_its_time(bench: MakeBench) -> None:
    rig = armed(bench)
    rig.wait(0.0995)
    assert rig.read(WATCHDOG) == 5
    rig.wait(0.101)
    assert rig.read(WATCHDOG) == EXPIRED


@pytest.mark.parametrize("instruction", [0x01, 0x02, 0x05, 0x77])
def test_any_instruction_to_the_servo_feeds_it(bench: MakeBench, instruction: int) -> None:
    rig = armed(bench)
    for _ in range(10):
        rig.wait(0.08)
        rig.ask(1, instruction, b"\x84\x00\x04\x00" if instruction == 2 else b"")
    assert rig.read(WATCHDOG) == 5


@pytest.mark.parametrize("named", [1, 77, 254])
def test_any_instruction_feeds_all_who_hear_it(bench: MakeBench, named: int) -> None:
    """The manual counts "all the Instruction Packet in the DYNAMIXEL Protocol"."""
    rig = armed(bench, "xm430-w350:1", "xm430-w350:2")
    for _ in range(3):
        rig.wait(0.08)
        rig.ask(named, 0x82 if named == 254 else 0x01, bytes((132, 0, 4, 0, 1)))
    assert [rig.read(WATCHDOG, servo_id=i) for i in (1, 2)] == [5, 5]


def test_what_a_servo_does_not_hear_does_not_feed_it(bench: MakeBench) -> None:
    rig = armed(bench, "xm430-w350:1", "xm430-w350:2")
    rig.servos[1].silenced = True
    for _ in range(3):
        rig.wait(0.08)
        rig.ask(1, 0x01)
    rig.servos[1].silenced = False
    assert [rig.read(WATCHDOG, servo_id=i) for i in (1, 2)] == [5, EXPIRED]


def test_it_stops_the_servo_where_it_is(bench: MakeBench) -> None:
    rig = armed(bench)
    rig.write(112, 20, 4)
    assert rig.write(GOAL, 3048, 4) == 0
    rig.wait(0.05)
    rig.wait(0.3)
    halt = rig.read(GOAL, 4)
    assert 2048 < halt < 2100  # 20 units are 313 ticks/s, for a tenth of a second
    rig.wait(2.0)
    assert abs(rig.read(132, 4) - halt) <= 1
    assert rig.read(112, 4) == rig.read(108, 4) == 0
    assert rig.read(64) == 1


@pytest.mark.parametrize(("address", "size"), [(100, 2), (102, 2), (104, 4), (116, 4)])
def test_it_refuses_goals_until_it_is_cleared(bench: MakeBench, address: int, size: int) -> None:
    rig = armed(bench)
    rig.wait(0.2)
    assert rig.write(address, 100, size) == StatusError.DATA_RANGE
    assert rig.write(WATCHDOG, 5) == StatusError.DATA_RANGE
    assert rig.write(65, 1) == 0  # other registers are free
    assert rig.write(WATCHDOG, 0) == 0
    assert rig.write(address, 100, size) == 0
    assert rig.write(WATCHDOG, 5) == 0


def test_sync_writes_are_refused_in_silence(bench: MakeBench) -> None:
    rig = armed(bench)
    rig.wait(0.2)
    held = rig.read(GOAL, 4)
    rig.ask(254, 0x83, bytes((116, 0, 4, 0, 1, 0, 10, 0, 0)))
    assert rig.read(GOAL, 4) == held


def test_it_watches_only_while_the_torque_is_on(bench: MakeBench) -> None:
    rig = bench()
    rig.write(WATCHDOG, 5)
    rig.wait(1.0)
    assert rig.read(WATCHDOG) == 5
    rig.write(64, 1)
    rig.wait(0.2)
    assert rig.read(WATCHDOG) == EXPIRED


def test_a_reboot_clears_it(bench: MakeBench) -> None:
    rig = armed(bench)
    rig.wait(0.2)
    rig.ask(1, 0x08)
    rig.wait(0.2)
    assert rig.read(WATCHDOG) == 0
