"""Public Dynamixel clients, unmodified, at the port of a running simulator.

The clients' own notion of the protocol is the oracle: the SDK's packet handler and group classes,
and rustypot.
"""

import math
import time
from collections.abc import Iterator

import dynamixel_sdk as sdk
import pytest
import rustypot

from firmware_sim.testing import running

BAUD_RATE = 1_000_000
SERVOS = ("xm540-w270:1", "xm430-w350:2", "xl430-w250:3", "xl330-m288:4")
IDS = (1, 2, 3, 4)
NUMBERS = {1: 1120, 2: 1020, 3: 1060, 4: 1200}
OK = (sdk.COMM_SUCCESS, 0)
TORQUE, GOAL, PRESENT = 64, 116, 132

handler = sdk.Protocol2PacketHandler()


@pytest.fixture
def port_name() -> Iterator[str]:
    arguments = ("--baud", str(BAUD_RATE), "--return-delay", "0")
    with running(*SERVOS, arguments=arguments) as name:
        yield name


@pytest.fixture
def port(port_name: str) -> Iterator[sdk.PortHandler]:
    handle = sdk.PortHandler(port_name)
    assert handle.openPort()
    assert handle.setBaudRate(BAUD_RATE)
    yield handle
    handle.closePort()


def wait_until_it_answers(port: sdk.PortHandler, servo_id: int) -> None:
    deadline = time.monotonic() + 10.0
    while handler.ping(port, servo_id)[1] != sdk.COMM_SUCCESS:
        assert time.monotonic() < deadline


def wait_for(port: sdk.PortHandler, servo_id: int, goal: int) -> None:
    deadline = time.monotonic() + 10.0
    while handler.read4ByteTxRx(port, servo_id, PRESENT)[0] != goal:
        assert time.monotonic() < deadline


def le4(value: int) -> list[int]:
    return list(value.to_bytes(4, "little", signed=True))


def test_sdk_pings(port: sdk.PortHandler) -> None:
    assert {i: handler.ping(port, i) for i in IDS} == {i: (NUMBERS[i], *OK) for i in IDS}
    assert handler.ping(port, 9)[1] == sdk.COMM_RX_TIMEOUT


def test_sdk_broadcast_ping(port: sdk.PortHandler) -> None:
    found, result = handler.broadcastPing(port)
    assert result == sdk.COMM_SUCCESS
    assert found == {1: [1120, 45], 2: [1020, 45], 3: [1060, 45], 4: [1200, 52]}


def test_sdk_reads_and_writes_every_size(port: sdk.PortHandler) -> None:
    assert handler.write1ByteTxRx(port, 1, 65, 1) == OK
    assert handler.write2ByteTxRx(port, 1, 84, 640) == OK
    assert handler.write4ByteTxRx(port, 1, GOAL, 3000) == OK
    assert handler.read1ByteTxRx(port, 1, 65) == (1, *OK)
    assert handler.read2ByteTxRx(port, 1, 84) == (640, *OK)
    assert handler.read4ByteTxRx(port, 1, GOAL) == (3000, *OK)
    assert handler.read2ByteTxRx(port, 1, 144) == (120, *OK)


def test_sdk_understands_each_error_number(port: sdk.PortHandler) -> None:
    assert handler.write1ByteTxRx(port, 1, TORQUE, 1) == OK
    expected = {
        (70, 1): sdk.ERRNUM_ACCESS,
        (9, 1): sdk.ERRNUM_ACCESS,
        (65, 2): sdk.ERRNUM_DATA_RANGE,
    }
    for (address, value), number in expected.items():
        assert handler.write1ByteTxRx(port, 1, address, value)[1] == number
    assert handler.write4ByteTxRx(port, 1, GOAL, 4096)[1] == sdk.ERRNUM_DATA_LIMIT
    assert handler.write2ByteTxRx(port, 1, GOAL, 100)[1] == sdk.ERRNUM_DATA_LENGTH


def test_sdk_registers_a_write_and_acts(port: sdk.PortHandler) -> None:
    assert handler.regWriteTxRx(port, 2, 65, 1, [1]) == OK
    assert handler.read1ByteTxRx(port, 2, 69)[0] == 1
    # The SDK does not read the answer to an action, so only a broadcast leaves a clean line.
    assert handler.action(port, sdk.BROADCAST_ID) == sdk.COMM_SUCCESS
    assert handler.read1ByteTxRx(port, 2, 65)[0] == 1
    assert handler.read1ByteTxRx(port, 2, 69)[0] == 0


def test_sdk_reboots(port: sdk.PortHandler) -> None:
    assert handler.write1ByteTxRx(port, 3, TORQUE, 1) == OK
    assert handler.reboot(port, 3) == OK
    wait_until_it_answers(port, 3)
    assert handler.read1ByteTxRx(port, 3, TORQUE)[0] == 0


def test_sdk_resets_to_the_factorys_settings(port: sdk.PortHandler) -> None:
    assert handler.write1ByteTxRx(port, 4, 31, 60) == OK
    assert handler.factoryReset(port, 4, 0x02) == OK
    wait_until_it_answers(port, 4)
    assert handler.read1ByteTxRx(port, 4, 31)[0] == 70
    assert handler.read1ByteTxRx(port, 4, 9)[0] == 250


def test_sdk_group_sync_write_moves_and_group_sync_read_sees_it(port: sdk.PortHandler) -> None:
    goals = {1: 2000, 2: 2100, 3: 2150, 4: 1990}
    torque = sdk.GroupSyncWrite(port, handler, TORQUE, 1)
    write = sdk.GroupSyncWrite(port, handler, GOAL, 4)
    read = sdk.GroupSyncRead(port, handler, 126, 10)
    for servo_id in IDS:
        assert torque.addParam(servo_id, [1])
        assert write.addParam(servo_id, le4(goals[servo_id]))
        assert read.addParam(servo_id)
    assert torque.txPacket() == write.txPacket() == sdk.COMM_SUCCESS
    for servo_id in IDS:
        wait_for(port, servo_id, goals[servo_id])
    assert read.txRxPacket() == sdk.COMM_SUCCESS
    assert {i: read.getData(i, PRESENT, 4) for i in IDS} == goals


def test_sdk_group_sync_read_stops_at_a_missing_servo(port: sdk.PortHandler) -> None:
    read = sdk.GroupSyncRead(port, handler, PRESENT, 4)
    for servo_id in (1, 9, 2):
        read.addParam(servo_id)
    assert read.txRxPacket() == sdk.COMM_RX_TIMEOUT


def test_sdk_gets_an_instruction_error_for_what_is_not_simulated(port: sdk.PortHandler) -> None:
    assert handler.clearMultiTurn(port, 1) == (sdk.COMM_SUCCESS, sdk.ERRNUM_INSTRUCTION)


def test_sdk_hears_nothing_useful_at_a_wrong_baud_rate(port: sdk.PortHandler) -> None:
    assert port.setBaudRate(57_600)
    assert handler.ping(port, 1)[1] in (sdk.COMM_RX_TIMEOUT, sdk.COMM_RX_CORRUPT)
    assert port.setBaudRate(BAUD_RATE)
    port.clearPort()
    assert handler.ping(port, 1)[1] == sdk.COMM_SUCCESS


def test_sdk_changes_id_and_baud_rate(port: sdk.PortHandler) -> None:
    assert handler.write1ByteTxRx(port, 1, 7, 11) == OK
    assert handler.write1ByteTxRx(port, 11, 8, 4) == OK
    assert port.setBaudRate(2_000_000)
    assert handler.ping(port, 11)[:2] == (1120, sdk.COMM_SUCCESS)


def test_clients_take_the_stuffing_out_of_an_answer(port_name: str) -> None:
    """A homing offset of -2 before a moving threshold of 253 reads as a header: FF FF FD 00."""
    payload = (-2).to_bytes(4, "little", signed=True) + (253).to_bytes(4, "little")
    assert b"\xff\xff\xfd\x00" in payload
    port = sdk.PortHandler(port_name)
    assert port.openPort()
    assert port.setBaudRate(BAUD_RATE)
    assert handler.write4ByteTxRx(port, 2, 20, 0xFFFFFFFE) == OK
    assert handler.write4ByteTxRx(port, 2, 24, 253) == OK
    assert handler.readTxRx(port, 2, 20, 8) == (list(payload), *OK)
    port.closePort()
    client = rustypot.Xl430PyController(port_name, BAUD_RATE, 0.1)
    assert bytes(client.read_raw_data(2, 20, 8)) == payload
    other = (-257).to_bytes(4, "little", signed=True) + (253).to_bytes(4, "little")
    client.sync_write_raw_data([2], 20, [list(other)])  # stuffed on the way out too
    assert [bytes(data) for data in client.sync_read_raw_data([2], 20, 8)] == [other]


def test_rustypot_reads_moves_and_reboots(port_name: str) -> None:
    client = rustypot.Xl330PyController(port_name, BAUD_RATE, 0.1)
    assert client.ping(4)
    assert not client.ping(9)
    assert client.read_model_number(4) == [1200]
    client.write_torque_enable(4, True)
    client.write_goal_position(4, 0.5)
    deadline = time.monotonic() + 10.0
    while abs(client.read_present_position(4)[0] - 0.5) > 2.0 * math.pi / 4096:
        assert time.monotonic() < deadline
    assert client.reboot(4)


def test_rustypot_syncs_several_models(port_name: str) -> None:
    definitions = {
        i: (rustypot.Xl330PyController if i == 4 else rustypot.Xl430PyController).definition()
        for i in IDS
    }
    with rustypot.Bus(port_name, BAUD_RATE, 0.1, definitions) as bus:
        assert bus.sync_read_register([3, 1, 4, 2], "present_position") == [2048] * 4
        assert bus.set_torque(IDS, True) == {}
        bus.sync_write_register(IDS, "goal_position", [2050 + i for i in IDS])
        assert bus.sync_read_register(IDS, "goal_position") == [2050 + i for i in IDS]
        deadline = time.monotonic() + 10.0
        while bus.sync_read_register(IDS, "present_position") != [2050 + i for i in IDS]:
            assert time.monotonic() < deadline
        assert bus.sync_read_register_with_error([2], "present_temperature") == [(25, 0)]
