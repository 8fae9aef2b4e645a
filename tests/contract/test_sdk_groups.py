"""The SDK's group classes, every method of each, unmodified, at a running simulator."""

from collections.abc import Callable, Iterator
from typing import Any

import dynamixel_sdk as sdk
import pytest

from firmware_sim.testing import running

from .clients import OK, SET_UP, STICKS, Recorder, le, opened, public, until

SERVOS = ("xm540-w270:1", "xm430-w350:2", "xl430-w250:3", "xl330-m288:4")
IDS = (1, 2, 3, 4)
NUMBERS = {1: 1120, 2: 1020, 3: 1060, 4: 1200}
TORQUE, LED, GOAL, PRESENT = 64, 65, 116, 132

handler = sdk.Protocol2PacketHandler()


@pytest.fixture(scope="module")
def port_name() -> Iterator[str]:
    with running(*SERVOS, arguments=SET_UP) as name:
        yield name


@pytest.fixture
def port(port_name: str) -> Iterator[sdk.PortHandler]:
    """The open port of the one simulator, whose servos rest and are dark before and after."""
    with opened(port_name) as handle:
        yield handle
        assert [handler.read2ByteTxRx(handle, i, TORQUE) for i in IDS] == [(0, *OK)] * 4


Make = Callable[..., Any]


@pytest.fixture
def whole(port: sdk.PortHandler) -> Iterator[Make]:
    """Make groups whose every public method must have been called when the test ends."""
    made = []

    def make(kind: type, *arguments: int) -> Recorder:
        made.append(Recorder(kind(port, handler, *arguments)))
        return made[-1]

    yield make
    for group in made:
        assert group.called == public(type(group.target))


def leds(port: sdk.PortHandler) -> list[int]:
    return [handler.read1ByteTxRx(port, servo_id, LED)[0] for servo_id in IDS]


def test_sync_read(whole: Make) -> None:
    group = whole(sdk.GroupSyncRead, 0, 7)
    assert group.txRxPacket() == group.fastSyncRead() == sdk.COMM_NOT_AVAILABLE  # for nobody
    for servo_id in (3, 9, 1, 4, 2):
        assert group.addParam(servo_id)
    assert not group.addParam(3)
    group.removeParam(9)
    assert not group.isAvailable(3, 0, 2)
    assert group.txRxPacket() == sdk.COMM_SUCCESS
    assert {i: group.getData(i, 0, 2) for i in IDS} == NUMBERS
    assert group.fastSyncRead() == sdk.COMM_SUCCESS
    assert {i: group.getData(i, 0, 2) for i in IDS} == NUMBERS
    assert all(group.getData(i, 6, 1) >= 45 for i in IDS)
    assert not group.isAvailable(3, 4, 4)
    assert group.getData(3, 4, 4) == 0
    assert group.txPacket() == group.rxPacket() == sdk.COMM_SUCCESS
    assert group.fastSyncReadTxPacket() == group.fastSyncReadRxPacket() == sdk.COMM_SUCCESS
    group.clearParam()
    group.makeParam()
    assert group.txPacket() == sdk.COMM_NOT_AVAILABLE


def test_a_sync_read_stops_at_a_missing_servo(port: sdk.PortHandler) -> None:
    read = sdk.GroupSyncRead(port, handler, PRESENT, 4)
    for servo_id in (1, 9, 2):
        read.addParam(servo_id)
    assert read.txRxPacket() == sdk.COMM_RX_TIMEOUT
    assert read.fastSyncRead() == sdk.COMM_RX_CORRUPT  # the packet was begun and never ended


def test_sync_write(port: sdk.PortHandler, whole: Make) -> None:
    group = whole(sdk.GroupSyncWrite, LED, 1)
    assert group.txPacket() == sdk.COMM_NOT_AVAILABLE
    for servo_id in (4, 2, 9, 1):
        assert group.addParam(servo_id, [1])
    assert not group.addParam(4, [1])
    assert not group.addParam(3, [1, 0])
    group.removeParam(9)
    assert group.changeParam(2, [0])
    group.makeParam()
    assert group.txPacket() == sdk.COMM_SUCCESS
    assert leds(port) == [1, 0, 0, 1]
    group.clearParam()
    for servo_id in IDS:
        assert group.addParam(servo_id, [0])
    assert group.txPacket() == sdk.COMM_SUCCESS
    assert leds(port) == [0, 0, 0, 0]


def test_bulk_read(whole: Make) -> None:
    group = whole(sdk.GroupBulkRead)
    assert group.txRxPacket() == group.fastBulkRead() == sdk.COMM_NOT_AVAILABLE  # for nobody
    # The SDK looks for an ID among the addresses and lengths of a fast read too: it finds 2 and 3,
    # which are not there, and would take the 4 of a length for servo 4.
    asked = {1: (0, 4), 2: (31, 1), 3: (52, 4)}
    for servo_id, (address, size) in {**asked, 9: (0, 2)}.items():
        assert group.addParam(servo_id, address, size)
    assert not group.addParam(1, 0, 2)
    group.removeParam(9)
    expected = {(1, 0, 2): 1120, (2, 31, 1): 80, (3, 52, 4): 0}
    for read in (group.txRxPacket, group.fastBulkRead):
        assert read() == sdk.COMM_SUCCESS
        assert {one: group.getData(*one) for one in expected} == expected
    assert group.isAvailable(1, 2, 2)
    assert not group.isAvailable(2, 31, 2)
    assert group.txPacket() == group.rxPacket() == sdk.COMM_SUCCESS
    assert group.fastBulkReadTxPacket() == group.fastBulkReadRxPacket() == sdk.COMM_SUCCESS
    group.clearParam()
    group.makeParam()
    assert group.txPacket() == sdk.COMM_NOT_AVAILABLE


def test_bulk_write(port: sdk.PortHandler, whole: Make) -> None:
    group = whole(sdk.GroupBulkWrite)
    assert group.txPacket() == sdk.COMM_NOT_AVAILABLE
    assert group.addParam(1, LED, 1, [1])
    assert group.addParam(4, 84, 2, le(700, 2))
    assert group.addParam(9, LED, 1, [1])
    assert not group.addParam(1, LED, 1, [0])
    assert not group.addParam(2, LED, 1, [0, 0])
    group.removeParam(9)
    group.makeParam()
    assert group.txPacket() == sdk.COMM_SUCCESS
    assert leds(port) == [1, 0, 0, 0]
    assert handler.read2ByteTxRx(port, 4, 84)[0] == 700
    assert group.changeParam(1, LED, 1, [0])
    assert group.changeParam(4, 84, 2, le(400, 2))
    assert group.txPacket() == sdk.COMM_SUCCESS
    assert leds(port) == [0, 0, 0, 0]
    assert handler.read2ByteTxRx(port, 4, 84)[0] == 400
    group.clearParam()
    assert group.txPacket() == sdk.COMM_NOT_AVAILABLE


def test_groups_move_servos_and_see_them_arrive(port: sdk.PortHandler) -> None:
    goals = {1: 2000, 2: 2100, 3: 2150, 4: 1990}
    torque = sdk.GroupSyncWrite(port, handler, TORQUE, 1)
    write = sdk.GroupSyncWrite(port, handler, GOAL, 4)
    read = sdk.GroupSyncRead(port, handler, 126, 10)
    for servo_id in IDS:
        assert torque.addParam(servo_id, [1])
        assert write.addParam(servo_id, le(goals[servo_id]))
        assert read.addParam(servo_id)
    assert torque.txPacket() == write.txPacket() == sdk.COMM_SUCCESS

    def arrived() -> bool:
        assert read.txRxPacket() == sdk.COMM_SUCCESS
        return {i: read.getData(i, PRESENT, 4) for i in IDS} == pytest.approx(goals, abs=STICKS)

    until(arrived)
    for servo_id in IDS:
        torque.changeParam(servo_id, [0])
    assert torque.txPacket() == sdk.COMM_SUCCESS
