"""Clients that are killed, hang up, or leave things behind at the port."""

import fcntl
import os
import subprocess
import sys
import termios
import time
from pathlib import Path

import pytest
import serial

from firmware_sim.testing import running, simulated, stepped
from firmware_sim.wire.packet import build_packet

PING = build_packet(1, 0x01)
READ_ALL = build_packet(1, 0x02, bytes((0, 0, 140, 0)))
TORQUE_ON = build_packet(1, 0x03, bytes((64, 0, 1)))
NOBODY = 65_534

KILLED_WHILE_ALONE = """
import fcntl, os, signal, sys, termios
if os.geteuid() == 0:
    os.setgid({nobody}); os.setuid({nobody})
port = os.open({port!r}, os.O_RDWR | os.O_NOCTTY)
fcntl.ioctl(port, termios.TIOCEXCL)
os.kill(os.getpid(), signal.SIGKILL)
"""

OPEN = """
import os, sys
if os.geteuid() == 0:
    os.setgid({nobody}); os.setuid({nobody})
os.close(os.open({port!r}, os.O_RDWR | os.O_NOCTTY))
"""


def run(program: str, port: str) -> subprocess.CompletedProcess[str]:
    """Run a program as somebody without privileges."""
    text = program.format(port=port, nobody=NOBODY)
    # isolated, for nobody may read the folder that tests run in
    return subprocess.run(
        [sys.executable, "-I", "-c", text], capture_output=True, text=True, check=False, cwd="/"
    )


def ping(port: str, baud: int = 57_600, timeout: float = 2.0) -> bytes:
    with serial.Serial(port, baud, timeout=timeout) as client:
        client.write(PING)
        return client.read(14)


def test_a_port_that_a_killed_client_kept_for_itself_can_be_opened_again() -> None:
    with running("xm430-w350:1") as port:
        Path(port).chmod(0o666)
        assert run(KILLED_WHILE_ALONE, port).returncode == -9
        assert ping(port)[4] == 1
        # The simulator notices the end of the ping's port in its own time.
        deadline = time.monotonic() + 5.0
        while (refused := run(OPEN, port).stderr) and time.monotonic() < deadline:
            pass
        assert refused == ""


def test_a_client_that_is_alive_keeps_the_port_for_itself() -> None:
    """Also after another one, whom it let in before, has gone."""
    with running("xm430-w350:1") as port:
        Path(port).chmod(0o666)
        with serial.Serial(port, 57_600, timeout=2.0) as client:
            assert run(OPEN, port).stderr == ""
            fcntl.ioctl(client.fileno(), termios.TIOCEXCL)
            client.write(PING)
            assert client.read(14)[4] == 1
            assert "busy" in run(OPEN, port).stderr


def test_what_a_client_did_not_read_is_not_for_the_next_one() -> None:
    with running("xm430-w350:1") as port:
        first = os.open(port, os.O_RDWR | os.O_NOCTTY)
        os.write(first, READ_ALL)
        wait_for_bytes(first)
        os.close(first)
        second = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        try:
            deadline = time.monotonic() + 5.0
            while waiting(second) and time.monotonic() < deadline:
                pass
            assert not waiting(second)
        finally:
            os.close(second)
        assert ping(port)[4] == 1


def waiting(descriptor: int) -> int:
    return int.from_bytes(fcntl.ioctl(descriptor, termios.FIONREAD, bytes(4)), sys.byteorder)


def wait_for_bytes(descriptor: int) -> None:
    deadline = time.monotonic() + 5.0
    while not waiting(descriptor):
        assert time.monotonic() < deadline


def test_the_last_words_of_a_client_are_heard() -> None:
    """A driver's torque off, written right before it closes the port."""
    with simulated("xm430-w350:1") as arm:
        with serial.Serial(arm.port, 57_600) as client:
            client.write(PING * 3 + TORQUE_ON)
        deadline = time.monotonic() + 5.0
        while not arm.status()["servos"][0]["registers"]["Torque Enable"]:
            assert time.monotonic() < deadline


def test_slow_bytes_of_a_client_that_is_gone_do_not_hold_up_the_next() -> None:
    with running("xm430-w350:1") as port:
        with serial.Serial(port, 50, timeout=2.0) as client:
            client.write(bytes(1000))  # 200 s of wire
        began = time.monotonic()
        assert ping(port, timeout=20.0)[4] == 1
        assert time.monotonic() - began < 20.0


def test_a_change_of_rate_sets_the_wire_free() -> None:
    with (
        running("xm430-w350:1") as port,
        serial.Serial(port, 50, timeout=20.0) as client,
    ):
        client.write(bytes(3))
        client.baudrate = 57_600
        client.write(PING)
        assert client.read_until(PING[:4]).endswith(PING[:4])  # behind what was garbled


def test_a_rate_of_zero_hangs_up_and_another_takes_the_line_up_again() -> None:
    with simulated("xm430-w350:1") as arm:
        descriptor = os.open(arm.port, os.O_RDWR | os.O_NOCTTY)
        try:
            attributes = termios.tcgetattr(descriptor)
            attributes[4] = attributes[5] = termios.B0
            termios.tcsetattr(descriptor, termios.TCSANOW, attributes)
            os.write(descriptor, PING)
            assert arm.status()["servos"][0]["id"] == 1
        finally:
            os.close(descriptor)
        assert ping(arm.port)[4] == 1
        assert arm.process.poll() is None


def test_a_stepped_port_refuses_what_is_no_rate() -> None:
    port = stepped("xm430-w350:1")
    for rate in (0, -1, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="above 0"):
            port.baud_rate = rate
    assert port.exchange(PING)[4] == 1


def test_a_stepped_ports_change_of_rate_sets_the_wire_free() -> None:
    port = stepped("xm430-w350:1")
    port.baud_rate = 50
    port.write(bytes(1000))
    port.baud_rate = 57_600
    assert PING[:4] in port.exchange(PING)
    assert port.clock.now() < 1.0
