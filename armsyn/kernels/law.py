"""The law by which a hand follows a target that may change: the synergy controller in the loop.

A joint's velocity is the controller's (Aubry, Julliard, Gibet 2009, 3.1-3.2: lambda phi M O(J, dX),
with a clock of its own since the target changed) plus what is left of the velocity that the arm
had at that moment, fading away. So neither speed nor acceleration jumps when a target does. It is
the scheme that the literature on double steps calls abort and replan (Henis and Flash, *Biol.
Cybern.* 72, 1995); as the rest fades, the controller remains, and contracts.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from armsyn.kernels.arm_numbers import Arm
from armsyn.kernels.chain import forward, jacobian
from armsyn.kernels.compiling import kernel
from armsyn.kernels.optimisers import change_of_posture
from armsyn.kernels.plain import ramp_value, task_error
from armsyn.kernels.types import FloatArray

TARGET, CLOCK, RATE, RAMP, LIMIT_RATE, FADE = slice(0, 3), 3, 4, 5, 6, 7
LATE, ENDS, END_GAP, HAND = 8, 9, 10, 11
"""Where what stands in `Law.hand`, and how much does."""

GAIN, SLOPE, OFFSET, CARRIED, BENT, END, JOINTS = range(7)
"""Rows of `Law.joints`, and how many there are."""

FADE_S = 0.12
"""Least time constant with which a carried velocity fades, s: of what people have left of an
abandoned movement little remains after 0.4 s."""


class Law(NamedTuple):
    """Which target the hand follows, and how; few arrays, for each costs a call some time.

    Attributes
    ----------
    hand : array, shape (11,)
        The target (m, base frame), then: time of phi at which the law begins, s; lambda, 1/s;
        duration of the minimum-jerk rise that phi is multiplied by, s; the rate at which the
        controller brings a joint nearer to a limit at most, times its distance, 1/s; time
        constant with which what was carried fades, s; the time of phi, s, from which gains below
        one rise to it, in as long again; then, of laws that end in a given posture, 1 and how
        far from it a joint may stay, rad.
    joints : array, shape (6, n)
        Gain; slope, 1/s, and offset of phi = 1 / (1 + exp(offset - slope t)); velocity, rad/s,
        and acceleration, rad/s2, that the arm had beyond the controller's as the law began;
        and the posture to end in, rad, which the controller gives way to as gains rise: a hand
        that is to be turned, too, is so in it.
    """

    hand: FloatArray
    joints: FloatArray

    @property
    def target(self) -> FloatArray:
        """m, base frame, shape (3,)."""
        return self.hand[TARGET]

    @property
    def clock(self) -> float:
        """Time of phi at which it begins, s."""
        return float(self.hand[CLOCK])

    def copy(self) -> Law:
        """Arrays that nobody else writes to."""
        return Law(self.hand.copy(), self.joints.copy())


class Work(NamedTuple):
    """Room to work in: a step allocates nothing."""

    padded: FloatArray
    sines: FloatArray
    cosines: FloatArray
    origins: FloatArray
    axes: FloatArray
    J: FloatArray
    error: FloatArray
    B: FloatArray
    V: FloatArray
    y: FloatArray


@kernel
def room_for(n: int) -> Work:
    """Room to work in for n joints, padded to whole vectors, as roll-outs are."""
    size = (n + 7) // 8 * 8
    return Work(
        np.zeros(size), np.empty(size), np.empty(size), np.empty((n + 1, 3)), np.empty((n, 3)),
        np.empty((3, n)), np.empty(3), np.empty((3, 3)), np.empty((3, 3)), np.empty(3),
    )  # fmt: skip


@kernel
def controller_velocity(
    arm: Arm,
    hand: FloatArray,
    joints: FloatArray,
    work: Work,
    seen: FloatArray,
    q: FloatArray,
    t: float,
    velocity: FloatArray,
) -> tuple[float, float]:
    """Fill `velocity`, shape (n,), rad/s, with the controller's; return what is left.

    `seen`, shape (n,), is the posture that the hand is judged by, `q` the one that is commanded;
    `t` is the time of phi, s. What is left is the hand's distance, m, and, of a law that ends in a
    posture, the farthest joint's, rad.
    """
    rotation, translation, prismatic, lower, upper = arm.chain
    padded, sines, cosines, origins, axes, J, dX, B, V, y = work
    n, no_tip = q.shape[0], J[:0, :0]
    padded[:n] = seen
    forward(rotation, translation, prismatic, padded, sines, cosines, origins, axes, no_tip)
    distance = task_error(hand, no_tip, origins[n], no_tip, dX)
    jacobian(prismatic, origins, axes, J)
    change_of_posture(arm.optimiser, J, dX, B, V, y, velocity)
    factor = hand[RATE] * ramp_value(t, hand[RAMP])
    late, gap = ramp_value(max(t - hand[LATE], 0.0), hand[LATE]), 0.0
    for i in range(n):
        phi = factor / (1.0 + math.exp(joints[OFFSET, i] - joints[SLOPE, i] * t))
        gain = joints[GAIN, i]
        wanted = phi * (gain + late * max(1.0 - gain, 0.0)) * velocity[i]
        if hand[ENDS]:
            away = joints[END, i] - seen[i]
            gap = max(gap, abs(away))
            wanted += late * (factor * away - wanted)
        nearer = hand[LIMIT_RATE] * min(lower[i] - q[i], 0.0)
        farther = hand[LIMIT_RATE] * max(upper[i] - q[i], 0.0)
        velocity[i] = min(max(wanted, nearer), farther)
    return distance, gap


@kernel
def carried_velocity(v: float, a: float, fade: float, elapsed: float) -> float:
    """What is left, rad/s, `elapsed` s after the law began, of a velocity and an acceleration.

    It fades as what is critically damped does, which has no memory: a law that takes over from
    another on the way goes on with the same fading.
    """
    return float((v + (a + v / fade) * elapsed) * math.exp(-elapsed / fade))


@kernel
def stopping_speed(room: float, braking: float, step: float) -> float:
    """Greatest speed, rad/s, at which a joint still stops within `room`, rad, by `braking`, rad/s2.

    With steps of `step` s it goes on for one more at the speed that it has.
    """
    if room <= 0.0:
        return 0.0
    slip = braking * step
    return math.sqrt(slip * slip + 2.0 * braking * room) - slip
