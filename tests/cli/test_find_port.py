"""`armsyn find-port` as a person gives it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator

import pytest
from serial.tools.list_ports_common import ListPortInfo

from armsyn.driver import find_port as ports
from armsyn.driver import port_probe
from firmware_sim.testing import RunningSimulator, simulated
from tests.cli.commands import Outcome

Call = Callable[..., Outcome]


@pytest.fixture(scope="module")
def servos() -> Iterator[RunningSimulator]:
    with simulated("xm430-w350:1", "xl430-w250:2", baud=1_000_000) as simulator:
        yield simulator


@pytest.fixture(autouse=True)
def only_named_ports(monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep this machine's own ports out of it, and try two rates only."""
    monkeypatch.setattr(ports.list_ports, "comports", list)
    defaults = port_probe.probe.__defaults__
    assert defaults is not None
    monkeypatch.setattr(port_probe.probe, "__defaults__", ((1_000_000,), *defaults[1:]))


def test_the_port_with_servos_is_found(call: Call, servos: RunningSimulator) -> None:
    said = call("find-port", "--also", servos.link, "--also", "/dev/nothing")
    assert said.status == 0, said.err
    assert said.out.splitlines() == [
        f"{servos.link}: pseudo-terminal (a simulator?)",
        "  2 servo(s) at 1000000 baud, protocol 2: 1 xm430-w350, 2 xl430-w250",
    ]
    assert "/dev/nothing does not exist" in said.err


def test_the_document_says_the_same(call: Call, servos: RunningSimulator) -> None:
    (port,) = call("find-port", "--also", servos.link, "--json").document["ports"]
    assert port["path"] == servos.link
    assert (port["baud"], port["forbidden"], port["taken"], port["latency_s"]) == (
        *(1_000_000, None, None, 0.0),
    )
    assert [servo["model"] for servo in port["servos"]] == ["xm430-w350", "xl430-w250"]


def test_a_port_may_only_be_listed(call: Call, servos: RunningSimulator) -> None:
    said = call("find-port", "--also", servos.link, "--no-probe")
    assert said.status == 0
    assert said.out.splitlines()[1] == "  may be opened; not asked for servos"


def test_no_port_at_all(call: Call) -> None:
    said = call("find-port")
    assert said.status == 3
    assert said.out.startswith("no serial port: plug the arm's adapter in")
    assert "then run armsyn find-port again" in said.out
    call("find-port", "--unplug").refused(3, "no serial port at all: plug the arm's adapter in")


def test_ports_without_an_adapter_say_what_to_do(
    call: Call, monkeypatch: pytest.MonkeyPatch, servos: RunningSimulator
) -> None:
    built_in = ListPortInfo(servos.port)
    monkeypatch.setattr(ports.list_ports, "comports", lambda: [built_in])
    said = call("find-port")
    assert said.status == 3
    lines = said.out.splitlines()
    assert lines[1].startswith("  not probed: no USB adapter")
    assert lines[2].startswith("no USB adapter among them: plug the arm's adapter in")
    assert "no USB adapter among" not in call("find-port", "--also", servos.port).out


def test_silent_servos_are_no_find(call: Call, servos: RunningSimulator) -> None:
    servos.inject("missing-servo:id=1")
    servos.inject("missing-servo:id=2")
    try:
        said = call("find-port", "--also", servos.link)
    finally:
        servos.clear()
    assert said.status == 3
    assert "no servo answers: check the servos' supply" in said.out


class Person:
    """Pulls the plug, or not, before pressing Enter."""

    def __init__(self, act: Callable[[], object]) -> None:
        self.act = act

    def readline(self, *_: object) -> str:
        self.act()
        return "\n"

    def isatty(self) -> bool:
        return False


def test_the_port_that_vanishes_is_the_arms(
    call: Call, servos: RunningSimulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdin", Person(lambda: None))
    said = call("find-port", "--unplug", "--also", servos.link)
    assert said.status == 3
    assert "no port has vanished" in said.err
    monkeypatch.setattr(sys, "stdin", Person(lambda: servos.inject("unplugged")))
    said = call("find-port", "--unplug", "--also", servos.link)
    servos.clear()
    assert said.status == 0, said.err
    assert f"{servos.link} has vanished: it is the arm's port" in said.out
