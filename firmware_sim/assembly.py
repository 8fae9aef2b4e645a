"""From a rig to a simulation: servos, physics, bus and faults put together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from firmware_sim.bus import Bus
from firmware_sim.rig import Rig
from firmware_sim.simulation import Simulation
from firmware_sim.world import build_world


def build_simulation(
    rig: Rig,
    *,
    gap_rule: bool = True,
    snapshots: Sequence[Mapping[str, Any]] | None = None,
    when: float = 0.0,
) -> Simulation:
    """Return servos on a bus, powered up.

    Parameters
    ----------
    rig : Rig
        The servos, and what feeds and holds them.
    gap_rule : bool
        Whether a silence of 1.5 ms within an instruction makes the servos give it up.
    snapshots : sequence of mapping, optional
        What each servo remembers from an earlier run, in the rig's order.
    when : float
        The time of power-up, s.

    Returns
    -------
    Simulation
        Ready to be told what arrives.
    """
    voltage = rig.supply.voltage
    settings = [
        servo if servo.supply_voltage else replace(servo, supply_voltage=voltage)
        for servo in rig.servos
    ]
    world = build_world(settings, when)
    for servo, snapshot in zip(world.servos, snapshots or (), strict=False):
        servo.restore_snapshot(snapshot)
    return Simulation(Bus(world, gap_rule=gap_rule), start=when)
