"""Faults that damage packets: what a client sees of each."""

import pytest

from tests.firmware_sim.faults_bench import (
    FaultBench,
    crc_fits,
    frames_of,
    read_request,
    request,
    sync_read_request,
)

PONG = FaultBench().ping()


def test_the_pong_that_all_tests_compare_with_is_whole() -> None:
    assert len(PONG) == 14
    assert crc_fits(PONG)


@pytest.mark.parametrize(("place", "kept"), [("before", PONG), ("after", PONG), ("inside", None)])
def test_noise_surrounds_or_parts_a_reply(place: str, kept: bytes | None) -> None:
    heard = FaultBench(f"noise:bytes=5,place={place}").ping()
    assert len(heard) == len(PONG) + 5
    if kept is None:
        assert PONG not in heard
    else:
        assert (heard[5:] if place == "before" else heard[:-5]) == kept


def test_a_truncated_status_lacks_its_end() -> None:
    assert FaultBench("truncated-status:bytes=3").ping() == PONG[:-3]
    heard = FaultBench("truncated-status").ping()
    assert 0 < len(heard) < len(PONG)
    assert PONG.startswith(heard)


def test_a_reply_that_is_cut_as_a_whole_is_not_there() -> None:
    assert FaultBench("truncated-status:bytes=100").ping() == b""


def test_lost_bytes_leave_the_others_in_order() -> None:
    heard = FaultBench("lost-bytes:bytes=2").ping()
    rest = iter(PONG)
    assert len(heard) == len(PONG) - 2
    assert all(byte in rest for byte in heard)


@pytest.mark.parametrize("seed", range(20))
def test_a_crc_error_keeps_the_shape_and_fails_the_check(seed: int) -> None:
    heard = FaultBench("crc-error:bits=3", seed=seed).ping()
    assert heard[:7] == PONG[:7]
    assert not crc_fits(heard)
    flipped = int.from_bytes(heard, "big") ^ int.from_bytes(PONG, "big")
    assert flipped.bit_count() == 3


def test_a_request_with_a_crc_error_is_answered_with_error_3() -> None:
    bench = FaultBench("crc-error:to=servos,count=1")
    refusal = bench.ping()
    assert refusal[8] == 3
    assert crc_fits(refusal)
    assert bench.ping() == PONG


def test_bit_errors_come_at_their_rate() -> None:
    bench = FaultBench("bit-errors:rate=0.01")
    flipped = 0
    for _ in range(200):
        heard = bench.ping()
        flipped += (int.from_bytes(heard, "big") ^ int.from_bytes(PONG, "big")).bit_count()
    expected = 0.01 * 200 * 14 * 8
    assert abs(flipped - expected) < 4.0 * expected**0.5


def test_missing_stuffing_leaves_a_reply_that_only_a_naive_sender_would_send() -> None:
    data = bytes.fromhex("ff ff ff ff fd 00 00 00")  # homing offset -1, moving threshold 253
    for fault, stuffed in ((), b"\xfd"), (("missing-stuffing",), b""):
        bench = FaultBench(*fault)
        assert bench.write(20, -1, 4) == 0
        assert bench.write(24, 253, 4) == 0
        heard = bench.exchange(read_request(20, 8))
        assert heard[9:-2] == data[:5] + stuffed + data[5:]
        assert int.from_bytes(heard[5:7], "little") == len(heard) - 7
        assert crc_fits(heard)


def test_replies_that_need_no_stuffing_stay_as_they_are() -> None:
    bench = FaultBench("missing-stuffing")
    assert bench.ping() == PONG
    assert not bench.told


def test_a_lying_length_says_what_it_is_told_to() -> None:
    assert FaultBench("lying-length").ping() == PONG[:5] + b"\xff\xff" + PONG[7:]
    assert FaultBench("lying-length:length=0").ping() == PONG[:5] + b"\0\0" + PONG[7:]


def test_requests_whose_length_lies_are_not_answered_and_do_no_harm() -> None:
    bench = FaultBench("lying-length:length=600,to=servos,count=1")
    assert bench.ping() == b""
    assert bench.ping() == PONG


def test_the_alert_bit_leaves_the_data_readable() -> None:
    bench = FaultBench("alert-bit:id=2", servos=("xm430-w350:1", "xm430-w350:2"))
    one, two = frames_of(bench.exchange(sync_read_request(132, 4, 1, 2)))
    assert (one[8], two[8]) == (0x00, 0x80)
    assert crc_fits(two)
    assert one[9:13] == two[9:13]


def test_the_overload_bit_stands_for_the_alert_bit_in_protocol_1() -> None:
    ping = b"\xff\xff\x01\x02\x01\xfb"
    assert FaultBench(servos=("ax-12a:1",)).exchange(ping) == b"\xff\xff\x01\x02\x00\xfc"
    heard = FaultBench("alert-bit", servos=("ax-12a:1",)).exchange(ping)
    assert heard == b"\xff\xff\x01\x02\x20\xdc"


def test_protocol_1_replies_are_damaged_too() -> None:
    ping = b"\xff\xff\x01\x02\x01\xfb"
    damaged = FaultBench("crc-error", servos=("ax-12a:1",)).exchange(ping)
    assert damaged[:4] == b"\xff\xff\x01\x02"
    assert sum(damaged[2:]) & 0xFF != 0xFF
    lying = FaultBench("lying-length", servos=("ax-12a:1",)).exchange(ping)
    assert lying == b"\xff\xff\x01\xff\x00\xfc"


def test_only_the_servo_meant_is_struck() -> None:
    bench = FaultBench("truncated-status:id=2,bytes=1", servos=("xm430-w350:1", "xm430-w350:2"))
    assert len(bench.ping(1)) == 14
    assert len(bench.ping(2)) == 13


def test_a_client_that_sends_byte_by_byte_is_damaged_by_packets_too() -> None:
    bench = FaultBench("crc-error:to=servos")
    for byte in request(1, 0x01):
        bench.port.write(bytes((byte,)))
        bench.port.wait_until(bench.clock.now() + 1.0e-5)
    bench.wait(0.01)
    assert bench.port.read(100, 0.0)[8] == 3
