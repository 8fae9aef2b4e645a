"""The servos' own limits, which a motion must keep."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.driver.facts import ServoFacts
from armsyn.driver.models import servo_model
from armsyn.driver.path import BLEND, Path
from armsyn.driver.registers import LAST_TICK, POSITION_MODE, VOLTAGE_UNIT
from armsyn.errors import LimitError
from armsyn.motion import Motion
from armsyn.safety import CommandLimits, check_commands
from armsyn.safety.limits import POSITION_TOLERANCE

FloatArray = NDArray[np.float64]

_LOWEST, _HIGHEST = -1_048_575, 1_048_575
"""Goals that servos of the X series take in their extended position mode (e-Manual, Goal
Position); MX with Protocol 1.0 take fewer."""

_MX1_HIGHEST = 28_672

_BLOCK = 2000
"""Ticks of a motion that are judged at a time."""

_AT_SPEED = 0.5
"""Part of the next step from which on a first step is no start from rest."""


def check_position_limits(motion: Motion, facts: Sequence[ServoFacts], arm: ArmDescription) -> None:
    """Refuse a motion with a goal that a servo would refuse: sync write tells nobody about it.

    A shadow is judged by its leader's goals, which it follows, and its own limits.

    Parameters
    ----------
    motion : Motion
        Checked; angles of shape (frames, n), rad.
    facts : sequence of ServoFacts
        Of servos that move joints; one a joint first, in the joints' order.
    arm : ArmDescription

    Raises
    ------
    LimitError
        It leaves the limits in the servo's position limit registers, where it is in position
        mode, or what its goal register takes.
    """
    assert motion.angles is not None  # noqa: S101 - check_trajectory made sure
    ticks = arm.calibration.to_ticks(motion.angles)
    lows, highs = ticks.min(axis=0).tolist(), ticks.max(axis=0).tolist()
    for servo in facts:
        column = arm.joint_names.index(servo.joint)
        lower, upper, where = goal_range(servo)
        low, high = lows[column], highs[column]
        if not lower <= low <= high <= upper:
            value, limit = (low, lower) if low < lower else (high, upper)
            raise LimitError(
                f"{servo.title} would be sent to tick {value}, its own limits are {lower} to"
                f" {upper} ({where}): plan another motion, or widen them",
                servo.joint,
                value,
                limit,
            )


def goal_range(servo: ServoFacts) -> tuple[int, int, str]:
    """Ticks that a servo takes as goals, and where that stands."""
    lower, upper = servo.minimum_position, servo.maximum_position
    classic = servo.servo.protocol == 1 or servo.servo.model == "xl-320"
    if servo.operating_mode == POSITION_MODE:
        where = "registers 6 and 8" if classic else "registers 52 and 48"
        return max(lower, 0), min(upper, LAST_TICK), where
    if servo.servo.protocol == 1:
        return -_MX1_HIGHEST, _MX1_HIGHEST, "its multi-turn mode"
    return _LOWEST, _HIGHEST, "its extended position mode"


def check_streamed(
    motion: Motion, start: FloatArray, limits: CommandLimits, meanwhile: Callable[[], None]
) -> FloatArray:
    """Refuse a motion whose ticks would be refused on the way, as where its samples are too few.

    Parameters
    ----------
    motion : Motion
        Checked; angles of shape (frames, n), rad.
    start : array, shape (n,)
        Where the goals stand, rad.
    limits : CommandLimits
        Of the stream.
    meanwhile : callable
        Called now and then: looking at a long motion takes a while. What it raises ends that.

    Returns
    -------
    array, shape (n,)
        Where the goals stand afterwards, rad.

    Raises
    ------
    LimitError
        The message names joint, time and the motion's row.
    """
    path = Path(motion, start=start)
    count = math.ceil(path.duration / limits.period) + 1
    before = None
    for first in range(0, count, _BLOCK):
        meanwhile()
        last = min(first + _BLOCK, count)
        commands = path.at_times(_moments(first, last, limits))
        refused = check_commands(commands, limits, before=before, rests=last == count)
        if refused is not None:
            raise _refused(refused[1], first + refused[0], motion, path, limits)
        before = commands[-3:]
    return np.asarray(commands[-1])


def _moments(first: int, last: int, limits: CommandLimits) -> FloatArray:
    return np.arange(first, last, dtype=np.float64) * limits.period


def _refused(
    refusal: LimitError, tick: int, motion: Motion, path: Path, limits: CommandLimits
) -> LimitError:
    """Say when a tick is refused, and what helps."""
    time = min(tick * limits.period, path.duration)
    moments = motion.time - motion.time[0]
    row = min(int(np.searchsorted(moments, time)), len(moments) - 1)
    said = f"{refusal} at {time:.3f} s (row {row} of {len(moments)})"
    column = limits.names.index(refusal.joint)
    wanted = float(path.at(time)[column])
    if limits.lower[column] <= wanted <= limits.upper[column]:
        said += f": {_advice(column, row, tick, motion, limits)}"
    return LimitError(said, refusal.joint, refusal.value, refusal.limit)


def _advice(column: int, row: int, tick: int, motion: Motion, limits: CommandLimits) -> str:
    """What to do about a tick that changes too much."""
    if tick * limits.period < BLEND + 3 * limits.period:
        a_little_more = math.ceil(2.0 * BLEND / limits.period)
        by_itself = Path(motion).at_times(_moments(0, a_little_more, limits))
        if check_commands(by_itself, limits, rests=False) is None:
            return "the motion starts too far from where the arm stands; plan it from there"
    assert motion.angles is not None  # noqa: S101 - its path has been made
    steps = np.abs(np.diff(motion.angles[:, column]))
    if row <= 1 and _alike(steps[:2]):
        return "the motion starts at speed; let it start from rest"
    if row >= len(steps) and _alike(steps[-2:]):
        return "the motion ends at speed; let it come to rest"
    return (
        "the samples are too far apart there, or too fast; give more of them, or slow the motion"
        " down"
    )


def _alike(steps: FloatArray) -> bool:
    """Whether a step goes on as the next; from rest it would be a third of that, or less."""
    return len(steps) == 2 and float(steps.min()) > _AT_SPEED * float(steps.max())


def with_servo_limits(
    limits: CommandLimits, facts: Sequence[ServoFacts], arm: ArmDescription, start: FloatArray
) -> CommandLimits:
    """Put the servos' own limits into a stream's: position, temperature, current, voltage.

    They refuse goals beyond their position limits, and sync write tells nobody; their position
    modes do not keep their Current Limit (e-Manual, "Current Limit").

    Parameters
    ----------
    limits : CommandLimits
    facts : sequence of ServoFacts
        Of servos that move joints, shadows among them: of each joint the stricter counts.
    arm : ArmDescription
    start : array, shape (n,)
        Where the goals stand, rad: that stays within the limits, whatever the servos say.

    Returns
    -------
    CommandLimits
        Currents stay unknown where a servo does not measure them, or has 0 as its limit.
    """
    joints = {name: [s for s in facts if s.joint == name] for name in limits.names}
    lower, upper = _own_ranges(facts, arm)
    return replace(
        limits,
        lower=np.minimum(np.maximum(limits.lower, lower), start),
        upper=np.maximum(np.minimum(limits.upper, upper), start),
        max_temperature=np.array(
            [float(min(s.temperature_limit for s in joints[name])) for name in limits.names]
        ),
        max_current=np.array(
            [np.fmin.reduce([_current_limit(s) for s in joints[name]]) for name in limits.names]
        ),
        min_voltage=np.array(
            [VOLTAGE_UNIT * max(s.minimum_voltage for s in joints[name]) for name in limits.names]
        ),
        max_voltage=np.array(
            [VOLTAGE_UNIT * min(s.maximum_voltage for s in joints[name]) for name in limits.names]
        ),
    )


def _own_ranges(facts: Sequence[ServoFacts], arm: ArmDescription) -> tuple[FloatArray, FloatArray]:
    """Range of each joint that rounds to goals which all of its servos take, rad."""
    calibration = arm.calibration
    lowest, highest = np.full(len(arm.joint), _LOWEST), np.full(len(arm.joint), _HIGHEST)
    for servo in facts:
        row = arm.joint_names.index(servo.joint)
        lower, upper, _ = goal_range(servo)
        lowest[row], highest[row] = max(lowest[row], lower), min(highest[row], upper)
    ends = np.array([calibration.to_radians(lowest), calibration.to_radians(highest)])
    # rounding to ticks brings this back also where a command is beyond by the tolerance; half a
    # tick would round to the even one of two, which may lie outside
    almost_half = 0.5 * np.abs(calibration.radians_per_tick) - 2.0 * POSITION_TOLERANCE
    return ends.min(axis=0) - almost_half, ends.max(axis=0) + almost_half


def _current_limit(servo: ServoFacts) -> float:
    """Ampere that a servo may take; NaN where nobody knows."""
    unit = servo_model(servo.servo.model, servo.servo.protocol).current_unit
    return unit * servo.current_limit if unit and servo.current_limit else np.nan
