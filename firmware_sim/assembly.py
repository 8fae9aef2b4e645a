"""From a rig to a simulation: servos, physics, bus and faults put together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from firmware_sim.errors import PlantError
from firmware_sim.faults.spec import FaultSpec
from firmware_sim.firmware.world import World, build_world
from firmware_sim.physics.plant import SUPPLY_RESISTANCE, JointsPlant, Plant
from firmware_sim.rig.mounting import Mounting, find_couplings, find_mountings
from firmware_sim.rig.settings import Rig
from firmware_sim.rig.state_file import SavedState
from firmware_sim.simulation import Simulation
from firmware_sim.wire.bus import Bus

_WARM_UP = 0.02
"""Simulated time in which all code has run, s."""


def build_simulation(
    rig: Rig,
    *,
    gap_rule: bool = True,
    mujoco: bool = False,
    faults: Sequence[FaultSpec] = (),
    seed: int = 0,
    state: SavedState | None = None,
    trace: Path | None = None,
    when: float = 0.0,
) -> Simulation:
    """Return servos on a bus, powered up.

    Parameters
    ----------
    rig : Rig
        The servos, and what feeds and holds them.
    gap_rule : bool
        Whether a silence of 1.5 ms within an instruction makes the servos give it up.
    mujoco : bool
        Whether the rig's bodies move as a whole under gravity; else each joint by itself.
    faults : sequence of FaultSpec
        In force from the start, each in its own time.
    seed : int
        Of the faults' chance.
    state : SavedState, optional
        What the servos remember from an earlier run.
    trace : Path, optional
        Where a trace is to go: the simulation is a `TracedSimulation` then.
    when : float
        The time of power-up, s.

    Returns
    -------
    Simulation
        Ready to be told what arrives.

    Raises
    ------
    PlantError
        If `mujoco` is asked for and the rig has no bodies, or MuJoCo is missing.
    FaultError
        If a fault cannot act on these servos.
    StateFileError
        If `state` is not one of these servos.
    """
    world = _build_world(rig, mujoco, state, when)
    bus = Bus(world, gap_rule=gap_rule)
    if trace is not None:
        from firmware_sim.trace.record import TracedSimulation  # noqa: PLC0415 - not for most

        return TracedSimulation(bus, when, faults, seed, trace)
    return Simulation(bus, when, faults=faults, seed=seed)


def warm_up(rig: Rig, mujoco: bool = False) -> None:
    """Let all code of the physics be compiled, or read from where it was kept compiled.

    Without it the first request would wait for that: half a minute, on a new machine.

    Raises
    ------
    PlantError
        If `mujoco` is asked for and the rig has no bodies, or MuJoCo is missing.
    """
    world = _build_world(rig, mujoco, None, 0.0)
    world.advance(_WARM_UP)


def _build_world(rig: Rig, mujoco: bool, state: SavedState | None, when: float) -> World:
    voltage = rig.supply.voltage
    settings = [
        servo if servo.supply_voltage else replace(servo, supply_voltage=voltage)
        for servo in rig.servos
    ]
    world = build_world(settings, when)
    mountings = find_mountings(rig.servos, world.servos)
    if state is not None:
        state.restore(world.servos)
    resistances = _connect_supplies(rig, world)
    build = _build_arm if mujoco else _build_joints
    world.plant = build(rig, world, mountings, resistances)
    return world


def _connect_supplies(rig: Rig, world: World) -> list[float]:
    """Let servos of one voltage share a supply; return the resistance of each, ohm."""
    voltages = sorted({servo.supply_voltage for servo in world.servos})
    for servo in world.servos:
        servo.axis.connect(voltages.index(servo.supply_voltage))
    resistance = SUPPLY_RESISTANCE if rig.supply.resistance is None else rig.supply.resistance
    return [resistance] * len(voltages)


def _build_joints(
    _rig: Rig, world: World, mountings: Sequence[Mounting], resistances: Sequence[float]
) -> Plant:
    """Return joints that know nothing of each other, each with the servos that share it."""
    axes = world.plant.axes
    for base, other, gear in find_couplings(mountings, [axis.angle for axis in axes]):
        axes.couple(base, other, gear)
    return JointsPlant(axes, resistances)


def _build_arm(
    rig: Rig, world: World, mountings: Sequence[Mounting], resistances: Sequence[float]
) -> Plant:
    """Return the rig's bodies with the world's servos in their joints."""
    if rig.mjcf is None:
        raise PlantError(
            "--plant mujoco needs a rig file with the arm's bodies, [plant] mjcf:"
            " write one with `armsyn arms rig NAME`, and give it with --rig"
        )
    from firmware_sim.physics.mujoco import MujocoPlant  # noqa: PLC0415 - an extra, and slow

    axes = world.plant.axes
    joints, directions, zeros = zip(*mountings, strict=True)
    named = {servo.mount.joint for servo in rig.servos if servo.mount is not None} - {rig.gripper}
    offsets = list(zeros)
    for base, other, gear in find_couplings(mountings, [axis.angle for axis in axes]):
        offsets[other] = axes[other].angle - gear * (axes[base].angle - zeros[base])
    return MujocoPlant(
        axes,
        rig.mjcf,
        joints,
        directions,
        offsets,
        resistances,
        outside={joint for joint in joints if joint and joint not in named},
    )
