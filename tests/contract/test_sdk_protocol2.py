"""Every call of the SDK's packet handler for Protocol 2.0, unmodified, at a running simulator.

The handler's own notion of the protocol is the oracle. What its groups do with it is in
`test_sdk_groups`.
"""

from collections.abc import Iterator

import dynamixel_sdk as sdk
import pytest
from dynamixel_sdk import protocol2_packet_handler as errors

from firmware_sim.testing import running

from .clients import BAUD_RATE, OK, SET_UP, STICKS, Ledger, Recorder, le, opened, public, until

SERVOS = ("xm540-w270@45:1", "xm430-w350@45:2", "xl430-w250@45:3", "xl330-m288@52:4")
IDS = (1, 2, 3, 4)
NUMBERS = {1: 1120, 2: 1020, 3: 1060, 4: 1200}
ID, DELAY, MODE, TORQUE, LED, ERROR_LEVEL, REGISTERED = 7, 9, 11, 64, 65, 68, 69
GOAL, MOVING, PRESENT = 116, 122, 132

handler = Recorder(sdk.Protocol2PacketHandler())
ledger = Ledger(handler)


@pytest.fixture(scope="module")
def port_name() -> Iterator[str]:
    with running(*SERVOS, arguments=SET_UP) as name:
        yield name


def settings_of(port: sdk.PortHandler) -> list[tuple[list[int], int, int]]:
    """Return each servo's EEPROM, and its RAM up to Hardware Error Status."""
    return [handler.readTxRx(port, servo_id, 0, 71) for servo_id in IDS]


@pytest.fixture
def port(port_name: str) -> Iterator[sdk.PortHandler]:
    """The open port of the one simulator, which every test leaves as it found it."""
    with opened(port_name) as handle:
        before = settings_of(handle)
        yield handle
        assert settings_of(handle) == before


def ignore_the_answer(port: sdk.PortHandler, size: int = 11) -> None:
    """Let an answer come in that the SDK does not read, so that it is not taken for the next.

    The SDK empties its buffer before it sends: an answer that is still on the wire by then is
    read as that of the next request, if it has the same ID. So it does with real servos.
    """
    until(lambda: port.getBytesAvailable() >= size)
    port.clearPort()


def test_the_first_request_to_a_new_simulator_is_answered() -> None:
    with running("xl330-m288:1", arguments=SET_UP) as name, opened(name) as port:
        assert handler.ping(port, 1) == (1200, *OK)


@ledger.calls("ping", "getProtocolVersion", "getTxRxResult")
def test_ping(port: sdk.PortHandler) -> None:
    assert handler.getProtocolVersion() == 2.0
    assert {i: handler.ping(port, i) for i in IDS} == {i: (NUMBERS[i], *OK) for i in IDS}
    model, result, _error = handler.ping(port, 9)
    assert (model, result) == (0, sdk.COMM_RX_TIMEOUT)
    assert "no status packet" in handler.getTxRxResult(result)


@ledger.calls("broadcastPing")
def test_broadcast_ping(port: sdk.PortHandler) -> None:
    found, result = handler.broadcastPing(port)
    assert result == sdk.COMM_SUCCESS
    assert found == {1: [1120, 45], 2: [1020, 45], 3: [1060, 45], 4: [1200, 52]}


@ledger.calls("txPacket", "rxPacket", "updateCRC", "removeStuffing")
def test_a_packet_by_hand(port: sdk.PortHandler) -> None:
    ping = [0, 0, 0, 0, 2, 3, 0, sdk.INST_PING, 0, 0]
    assert handler.txPacket(port, ping) == sdk.COMM_SUCCESS
    port.setPacketTimeout(14)
    answer, result = handler.rxPacket(port, False)
    assert result == sdk.COMM_SUCCESS
    assert answer[:12] == [0xFF, 0xFF, 0xFD, 0, 2, 7, 0, 0x55, 0, *le(1020, 2), 45]
    assert handler.updateCRC(0, answer, 12) == int.from_bytes(bytes(answer[12:]), "little")
    assert handler.removeStuffing(list(answer)) == answer


@ledger.calls("addStuffing", "txRxPacket")
def test_stuffing_both_ways(port: sdk.PortHandler) -> None:
    """A homing offset of -2 before a moving threshold of 253 reads as a header: FF FF FD 00."""
    payload = [*le(-2), *le(253)]
    before = handler.readTxRx(port, 2, 20, 8)[0]
    request = [0xFF, 0xFF, 0xFD, 0, 2, 13, 0, sdk.INST_WRITE, 20, 0, *payload, 0, 0]
    # The SDK's `txPacket` stuffs into a copy that it throws away, so that it must be sent by hand.
    stuffed = handler.addStuffing(request)
    assert len(stuffed) == 21
    stuffed[-2:] = le(handler.updateCRC(0, stuffed, 19), 2)
    port.writePort(stuffed)
    ignore_the_answer(port)
    assert handler.readTxRx(port, 2, 20, 8) == (payload, *OK)
    # The SDK would take an answer without stuffing too, so that it is looked at as it comes.
    assert handler.readTx(port, 2, 20, 8) == sdk.COMM_SUCCESS
    until(lambda: port.getBytesAvailable() >= 20)
    assert b"\xff\xff\xfd\xfd\x00" in port.readPort(20)
    port.is_using = False  # as the SDK's own reading leaves it
    restore = [0, 0, 0, 0, 2, 13, 0, sdk.INST_WRITE, 20, 0, *before, 0, 0]
    assert handler.txRxPacket(port, restore)[1:] == OK


@pytest.mark.parametrize("size", [1, 2, 4])
@pytest.mark.parametrize("form", ["Tx", "TxRx"])
def test_reads_of_every_size(port: sdk.PortHandler, size: int, form: str) -> None:
    address, value = {1: (31, 80), 2: (36, 885), 4: (48, 4095)}[size]
    if form == "TxRx":
        answer = getattr(handler, f"read{size}ByteTxRx")(port, 1, address)
    else:
        assert getattr(handler, f"read{size}ByteTx")(port, 1, address) == sdk.COMM_SUCCESS
        answer = getattr(handler, f"read{size}ByteRx")(port, 1)
    assert answer == (value, *OK)


@ledger.calls("readTx", "readRx", "readTxRx")
def test_reads_of_many_bytes(port: sdk.PortHandler) -> None:
    whole, *rest = handler.readTxRx(port, 1, 0, 147)
    assert tuple(rest) == OK
    assert len(whole) == 147
    assert whole[:2] == le(1120, 2)
    assert handler.readTx(port, 1, 32, 40) == sdk.COMM_SUCCESS
    assert handler.readRx(port, 1, 40) == (whole[32:72], *OK)
    # Of a refusal the SDK hands on the CRC as if it were data.
    assert handler.readTxRx(port, 1, 660, 4)[1:] == (sdk.COMM_SUCCESS, errors.ERRNUM_ACCESS)


@pytest.mark.parametrize("size", [1, 2, 4])
@pytest.mark.parametrize("form", ["TxOnly", "TxRx"])
def test_writes_of_every_size(port: sdk.PortHandler, size: int, form: str) -> None:
    address, value = {1: (LED, 1), 2: (84, 640), 4: (GOAL, 3000)}[size]
    read = getattr(handler, f"read{size}ByteTxRx")
    write = getattr(handler, f"write{size}Byte{form}")
    before = read(port, 2, address)[0]
    for wanted in (value, before):
        result = write(port, 2, address, wanted)
        if form == "TxOnly":
            ignore_the_answer(port)
        assert result == (OK if form == "TxRx" else sdk.COMM_SUCCESS)
        assert read(port, 2, address) == (wanted, *OK)


@ledger.calls("writeTxOnly", "writeTxRx")
def test_writes_of_many_bytes(port: sdk.PortHandler) -> None:
    profile = [*le(20), *le(100), *le(2500)]
    assert handler.writeTxRx(port, 1, 108, 12, profile) == OK
    assert handler.readTxRx(port, 1, 108, 12) == (profile, *OK)
    assert handler.writeTxOnly(port, 1, 108, 8, [0] * 8) == sdk.COMM_SUCCESS
    ignore_the_answer(port)
    assert handler.readTxRx(port, 1, 108, 12) == ([0] * 8 + profile[8:], *OK)


@ledger.calls("getRxPacketError")
def test_each_error_number(port: sdk.PortHandler) -> None:
    def error(address: int, size: int, value: int) -> int:
        result, number = handler.writeTxRx(port, 1, address, size, le(value, size))
        assert result == sdk.COMM_SUCCESS
        return int(number)

    assert error(TORQUE, 1, 1) == 0
    expected = {
        (70, 1, 1): errors.ERRNUM_ACCESS,
        (DELAY, 1, 1): errors.ERRNUM_ACCESS,
        (LED, 1, 2): errors.ERRNUM_DATA_RANGE,
        (GOAL, 4, 4096): errors.ERRNUM_DATA_LIMIT,
        (GOAL, 2, 100): errors.ERRNUM_DATA_LENGTH,
    }
    assert {arguments: error(*arguments) for arguments in expected} == expected
    assert "not available" in handler.getRxPacketError(errors.ERRNUM_ACCESS)
    assert error(TORQUE, 1, 0) == 0


@ledger.calls("regWriteTxOnly", "regWriteTxRx", "action")
def test_registered_writes(port: sdk.PortHandler) -> None:
    for registers, value in ((handler.regWriteTxRx, 1), (handler.regWriteTxOnly, 0)):
        if registers(port, 2, LED, 1, [value]) == sdk.COMM_SUCCESS:
            ignore_the_answer(port)
        assert handler.read2ByteTxRx(port, 2, ERROR_LEVEL)[0] == 2 | 1 << 8
        assert handler.read1ByteTxRx(port, 2, LED)[0] == 1 - value
        # The SDK reads no answer to an action, but the servo gives one, unless it was to all.
        servo_id = 2 if value else sdk.BROADCAST_ID
        assert handler.action(port, servo_id) == sdk.COMM_SUCCESS
        if value:
            ignore_the_answer(port)
        assert handler.read1ByteTxRx(port, 2, LED)[0] == value
        assert handler.read1ByteTxRx(port, 2, REGISTERED)[0] == 0


@ledger.calls("reboot")
def test_reboot(port: sdk.PortHandler) -> None:
    assert handler.write1ByteTxRx(port, 3, TORQUE, 1) == OK
    assert handler.reboot(port, 3) == OK
    until(lambda: handler.ping(port, 3)[1] == sdk.COMM_SUCCESS)
    assert handler.read1ByteTxRx(port, 3, TORQUE)[0] == 0


@ledger.calls("clearMultiTurn")
def test_clear_of_turns(port: sdk.PortHandler) -> None:
    assert handler.write1ByteTxRx(port, 2, MODE, 4) == OK
    assert handler.write1ByteTxRx(port, 2, TORQUE, 1) == OK
    assert handler.write4ByteTxRx(port, 2, GOAL, 4500) == OK
    until(lambda: handler.read1ByteTxRx(port, 2, MOVING)[0] == 1)
    assert handler.clearMultiTurn(port, 2) == (sdk.COMM_SUCCESS, errors.ERRNUM_RESULT_FAIL)
    near = pytest.approx(4500, abs=STICKS)
    until(lambda: handler.read4ByteTxRx(port, 2, PRESENT)[0] == near)
    until(lambda: handler.clearMultiTurn(port, 2) == OK)  # as soon as it has stopped
    near = pytest.approx(4500 - 4096, abs=STICKS)
    assert handler.read4ByteTxRx(port, 2, PRESENT)[0] == near
    assert handler.write1ByteTxRx(port, 2, TORQUE, 0) == OK
    assert handler.write1ByteTxRx(port, 2, MODE, 3) == OK


@ledger.calls("factoryReset")
def test_factory_reset(port: sdk.PortHandler) -> None:
    assert handler.write1ByteTxRx(port, 4, 31, 60) == OK
    assert handler.factoryReset(port, 4, 0x02) == OK
    until(lambda: handler.ping(port, 4)[1] == sdk.COMM_SUCCESS)
    assert handler.read1ByteTxRx(port, 4, 31)[0] == 70
    assert handler.read1ByteTxRx(port, 4, DELAY)[0] == 250
    assert handler.write1ByteTxRx(port, 4, DELAY, 0) == OK


@ledger.calls("syncReadTx", "readRx", "fastSyncReadRx")
def test_sync_reads(port: sdk.PortHandler) -> None:
    order = [3, 1, 4, 2]
    assert handler.syncReadTx(port, 0, 2, order, 4, False) == sdk.COMM_SUCCESS
    answers = [handler.readRx(port, servo_id, 2) for servo_id in order]
    assert answers == [(le(NUMBERS[i], 2), *OK) for i in order]
    assert handler.syncReadTx(port, 0, 2, order, 4, True) == sdk.COMM_SUCCESS
    data, *rest = handler.fastSyncReadRx(port, sdk.BROADCAST_ID, 24)
    assert tuple(rest) == OK
    parts = [data[start : start + 6] for start in range(0, 24, 6)]
    assert [part[:4] for part in parts] == [[0, i, *le(NUMBERS[i], 2)] for i in order]


@ledger.calls("syncWriteTxOnly")
def test_sync_write(port: sdk.PortHandler) -> None:
    for value in (1, 0):
        shares = [number for servo_id in IDS for number in (servo_id, value)]
        assert handler.syncWriteTxOnly(port, LED, 1, shares, len(shares)) == sdk.COMM_SUCCESS
        assert [handler.read1ByteTxRx(port, i, LED)[0] for i in IDS] == [value] * 4


@ledger.calls("bulkReadTx", "fastBulkReadRx")
def test_bulk_reads(port: sdk.PortHandler) -> None:
    # The SDK looks for an ID among addresses and lengths too, so that these must have no 2 or 3.
    shares = [1, *le(0, 2), *le(4, 2), 2, *le(31, 2), *le(1, 2), 3, *le(52, 2), *le(4, 2)]
    asked = {1: (0, 4), 2: (31, 1), 3: (52, 4)}
    expected = {i: handler.readTxRx(port, i, *asked[i])[0] for i in asked}
    assert handler.bulkReadTx(port, shares, 15, False) == sdk.COMM_SUCCESS
    for servo_id, data in expected.items():
        assert handler.readRx(port, servo_id, len(data)) == (data, *OK)
    assert handler.bulkReadTx(port, shares, 15, True) == sdk.COMM_SUCCESS
    assert handler.fastBulkReadRx(port, shares) == (expected, sdk.COMM_SUCCESS)


@ledger.calls("bulkWriteTxOnly")
def test_bulk_write(port: sdk.PortHandler) -> None:
    for led, gain in ((1, 700), (0, 400)):
        shares = [1, *le(LED, 2), *le(1, 2), led, 4, *le(84, 2), *le(2, 2), *le(gain, 2)]
        assert handler.bulkWriteTxOnly(port, shares, len(shares)) == sdk.COMM_SUCCESS
        assert handler.read1ByteTxRx(port, 1, LED)[0] == led
        assert handler.read2ByteTxRx(port, 4, 84)[0] == gain


def test_a_wrong_baud_rate_brings_nothing_useful(port: sdk.PortHandler) -> None:
    assert port.setBaudRate(57_600)
    assert handler.ping(port, 1)[1] in (sdk.COMM_RX_TIMEOUT, sdk.COMM_RX_CORRUPT)
    assert port.setBaudRate(BAUD_RATE)
    port.clearPort()
    assert handler.ping(port, 1)[1] == sdk.COMM_SUCCESS


def test_a_new_id_and_baud_rate(port: sdk.PortHandler) -> None:
    assert handler.write1ByteTxRx(port, 1, ID, 11) == OK
    assert handler.write1ByteTxRx(port, 11, 8, 4) == OK
    assert port.setBaudRate(2_000_000)
    assert handler.ping(port, 11)[:2] == (1120, sdk.COMM_SUCCESS)
    assert handler.write1ByteTxRx(port, 11, 8, 3) == OK
    assert port.setBaudRate(BAUD_RATE)
    assert handler.write1ByteTxRx(port, 11, ID, 1) == OK


def test_every_public_method_is_exercised() -> None:
    sized = {f"read{n}Byte{form}" for n in (1, 2, 4) for form in ("Tx", "Rx", "TxRx")}
    sized |= {f"write{n}Byte{form}" for n in (1, 2, 4) for form in ("TxOnly", "TxRx")}
    assert public(sdk.Protocol2PacketHandler) == ledger.listed | sized
