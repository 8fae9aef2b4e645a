"""Second servos on a joint: whose shadow each is, and where it lies.

``shadow_of = ID`` in a ``[[servo]]`` table puts a servo on the joint of another, its leader. Its
shaft is coupled with the leader's; it has an encoder, a current and a temperature of its own. It is
set up as makers of arms do it: its Secondary ID is the leader's ID, so that it obeys what is
written to the leader's RAM (`registers` may say otherwise; servos without that register are only
coupled). A reboot, a clear or a factory reset of the leader is none of the shadow's (e-Manual,
"Secondary ID(12)": it can modify RAM only): the one goes limp, the other goes on.

``direction`` and ``zero_tick`` are in its own count, which ``drive_mode`` may reverse: a mirrored
servo is ``direction = 1`` with ``drive_mode = 1``, and follows; with ``direction = -1`` and no
reverse mode it is mirrored too, but fights its leader, as a wrongly set up one does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from firmware_sim.errors import RigError
from firmware_sim.rig.settings import Mount, ServoSettings, centre_tick, highest_tick


def join_shadows(
    servos: Sequence[ServoSettings], placed: Sequence[bool], file: str
) -> list[ServoSettings]:
    """Return the servos with every shadow on its leader's joint.

    Parameters
    ----------
    servos : sequence of ServoSettings
        In the order of their tables.
    placed : sequence of bool
        Which of them say themselves where they lie; other shadows lie where their leader does.
        What they say may differ from that by a few ticks: that is how they are mounted.
    file : str
        Where they stand, for errors.

    Raises
    ------
    RigError
        If a shadow has no leader, one that is a shadow itself, or one on another joint, or would
        lie outside its range.
    """
    leaders = {servo.servo_id: servo for servo in servos if servo.shadow_of is None}
    joined = []
    for number, (servo, own_place) in enumerate(zip(servos, placed, strict=True), 1):
        try:
            joined.append(_join(servo, leaders, own_place))
        except RigError as error:
            message = f"{file}: [[servo]] table {number}: {error}"
            raise RigError(message, file, number, error.field) from None
    return joined


def _join(
    servo: ServoSettings, leaders: dict[int, ServoSettings], own_place: bool
) -> ServoSettings:
    """Return a servo on its leader's joint, if it has one."""
    if servo.shadow_of is None:
        return servo
    leader = leaders.get(servo.shadow_of)
    if leader is None:
        raise RigError(
            f"shadow_of = {servo.shadow_of} is no servo, or a shadow itself", field="shadow_of"
        )
    own, its = servo.mount or Mount(""), leader.mount or Mount("", 1, centre_tick(leader.model))
    if own.joint not in ("", its.joint):
        raise RigError(
            f"joint = {own.joint!r} is not that of servo {leader.servo_id}, whose shadow it is",
            field="joint",
        )
    servo = replace(servo, mount=replace(own, joint=its.joint))
    return servo if own_place else replace(servo, start_tick=_beside(servo, leader, own, its))


def _beside(servo: ServoSettings, leader: ServoSettings, own: Mount, its: Mount) -> int:
    """Return the tick of a shadow whose joint lies where its leader says."""
    angle = its.direction * (leader.start_tick - its.zero_tick) * leader.model.units.angle
    tick = own.zero_tick + round(own.direction * angle / servo.model.units.angle)
    if not 0 <= tick <= highest_tick(servo.model):
        raise RigError(
            f"beside servo {leader.servo_id} it would lie at {tick}: check zero_tick and"
            " direction, or give start_tick",
            field="start_tick",
        )
    return tick
