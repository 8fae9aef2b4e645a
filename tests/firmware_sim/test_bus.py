"""Time on the wire, wrong baud rates, gaps, and the same bytes each time."""

from collections.abc import Callable
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_sim.wire.line import garble
from firmware_sim.wire.observed import Heard, Said
from firmware_sim.wire.packet import build_packet, build_status
from firmware_sim.wire.packet1 import build_packet_1
from firmware_sim.wire.parser import DamagedPacket, Packet, PacketParser

from .conftest import Bench
from .wire import Wire, servo

MakeBench = Callable[..., Bench]
PING = build_packet(1, 0x01)
PING_1 = build_packet_1(1, 0x01)


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


def test_a_request_takes_effect_at_the_end_of_its_last_byte() -> None:
    slow = {"Baud Rate": 0}  # 9600 bit/s: 16 bytes take 16.7 ms
    wire = Wire(servo("xm430-w350:1", registers=slow))
    wire.rate = 9_600
    wire.ask(1, 0x03, bytes((112, 0, 20, 0, 0, 0)))
    wire.ask(1, 0x03, bytes((64, 0, 1)))
    wire.now = 1.0
    wire.bus.receive(build_packet(1, 0x03, bytes((116, 0, 0xB8, 11, 0, 0))), 1.0, 9_600)
    wire.bus.advance(1.0 + 15.5e-3)
    assert wire.peek(140, 4) == 2048
    wire.bus.advance(1.0 + 40e-3)
    assert wire.peek(140, 4) > 2048


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


def test_two_servos_of_one_id_talk_at_once() -> None:
    """A line is low where either pulls it: what comes is the bytes of both, and-ed."""
    one, other = (Wire(f"{name}:1").exchange(PING) for name in ("xm430-w350", "xm540-w270"))
    wire = Wire("xm430-w350:1", "xm540-w270:1")
    both = wire.exchange(PING)
    assert one != other
    assert both == bytes(a & b for a, b in zip(one, other, strict=True))
    assert [type(p) for p in PacketParser().feed(both)] == [DamagedPacket]
    assert len(wire.ask(1, 0x03, bytes((65, 0, 1)))) == 1  # equal answers are heard as one


def test_two_servos_of_one_id_with_different_delays_garble_each_other() -> None:
    late = {"Return Delay Time": 10}  # 20 us: two bytes
    wire = Wire("xm430-w350:1", servo("xm430-w350:1", registers=late))
    alone = Wire("xm430-w350:1").send(PING)[0]
    (heard,) = wire.send(PING)
    assert heard.due == pytest.approx(alone.due + 20e-6)
    assert heard.data[:2] == alone.data[:2]
    assert heard.data != alone.data
    assert not [p for p in PacketParser().feed(heard.data) if isinstance(p, Packet)]


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
    wire = Wire(servo("xm430-w350:1", registers={"Baud Rate": 1}), "xm430-w350:2")
    assert [answer[0] for answer in wire.ask(254, 0x01)] == [2]
    wire.rate = 57_600
    assert [answer[0] for answer in wire.ask(254, 0x01)] == [1]


def test_a_slow_line_is_a_few_breaks_to_a_fast_receiver() -> None:
    assert garble(b"\x00\xff" * 100, 50, 4_000_000) == b"\x00" * 200


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


def test_the_gap_rule_is_on_unless_switched_off() -> None:
    for wire, answered in ((Wire("xm430-w350:1"), 0), (Wire("xm430-w350:1", gap_rule=False), 1)):
        wire.send(PING[:5])
        wire.now += 0.01
        assert len(wire.send(PING[5:])) == answered


def test_a_gap_counts_from_the_end_of_the_last_byte() -> None:
    """At 9600 bit/s five bytes alone take 5.2 ms: that is no pause."""
    wire = Wire(servo("xm430-w350:1", registers={"Baud Rate": 0}))
    wire.rate = 9_600
    wire.bus.receive(PING[:5], 1.0, 9_600)
    assert wire.bus.receive(PING[5:], 1.0 + 5 * 10 / 9_600 + 1.4e-3, 9_600)
    wire.bus.receive(PING[:5], 2.0, 9_600)
    assert not wire.bus.receive(PING[5:], 2.0 + 5 * 10 / 9_600 + 1.6e-3, 9_600)


def test_protocol_1_waits_100_ms_for_the_next_byte() -> None:
    wire = Wire("ax-12a:1")
    for pause, answered in ((0.09, 1), (0.11, 0)):
        wire.wait(1.0)
        wire.send(PING_1[:3])
        wire.now += pause
        assert len(wire.send(PING_1[3:])) == answered


@pytest.mark.parametrize("ids", [(0,), (0, 1, 2), (5, 200), (252,)])
def test_a_broadcast_ping_is_answered_in_the_turn_of_each_id(ids: tuple[int, ...]) -> None:
    wire = Wire(*(f"xm430-w350:{i}" for i in ids))
    request = build_packet(254, 0x01)
    sent = wire.send(request)
    assert [answer.data[4] for answer in sent] == list(ids)
    end = len(request) * 10e-6
    assert [answer.due for answer in sent] == pytest.approx([end + i * 3e-3 + 14e-5 for i in ids])


def test_a_broadcast_ping_of_slow_servos_keeps_within_what_the_sdk_waits() -> None:
    """It waits for the bytes of 252 answers, 3 ms for each and 16 ms more."""
    ids = (1, 2, 3, 4, 5)
    slow = {"Baud Rate": 0, "Return Delay Time": 250}
    wire = Wire(*(servo(f"xm430-w350:{i}", registers=slow) for i in ids))
    wire.rate = 9_600
    sent = wire.send(build_packet(254, 0x01))
    assert [answer.data[4] for answer in sent] == list(ids)
    times = [answer.due for answer in sent]
    answer_time = 14 * 10 / 9_600
    assert all(b - a >= answer_time for a, b in pairwise(times))
    assert times[-1] <= 10 * 10 / 9_600 + 5 * (answer_time + 3e-3) + 16e-3


def test_requests_that_arrive_together_are_answered_one_after_the_other() -> None:
    wire = Wire("xm430-w350:1", "ax-12a:2")
    sent = wire.bus.receive(PING + build_packet_1(2, 0x01) + PING, 0.0, 1_000_000)
    assert [answer.data[:5] for answer in sent] == [
        bytes.fromhex("FF FF FD 00 01"),
        bytes.fromhex("FF FF 02 02 00"),
        bytes.fromhex("FF FF FD 00 01"),
    ]
    assert all(a.due < b.due for a, b in pairwise(sent))


def test_a_request_may_change_who_hears_the_next_one_of_the_same_chunk() -> None:
    wire = Wire("xm430-w350:1")
    renamed = build_packet(1, 0x03, bytes((7, 0, 9)))
    answers = PacketParser().feed(wire.exchange(renamed + PING + build_packet(9, 0x01)))
    assert [p.servo_id for p in answers] == [1, 9]


def test_a_half_request_at_one_rate_is_not_finished_at_another() -> None:
    wire = Wire("xm430-w350:1", servo("xm430-w350:2", registers={"Baud Rate": 1}), gap_rule=False)
    ping = build_packet(2, 0x01)
    wire.send(ping[:6])
    wire.rate = 57_600
    assert wire.send(ping[6:]) == []
    assert len(wire.send(ping)) == 1


def test_observers_are_told_of_every_frame_with_its_time() -> None:
    wire = Wire("xm430-w350:1", "ax-12a:2")
    seen: list[Heard | Said] = []
    wire.bus.observers.append(seen.append)
    wire.send(PING + PING_1[:-1] + b"\0" + build_packet_1(2, 0x01))
    assert [(type(event), event.protocol, event.data) for event in seen] == [
        (Heard, 2, PING),
        (Said, 2, build_status(1, 0, b"\xfc\x03" + bytes((wire.servos[0].model.firmware,)))),
        (Heard, 1, PING_1[:-1] + b"\0"),
        (Heard, 1, build_packet_1(2, 0x01)),
        (Said, 1, build_packet_1(2, 0)),
    ]
    assert [event.when for event in seen] == sorted(event.when for event in seen)
    assert seen[0].when == pytest.approx(100e-6)


@given(st.lists(st.binary(max_size=40), max_size=12))
def test_no_bytes_whatever_end_a_bus(chunks: list[bytes]) -> None:
    wire = Wire("xl330-m288:1", "ax-12a:2")
    for number, chunk in enumerate(chunks):
        wire.bus.receive(chunk, number * 0.01, 1_000_000)
        for build in (build_packet, build_packet_1):
            frame = build(254, chunk[0] if chunk else 1, chunk)
            wire.bus.receive(frame, number * 0.01, 1_000_000)
    wire.bus.advance(10.0)
    wire.bus.receive(b"", 20.0, 1_000_000)
    assert wire.bus.ears.parser.pending == wire.bus.ears.parser1.pending == 0
