"""Read plans: their packets against the vendor's SDK, their durations against the reference."""

# ruff: noqa: N802 - the names are the SDK's

import pytest
from dynamixel_sdk import Protocol1PacketHandler, Protocol2PacketHandler

from armsyn.driver.plans import Kind, ReadPlan, bulk_plan, exchange_duration
from armsyn.driver.protocol import sync_write

IDS = (3, 7, 4)


class CapturingPort:
    """What the SDK's packet handlers need of a port, to see what they would send."""

    is_using = False

    def clearPort(self) -> None:
        pass

    def setPacketTimeout(self, length: int) -> None:
        self.expected = length

    def writePort(self, data: list[int]) -> int:
        self.sent = bytes(data)
        return len(data)


def le(*values: int) -> list[int]:
    return [byte for value in values for byte in value.to_bytes(2, "little")]


@pytest.mark.parametrize("kind", ["sync", "fast"])
def test_a_sync_read_is_the_sdks(kind: Kind) -> None:
    port = CapturingPort()
    Protocol2PacketHandler().syncReadTx(port, 132, 4, list(IDS), len(IDS), kind == "fast")
    (request,) = ReadPlan(kind, 2, 132, 4, IDS).requests
    assert request.data == port.sent
    assert port.expected == 45  # the SDK waits for as much where they answer together
    assert request.reply_bytes == (45 if kind == "sync" else 32)


def test_a_fast_sync_read_is_the_manuals() -> None:
    (request,) = ReadPlan("fast", 2, 132, 4, IDS).requests
    assert request.data == bytes.fromhex("FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2")
    assert request.reply_bytes == 8 + 3 * 8


def test_bulk_reads_are_the_sdks() -> None:
    port = CapturingPort()
    handler = Protocol2PacketHandler()
    handler.bulkReadTx(port, [1, *le(144, 2), 2, *le(146, 1)], 10, False)
    blocks = {1: (144, 2), 2: (146, 1)}
    (request,) = bulk_plan(blocks).requests
    assert request.data == port.sent
    assert dict(request.sizes) == {1: 2, 2: 1}
    port = CapturingPort()
    Protocol1PacketHandler().bulkReadTx(port, [2, 1, 30, 2, 2, 36], 6)
    (request,) = bulk_plan({1: (30, 2), 2: (36, 2)}, 1).requests
    assert request.data == port.sent


def test_single_reads_are_the_sdks() -> None:
    requests = ReadPlan("single", 1, 36, 8, (1, 2)).requests
    for servo_id, request in zip((1, 2), requests, strict=True):
        port = CapturingPort()
        Protocol1PacketHandler().readTx(port, servo_id, 36, 8)
        assert request.data == port.sent
        assert request.reply_bytes == port.expected == 14


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("sync", 1, 36, 8, (1,)), "protocol 1 has no sync read"),
        (("fast", 1, 36, 8, (1,)), "protocol 1 has no fast read"),
        (("sync", 3, 36, 8, (1,)), "protocol 3 has no sync read"),
        (("sync", 2, 36, 8, (1, 2, 1)), "hold one twice"),
        (("bulk", 2, 0, 0, (1, 2), ((1, 1),)), "1 blocks are none for each of 2"),
        (("sync", 2, 0, 0, (1,), ((1, 1),)), "blocks"),
    ],
)
def test_reads_that_are_none(arguments: tuple, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ReadPlan(*arguments)


def test_plans_are_keys_and_keep_their_requests() -> None:
    plan = ReadPlan("sync", 2, 126, 10, IDS)
    assert plan.requests is plan.requests
    assert {plan: 1}[ReadPlan("sync", 2, 126, 10, IDS)] == 1
    assert ReadPlan("sync", 2, 126, 10, ()).requests == ()


# servos, bytes read, return delay (us): milliseconds at 57600, 1 M and 4 M baud, of a fast cycle
FAST = [
    (6, 4, 500, (21.3, 1.70, 0.80)),
    (6, 4, 0, (20.8, 1.20, 0.30)),
    (7, 10, 500, (31.1, 2.26, 0.94)),
    (7, 10, 0, (30.6, 1.76, 0.44)),
]


@pytest.mark.parametrize(("servos", "size", "delay", "expected"), FAST)
def test_a_fast_cycle_on_the_wire(
    servos: int, size: int, delay: int, expected: tuple[float, ...]
) -> None:
    ids = tuple(range(1, servos + 1))
    before = len(sync_write(116, 4, ids, bytes(4 * servos)))
    plan = ReadPlan("fast", 2, 126, size, ids)
    for baud, milliseconds in zip((57_600, 1_000_000, 4_000_000), expected, strict=True):
        cycle = exchange_duration(before, (plan,), baud, dict.fromkeys(ids, delay * 1e-6))
        assert cycle * 1e3 == pytest.approx(milliseconds, abs=0.06 if baud < 1e5 else 0.006)
