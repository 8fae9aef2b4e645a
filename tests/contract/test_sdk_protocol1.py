"""Every call of the SDK's packet handler for Protocol 1.0, unmodified, at a running simulator.

AX and MX servos of protocol 1.0 share the wire with servos of protocol 2.0, and with one of the X
series that was set to speak 1.0.
"""

from collections.abc import Iterator

import dynamixel_sdk as sdk
import pytest
from dynamixel_sdk import protocol1_packet_handler as errors

from firmware_sim.testing import running

from .clients import BAUD_RATE, OK, STICKS, Ledger, Recorder, le, opened, public, until

SERVO = f"""
[[servo]]
id = {{}}
model = "{{}}"
protocol = {{}}
baud = {BAUD_RATE}
return_delay_us = 0
"""
SERVOS = (
    (1, "ax-12a", 1),
    (2, "mx-28", 1),
    (3, "mx-64", 1),
    (4, "xl430-w250", 2),
    (5, "mx-106", 2),
    (6, "xm430-w350", 1),
)
CLASSIC = (1, 2, 3)
ID, BAUD, DELAY, CCW_LIMIT, TEMPERATURE_LIMIT = 3, 4, 5, 8, 11
TORQUE, LED, GOAL, SPEED, PRESENT, REGISTERED = 24, 25, 30, 32, 36, 44

handler = Recorder(sdk.Protocol1PacketHandler())
handler_2 = sdk.Protocol2PacketHandler()
ledger = Ledger(handler)


@pytest.fixture(scope="module")
def port_name(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    rig = tmp_path_factory.mktemp("rig") / "mixed.toml"
    rig.write_text("".join(SERVO.format(*servo) for servo in SERVOS))
    with running(arguments=("--rig", str(rig))) as name:
        yield name


def settings_of(port: sdk.PortHandler) -> list[tuple[list[int], int, int]]:
    """Return each servo's EEPROM, with its torque and LED."""
    return [handler.readTxRx(port, servo_id, 0, 26) for servo_id in CLASSIC]


@pytest.fixture
def port(port_name: str) -> Iterator[sdk.PortHandler]:
    """The open port of the one simulator, which every test leaves as it found it."""
    with opened(port_name) as handle:
        before = settings_of(handle)
        yield handle
        assert settings_of(handle) == before


def ignore_the_answer(port: sdk.PortHandler) -> None:
    """Let an answer come in that the SDK does not read, lest it be taken for the next one."""
    until(lambda: port.getBytesAvailable() >= 6)
    port.clearPort()


def answers(port: sdk.PortHandler, servo_id: int) -> bool:
    return bool(handler.ping(port, servo_id)[1] == sdk.COMM_SUCCESS)


@ledger.calls("ping", "broadcastPing", "getProtocolVersion", "getTxRxResult")
def test_ping(port: sdk.PortHandler) -> None:
    assert handler.getProtocolVersion() == 1.0
    found = {servo_id: handler.ping(port, servo_id) for servo_id in (1, 2, 3, 6)}
    assert found == {1: (12, *OK), 2: (29, *OK), 3: (310, *OK), 6: (1020, *OK)}
    for servo_id in (4, 5, 9):
        assert handler.ping(port, servo_id)[1] == sdk.COMM_RX_TIMEOUT
    assert handler.broadcastPing(port) == (None, sdk.COMM_NOT_AVAILABLE)
    assert "does not support" in handler.getTxRxResult(sdk.COMM_NOT_AVAILABLE)


def test_both_protocols_on_one_wire(port: sdk.PortHandler) -> None:
    for _ in range(3):
        assert handler.ping(port, 1) == (12, *OK)
        assert handler_2.ping(port, 4) == (1060, *OK)
        assert handler.ping(port, 3) == (310, *OK)
        assert handler_2.ping(port, 5) == (321, *OK)
    assert handler_2.ping(port, 6)[1] == sdk.COMM_RX_TIMEOUT
    assert set(handler_2.broadcastPing(port)[0]) == {4, 5}
    # Address 132 of an X-series servo is its Present Position in protocol 1.0 too.
    assert handler.read4ByteTxRx(port, 6, 132) == (2048, *OK)


@ledger.calls("txPacket", "rxPacket", "txRxPacket")
def test_a_packet_by_hand(port: sdk.PortHandler) -> None:
    ping = [0, 0, 1, 2, sdk.INST_PING, 0]
    assert handler.txPacket(port, ping) == sdk.COMM_SUCCESS
    port.setPacketTimeout(6)
    status = [0xFF, 0xFF, 1, 2, 0, 0xFC]
    assert handler.rxPacket(port) == (status, sdk.COMM_SUCCESS)
    assert handler.txRxPacket(port, ping) == (status, *OK)


@pytest.mark.parametrize("size", [1, 2, 4])
@pytest.mark.parametrize("form", ["Tx", "TxRx"])
def test_reads_of_every_size(port: sdk.PortHandler, size: int, form: str) -> None:
    address, value = {1: (18, 36), 2: (14, 1023), 4: (6, 1023 << 16)}[size]
    if form == "TxRx":
        answer = getattr(handler, f"read{size}ByteTxRx")(port, 1, address)
    else:
        assert getattr(handler, f"read{size}ByteTx")(port, 1, address) == sdk.COMM_SUCCESS
        answer = getattr(handler, f"read{size}ByteRx")(port, 1)
    assert answer == (value, *OK)


@ledger.calls("readTx", "readRx", "readTxRx")
def test_reads_of_many_bytes(port: sdk.PortHandler) -> None:
    whole, *rest = handler.readTxRx(port, 2, 0, 50)
    assert tuple(rest) == OK
    assert whole[:2] + whole[8:10] + whole[36:38] == [*le(29, 2), *le(4095, 2), *le(2048, 2)]
    assert handler.readTx(port, 2, 0, 26) == sdk.COMM_SUCCESS
    assert handler.readRx(port, 2, 26) == (whole[:26], *OK)
    assert handler.readTxRx(port, 2, 0, 200)[2] == errors.ERRBIT_RANGE


@pytest.mark.parametrize("size", [1, 2, 4])
@pytest.mark.parametrize("form", ["TxOnly", "TxRx"])
@pytest.mark.parametrize("servo_id", CLASSIC)
def test_writes_of_every_size(port: sdk.PortHandler, servo_id: int, size: int, form: str) -> None:
    address, value = {1: (LED, 1), 2: (SPEED, 300), 4: (SPEED, 200 | 900 << 16)}[size]
    read = getattr(handler, f"read{size}ByteTxRx")
    write = getattr(handler, f"write{size}Byte{form}")
    before = read(port, servo_id, address)[0]
    for wanted in (value, before):
        result = write(port, servo_id, address, wanted)
        if form == "TxOnly":
            ignore_the_answer(port)
        assert result == (OK if form == "TxRx" else sdk.COMM_SUCCESS)
        assert read(port, servo_id, address) == (wanted, *OK)


@ledger.calls("writeTxOnly", "writeTxRx", "syncWriteTxOnly")
def test_goals_of_all_kinds_of_write(port: sdk.PortHandler) -> None:
    """A goal switches the torque on by itself."""
    goals = {1: 560, 2: 2200, 3: 1900}
    assert handler.writeTxRx(port, 1, GOAL, 4, [*le(goals[1], 2), *le(300, 2)]) == OK
    assert handler.writeTxOnly(port, 2, GOAL, 2, le(goals[2], 2)) == sdk.COMM_SUCCESS
    ignore_the_answer(port)
    share = [3, *le(goals[3], 2), *le(100, 2)]
    assert handler.syncWriteTxOnly(port, GOAL, 4, share, 5) == sdk.COMM_SUCCESS
    for servo_id, goal in goals.items():
        near = pytest.approx(goal, abs=2 * STICKS)
        until(lambda i=servo_id, near=near: handler.read2ByteTxRx(port, i, PRESENT)[0] == near)
    torque = [number for i in CLASSIC for number in (i, 0)]
    assert handler.syncWriteTxOnly(port, TORQUE, 1, torque, 6) == sdk.COMM_SUCCESS


@ledger.calls("getRxPacketError")
def test_error_bits(port: sdk.PortHandler) -> None:
    # Neither error is among those that shut these servos down: Shutdown(18) is 36.
    assert handler.write1ByteTxRx(port, 1, LED, 2) == (sdk.COMM_SUCCESS, errors.ERRBIT_RANGE)
    assert "Out of range" in handler.getRxPacketError(errors.ERRBIT_RANGE)
    assert handler.write2ByteTxRx(port, 2, CCW_LIMIT, 3000) == OK
    assert handler.write2ByteTxRx(port, 2, GOAL, 3001) == (sdk.COMM_SUCCESS, errors.ERRBIT_ANGLE)
    assert handler.write2ByteTxRx(port, 2, CCW_LIMIT, 4095) == OK
    unknown = [0, 0, 3, 2, 0x0A, 0]
    assert handler.txRxPacket(port, unknown)[1:] == (sdk.COMM_SUCCESS, errors.ERRBIT_INSTRUCTION)
    assert handler.read1ByteTxRx(port, 1, LED) == (0, *OK)


@ledger.calls("regWriteTxOnly", "regWriteTxRx", "action")
def test_registered_writes(port: sdk.PortHandler) -> None:
    """Unlike with protocol 2.0, the SDK reads the answer to an action."""
    for servo_id in CLASSIC:
        assert handler.regWriteTxRx(port, servo_id, LED, 1, [1]) == OK
        assert handler.read1ByteTxRx(port, servo_id, REGISTERED)[0] == 1
        assert handler.read1ByteTxRx(port, servo_id, LED)[0] == 0
    assert handler.action(port, sdk.BROADCAST_ID) == sdk.COMM_SUCCESS
    for servo_id in CLASSIC:
        assert handler.read1ByteTxRx(port, servo_id, LED)[0] == 1
        assert handler.regWriteTxOnly(port, servo_id, LED, 1, [0]) == sdk.COMM_SUCCESS
        ignore_the_answer(port)
        assert handler.action(port, servo_id) == sdk.COMM_SUCCESS
        assert handler.read1ByteTxRx(port, servo_id, LED)[0] == 0


@ledger.calls("bulkReadTx", "readRx")
def test_bulk_read_of_mx(port: sdk.PortHandler) -> None:
    # `GroupBulkRead` cannot be used: it hands the handler of protocol 1.0 one argument too many.
    for servo_id in (2, 3):
        assert handler.write2ByteTxRx(port, servo_id, SPEED, 100 + servo_id) == OK
    shares = [2, 3, SPEED, 4, 2, CCW_LIMIT - 2]
    assert handler.bulkReadTx(port, shares, 6) == sdk.COMM_SUCCESS
    assert handler.readRx(port, 3, 2) == (le(103, 2), *OK)
    assert handler.readRx(port, 2, 4) == (le(4095 << 16), *OK)
    # AX does not know the instruction, and whoever comes after it waits in vain.
    assert handler.bulkReadTx(port, [2, 1, 0, 2, 2, 0], 6) == sdk.COMM_SUCCESS
    assert handler.readRx(port, 1, 2)[1] == sdk.COMM_RX_TIMEOUT


@ledger.calls("reboot", "syncReadTx", "bulkWriteTxOnly")
def test_what_protocol_1_has_not(port: sdk.PortHandler) -> None:
    assert handler.reboot(port, 2)[0] == sdk.COMM_NOT_AVAILABLE
    assert handler.syncReadTx(port, 0, 2, [2, 3], 2) == sdk.COMM_NOT_AVAILABLE
    assert handler.bulkWriteTxOnly(port, [], 0) == sdk.COMM_NOT_AVAILABLE


@ledger.calls("factoryReset")
def test_factory_reset(port: sdk.PortHandler) -> None:
    """An AX keeps answering, for its factory's ID is 1 and its baud rate 1 Mbit/s; an MX moves."""
    assert handler.write1ByteTxRx(port, 1, TEMPERATURE_LIMIT, 60) == OK
    until(lambda: answers(port, 1))
    assert handler.factoryReset(port, 1) == OK
    until(lambda: answers(port, 1))
    assert handler.read1ByteTxRx(port, 1, TEMPERATURE_LIMIT) == (70, *OK)
    assert handler.write1ByteTxRx(port, 1, DELAY, 0) == OK
    until(lambda: answers(port, 1))
    assert handler.factoryReset(port, 2) == OK
    assert port.setBaudRate(57_600)
    until(lambda: handler.ping(port, 1) == (29, *OK))
    for address, value in ((ID, 2), (DELAY, 0), (BAUD, 1)):
        servo_id = 1 if address == ID else 2
        assert handler.write1ByteTxRx(port, servo_id, address, value) == OK
    assert port.setBaudRate(BAUD_RATE)


def test_every_public_method_is_exercised() -> None:
    sized = {f"read{n}Byte{form}" for n in (1, 2, 4) for form in ("Tx", "Rx", "TxRx")}
    sized |= {f"write{n}Byte{form}" for n in (1, 2, 4) for form in ("TxOnly", "TxRx")}
    assert public(sdk.Protocol1PacketHandler) == ledger.listed | sized
