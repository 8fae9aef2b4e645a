"""Time on the wire, wrong baud rates, gaps, and the same bytes each time."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_sim.bus import Bus
from firmware_sim.line import garble
from firmware_sim.packet import build_packet
from firmware_sim.servo import Servo
from firmware_sim.tables import find_model

from .conftest import FACTORY, Bench

MakeBench = Callable[..., Bench]
PING = build_packet(1, 0x01)


def sync_read(size: int, *servo_ids: int) -> bytes:
    return build_packet(254, 0x82, bytes((126, 0, size, 0, *servo_ids)))


def test_a_ping_takes_its_own_and_its_answers_wire_time(bench: MakeBench) -> None:
    rig = bench()
    answers = rig.bus.receive(PING, 1.0, 1_000_000)
    assert [answer.due for answer in answers] == [pytest.approx(1.0 + 10e-5 + 14e-5)]


@pytest.mark.parametrize(
    ("baud", "delay_us", "milliseconds"),
    [(57_600, 500, 41.174), (1_000_000, 500, 5.67), (1_000_000, 0, 2.17), (4_000_000, 0, 0.54)],
)
def test_a_cycle_of_seven_servos_takes_what_the_arithmetic_says(
    bench: MakeBench, baud: int, delay_us: int, milliseconds: float
) -> None:
    """Goals out, ten bytes of each servo back: 14 + 5N, 14 + N and N (11 + L) bytes."""
    ids = range(1, 8)
    code = {57_600: 1, 1_000_000: 3, 4_000_000: 6}[baud]
    rig = bench(*(f"xm430-w350:{i}" for i in ids), Baud_Rate=code, Return_Delay_Time=delay_us // 2)
    goals = build_packet(
        254, 0x83, bytes((116, 0, 4, 0)) + b"".join(bytes((i, 0, 8, 0, 0)) for i in ids)
    )
    assert rig.bus.receive(goals, 0.0, baud) == []
    answers = rig.bus.receive(sync_read(10, *ids), 0.0, baud)
    assert len(answers) == 7
    assert answers[-1].due * 1e3 == pytest.approx(milliseconds, abs=0.006)


def test_answers_fall_due_one_after_the_other(bench: MakeBench) -> None:
    rig = bench("xm430-w350:1", "xm430-w350:2")
    dues = [answer.due for answer in rig.bus.receive(sync_read(10, 1, 2), 0.0, 1_000_000)]
    assert dues == pytest.approx([16e-5 + 21e-5, 16e-5 + 42e-5])


def test_a_request_takes_effect_at_the_end_of_its_last_byte(bench: MakeBench) -> None:
    rig = bench(Baud_Rate=0)  # 9600 bit/s: 14 bytes take 14.6 ms
    rig.port.baud_rate = 9_600
    rig.ask(1, 0x03, bytes((112, 0, 20, 0, 0, 0)))
    rig.ask(1, 0x03, bytes((64, 0, 1)))
    rig.clock.advance_to(1.0)
    rig.port.write(build_packet(1, 0x03, bytes((116, 0, 0xB8, 11, 0, 0))))
    rig.bus.advance(1.0 + 15.5e-3)
    assert rig.servos[0].actuator.drive.trajectory == 2048
    rig.bus.advance(1.0 + 20e-3)
    assert rig.servos[0].actuator.drive.trajectory > 2048


def test_the_same_requests_give_the_same_bytes(bench: MakeBench) -> None:
    def run() -> bytes:
        rig = bench("xm430-w350:1", "xl330-m288:2")
        heard = b""
        for step in range(100):
            rig.clock.advance_to(step * 0.005)
            heard += rig.port.exchange(build_packet(254, 0x03, bytes((64, 0, 1))))
            goal = (2048 + 7 * step).to_bytes(4, "little")
            shares = b"\x01" + goal + b"\x02" + goal
            heard += rig.port.exchange(build_packet(254, 0x83, bytes((116, 0, 4, 0)) + shares))
            heard += rig.port.exchange(sync_read(21, 1, 2))
        return heard

    assert run() == run()


def test_a_stepped_run_does_not_depend_on_who_asks_meanwhile(bench: MakeBench) -> None:
    """Physics goes on in steps of its own, whether it is looked at or not."""

    def position(looks: int) -> int:
        rig = bench()
        rig.write(64, 1)
        rig.write(116, 3000, 4)
        rig.clock.advance_to(0.0101)
        for look in range(looks):
            rig.clock.advance_to(0.0101 + 0.05 * look / looks)
            rig.read(132, 4)
        rig.clock.advance_to(0.0801)
        return rig.read(132, 4)

    assert position(1) == position(7) == position(33)


def test_two_servos_of_one_id_both_answer(bench: MakeBench) -> None:
    rig = bench("xm430-w350:1", "xm540-w270:1")
    assert [answer[2] for answer in rig.ask(1, 0x01)] == [1020 & 0xFF, 1120 & 0xFF]


@pytest.mark.parametrize("baud", [57_600, 115_200, 2_000_000, 980_000 // 2])
def test_a_wrong_baud_rate_is_answered_with_garbage_and_does_nothing(
    bench: MakeBench, baud: int
) -> None:
    rig = bench()
    rig.port.baud_rate = baud
    write = build_packet(1, 0x03, bytes((65, 0, 1)))
    noise = rig.port.exchange(write)
    assert noise != write
    assert noise or baud > 1_000_000
    assert b"\xff\xff\xfd\x00" not in noise
    rig.port.baud_rate = 1_000_000
    assert rig.read(65) == 0


def test_a_baud_rate_off_by_less_than_three_percent_is_understood(bench: MakeBench) -> None:
    rig = bench()
    rig.port.baud_rate = 1_020_000
    assert rig.ask(1, 0x01)


def test_servos_of_another_baud_rate_are_deaf() -> None:
    slow = Servo(find_model("xm430-w350"), 1)
    fast = Servo(find_model("xm430-w350"), 2, settings=FACTORY)
    rig = Bench([slow, fast])
    assert [answer[0] for answer in rig.ask(254, 0x01)] == [2]
    rig.port.baud_rate = 57_600
    assert [answer[0] for answer in rig.ask(254, 0x01)] == [1]


@given(st.binary(max_size=40))
def test_a_line_at_one_rate_garbles_nothing(data: bytes) -> None:
    assert garble(data, 57_600, 57_600) == data


def test_a_slow_byte_heard_fast_is_the_bits_that_last_longer() -> None:
    """At four times the rate a start bit is four zeros: 00 is one long zero, then idle."""
    assert garble(b"\x00", 250_000, 1_000_000)[0] == 0x00
    assert garble(b"\xff", 250_000, 1_000_000) == b"\xf8"  # three zeros after the start bit


def test_a_fast_byte_heard_slowly_is_sampled_in_the_middle_of_the_slow_bits() -> None:
    """0 1010 1010 1 on the line: at half the rate the samples fall on bits 3, 5, 7, 9, all ones."""
    assert garble(b"\x55", 2_000_000, 1_000_000) == b"\xff"


@pytest.mark.parametrize(("gap_rule", "answered"), [(False, 1), (True, 0)])
def test_a_pause_within_a_packet_loses_it_where_the_gap_rule_is_on(
    bench: MakeBench, gap_rule: bool, answered: int
) -> None:
    rig = bench(gap_rule=gap_rule)
    rig.port.write(PING[:5])
    rig.wait(0.002)
    assert len(rig.port.exchange(PING[5:])) == 14 * answered


def test_a_short_pause_within_a_packet_is_no_gap(bench: MakeBench) -> None:
    rig = bench(gap_rule=True)
    rig.port.write(PING[:5])
    rig.wait(0.001)
    assert len(rig.port.exchange(PING[5:])) == 14


@given(st.lists(st.binary(max_size=40), max_size=12))
def test_no_bytes_whatever_end_a_bus(chunks: list[bytes]) -> None:
    bus = Bus([Servo(find_model("xl330-m288"), 1, settings=FACTORY)])
    for number, chunk in enumerate(chunks):
        bus.receive(chunk, number * 0.01, 1_000_000)
        bus.receive(build_packet(254, chunk[0] if chunk else 1, chunk), number * 0.01, 1_000_000)
    bus.advance(10.0)
    assert bus.receive(build_packet(254, 0x01), 20.0, 1_000_000)
