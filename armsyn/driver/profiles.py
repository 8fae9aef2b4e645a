"""How fast servos may go to a goal by themselves while goals are streamed: a second net.

Without a profile a servo goes to any goal as fast as it can. While the driver lives, no goal is
farther than a step; but a goal that was garbled on the wire past its CRC, a host that dies after
sending one it should not have, or another program are not its to judge. So Profile Velocity (112;
Moving Speed of older servos) is set a little above what is planned, and Profile Acceleration to 0:
a rectangular profile, which between two goals of a stream is a straight line instead of a step. It
is never slower than the stream: `ArmDescription.max_velocity` bounds that.

In the time-based drive mode (bit 2 of Drive Mode) the same register holds the milliseconds that
each goal is to take: any but 0 would make goals of a stream late, and 1 ms is no net. It is left
0 there, and so no net. An expiry of the watchdog, a restart and a change of mode make it 0, too
(e-Manual, XM430-W350, "Profile Velocity(112)", "Bus Watchdog(98)"; MX-28, "Moving Speed(32)").
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from armsyn.arm import ArmDescription
from armsyn.driver import registers as reg
from armsyn.driver.facts import ServoFacts
from armsyn.driver.servos import ServoGroup

HEADROOM = 1.1
"""Times the greatest planned speed: blending and rounding add up to 5 %."""

LEAD_SPEED = 1.0
"""rad/s more, by which goals may move against gravity (`armsyn.driver.gravity`)."""

_GREATEST_MOVING_SPEED = 1023


def streaming_profiles(
    arm: ArmDescription, facts: Sequence[ServoFacts], group: ServoGroup
) -> dict[str, dict[int, int]]:
    """Profiles to stream with.

    Parameters
    ----------
    arm : ArmDescription
        Its greatest planned speeds count.
    facts : sequence of ServoFacts
        Of servos that move joints.
    group : ServoGroup
        Of the same servos.

    Returns
    -------
    dict of str to dict of int to int
        Register, ID and value, where it is not 0.
    """
    planned = dict(zip(arm.joint_names, arm.max_velocity.tolist(), strict=True))
    profiles: dict[str, dict[int, int]] = {"Profile Velocity": {}, "Moving Speed": {}}
    for servo in facts:
        if servo.drive_mode & reg.DRIVE_MODE_TIME_PROFILE:
            continue
        speed = HEADROOM * planned[servo.joint] + LEAD_SPEED
        units = math.ceil(speed / group.models[servo.servo_id].velocity_unit)
        if "Profile Velocity" in servo.profiles:
            limit = units if servo.velocity_limit is None else servo.velocity_limit
            profiles["Profile Velocity"][servo.servo_id] = min(units, limit)
        else:
            profiles["Moving Speed"][servo.servo_id] = min(units, _GREATEST_MOVING_SPEED)
    return profiles
