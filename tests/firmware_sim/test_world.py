"""Servos in one time: what happens does not depend on how often the world is told the time."""

import hypothesis.strategies as st
import pytest
from hypothesis import given, settings

from firmware_sim.firmware.codes import CLEAR_MULTI_TURN, StatusError
from firmware_sim.firmware.servo import Servo
from firmware_sim.firmware.world import World, build_world
from firmware_sim.rig.settings import ServoSettings
from firmware_sim.tables import find_model

from .solo import Solo, raw

XM430, XL330 = find_model("xm430-w350"), find_model("xl330-m288")


def pair() -> World:
    """Two servos that move, one of which runs into a stop and shuts down."""
    world = build_world([ServoSettings(XM430, 1), ServoSettings(XL330, 2)])
    first, second = world.servos
    for servo in world.servos:
        assert servo.write(64, b"\x01") == StatusError.NONE
    second.write(98, b"\x14")  # the watchdog, 400 ms
    assert first.write(112, raw(30, 4)) == StatusError.NONE
    assert first.write(116, raw(3000, 4)) == StatusError.NONE
    assert second.write(116, raw(4000, 4)) == StatusError.NONE
    second.axis.jam(on=True)
    return world


def registers(servo: Servo) -> bytes:
    error, data = servo.read(64, 104)
    assert error == StatusError.NONE
    return data


@given(st.lists(st.floats(0.0, 0.7), min_size=1, max_size=15))
@settings(max_examples=40, deadline=None)
def test_the_way_there_makes_no_difference(waits: list[float]) -> None:
    often, once = pair(), pair()
    now = 0.0
    for wait in waits:
        now += wait
        often.advance(now)
        for servo in often.servos:
            servo.read(120, 27)
    once.advance(now)
    for one, other in zip(often.servos, once.servos, strict=True):
        assert registers(one) == registers(other)


def test_time_does_not_go_back() -> None:
    world = pair()
    world.advance(1.0)
    before = [registers(servo) for servo in world.servos]
    world.advance(0.3)
    assert world.now == 1.0
    assert [registers(servo) for servo in world.servos] == before


def test_the_next_event_is_what_a_servo_does_of_itself() -> None:
    world = build_world([ServoSettings(XM430, 1), ServoSettings(XL330, 2)], when=10.0)
    assert world.next_event is None
    servo = world.servos[1]
    servo.feed(10.0)
    for address, value in ((64, 1), (98, 5)):
        servo.write(address, bytes((value,)))
    assert world.next_event == pytest.approx(10.1)
    world.advance(10.05)
    servo.feed(10.05)
    assert world.next_event == pytest.approx(10.15)
    world.advance(10.16)
    assert servo.read(98, 1)[1] == b"\xff"
    assert world.next_event is None
    world.servos[0].power_cycle(off_for=2.0)
    assert world.next_event == pytest.approx(12.16)


def test_a_world_at_rest_says_so() -> None:
    world = build_world([ServoSettings(XM430, 1)])
    world.advance(1.0)
    assert not world.moving
    world.servos[0].write(64, b"\x01")
    world.servos[0].write(116, raw(3000, 4))
    assert world.moving
    world.advance(5.0)
    assert not world.moving


def test_an_hour_at_rest_takes_no_steps_of_its_own() -> None:
    solo = Solo()
    solo.set(Torque_Enable=1)
    solo.axis.apply_load(1.0)
    solo.wait(5.0)
    warm = solo.read("Present Temperature")
    solo.wait(3600.0)
    current = (1.0 / 4.1) * 2.3
    final = 25.0 + 8.0 * 12.0 / 2.3 * current**2
    assert warm < solo.read("Present Temperature") == pytest.approx(final, abs=1.5)


def test_servos_need_not_differ_in_their_ids() -> None:
    world = build_world([ServoSettings(XM430, 1, 1000), ServoSettings(XM430, 1, 2000)])
    positions = [servo.read(132, 4)[1] for servo in world.servos]
    assert positions == [raw(1000, 4), raw(2000, 4)]


def test_the_realtime_tick_counts_milliseconds_and_wraps() -> None:
    solo = Solo()
    solo.wait(0.123)
    assert solo.read("Realtime Tick") == 123
    solo.wait(32.0)
    assert solo.read("Realtime Tick") == 32_123
    solo.wait(0.645)
    assert solo.read("Realtime Tick") == 0
    solo.wait(0.5)
    solo.servo.reboot()
    assert solo.read("Realtime Tick") == 0


def test_clear_folds_the_turns_and_keeps_the_horn() -> None:
    solo = Solo(Operating_Mode=4)
    solo.set(Torque_Enable=1, Goal_Position=10_000)
    solo.wait(0.2)
    assert solo.servo.clear(CLEAR_MULTI_TURN) == StatusError.RESULT_FAIL  # it moves
    solo.wait(5.0)
    before = solo.read("Present Position")
    assert solo.servo.clear(CLEAR_MULTI_TURN) == StatusError.NONE
    solo.wait(1.0)
    assert solo.read("Present Position") == before - 2 * 4096
    assert solo.read("Goal Position") == 10_000 - 2 * 4096
    assert solo.servo.clear(b"\x02DXL\x22") == StatusError.DATA_RANGE


def test_positions_of_a_hundred_thousand_turns_wrap_as_the_register_does() -> None:
    """A wheel that has turned for weeks: 2^31 ticks are 524288 turns."""
    solo = Solo(start_tick=2**31 - 3)
    solo.servo.firmware.install(solo.servo.firmware.angle(2**31 + 5), 12.0)
    assert solo.read("Present Position") == -(2**31) + 5 - 2 * 4096 % 4096


def test_an_external_port_reads_its_pull_and_writes_as_an_output() -> None:
    solo = Solo("xm540-w270", External_Port_Mode_1=2, External_Port_Mode_2=3)
    assert solo.read("External Port Data 1") == 1
    assert solo.read("External Port Data 2") == 0
    assert solo.write("External Port Data 1", 1) == StatusError.ACCESS
    solo.set(External_Port_Mode_3=1)
    solo.set(External_Port_Data_3=1)
    assert solo.read("External Port Data 3") == 1
    solo.set(External_Port_Mode_3=0)
    assert solo.read("External Port Data 3") == 0


def test_a_secondary_id_reaches_ram_only() -> None:
    solo = Solo()
    assert solo.servo.secondary_id is None
    for value, seen in ((7, 7), (252, 252), (253, None), (0, 0), (255, None)):
        solo.set(**{"Secondary(Shadow)_ID": value})
        assert solo.servo.secondary_id == seen
    assert solo.servo.write(7, b"\x05", ram_only=True) == StatusError.ACCESS
    assert solo.servo.write(65, b"\x01", ram_only=True) == StatusError.NONE
    assert (solo.servo.servo_id, solo.read("LED")) == (1, 1)
    assert solo.servo.register_write(31, b"\x05", ram_only=True) == StatusError.ACCESS


def test_a_registered_write_waits_for_its_action() -> None:
    solo = Solo()
    assert solo.servo.act() == StatusError.INSTRUCTION
    assert solo.servo.register_write(65, b"\x01") == StatusError.NONE
    assert (solo.read("Registered Instruction"), solo.read("LED")) == (1, 0)
    assert solo.servo.act() == StatusError.NONE
    assert (solo.read("Registered Instruction"), solo.read("LED")) == (0, 1)
    assert solo.servo.act() == StatusError.INSTRUCTION
    solo.servo.register_write(65, b"\x00")
    solo.servo.reboot()
    assert solo.read("Registered Instruction") == 0
    assert solo.servo.act() == StatusError.INSTRUCTION


@pytest.mark.parametrize("name", ["xm430-w350", "xl330-m288", "mx-28"])
def test_protocol_types(name: str) -> None:
    solo = Solo(name, protocol=2)
    takes_1 = name != "xl330-m288"
    assert solo.servo.protocol == 2
    for value in (20, 21, 22, 0, 3):
        assert solo.write("Protocol Type", value) == StatusError.DATA_RANGE
    refused = StatusError.NONE if takes_1 else StatusError.DATA_RANGE
    assert solo.write("Protocol Type", 1) == refused
    assert solo.servo.protocol == (1 if takes_1 else 2)


def test_a_servo_on_protocol_1_has_no_bus_watchdog() -> None:
    solo = Solo(Protocol_Type=1)
    solo.set(Torque_Enable=1, Bus_Watchdog=1)
    solo.wait(1.0)
    assert solo.read("Bus Watchdog") == 1
