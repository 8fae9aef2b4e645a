"""Code that was written for pyserial, on a stepped clock."""

from pathlib import Path

import pytest
from dynamixel_sdk import COMM_RX_TIMEOUT, COMM_SUCCESS, PortHandler, Protocol2PacketHandler

from firmware_sim.errors import FaultError, RigError
from firmware_sim.testing import SteppedSerial, stepped
from firmware_sim.wire.packet import build_packet

PING = build_packet(1, 0x01)


def handler(serial: SteppedSerial) -> PortHandler:
    """The vendor's port handler with another port in it."""
    port = PortHandler("stepped")
    port.ser = serial
    port.is_open = True
    port.baudrate = serial.baudrate
    port.tx_time_per_byte = 10_000 / serial.baudrate
    return port


def test_the_vendors_sdk_runs_on_it() -> None:
    serial = SteppedSerial(stepped("xm430-w350:1", "xl330-m288:2"), timeout=0)
    packets, port = Protocol2PacketHandler(), handler(serial)
    assert packets.ping(port, 1) == (1020, COMM_SUCCESS, 0)
    assert packets.write4ByteTxRx(port, 2, 116, 1000) == (COMM_SUCCESS, 0)
    assert packets.read4ByteTxRx(port, 2, 116) == (1000, COMM_SUCCESS, 0)
    assert packets.ping(port, 9)[1] == COMM_RX_TIMEOUT
    assert serial.stepped.clock.now() > 0.0


def test_reads_end_with_their_timeout_in_simulated_time() -> None:
    with SteppedSerial(stepped("xm430-w350:1"), timeout=2.5) as serial:
        assert serial.write(PING) == len(PING)
        assert serial.read(14)[4] == 1
        began = serial.stepped.clock.now()
        assert serial.read(1) == b""
        assert serial.stepped.clock.now() - began == pytest.approx(2.5)
    assert not serial.is_open


def test_without_a_timeout_it_waits_for_what_comes_and_no_longer() -> None:
    serial = SteppedSerial(stepped("xm430-w350:1"))
    serial.write(PING)
    assert serial.read(14)[4] == 1
    with pytest.raises(TimeoutError, match="nothing is on its way"):
        serial.read(1)


def test_loops_that_poll_come_to_an_end() -> None:
    serial = SteppedSerial(stepped("xm430-w350:1"), timeout=0)
    serial.write(PING)
    looks = 0
    while serial.in_waiting < 14:
        looks += 1
        assert looks < 1000
    serial.reset_input_buffer()
    assert serial.in_waiting == 0


def test_its_rate_is_the_ports() -> None:
    serial = SteppedSerial(stepped("xm430-w350:1", baud=1_000_000), timeout=0.1)
    assert serial.baudrate == 1_000_000
    serial.baudrate = 57_600
    serial.write(PING)
    assert PING[:4] not in serial.read(14)


def test_servos_come_from_a_rig_file_too(tmp_path: Path) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text('[[servo]]\nid = 7\nmodel = "xm430-w350"\n')
    assert stepped(rig=rig).exchange(build_packet(7, 0x01))[4] == 7


@pytest.mark.parametrize("seed", [-1, 2**64, 1.5])
def test_what_makes_no_sense_is_refused(seed: int) -> None:
    with pytest.raises(RigError, match="say which servos"):
        stepped()
    with pytest.raises(RigError, match="say which servos"):
        stepped("xm430-w350:1", rig=Path("rig.toml"))
    with pytest.raises(FaultError, match="a seed goes"):
        stepped("xm430-w350:1", seed=seed)
