"""Exchanges on a bus of both protocols, in threads, and over lines that echo, talk or vanish."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator

import pytest

from armsyn.driver import protocol, protocol1
from armsyn.driver import registers as reg
from armsyn.driver.budget import ErrorBudget
from armsyn.driver.plans import ReadPlan, bulk_plan
from armsyn.driver.transactions import Bus
from armsyn.errors import BusBudgetError, BusError, BusTimeoutError, PortLostError, ServoStatusError
from firmware_sim.testing import RunningSimulator, running, simulated
from tests.driver.scripted import ScriptedPort, status

BAUD = 1_000_000
SERVO = """
[[servo]]
id = {}
model = "{}"
protocol = {}
baud = 1000000
return_delay_us = 0
"""
SERVOS = (
    (1, "xm430-w350", 2),
    (2, "xl330-m288", 2),
    (3, "xm540-w270", 2),
    (11, "mx-28", 1),
    (12, "mx-64", 1),
    (13, "ax-12a", 1),
    (14, "xm430-w350", 1),
)
NUMBERS = {1: 1020, 2: 1200, 3: 1120, 11: 29, 12: 310, 13: 12, 14: 1020}
X_IDS, CLASSIC_IDS = (1, 2, 3), (11, 12, 13)
PRESENT = reg.Register("Present Position", 36, 2)
LED = reg.Register("LED", 25, 1)


@pytest.fixture(scope="module")
def port(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    rig = tmp_path_factory.mktemp("rig") / "mixed.toml"
    rig.write_text("".join(SERVO.format(*servo) for servo in SERVOS))
    with running(arguments=("--rig", str(rig))) as path:
        yield path


@pytest.fixture
def bus(port: str) -> Iterator[Bus]:
    opened = Bus(port, BAUD, 0.2)
    opened.return_delays = dict.fromkeys(NUMBERS, 0.0)
    opened.protocols = dict.fromkeys((*CLASSIC_IDS, 14), 1)
    yield opened
    opened.close()


def test_pings_of_both_protocols(bus: Bus) -> None:
    assert {i: bus.ping(i)[0] for i in NUMBERS} == NUMBERS
    bus.protocols.clear()
    assert bus.ping(11, protocol=1)[0] == 29
    assert bus.ping(14, protocol=1) == bus.ping(1, protocol=2)  # the same model and firmware


def test_all_servos_are_found(bus: Bus) -> None:
    assert bus.broadcast_ping() == {i: NUMBERS[i] for i in X_IDS}
    assert bus.broadcast_ping(protocol=1) == {i: NUMBERS[i] for i in (*CLASSIC_IDS, 14)}


def test_one_register_of_servos_of_both_protocols(bus: Bus) -> None:
    mixed = reg.Register("of the X series and, by chance, of MX", 25, 1)
    bus.sync_write(mixed, {11: 1, 12: 1, 13: 1})
    assert bus.read_all(mixed, (11, 1, 13)).keys() == {11, 1, 13}
    assert bus.read_all(LED, CLASSIC_IDS) == {11: 1, 12: 1, 13: 1}
    bus.write(12, LED, 0)
    assert bus.read(12, LED) == 0
    bus.sync_write(LED, dict.fromkeys(CLASSIC_IDS, 0))


def test_every_kind_of_read_tells_the_same(bus: Bus) -> None:
    address, size = reg.PRESENT_POSITION.address, reg.PRESENT_POSITION.size
    found = [
        bus.exchange(b"", [plan])
        for plan in (
            ReadPlan("sync", 2, address, size, X_IDS),
            ReadPlan("fast", 2, address, size, X_IDS),
            ReadPlan("single", 2, address, size, X_IDS),
            bulk_plan(dict.fromkeys(X_IDS, (address, size))),
        )
    ]
    assert found[0].keys() == set(X_IDS)
    assert all(replies == found[0] for replies in found[1:])
    blocks = {1: (132, 4), 3: (0, 2), 2: (144, 3)}
    sizes = {
        i: len(reply.parameters) for i, reply in bus.exchange(b"", [bulk_plan(blocks)]).items()
    }
    assert sizes == {1: 4, 2: 3, 3: 2}
    assert bus.counters.timeouts == 0


def test_a_cycle_writes_and_reads_both_protocols(bus: Bus) -> None:
    goal = (700).to_bytes(4, "little")
    before = protocol.sync_write(116, 4, [1], goal) + protocol1.sync_write(25, 1, [11], b"\x01")
    reads = (
        ReadPlan("sync", 2, 116, 4, X_IDS),
        bulk_plan({11: (25, 1), 12: (0, 2)}, 1),
        ReadPlan("single", 1, 0, 2, (13,)),
    )
    replies = bus.exchange(before, reads)
    assert replies.keys() == {*X_IDS, *CLASSIC_IDS}
    assert replies[1].parameters == goal
    assert (replies[11].parameters, replies[11].protocol) == (b"\x01", 1)
    assert replies[13].parameters == bytes([12, 0])
    assert bus.exchange(protocol1.sync_write(25, 1, [11], b"\0"), ()) == {}
    assert bus.read(11, LED) == 0


def test_refusals_of_both_protocols(bus: Bus) -> None:
    with pytest.raises(ServoStatusError, match=r"servo 13 .* refused a request: range error"):
        bus.write(13, LED, 2)
    with pytest.raises(ServoStatusError, match=r"servo 1 .* refused a request: data"):
        bus.write(1, reg.TORQUE_ENABLE, 2)


def test_who_is_missing_is_left_out(bus: Bus) -> None:
    ids = (1, 9, 2)
    for kind in ("sync", "fast"):  # who is to answer after the silent one waits in vain
        assert bus.exchange(b"", [ReadPlan(kind, 2, 132, 4, ids)], 0.05).keys() == {1}
    assert bus.exchange(b"", [ReadPlan("single", 2, 132, 4, ids)], 0.05).keys() == {1, 2}
    classic = bus.exchange(b"", [ReadPlan("single", 1, 36, 2, (11, 15, 12))], 0.05)
    assert classic.keys() == {11, 12}
    with pytest.raises(BusTimeoutError) as caught:
        bus.read_all(PRESENT, (11, 15), attempts=2)
    assert caught.value.servo_ids == (15,)
    with pytest.raises(BusTimeoutError) as caught:
        bus.read_all(reg.PRESENT_POSITION, ids, attempts=2)
    assert caught.value.servo_ids == (9,)


def test_a_reboot(bus: Bus) -> None:
    bus.write(2, reg.PROFILE_VELOCITY, 33)
    bus.reboot(2)
    assert bus.ping(2, attempts=50)[0] == NUMBERS[2]
    assert bus.read(2, reg.PROFILE_VELOCITY) != 33
    with pytest.raises(BusError, match=r"protocol 1.0, which cannot reboot: switch its power"):
        bus.reboot(11)


def test_threads_share_a_bus(bus: Bus) -> None:
    """Each thread's values come back to it, whatever the others do in between."""
    wrong: list[object] = []
    plan = ReadPlan("sync", 2, reg.PROFILE_VELOCITY.address, 4, X_IDS)

    def work(servo_id: int) -> None:
        for value in range(1, 60):
            bus.write(servo_id, reg.PROFILE_VELOCITY, value)
            replies = bus.exchange(b"", [plan])
            read = bus.read(servo_id, reg.PROFILE_VELOCITY)
            if read != value or len(replies) != len(X_IDS):
                wrong.append((servo_id, value, read, replies))
            if (
                bus.read(10 + servo_id, reg.Register("Model Number", 0, 2))
                != NUMBERS[10 + servo_id]
            ):
                wrong.append(servo_id)

    threads = [threading.Thread(target=work, args=(i,)) for i in X_IDS]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []
    assert bus.counters.unexpected == bus.counters.unsolicited_bytes == 0


@pytest.fixture
def simulator() -> Iterator[RunningSimulator]:
    with simulated("xm430-w350:1", baud=BAUD) as arm:
        yield arm


def use_until_lost(bus: Bus) -> None:
    while True:
        bus.ping(1)


@pytest.mark.fault(12)
def test_a_port_comes_back_only_on_request(simulator: RunningSimulator) -> None:
    bus = Bus(simulator.link, BAUD, 0.2)
    assert bus.ping(1)[0] == 1020
    simulator.inject("unplugged:for=0.3")
    with pytest.raises(PortLostError, match="was lost while in use"):
        use_until_lost(bus)
    for _ in range(2):
        with pytest.raises(PortLostError, match=r"is closed: .* open it again"):
            bus.ping(1)
    while simulator.status()["faults"]:
        pass
    with pytest.raises(PortLostError, match="is closed"):
        bus.ping(1)
    bus.reopen()
    assert bus.ping(1)[0] == 1020
    bus.reopen()  # of a port that is open
    assert bus.ping(1)[0] == 1020
    bus.close()


POSITION = (1234).to_bytes(4, "little")


@pytest.mark.fault(6)
def test_an_echo_is_stripped_every_time() -> None:
    with ScriptedPort(lambda r: r + status(1, POSITION)) as scripted:
        bus = Bus(scripted.path, BAUD, 0.5)
        for _ in range(3):
            assert bus.read(1, reg.PRESENT_POSITION) == 1234
        assert bus.counters.echoed_bytes == sum(map(len, scripted.requests))
        assert bus.counters.timeouts == bus.foreign_traffic == 0
        bus.close()


@pytest.mark.parametrize("at_once", [True, False])
def test_the_echo_of_what_nobody_answers_is_no_stranger(at_once: bool) -> None:
    """Whether it has come when the next request goes out, or comes before its reply."""
    goal = protocol.sync_write(116, 4, [1], POSITION)

    def script(request: bytes) -> bytes:
        return request + (b"" if request == goal else status(1, POSITION))

    with ScriptedPort(script) as scripted:
        bus = Bus(scripted.path, BAUD, 0.5)
        for _ in range(3):
            bus.send(goal)
            bus.exchange(goal, ())
            while not at_once and bus.serial_port.waiting() < 2 * len(goal):
                pass
            assert bus.read(1, reg.PRESENT_POSITION) == 1234
        assert bus.counters.echoed_bytes == sum(map(len, scripted.requests))
        assert bus.counters.unsolicited_bytes == bus.foreign_traffic == 0
        assert bus.counters.timeouts == 0
        bus.close()


def test_a_broken_echo_of_what_nobody_answers_is_no_stranger() -> None:
    goal = protocol.sync_write(116, 4, [1], POSITION)

    def script(request: bytes) -> bytes:
        return b"\x00" + request if request == goal else request + status(1, POSITION)

    with ScriptedPort(script) as scripted:
        bus = Bus(scripted.path, BAUD, 0.5)
        bus.send(goal)
        while bus.serial_port.waiting() < len(goal) + 1:
            pass
        assert bus.read(1, reg.PRESENT_POSITION) == 1234
        assert bus.foreign_traffic == bus.counters.timeouts == 0
        bus.close()


@pytest.mark.fault(6)
@pytest.mark.parametrize("kept", [slice(0, 5), slice(5, None), slice(3, 9)])
def test_a_partial_echo_is_tolerated(kept: slice) -> None:
    def script(request: bytes) -> bytes:
        return request[kept] + status(1, POSITION)

    with ScriptedPort(script) as scripted:
        bus = Bus(scripted.path, BAUD, 0.5)
        assert bus.read(1, reg.PRESENT_POSITION) == 1234
        assert bus.foreign_traffic == bus.counters.timeouts == 0
        bus.close()


@pytest.mark.fault(6)
def test_the_echo_of_protocol_1_is_no_answer() -> None:
    def script(request: bytes) -> bytes:
        return request + protocol1.packet(1, 0, b"\x34\x12")

    with ScriptedPort(script, protocol1_packets) as scripted:
        bus = Bus(scripted.path, BAUD, 0.5)
        bus.protocols[1] = 1
        for _ in range(3):
            assert bus.read(1, PRESENT) == 0x1234
        bus.close()


def protocol1_packets(buffer: bytes) -> int:
    """Bytes of the packet at a buffer's start, 0 while it is not whole."""
    return 4 + buffer[3] if len(buffer) >= 4 and len(buffer) >= 4 + buffer[3] else 0


@pytest.mark.fault(40)
def test_another_masters_traffic_is_counted() -> None:
    """Both in the midst of a transaction and between two."""
    stranger = protocol.ping(7)

    def script(_: bytes) -> bytes:
        return stranger + status(1, POSITION) + (stranger if len(scripted.requests) == 1 else b"")

    with ScriptedPort(script) as scripted:
        bus = Bus(scripted.path, BAUD, 0.5)
        assert bus.read(1, reg.PRESENT_POSITION) == 1234
        assert bus.read(1, reg.PRESENT_POSITION) == 1234
        assert bus.foreign_traffic == 3
        bus.close()


@pytest.mark.fault(3)
def test_a_spent_budget_is_said() -> None:
    with (
        ScriptedPort(lambda _: b"") as scripted,
        contextlib.closing(Bus(scripted.path, BAUD, 0.001)) as bus,
    ):
        bus.budget = ErrorBudget(capacity=5, rate=0.0)
        for _ in range(2):
            with pytest.raises(BusTimeoutError) as caught:
                bus.ping(1, attempts=3)
            assert not isinstance(caught.value, BusBudgetError)
        with pytest.raises(BusBudgetError, match="5 answers had to be asked for again") as caught:
            bus.read_all(reg.PRESENT_POSITION, (1, 2), attempts=3)
        assert caught.value.servo_ids == (1, 2)
        assert bus.counters.transactions == 3 + 3 + 1 + 2  # the last ones one by one
        with pytest.raises(BusTimeoutError):
            bus.ping(1, attempts=1)  # what asks only once goes on


def test_time_gives_repetitions_back() -> None:
    budget = ErrorBudget(capacity=2, rate=0.5)
    assert [budget.take(0.0) for _ in range(3)] == [True, True, False]
    assert [budget.take(2.0) for _ in range(2)] == [True, False]
    assert [budget.take(100.0) for _ in range(3)] == [True, True, False]
    assert budget.spent == 5
