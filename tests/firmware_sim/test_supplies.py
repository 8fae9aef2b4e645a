"""Servos of several voltages on one bus: each supply sags by itself."""

import pytest

from firmware_sim.testing import stepped

RESISTANCE = 0.2

RIG = f"""
[supply]
resistance = {RESISTANCE}

[[servo]]
id = 1
model = "xl430-w250"
supply_voltage = 12.0

[[servo]]
id = 2
model = "xl330-m288"
supply_voltage = 5.0

[[servo]]
id = 3
model = "xl330-m077"
supply_voltage = 5.0
"""


def test_a_load_on_one_supply_leaves_the_other() -> None:
    """V = E / (1 + Rs / R) at a blocked servo's full duty, for all on its supply."""
    port = stepped(rig=RIG)
    twelve, five, other = port.bus.servos
    winding = 5.0 / five.model.motor.stall_current
    five.axis.jam(on=True)
    five.axis.drive_duty(1.0)
    port.simulation.advance(0.1)
    sagged = 5.0 / (1.0 + RESISTANCE / winding)
    assert five.axis.voltage == pytest.approx(sagged, rel=1e-9)
    assert other.axis.voltage == five.axis.voltage
    assert twelve.axis.voltage == 12.0
    twelve.axis.jam(on=True)
    twelve.axis.drive_duty(1.0)
    port.simulation.advance(0.2)
    assert twelve.axis.voltage < 11.99
    assert five.axis.voltage == pytest.approx(sagged, rel=1e-9)


def test_what_no_file_says_is_each_motors_own_voltage() -> None:
    port = stepped("xl430-w250:1", "xl330-m288:2")
    twelve, five = port.bus.servos
    assert (twelve.axis.voltage, five.axis.voltage) == (
        twelve.model.motor.nominal_voltage,
        five.model.motor.nominal_voltage,
    )
    five.axis.jam(on=True)
    five.axis.drive_duty(1.0)
    port.simulation.advance(0.1)
    assert five.axis.voltage < 5.0
    assert twelve.axis.voltage == twelve.model.motor.nominal_voltage
