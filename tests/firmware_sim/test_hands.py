"""Scripts of a person's hands, on the stepped clock and in a process of its own."""

import pytest

from firmware_sim.errors import ControlError, FaultError
from firmware_sim.testing import simulated, stepped

PAIR = """
[[servo]]
id = 1
model = "xm430-w350"

[[servo]]
id = 2
model = "ax-12a"
"""


def positions(port: object) -> list[int]:
    return [servo.axis.ticks for servo in port.bus.servos]  # type: ignore[attr-defined]


def test_they_turn_joints_and_let_go() -> None:
    port = stepped(rig=PAIR)
    assert port.hands.turn({1: 3000, 2: 300}, speed=2.0)
    assert not port.simulation.faults
    assert 1.0 < port.clock.now() < 1.0 / 2.0 * 1.5 + 2.0
    for servo, (address, tick) in zip(port.bus.servos, ((132, 3000), (36, 300)), strict=True):
        _, data = servo.read(address, 2)
        assert int.from_bytes(data, "little") == pytest.approx(tick, abs=2)


def test_they_hold_on_when_they_are_told_to() -> None:
    port = stepped("xm430-w350:1")
    assert port.hands.turn({1: 2500}, keep=True)
    assert port.hands.turn({1: 2600}, keep=True)
    port.bus.servos[0].apply_load(1.0)
    port.wait_until(port.clock.now() + 1.0)
    port.simulation.advance(port.clock.now())
    assert positions(port)[0] == pytest.approx(2600, abs=2)
    assert len(port.simulation.clear("hand")) == 2


def test_they_say_when_they_are_held_back() -> None:
    port = stepped("xm430-w350:1")
    port.simulation.inject("jam:id=1")
    assert not port.hands.turn({1: 2500})
    assert positions(port) == [2048]
    assert port.clock.now() < 6.0


def test_nothing_to_turn_and_nobody_there() -> None:
    port = stepped("xm430-w350:1")
    assert port.hands.turn({})
    with pytest.raises(FaultError, match="no servo 2"):
        port.hands.turn({2: 1000})


def test_hands_reach_a_simulator_in_another_process() -> None:
    with simulated(rig=PAIR) as simulator:
        assert simulator.hands.turn({1: 2300, 2: 600}, speed=5.0)
        servos = simulator.status()["servos"]
        found = [servo["registers"]["Present Position"] for servo in servos]
        assert found == pytest.approx([2300, 600], abs=2)
        assert simulator.status()["faults"] == []
        with pytest.raises(ControlError, match="no servo 7"):
            simulator.hands.turn({7: 1000})
