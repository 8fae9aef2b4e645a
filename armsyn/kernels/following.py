"""Following a law: what an arm does from step to step."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from armsyn.kernels.arm_numbers import Arm, unpacked
from armsyn.kernels.compiling import generated_kernel, kernel
from armsyn.kernels.law import (
    BENT,
    CARRIED,
    CLOCK,
    END_GAP,
    FADE,
    FADE_S,
    LATE,
    LIMIT_RATE,
    OFFSET,
    RAMP,
    SLOPE,
    Work,
    carried_velocity,
    controller_velocity,
    room_for,
    stopping_speed,
)
from armsyn.kernels.plain import ramp_value
from armsyn.kernels.types import FloatArray

POSTURE, VELOCITY, BEND, OFF, EXPECTED, TRAILED, MOVED = range(7)
"""Rows of a state, shape (7, n): as commanded, rad, rad/s, rad/s2; then how far the arm stands off
its commands, rad; where it is expected to be, rad; and, of the line through the origin that tells
a joint's lag, the two sums."""

BRAKING = 0.8
"""Share of a joint's acceleration that it keeps for stopping before the end of its range."""

_CLOCKS = 201
_SATURATED = 7.0
"""phi is 0.999 where its exponent is this far past the middle."""


class Followed(NamedTuple):
    """What came of following a law.

    Attributes
    ----------
    made : int
        Steps.
    distance : float
        Of the hand from its target before the last, m.
    excess : float
        By how much the law would have to be slowed to keep the bounds, at most 1 where it does.
    fastest : float
        The fastest joint's speed, rad/s.
    """

    made: int
    distance: float
    excess: float
    fastest: float


@kernel
def moves(state: FloatArray) -> bool:
    """Whether any joint has a velocity or an acceleration."""
    return bool(np.any(state[VELOCITY:OFF] != 0.0))


@kernel
def _begin(
    arm: Arm, hand: FloatArray, joints: FloatArray, work: Work, state: FloatArray, step: float
) -> None:
    """Let a law carry over what the arm has and it does not; an arm at rest has nothing."""
    n = state.shape[1]
    hand[FADE] = FADE_S
    joints[CARRIED], joints[BENT] = 0.0, 0.0
    if not moves(state):
        return
    here, soon, q, seen = np.empty(n), np.empty(n), state[POSTURE].copy(), np.empty(n)
    for i in range(n):
        seen[i] = q[i] + state[OFF, i]
    controller_velocity(arm, hand, joints, work, seen, q, hand[CLOCK], here)
    for i in range(n):
        q[i] += step * state[VELOCITY, i]
        seen[i] += step * state[VELOCITY, i]
    controller_velocity(arm, hand, joints, work, seen, q, hand[CLOCK] + step, soon)
    for i in range(n):
        most = arm.acceleration[i]
        rest = state[VELOCITY, i] - here[i]
        joints[CARRIED, i] = rest
        joints[BENT, i] = min(max(state[BEND, i] - (soon[i] - here[i]) / step, -most), most)
        # what fades so decelerates by 1/e of its speed a time constant: half of what may be
        hand[FADE] = max(hand[FADE], 2.0 / math.e * abs(rest) / most)


@kernel
def advance(
    arm: Arm,
    hand: FloatArray,
    joints: FloatArray,
    state: FloatArray,
    elapsed: float,
    step: float,
    steps: int,
    tolerance: float,
    guarded: bool,
    path: FloatArray,
) -> Followed:
    """Let an arm follow a law; see `follow`."""
    n = state.shape[1]
    seen, velocity, work = np.empty(n), np.empty(n), room_for(n)
    if elapsed == 0.0:
        _begin(arm, hand, joints, work, state, step)
    lower, upper = arm.chain.lower, arm.chain.upper
    distance, gap, excess, fastest, made = math.inf, 0.0, 0.0, 0.0, 0
    q, speeds, bends, off = state[POSTURE], state[VELOCITY], state[BEND], state[OFF]
    while made < steps:
        elapsed += step
        made += 1
        for i in range(n):
            seen[i] = q[i] + off[i]
        t = hand[CLOCK] + elapsed
        distance, gap = controller_velocity(arm, hand, joints, work, seen, q, t, velocity)
        fastest = 0.0
        for i in range(n):
            v = velocity[i]
            v += carried_velocity(joints[CARRIED, i], joints[BENT, i], hand[FADE], elapsed)
            before = speeds[i]
            most = arm.acceleration[i]
            strain = abs(v - before) / (step * most)
            excess = max(excess, abs(v) / arm.speed[i], math.sqrt(strain))
            if guarded:
                twist = arm.jerk[i] * step
                a = min(max((v - before) / step, bends[i] - twist), bends[i] + twist)
                a = min(max(a, -most), most)
                v = min(max(before + a * step, -arm.speed[i]), arm.speed[i])
                v = min(v, stopping_speed(upper[i] - q[i], BRAKING * most, step))
                v = max(v, -stopping_speed(q[i] - lower[i], BRAKING * most, step))
            bends[i] = (v - before) / step
            speeds[i] = v
            q[i] += v * step
            fastest = max(fastest, abs(v))
        if path.shape[0] > 0:
            path[made - 1] = q
        near = distance <= tolerance and gap <= hand[END_GAP]
        if near and 0.1 * fastest <= tolerance:
            break
    return Followed(made, distance, excess, fastest)


@generated_kernel  # gives way to other threads of Python: one plans while another streams
def follow(
    arm: FloatArray,
    hand: FloatArray,
    joints: FloatArray,
    state: FloatArray,
    elapsed: float,
    step: float,
    steps: int,
    tolerance: float,
    guarded: bool,
    path: FloatArray,
) -> Followed:
    """Let an arm follow a law for up to `steps` steps of `step` seconds.

    Parameters
    ----------
    arm : array
        `armsyn.kernels.arm_numbers.packed`.
    hand, joints : array
        Of a `Law`; where it begins (`elapsed` is 0), what it carries is written to it.
    state : array, shape (7, n)
        How the arm moves; written to.
    elapsed : float
        Since the law began, s.
    step : float
        s.
    steps : int
    tolerance : float
        Stop once the hand is this near, m, and every joint slower than that,
        m, in a tenth of a second and radians; negative: never.
    guarded : bool
        Whether velocities are kept within `bounds` and joints within their ranges; without it the
        motion is as the law alone wants it.
    path : array, shape (steps, n) or (0, n)
        Filled with the posture after each step, rad.

    Returns
    -------
    Followed
    """
    plain = unpacked(arm, state.shape[1])
    return advance(plain, hand, joints, state, elapsed, step, steps, tolerance, guarded, path)


@generated_kernel
def nearest_clock(
    arm: FloatArray, hand: FloatArray, joints: FloatArray, state: FloatArray
) -> float:
    """The earliest time of phi, s, at which a law is nearest to the velocity that an arm has.

    An arm at rest begins anew, and so does one that moves elsewhere.

    Parameters
    ----------
    arm, hand, joints, state
        As `follow`; not written to.
    """
    n = state.shape[1]
    ready_hand, ready, full = hand.copy(), joints.copy(), np.empty(n)
    ready_hand[RAMP], ready_hand[LIMIT_RATE], ready_hand[LATE] = 0.0, np.inf, np.inf
    ready[SLOPE], ready[OFFSET] = 0.0, -np.inf
    seen = state[POSTURE] + state[OFF]
    plain, q = unpacked(arm, n), state[POSTURE]
    controller_velocity(plain, ready_hand, ready, room_for(n), seen, q, 0.0, full)
    latest = hand[RAMP]
    for i in range(n):
        if abs(joints[OFFSET, i]) < math.inf:
            latest = max(latest, (joints[OFFSET, i] + _SATURATED) / joints[SLOPE, i])
    best, least = 0.0, np.inf
    for k in range(_CLOCKS):
        t = latest * k / (_CLOCKS - 1)
        gap, risen = 0.0, ramp_value(t, hand[RAMP])
        for i in range(n):
            phi = risen / (1.0 + math.exp(joints[OFFSET, i] - joints[SLOPE, i] * t))
            gap += (state[VELOCITY, i] - phi * full[i]) ** 2
        if gap < least:
            best, least = t, gap
    return best
