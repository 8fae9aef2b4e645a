"""What a data sheet says of a motor with its gears, and what it does not."""

from __future__ import annotations

from dataclasses import dataclass

FRICTION = 0.01
"""Coulomb friction of the gears over the stall torque. No data sheet has it: chosen so that a
position loop with the maker's gains stands within two encoder counts of its goal. Three times as
much makes that five, half a degree, which servos of this make do better."""

DRAG = 0.05
"""Speed-dependent loss of the gears at no-load speed over the stall torque; chosen so that, with
`FRICTION`, a motor without load takes 6 % of its stall current, as small geared motors do. An
XM430-W350 cut at full speed runs on by 35 degrees: its rotor, seen through the gears, has a tenth
of a joule; with five times the Coulomb friction it would still be 24 degrees."""


@dataclass(frozen=True, slots=True)
class MotorData:
    """A motor with its gears, at the horn, as its data sheet has it.

    Parameters
    ----------
    nominal_voltage : float
        Of the figures below, V.
    stall_torque : float
        N m.
    stall_current : float
        A.
    no_load_speed : float
        rev/min, losses of the gears included.
    inertia : float
        Rotor and gears seen from the horn, with a light horn, kg m^2. No data sheet has it: it is
        chosen for a mechanical time constant of about 10 ms.
    friction : float
        Coulomb friction of the gears over the stall torque.
    drag : float
        Speed-dependent loss of the gears at no-load speed over the stall torque.
    backlash : float
        Width of the gears' play, rad; the encoder is at the horn. The data sheets state 0.25
        degrees for X430 and X540, 0.33 for MX; 0 unless it is asked for (a rig file can), as under
        a load that closes it.
    mass : float
        Of the whole servo, kg: its heat goes by it. An XM430's by default.
    """

    nominal_voltage: float
    stall_torque: float
    stall_current: float
    no_load_speed: float
    inertia: float
    friction: float = FRICTION
    drag: float = DRAG
    backlash: float = 0.0
    mass: float = 0.082
