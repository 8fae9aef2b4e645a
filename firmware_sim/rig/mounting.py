"""How servos sit on joints: which of them share one, and which way each shaft turns there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from firmware_sim.errors import PlantError
from firmware_sim.firmware.servo import Servo
from firmware_sim.rig.settings import Mount, ServoSettings

APART = 0.2
"""By how much servos on one joint may disagree about its angle at the start, rad: more is no way in
which horns are mounted, but a mistake in the file."""


class Mounting(NamedTuple):
    """Where one servo sits.

    Parameters
    ----------
    joint : str or None
        What servos of one joint have in common: its name where it has one. None for a servo alone
        on a joint without a name.
    direction : int
        1 where the horn's counter-clockwise is the joint's positive direction, -1 where it is not.
    zero : float
        The horn's angle at the joint's zero, rad.
    """

    joint: str | None
    direction: int
    zero: float


def find_mountings(settings: Sequence[ServoSettings], servos: Sequence[Servo]) -> list[Mounting]:
    """Return where servos sit.

    Parameters
    ----------
    settings : sequence of ServoSettings
        What the rig says of each.
    servos : sequence of Servo
        Just powered up: their registers, as the rig sets them, say how directions and zeros count.
        What is written to them later, or was restored from a file, turns no screw.
    """
    led = {servo.shadow_of for servo in settings}
    return [
        _mounting(setting, servo, setting.servo_id in led)
        for setting, servo in zip(settings, servos, strict=True)
    ]


def _mounting(setting: ServoSettings, servo: Servo, leads: bool) -> Mounting:
    mount = setting.mount or Mount("")
    zero = servo.firmware.angle(mount.zero_tick)
    counts_clockwise = servo.firmware.angle(mount.zero_tick + 1) < zero
    leader = setting.servo_id if leads else setting.shadow_of
    nameless = None if leader is None else f"of servo {leader}"
    direction = -mount.direction if counts_clockwise else mount.direction
    return Mounting(mount.joint or nameless, direction, zero)


def find_couplings(
    mountings: Sequence[Mounting], angles: Sequence[float]
) -> list[tuple[int, int, int]]:
    """Return which shafts turn together.

    Parameters
    ----------
    mountings : sequence of Mounting
        Of all servos.
    angles : sequence of float
        Of their horns, rad. What they disagree by is how they are mounted, and stays.

    Returns
    -------
    list of (int, int, int)
        First axis of a joint, another one there, and -1 if they turn opposite ways, 1 if not.

    Raises
    ------
    PlantError
        If two disagree by more than `APART`.
    """
    first: dict[str, int] = {}
    couplings = []
    for number, (joint, direction, zero) in enumerate(mountings):
        base = number if joint is None else first.setdefault(joint, number)
        if base == number:
            continue
        gear = direction * mountings[base].direction
        apart = abs(zero + gear * (angles[base] - mountings[base].zero) - angles[number])
        if apart > APART:
            raise PlantError(
                f"servos on the joint {joint} disagree: number {number + 1} lies {apart:.3f} rad"
                " from where the first says; check start_tick, zero_tick and direction"
            )
        couplings.append((base, number, gear))
    return couplings
