"""Faults of a simulator that runs as a process, on a real port and in real time."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import serial

from firmware_sim.control.client import send
from firmware_sim.testing import SimulatorProcess
from tests.firmware_sim.faults_bench import request

PATIENCE = 20.0
PING = request(1, 0x01)


def wait_for(condition: Callable[[], bool]) -> None:
    """Wait until it is so; fail after a time that no working simulator needs."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def fails(port: serial.Serial) -> bool:
    """Whether writing raises what it raises when a cable is pulled."""
    try:
        port.write(PING)
    except serial.SerialException:
        return True
    return False


class Arm:
    """A running simulator, its link and its control file."""

    def __init__(self, folder: Path) -> None:
        self.link, self.file = folder / "arm", folder / "control"
        servo = ("--servo", "xm430-w350:1", "--baud", "1000000")
        files = ("--link", str(self.link), "--control", str(self.file))
        self.process = SimulatorProcess(*servo, *files)

    def ask(self, command: str, fault: str | None = None) -> object:
        """Speak to its control socket."""
        return send(self.file, command, fault)

    def ping(self) -> int:
        """Open the port, ping, and return how many bytes come back."""
        with serial.Serial(str(self.link), 1_000_000, timeout=PATIENCE) as port:
            port.write(PING)
            return len(port.read(14))


@pytest.fixture
def arm(tmp_path: Path) -> Iterator[Arm]:
    made = Arm(tmp_path)
    try:
        yield made
    finally:
        made.process.stop()


def test_a_pulled_cable_is_an_error_to_the_client_until_it_is_back(arm: Arm) -> None:
    with serial.Serial(str(arm.link), 1_000_000, timeout=PATIENCE) as port:
        arm.ask("inject", "unplugged")
        wait_for(lambda: fails(port))
        wait_for(lambda: not arm.link.is_symlink())
    arm.ask("clear", "unplugged")
    wait_for(arm.link.exists)
    assert arm.ping() == 14


def test_a_forbidden_port_has_no_permissions(arm: Arm) -> None:
    arm.ask("inject", "no-permission")
    wait_for(lambda: arm.link.stat().st_mode & 0o777 == 0)
    arm.ask("clear", "no-permission")
    wait_for(lambda: arm.link.stat().st_mode & 0o777 != 0)
    assert arm.ping() == 14


def test_noise_comes_without_a_request(arm: Arm) -> None:
    with serial.Serial(str(arm.link), 1_000_000, timeout=PATIENCE) as port:
        arm.ask("inject", "idle-noise:bytes=5,to=client")
        assert len(port.read(5)) == 5


def test_the_control_file_goes_with_the_simulator(arm: Arm) -> None:
    assert arm.file.exists()
    assert arm.process.stop() == 0
    assert not arm.file.exists()
