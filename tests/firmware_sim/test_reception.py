"""What servos make of damaged and unfinished requests: Processing Order of Reception."""

import pytest

from firmware_sim.firmware.codes import StatusError
from firmware_sim.wire.bus import GAP_TIME
from firmware_sim.wire.packet import build_packet, build_status

from .wire import Wire, le

PING = build_packet(1, 0x01)
WRITE = build_packet(1, 0x03, le(116) + le(2100, size=4))
PONG = build_status(1, 0, b"\xfc\x03\x2d")
REFUSED = build_status(1, StatusError.CRC)


def flipped(frame: bytes) -> bytes:
    return frame[:-3] + bytes((frame[-3] ^ 0x04,)) + frame[-2:]


def test_a_damaged_request_is_answered_with_a_crc_error_and_not_obeyed() -> None:
    wire = Wire("xm430-w350:1")
    before = wire.peek(116, 4)
    assert wire.exchange(flipped(WRITE)) == REFUSED
    assert wire.peek(116, 4) == before != 2100


def test_a_damaged_status_packet_of_another_is_ignored_as_a_sound_one_is() -> None:
    wire = Wire("xm430-w350:1")
    status = build_status(1, 0, b"\x01\x02\x03\x04")
    assert wire.exchange(status) == b""
    assert wire.exchange(flipped(status)) == b""
    assert wire.exchange(PING) == PONG


def test_a_write_cut_short_swallows_the_beginning_of_a_ping_sent_at_once() -> None:
    wire = Wire("xm430-w350:1")
    assert wire.exchange(WRITE[:-4] + PING) == REFUSED


@pytest.mark.parametrize("missing", range(1, len(WRITE)))
def test_whoever_tries_again_after_a_silence_is_answered(missing: int) -> None:
    wire = Wire("xm430-w350:1")
    wire.exchange(WRITE[:-missing] + PING)
    wire.now += 1.01 * GAP_TIME
    assert wire.exchange(PING) == PONG


def test_a_length_that_lies_makes_servos_deaf_until_there_is_a_silence() -> None:
    wire = Wire("xm430-w350:1")
    wire.exchange(WRITE[:5] + le(4000))
    for _ in range(3):
        assert wire.exchange(PING) == b""
        wire.now += 0.5 * GAP_TIME
    wire.now += GAP_TIME
    assert wire.exchange(PING) == PONG


def test_without_the_gap_rule_the_next_header_begins_a_frame() -> None:
    wire = Wire("xm430-w350:1", gap_rule=False)
    assert wire.exchange(WRITE[:5] + le(4000) + PING) == PONG
    assert wire.exchange(WRITE[:-6] + PING) == PONG
