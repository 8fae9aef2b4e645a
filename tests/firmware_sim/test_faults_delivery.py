"""Faults of delivery: replies lost, late, twice, in pieces, or kept by the adapter."""

import pytest

from tests.firmware_sim.faults_bench import (
    BYTE,
    FaultBench,
    frames_of,
    read_request,
    request,
    sync_read_request,
)

PING = request(1, 0x01)
PONG = FaultBench().ping()
TWO = ("xm430-w350:1", "xm430-w350:2")


def arrivals(bench: FaultBench, data: bytes, patience: float = 0.1) -> list[tuple[float, bytes]]:
    """Send bytes; return when which bytes arrived after that, s, to 10 us."""
    start = bench.clock.now()
    bench.port.write(data)
    heard = []
    while bench.clock.now() < start + patience:
        bench.port.wait_until(bench.clock.now() + 1.0e-5)
        if count := bench.port.in_waiting():
            heard.append((bench.clock.now() - start, bench.port.read(count, 0.0)))
    return heard


def test_without_faults_a_pong_arrives_when_its_last_byte_has_left_the_wire() -> None:
    ((when, data),) = arrivals(FaultBench(), PING)
    assert data == PONG
    assert when == pytest.approx((len(PING) + len(PONG)) * BYTE, abs=2.0e-5)


def test_a_lost_reply_does_not_come_and_the_servo_has_obeyed() -> None:
    bench = FaultBench("lost-replies:count=1")
    assert bench.exchange(request(1, 0x03, b"\x41\x00\x01")) == b""
    assert bench.register(65) == 1


def test_a_lost_instruction_is_not_obeyed() -> None:
    bench = FaultBench("lost-instructions:count=1")
    assert bench.exchange(request(1, 0x03, b"\x41\x00\x01")) == b""
    assert bench.register(65) == 0


def test_one_servo_misses_what_is_said_to_all() -> None:
    bench = FaultBench("lost-instructions:id=2,count=1", servos=TWO)
    ask = sync_read_request(132, 4, 1, 2)
    assert [frame[4] for frame in frames_of(bench.exchange(ask))] == [1]
    assert [frame[4] for frame in frames_of(bench.exchange(ask))] == [1, 2]
    assert "lost-instructions servo 2" in bench.told[0]


def test_instructions_to_others_are_not_lost() -> None:
    bench = FaultBench("lost-instructions:id=2", servos=TWO)
    assert len(bench.ping(1)) == 14
    assert bench.ping(2) == b""


def test_a_duplicate_reply_comes_twice() -> None:
    first, second = arrivals(FaultBench("duplicate-reply"), PING)
    assert first[1] == second[1] == PONG
    assert second[0] - first[0] == pytest.approx(len(PONG) * BYTE, abs=2.0e-5)


def test_a_late_reply_comes_as_the_answer_to_the_next_request() -> None:
    bench = FaultBench("late-reply:count=1")
    assert bench.exchange(PING) == b""
    when, data = arrivals(bench, read_request(0, 2))[0]
    assert data[: len(PONG)] == PONG
    assert when == pytest.approx(14 * BYTE, abs=2.0e-5)
    assert bench.ping() == PONG


def test_a_late_reply_with_a_delay_overtakes_nothing_before_that() -> None:
    bench = FaultBench("late-reply:count=1,delay=0.02")
    ((when, data),) = arrivals(bench, PING)
    assert data == PONG
    assert when == pytest.approx(0.02 + 24 * BYTE, abs=2.0e-5)


def test_later_requests_are_answered_before_a_late_reply() -> None:
    bench = FaultBench("late-reply:count=1,delay=0.02")
    bench.port.write(PING)
    bench.port.wait_until(0.005)
    (first, _pong) = arrivals(bench, read_request(7, 1), 0.03)
    assert len(first[1]) == 12


def test_a_longer_return_delay_holds_up_those_who_answer_behind() -> None:
    ask = sync_read_request(132, 4, 1, 2)
    normal = arrivals(FaultBench(servos=TWO), ask)
    later = arrivals(FaultBench("return-delay:id=1,delay=0.003", servos=TWO), ask)
    assert [b - a for (a, _), (b, _) in zip(normal, later, strict=True)] == pytest.approx(
        [0.003, 0.003], abs=3.0e-5
    )
    last = arrivals(FaultBench("return-delay:id=2,delay=0.003", servos=TWO), ask)
    assert last[0][0] == pytest.approx(normal[0][0], abs=3.0e-5)


def test_an_echo_comes_before_the_reply() -> None:
    first, second = arrivals(FaultBench("local-echo"), PING)
    assert first[1] == PING
    assert first[0] == pytest.approx(len(PING) * BYTE, abs=2.0e-5)
    assert second[1] == PONG


def test_an_echo_may_be_partial() -> None:
    assert FaultBench("local-echo:share=0.5").exchange(PING) == PING[:5] + PONG


def test_requests_nobody_answers_are_echoed_too() -> None:
    assert FaultBench("local-echo").exchange(request(9, 0x01)) == request(9, 0x01)


def test_a_reply_in_chunks_is_the_same_reply() -> None:
    chunks = arrivals(FaultBench("chunked-reply:bytes=5,gap=0.004"), PING)
    assert b"".join(data for _, data in chunks) == PONG
    assert [len(data) for _, data in chunks] == [5, 5, 4]
    assert chunks[2][0] - chunks[0][0] == pytest.approx(0.008, abs=2.0e-5)


def test_a_slow_adapter_is_late_within_its_jitter_and_keeps_the_order() -> None:
    bench = FaultBench("slow-adapter:delay=0.004,jitter=0.002", servos=TWO)
    spread = set()
    for _ in range(20):
        ask = sync_read_request(132, 4, 1, 2)
        heard = arrivals(bench, ask, 0.01)
        stream = b"".join(data for _, data in heard)
        assert [frame[4] for frame in frames_of(stream)] == [1, 2]
        assert 0.004 < heard[0][0] < 0.0065
        spread.add(round(heard[0][0], 4))
    assert len(spread) > 5


def test_requests_can_be_held_up_instead() -> None:
    ((when, _),) = arrivals(FaultBench("slow-adapter:delay=0.01,to=servos"), PING)
    assert when == pytest.approx(0.01 + 24 * BYTE, abs=2.0e-5)


def test_the_latency_timer_makes_a_cycle_last_as_long_as_itself() -> None:
    bench = FaultBench("latency-timer:latency=0.016")
    times = []
    for _ in range(5):
        bench.port.write(PING)
        assert bench.port.read(14, 1.0) == PONG
        times.append(bench.clock.now())
    assert times == pytest.approx([0.016, 0.032, 0.048, 0.064, 0.080])


def test_a_full_packet_does_not_wait_for_the_latency_timer() -> None:
    chunks = arrivals(FaultBench("latency-timer:latency=0.016"), read_request(0, 100))
    assert [len(data) for _, data in chunks] == [62, 111 - 62]
    assert chunks[0][0] == pytest.approx((14 + 62) * BYTE, abs=2.0e-5)
    assert chunks[1][0] == pytest.approx(0.016, abs=2.0e-5)


def test_bytes_of_two_requests_leave_the_adapter_in_order() -> None:
    bench = FaultBench("latency-timer:latency=0.016")
    bench.port.write(read_request(0, 50))
    bench.port.wait_until(0.008)
    bench.port.write(read_request(0, 60))
    assert bench.port.read(61 + 71, 0.016) == b"".join(
        FaultBench().exchange(read_request(0, size)) for size in (50, 60)
    )
    assert bench.clock.now() == pytest.approx(0.016)


@pytest.mark.parametrize("fault", ["slow-adapter:delay=0.05", "latency-timer:latency=0.05"])
def test_what_comes_after_a_slow_adapter_does_not_overtake(fault: str) -> None:
    bench = FaultBench(f"{fault},for=0.01")
    bench.port.write(PING)
    bench.port.wait_until(0.011)
    bench.port.write(read_request(7, 1))
    stream = bench.port.read(14 + 12, 0.2)
    assert stream[:14] == PONG
    assert len(stream) == 26
    bench.wait(0.1)
    assert not bench.simulation.faults
