"""Ports that are listed, explained and asked for servos. Rows 13, 15 and 40 of the faults."""

import os
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pytest

from armsyn.driver import find_port, port_probe
from armsyn.driver.find_port import PortFacts, find_ports, forbidden, taken, vanished
from armsyn.driver.parser import ParserCounters
from armsyn.driver.port_probe import Probe, probe
from armsyn.driver.serial_port import SerialPort
from armsyn.errors import PortError
from firmware_sim.testing import simulated


@dataclass
class Listed:
    """What pyserial tells of a port."""

    device: str
    description: str = "n/a"
    vid: int | None = None
    pid: int | None = None
    serial_number: str | None = None


@pytest.fixture
def pseudo() -> Iterator[tuple[str, str]]:
    pairs = [os.openpty() for _ in range(2)]
    yield os.ttyname(pairs[0][1]), os.ttyname(pairs[1][1])
    for pair in pairs:
        for descriptor in pair:
            os.close(descriptor)


def listing(*ports: Listed) -> Callable[[], list[Listed]]:
    return lambda: list(ports)


def test_usb_adapters_come_first_with_what_names_them(pseudo: tuple[str, str]) -> None:
    built_in, usb = pseudo
    found = find_ports(
        listing=listing(Listed(built_in), Listed(usb, "U2D2 - UART", 0x0403, 0x6014, "FT4TFO"))
    )
    assert [port.path for port in found] == [usb, built_in]
    assert found[0].usb_id == "0403:6014"
    assert found[0].serial_number == "FT4TFO"
    assert found[0].description == "U2D2 - UART"
    assert found[0].unfit is None
    assert found[1].unfit == f"not probed: no USB adapter (--also {built_in} probes it)"


def test_a_port_that_is_named_is_probed_whatever_it_is(pseudo: tuple[str, str]) -> None:
    (port,) = find_ports([pseudo[0], "/dev/nothing"], listing(Listed(pseudo[0])))
    assert (port.path, port.named, port.unfit) == (pseudo[0], True, None)


@pytest.mark.fault(15)
def test_the_latency_timer_of_an_adapter_is_seen(
    pseudo: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    seconds = {pseudo[0]: 0.016, pseudo[1]: 0.001}
    monkeypatch.setattr(find_port, "adapter_latency", lambda path: seconds[path])
    found = find_ports(pseudo, listing())
    assert [(port.latency, port.slow) for port in found] == [(0.016, True), (0.001, False)]


@pytest.mark.fault(13)
def test_no_permission_names_the_group_to_join(pseudo: tuple[str, str]) -> None:
    asked: list[int] = []

    def denied(_: str, mode: int) -> bool:
        asked.append(mode)
        return False

    said = forbidden(pseudo[0], denied)
    assert asked == [os.R_OK | os.W_OK]
    assert said is not None
    assert said.startswith("no permission: join the group ")
    assert "usermod -aG" in said
    assert forbidden(pseudo[0]) is None


def test_what_is_no_port_is_said(tmp_path: Path) -> None:
    file = tmp_path / "notes"
    file.touch()
    assert forbidden(str(file)) == "is not a serial port"
    assert "No such file" in str(forbidden(str(tmp_path / "nothing")))


def test_a_program_of_this_driver_is_named(pseudo: tuple[str, str]) -> None:
    with closing(SerialPort(pseudo[0], 1_000_000)):
        assert taken(pseudo[0]) == f"is taken by process {os.getpid()}: end it first"
        (port,) = find_ports(pseudo[:1], listing())
        assert port.unfit == port.taken
    assert taken(pseudo[0]) is None


def test_another_program_is_named_by_its_descriptor(tmp_path: Path) -> None:
    device = tmp_path / "ttyUSB0"
    device.touch()
    for process, name, target in (("41", "bash", tmp_path), ("42", "screen", device)):
        folder = tmp_path / "proc" / process / "fd"
        folder.mkdir(parents=True)
        (folder / "3").symlink_to(target)
        (folder.parent / "comm").write_text(f"{name}\n")
    processes = tmp_path / "proc"
    assert taken(str(device), processes) == "is taken by process 42 (screen): end it first"
    (processes / "42" / "fd" / "3").unlink()
    assert taken(str(device), processes) is None


def test_what_vanishes_is_what_was_unplugged() -> None:
    def port(path: str) -> PortFacts:
        return PortFacts(path, "", None, None, 0.0, None, None)

    before = (port("/dev/ttyUSB0"), port("/dev/ttyUSB1"))
    assert vanished(before, before[:1]) == before[1:]
    assert vanished(before, before) == ()


def test_servos_of_both_protocols_are_found_and_nothing_is_written() -> None:
    with simulated("xm430-w350:3", "ax-12a:7", baud=1_000_000) as simulator:
        found = probe(simulator.port, (1_000_000,))
    assert found.baud == 1_000_000
    assert [(s.servo_id, s.model, s.protocol) for s in found.servos] == [
        (3, "xm430-w350", 2),
        (7, "ax-12a", 1),
    ]
    assert found.problem is None
    requests = [line for line in simulator.trace.splitlines() if " -> " in line]
    assert len(requests) > 200
    assert all(" ping " in line or " read " in line for line in requests)


class Counted:
    """A bus that notes which rates it was asked at."""

    asked: ClassVar[list[tuple[int, int]]] = []

    def __init__(self, path: str, baud: int, margin: float) -> None:
        del path, margin
        self.baudrate = baud
        self.parser_counters = ParserCounters()

    def setBaudRate(self, baud: int) -> bool:  # noqa: N802 - the SDK's name
        if baud == 3_000_000:
            raise PortError("this adapter does not")
        self.baudrate = baud
        return True

    def broadcast_ping(self, protocol: int) -> dict[int, int]:
        self.asked.append((self.baudrate, protocol))
        return {4: 1020} if (self.baudrate, protocol) == (2_000_000, 2) else {}

    def close(self) -> None:
        pass


def test_rates_are_tried_until_one_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(port_probe, "Bus", Counted)
    steps: list[tuple[int, int]] = []
    rates = (57_600, 3_000_000, 2_000_000, 1_000_000)
    found = probe("anywhere", rates, lambda *step: steps.append(step))
    assert (found.baud, [s.servo_id for s in found.servos]) == (2_000_000, [4])
    assert Counted.asked == [(57_600, 2), (57_600, 1), (2_000_000, 2), (2_000_000, 1)]
    assert steps[0] == (0, 8)
    assert probe("anywhere", (57_600,)) == Probe()


class Noisy(Counted):
    """One that hears garbage at a rate that is not its servo's, or at that one, too."""

    rates: ClassVar[set[int]] = {57_600}

    def broadcast_ping(self, protocol: int) -> dict[int, int]:
        if self.baudrate in self.rates:
            self.parser_counters.garbage_bytes += 50
        return super().broadcast_ping(protocol)


def test_garbage_at_another_rate_is_no_second_servo(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(port_probe, "Bus", Noisy)
    assert not probe("anywhere", (57_600, 2_000_000)).garbled
    assert probe("anywhere", (57_600,)).garbled
    monkeypatch.setattr(Noisy, "rates", {2_000_000})
    assert probe("anywhere", (57_600, 2_000_000)).garbled


def test_a_port_that_cannot_be_opened_is_a_problem_not_an_error(pseudo: tuple[str, str]) -> None:
    with closing(SerialPort(pseudo[0], 1_000_000)):
        found = probe(pseudo[0])
    assert found == Probe(problem=f"is taken by process {os.getpid()}: end it first")
    assert "does not exist" in str(probe("/dev/nothing").problem)
