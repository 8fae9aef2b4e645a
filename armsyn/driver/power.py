"""Torque, watchdog and profiles: brought up before a motion, and put back when it fails.

Everything is written by sync write and verified by reading back, which works at Status Return
Level 1 as well as 2. A shadow gets its goals through its Secondary ID only, and is read back too:
so a pair that does not hang together is found before its torque comes on.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from armsyn.arm import ServoDescription
from armsyn.arm.calibration import radians_per_tick
from armsyn.driver import registers as reg
from armsyn.driver.checks import check_pairs
from armsyn.driver.facts import PROFILES, ServoFacts
from armsyn.driver.limits import goal_range
from armsyn.driver.registers import AX, LAST_TICK, MX1, XL320
from armsyn.driver.servos import ServoGroup
from armsyn.driver.stillness import LEANING
from armsyn.driver.timing import WATCHDOG_UNITS
from armsyn.errors import ArmFaultError, HardwareFaultError
from armsyn.safety import START_TOLERANCE

RESTORE_ATTEMPTS = 3
"""How often what was found is written back before a servo is given up."""

GOAL_TOLERANCE = 0.23
"""rad that a servo under torque may be from its goal for a motion to begin: goals lead by up to
0.22 rad against gravity (`armsyn.driver.gravity`)."""

MOVED_TOLERANCE = 0.098
"""rad that a servo may move as torque comes on."""

DRIFT_TICKS_X = 8
DRIFT_TICKS = {AX: 3, XL320: 3}
"""How far a limp servo may drift (0.7 degrees) from where its goal is until its torque comes on:
it jerks back by as much."""

_TURN = LAST_TICK + 1

STEADY_TICKS = {AX: 2, MX1: 4, XL320: 2}
"""How far off a goal older families may read theirs while limp: they then read where they are."""


def prepare(
    group: ServoGroup,
    facts: Sequence[ServoFacts],
    profiles: Mapping[str, Mapping[int, int]] | None = None,
    also: Callable[[], None] | None = None,
) -> tuple[ServoFacts, ...]:
    """Do all that takes time before torque, and read once more where limp servos are.

    Profiles are set for streaming; `restore_profiles` puts them back after a run that ends well,
    after a fault they stay. The watchdog is armed, where there is one.

    Parameters
    ----------
    group : ServoGroup
        Leaders and shadows; no gripper.
    facts : sequence of ServoFacts
        Of the group, as read before.
    profiles : mapping of str to mapping of int to int, optional
        Register and ID to value; 0, which is no profile, where none is given.
    also : callable, optional
        What else takes time; called with the watchdogs armed, before the last reading: a limp arm
        may be sinking.

    Returns
    -------
    tuple of ServoFacts
        The same, with positions as they are now.

    Raises
    ------
    HardwareFaultError
        A servo does not take its watchdog or profile, is away from the goal it holds, or has
        moved while limp since `facts` were read.
    BusError, PortLostError
        As the bus.
    """
    goals = standing_goals(facts)
    for servo in facts:
        off = abs(goals[servo.servo_id] - servo.present_position)
        if servo.torque_enabled and off > ticks_of(GOAL_TOLERANCE, servo.servo):
            raise HardwareFaultError(
                f"{servo.title} is under torque and {off} ticks from its goal: it is moving or"
                " held by something; wait, or free it",
                servo.servo_id,
            )
    for name in PROFILES:
        wanted = (profiles or {}).get(name, {})
        group.set(name, {i: wanted.get(i, 0) for i in group.having(name)})
    group.set("Bus Watchdog", dict.fromkeys(group.ids, WATCHDOG_UNITS))
    if also is not None:
        also()
    start = {servo.servo_id: ticks_of(START_TOLERANCE, servo.servo) for servo in facts}
    present = _present_near(group, facts, start)
    return tuple(replace(servo, present_position=present[servo.servo_id]) for servo in facts)


def power_up(group: ServoGroup, facts: Sequence[ServoFacts]) -> None:
    """Give torque without a jerk: goal := present, verified, then torque on, verified.

    A servo that holds already keeps its goal, so that a raised arm does not dip; so does a pair of
    which one holds, and both get the leader's tick otherwise.

    Parameters
    ----------
    group : ServoGroup
        As of `prepare`.
    facts : sequence of ServoFacts
        Of `prepare`, right before.

    Raises
    ------
    HardwareFaultError
        A servo does not take its goal or torque, has moved while limp since `prepare`, moves as
        its torque comes on, or its watchdog is not armed.
    ServoMismatchError
        The two servos of a dual joint read too far apart: they would fight.
    BusError, PortLostError
        As the bus.
    """
    check_pairs(facts)
    goals = standing_goals(facts)
    limp = [servo.servo_id for servo in facts if not servo.torque_enabled]
    _send_goals(group, {i: goals[i] for i in _pairs_of(facts, limp)})
    drift = {i: DRIFT_TICKS.get(group.models[i].layout, DRIFT_TICKS_X) for i in group.ids}
    present = _present_near(group, facts, drift)
    group.set("Torque Enable", dict.fromkeys(limp, 1))
    group.verify("Bus Watchdog", dict.fromkeys(group.ids, WATCHDOG_UNITS))
    _check_still(group, facts, present)


def ticks_of(angle: float, servo: ServoDescription) -> int:
    """How many whole ticks of a servo an angle is, rad: they differ between families."""
    return int(angle / radians_per_tick(servo.model))


def standing_goals(facts: Sequence[ServoFacts]) -> dict[int, int]:
    """Goals that leave servos where they are: held ones keep theirs, a pair has its leader's.

    One that leans a little beyond its own position limits, where it takes no goal, gets its limit.

    Parameters
    ----------
    facts : sequence of ServoFacts

    Returns
    -------
    dict of int to int
        ID to tick.
    """
    by_id = {servo.servo_id: servo for servo in facts}
    goals = {}
    for servo in facts:
        leader = by_id.get(_leader(servo), servo)
        pair = [leader, *(s for s in facts if _leader(s) == leader.servo_id and s is not leader)]
        held = next((one for one in pair if one.torque_enabled), None)
        goals[servo.servo_id] = _nearest_goal(leader) if held is None else held.goal_position
    return goals


def _nearest_goal(servo: ServoFacts) -> int:
    """Where a limp servo is, or the position limit that it leans beyond.

    Never across the end of its turn: its position folds there as torque comes on, and the way to
    the limit would be a whole turn.
    """
    lower, upper, _ = goal_range(servo)
    here = servo.present_position
    goal = min(max(here, lower), upper)
    leans = abs(goal - here) <= ticks_of(LEANING, servo.servo)
    return goal if leans and here // _TURN == goal // _TURN else here


def _leader(servo: ServoFacts) -> int:
    leader = servo.servo.shadow_of
    return servo.servo_id if leader is None else leader


def _pairs_of(facts: Sequence[ServoFacts], ids: Sequence[int]) -> list[int]:
    """Servos that share a joint with one of `ids`."""
    joints = {_leader(servo) for servo in facts if servo.servo_id in ids}
    return [servo.servo_id for servo in facts if _leader(servo) in joints]


def _send_goals(group: ServoGroup, goals: Mapping[int, int]) -> None:
    """Write goals to leaders, and make sure that their shadows have heard them."""
    shadows = {servo.id for servo in group.servos if servo.shadow_of in goals}
    group.write("Goal Position", {i: goal for i, goal in goals.items() if i not in shadows})
    group.verify("Goal Position", goals, STEADY_TICKS)


def _present_near(
    group: ServoGroup, facts: Sequence[ServoFacts], allowed: Mapping[int, int]
) -> dict[int, int]:
    """Read positions; refuse a limp servo that is more ticks than allowed from where it was."""
    present = group.read("Present Position")
    for servo in facts:
        moved = abs(present[servo.servo_id] - servo.present_position)
        if not servo.torque_enabled and moved > allowed[servo.servo_id]:
            raise HardwareFaultError(
                f"{servo.title} moved by {moved} ticks before its torque came on: somebody moves"
                " the limp arm, or it falls; hold it still and run it again",
                servo.servo_id,
            )
    return present


def _check_still(group: ServoGroup, facts: Sequence[ServoFacts], before: Mapping[int, int]) -> None:
    """Make sure that torque has moved nothing: position mode folds to one turn as it comes on."""
    present = group.read("Present Position")
    for servo in facts:
        moved = abs(present[servo.servo_id] - before[servo.servo_id])
        if moved > ticks_of(MOVED_TOLERANCE, servo.servo):
            raise HardwareFaultError(
                f"{servo.title} moved by {moved} ticks as its torque came on: check what pulls at"
                " it, and its operating mode and homing offset",
                servo.servo_id,
            )


def restore(group: ServoGroup, facts: Sequence[ServoFacts]) -> dict[int, str]:
    """Put torque, watchdog and profiles back as they were found; nothing has moved yet.

    Raises nothing for a bus or port that fails: it is called for an error that says why.

    Parameters
    ----------
    group : ServoGroup
    facts : sequence of ServoFacts
        Of the group, as found.

    Returns
    -------
    dict of int to str
        Servos that do not read what they should, each with the first register that is wrong.
    """
    found: dict[str, dict[int, int]] = {
        "Torque Enable": {s.servo_id: 0 for s in facts if not s.torque_enabled},
        "Bus Watchdog": {s.servo_id: s.bus_watchdog for s in facts if s.bus_watchdog is not None},
    }
    for name in PROFILES:
        found[name] = {s.servo_id: s.profiles[name] for s in facts if name in s.profiles}
    failed: dict[int, str] = {}
    for name, values in found.items():
        for servo_id, reads in _put_back(group, name, values).items():
            failed.setdefault(servo_id, f"{name} reads {reads} instead of {values[servo_id]}")
    return failed


def _put_back(group: ServoGroup, name: str, values: Mapping[int, int]) -> dict[int, str]:
    """Write until the values are read back; returns what else is read, where it is."""
    wrong = dict.fromkeys(values, "")
    for _ in range(RESTORE_ATTEMPTS):
        if not wrong:
            break
        with contextlib.suppress(ArmFaultError):  # reading back shows what came of it
            group.write(name, {i: values[i] for i in wrong})
        reads = {i: _reading(group, name, i) for i in wrong}
        wrong = {i: read for i, read in reads.items() if read != str(values[i])}
    return wrong


def _reading(group: ServoGroup, name: str, servo_id: int) -> str:
    try:
        return str(group.read(name, (servo_id,))[servo_id])
    except ArmFaultError:
        return "nothing"


def restore_profiles(group: ServoGroup, facts: Sequence[ServoFacts]) -> None:
    """Put the profiles back as they were found, velocity first, which bounds acceleration.

    Parameters
    ----------
    group : ServoGroup
    facts : sequence of ServoFacts
        Of the group, as found.

    Raises
    ------
    HardwareFaultError
        A servo does not take its profile back.
    BusError, PortLostError
        As the bus.
    """
    for name in PROFILES:
        group.set(name, {s.servo_id: s.profiles[name] for s in facts if name in s.profiles})


def disarm_watchdog(group: ServoGroup) -> None:
    """Switch the bus watchdogs off; HardwareFaultError when a servo keeps it, or had expired."""
    expired = [i for i, value in group.read("Bus Watchdog").items() if value < 0]
    if expired:
        raise HardwareFaultError(
            f"the bus watchdog of servo {expired[0]} expired during the motion: it did not"
            " follow to the end",
            expired[0],
        )
    group.set("Bus Watchdog", dict.fromkeys(group.ids, 0))


def check_holding(group: ServoGroup) -> None:
    """Make sure that all servos still hold; HardwareFaultError when one has let go or restarted."""
    limp = [i for i, value in group.read("Torque Enable").items() if not value]
    if limp:
        raise HardwareFaultError(f"{group.title(limp[0])} has lost its torque: check it", limp[0])
    disarmed = [i for i, value in group.read("Bus Watchdog").items() if value == 0]
    if disarmed:
        raise HardwareFaultError(
            f"{group.title(disarmed[0])} has lost its bus watchdog: it restarted, check its power",
            disarmed[0],
        )


def torque_off(group: ServoGroup) -> None:
    """Let all servos of a group go; HardwareFaultError when one does not."""
    group.set("Torque Enable", dict.fromkeys(group.ids, 0))


def release_watchdogs(group: ServoGroup) -> tuple[int, ...]:
    """Switch bus watchdogs off; a servo that one has stopped is held where it is.

    Parameters
    ----------
    group : ServoGroup
        All servos of an arm, or some.

    Returns
    -------
    tuple of int
        Servos whose watchdog was armed or had expired.

    Raises
    ------
    HardwareFaultError
        A watchdog that stays on, or a stopped servo that does not take its goal.
    BusError, PortLostError
        As the bus.
    """
    watchdogs = group.read("Bus Watchdog")
    active = tuple(i for i, value in watchdogs.items() if value)
    expired = tuple(i for i in active if watchdogs[i] == reg.WATCHDOG_EXPIRED)
    goals = _where_stopped(group, expired)
    if active:
        # back to back: a goal from before must not start a motion in between
        group.write("Bus Watchdog", dict.fromkeys(active, 0))
    if goals:
        group.write("Goal Position", goals)
    group.verify("Bus Watchdog", dict.fromkeys(active, 0))
    group.verify("Goal Position", goals)
    return active


def _where_stopped(group: ServoGroup, expired: Sequence[int]) -> dict[int, int]:
    """Goals that leave stopped servos standing; a shadow's is its leader's.

    A servo under torque is held at its Position Trajectory, which leads its position against
    gravity: with its position as its goal it would sink. That counts while it is near.
    """
    goals = group.read("Present Position", expired) if expired else {}
    torque = group.read("Torque Enable", expired) if expired else {}
    near = {servo.id: ticks_of(GOAL_TOLERANCE, servo) for servo in group.servos}
    for servo_id, held in group.read("Position Trajectory", expired).items():
        if torque[servo_id] and abs(held - goals[servo_id]) <= near[servo_id]:
            goals[servo_id] = held
    standing: dict[int, int] = {}
    for servo in group.servos:
        if servo.id in expired and servo.shadow_of in group.ids:
            leader = servo.shadow_of
            if leader not in goals:
                standing |= group.read("Goal Position", (leader,))
            goals[servo.id] = {**standing, **goals}[leader]
    return goals
