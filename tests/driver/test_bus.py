"""Transactions over a pseudo-terminal, with servos that answer wrongly, late or not at all."""

from collections.abc import Iterator
from contextlib import closing

import pytest
import rustypot
from dynamixel_sdk import COMM_SUCCESS, GroupSyncRead, PacketHandler

from armsyn.arm.calibration import RADIANS_PER_TICK
from armsyn.driver import protocol
from armsyn.driver import registers as reg
from armsyn.driver.plans import ReadPlan
from armsyn.driver.transactions import Bus
from armsyn.errors import BusTimeoutError, PortLostError, ServoStatusError
from firmware_sim.testing import SimulatorProcess, running
from tests.driver.scripted import ScriptedPort, status

MARGIN = 0.05
POSITION = (1234).to_bytes(4, "little")
POSITIONS = (ReadPlan("sync", 2, 132, 4, (1,)),)


def open_bus(port: str, margin: float = MARGIN) -> Bus:
    return Bus(port, 1_000_000, margin)


@pytest.fixture(scope="module")
def port() -> Iterator[str]:
    with running("xm430-w350:1", "xm430-w350:2", arguments=("--baud", "1000000")) as path:
        yield path


@pytest.fixture
def bus(port: str) -> Iterator[Bus]:
    opened = open_bus(port)
    yield opened
    opened.close()


def test_ping_and_broadcast_ping(bus: Bus) -> None:
    assert bus.ping(2)[0] == 1020
    assert bus.broadcast_ping() == {1: 1020, 2: 1020}


def test_what_is_written_is_read(bus: Bus) -> None:
    bus.write(1, reg.PROFILE_VELOCITY, 77)
    assert bus.read(1, reg.PROFILE_VELOCITY) == 77
    bus.sync_write(reg.PROFILE_VELOCITY, {2: 5, 1: 9})
    assert bus.read_all(reg.PROFILE_VELOCITY, (1, 2)) == {1: 9, 2: 5}


def test_a_refusal_is_named(bus: Bus) -> None:
    with pytest.raises(ServoStatusError, match=r"servo 1 .*: data range error") as caught:
        bus.write(1, reg.TORQUE_ENABLE, 2)
    assert caught.value.error_number in (4, 6)


def test_a_servo_that_is_not_there(port: str) -> None:
    bus = open_bus(port, margin=0.002)
    with pytest.raises(BusTimeoutError, match="servo 9") as caught:
        bus.ping(9, attempts=2)
    assert caught.value.servo_ids == (9,)
    assert isinstance(caught.value, TimeoutError)
    with pytest.raises(BusTimeoutError) as caught:
        bus.read_all(reg.PRESENT_POSITION, (1, 9), attempts=2)
    assert caught.value.servo_ids == (9,)
    bus.close()


def test_the_sdk_shares_our_port(bus: Bus) -> None:
    handler = PacketHandler(2.0)
    model, result, error = handler.ping(bus, 1)
    assert (model, result, error) == (1020, COMM_SUCCESS, 0)
    handler.write4ByteTxRx(bus, 1, 112, 31)
    group = GroupSyncRead(bus, handler, 112, 4)
    group.addParam(1)
    group.addParam(2)
    assert group.txRxPacket() == COMM_SUCCESS
    assert group.getData(1, 112, 4) == 31
    assert bus.read(1, reg.PROFILE_VELOCITY) == 31  # and ours goes on


def test_rustypot_sends_the_same_bytes() -> None:
    # rustypot is built for the XL330, whose registers here are the same
    def script(request: bytes) -> bytes:
        ids = request[12:-2] if request[7] == protocol.SYNC_READ else b""
        return b"".join(status(i, POSITION) for i in ids)

    with ScriptedPort(script) as scripted:
        client = rustypot.Xl330PyController(scripted.path, 1_000_000, 1.0)
        client.sync_write_goal_position([1, 2], [0.0, 1000.5 * RADIANS_PER_TICK])
        client.sync_read_present_position([1, 2])
        del client
    # half a tick more than a thousand, for it cuts where we round
    data = b"".join(tick.to_bytes(4, "little") for tick in (2048, 3048))
    assert scripted.requests == [
        protocol.sync_write(116, 4, [1, 2], data),
        protocol.sync_read(132, 4, [1, 2]),
    ]


@pytest.mark.fault(20)
def test_an_alert_keeps_the_data_and_the_bit() -> None:
    with ScriptedPort(lambda _: status(1, POSITION, error=0x80)) as scripted:
        bus = open_bus(scripted.path)
        assert bus.read(1, reg.PRESENT_POSITION) == 1234
        assert bus.exchange(b"", POSITIONS)[1].alert
        bus.close()


def test_echo_noise_and_strangers_are_passed_over() -> None:
    def script(request: bytes) -> bytes:
        return request + b"\x00\xff\xff" + status(7, POSITION) + status(1, POSITION)

    with ScriptedPort(script) as scripted:
        bus = open_bus(scripted.path)
        assert bus.read(1, reg.PRESENT_POSITION) == 1234
        assert bus.counters.unexpected == 1
        assert bus.counters.echoed_bytes == len(scripted.requests[0])
        assert bus.foreign_traffic == 0
        assert bus.parser_counters.garbage_bytes == 3
        bus.close()


@pytest.mark.fault(17)
def test_a_reply_of_the_wrong_size_is_no_reply() -> None:
    with ScriptedPort(lambda _: status(1, b"\x01\x02")) as scripted:
        bus = open_bus(scripted.path, margin=0.01)
        assert bus.exchange(b"", POSITIONS) == {}
        assert bus.counters.timeouts == 1
        bus.close()


@pytest.mark.fault(17)
def test_a_late_reply_does_not_answer_the_next_request() -> None:
    """The first reply is held back and comes, whole, in front of the second one."""
    held = []

    def script(_: bytes) -> bytes:
        if not held:
            held.append(status(1, POSITION))
            return held[0][:9]  # the start only: the rest comes after the time-out
        if len(held) == 1:
            held.append(b"")
            return held[0][9:] + status(1, (7).to_bytes(4, "little"))
        return status(1, (7).to_bytes(4, "little"))

    with ScriptedPort(script) as scripted:
        bus = open_bus(scripted.path, margin=0.01)
        assert bus.exchange(b"", POSITIONS) == {}
        assert bus.exchange(b"", POSITIONS)[1].parameters == (7).to_bytes(4, "little")
        bus.close()


@pytest.mark.fault(17)
def test_stale_bytes_are_drained_before_the_next_request() -> None:
    def script(_: bytes) -> bytes:
        # servo 2 answers what servo 1 was asked for: it comes, but is not waited for
        return status(2, POSITION) if len(scripted.requests) == 1 else status(1, b"\x05\0\0\0")

    with ScriptedPort(script) as scripted:
        bus = open_bus(scripted.path, margin=0.005)
        assert bus.exchange(b"", POSITIONS) == {}
        assert bus.read(1, reg.PRESENT_POSITION) == 5
        bus.close()


def test_one_lost_reply_is_asked_for_again() -> None:
    def script(_: bytes) -> bytes:
        return b"" if len(scripted.requests) == 1 else status(1, POSITION)

    with ScriptedPort(script) as scripted:
        bus = open_bus(scripted.path, margin=0.01)
        assert bus.read(1, reg.PRESENT_POSITION) == 1234
        assert bus.counters.timeouts == 1
        bus.close()


def test_a_port_that_vanishes() -> None:
    simulator = SimulatorProcess("--servo", "xm430-w350:1", "--baud", "1000000")
    bus = open_bus(simulator.port)
    bus.ping(1)
    simulator.stop()
    with pytest.raises(PortLostError, match="was lost while in use"):
        bus.ping(1)
    with pytest.raises(PortLostError):
        bus.sync_write(reg.GOAL_POSITION, {1: 2048})
    bus.close()
    bus.close()
    with pytest.raises(PortLostError):
        bus.ping(1)


@pytest.mark.fault(3)
@pytest.mark.parametrize(
    ("servo", "protocol_number", "register"),
    [("xm430-w350:1", 2, reg.PROFILE_VELOCITY), ("ax-12a:1", 1, reg.Register("Speed", 32, 2))],
)
def test_a_damaged_request_is_repeated(
    servo: str, protocol_number: int, register: reg.Register
) -> None:
    arguments = ("--baud", "1000000", "--fault", "crc-error:to=servos,count=1")
    for ask in (
        lambda bus: bus.read(1, register) is not None,
        lambda bus: bus.read_all(register, (1,)).keys() == {1},
        lambda bus: bus.write(1, register, 77) is None and bus.read(1, register) == 77,
    ):
        with running(servo, arguments=arguments) as path, closing(open_bus(path)) as bus:
            bus.protocols = {1: protocol_number}
            assert ask(bus)
            assert bus.budget.spent == 1


def test_a_damaged_reboot_is_repeated() -> None:
    arguments = ("--baud", "1000000", "--fault", "crc-error:to=servos,count=1")
    with running("xm430-w350:1", arguments=arguments) as path, closing(open_bus(path)) as bus:
        bus.reboot(1)  # a servo that heard it whole answers without an error
        assert bus.budget.spent == 1
        assert bus.ping(1, attempts=50)


@pytest.mark.fault(3)
def test_a_servo_that_hears_nothing_whole_counts_as_silent() -> None:
    arguments = ("--baud", "1000000", "--fault", "crc-error:to=servos")
    with running("xm430-w350:1", arguments=arguments) as path, closing(open_bus(path)) as bus:
        with pytest.raises(BusTimeoutError, match="no answer from servo 1"):
            bus.read(1, reg.PROFILE_VELOCITY)
        with pytest.raises(BusTimeoutError, match="no answer from servo 1"):
            bus.read_all(reg.PROFILE_VELOCITY, (1,))
