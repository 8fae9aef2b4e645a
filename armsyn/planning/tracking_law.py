"""The law by which a hand follows a target that may change: the synergy controller in the loop.

A joint's velocity is the controller's (Aubry, Julliard, Gibet 2009, 3.1-3.2: lambda phi M O(J, dX),
with a clock of its own since the target changed) plus what is left of the velocity that the arm
had at that moment, fading away. So neither speed nor acceleration jumps when a target does. It is
the scheme that the literature on double steps calls abort and replan (Henis and Flash, *Biol.
Cybern.* 72, 1995); as the rest fades, the controller remains, and contracts.

All of it stands in one file: a compiled function carries the code and the constants of those that
it calls, and its cache on disk is only compared with the file that it stands in.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from armsyn.kernels.chain import ChainArrays, forward, jacobian
from armsyn.kernels.compiling import generated_kernel, kernel
from armsyn.kernels.optimisers import OptimiserSettings, change_of_posture
from armsyn.kernels.plain import ramp_value, task_error
from armsyn.kernels.types import BoolArray, FloatArray

TARGET, CLOCK, RATE, RAMP, LIMIT_RATE, FADE = slice(0, 3), 3, 4, 5, 6, 7
"""Where what stands in `Law.hand`."""

GAIN, SLOPE, OFFSET, CARRIED, BENT = range(5)
"""Rows of `Law.joints`."""

SPEED, ACCELERATION, JERK = range(3)
"""Rows of bounds."""

POSTURE, VELOCITY, BEND = range(3)
"""Rows of how an arm moves: rad, rad/s, rad/s2."""

OFF, EXPECTED, TRAILED, MOVED = range(4)
"""Rows of what is sensed: how far the arm stands off its commands, rad; where it is expected to
be, rad; and, of the line through the origin that tells a joint's lag, the two sums."""

LAGS_S = (0.01, 0.15)
"""Lags of servos that are believed, s."""

LARGEST_OFF = 0.1
"""rad that the arm may stand off its commands and be corrected for."""

SLOW = 0.1
"""rad/s at which a joint tells half as much of what it stands off as one at rest: the faster, the
more of its error is lag."""

BRAKING = 0.8
"""Share of a joint's acceleration that it keeps for stopping before the end of its range."""


class Law(NamedTuple):
    """Which target the hand follows, and how; few arrays, for each costs a call some time.

    Attributes
    ----------
    hand : array, shape (8,)
        The target (m, base frame), then: time of phi at which the law begins, s; lambda, 1/s;
        duration of the minimum-jerk rise that phi is multiplied by, s; the rate at which the
        controller brings a joint nearer to a limit at most, times its distance, 1/s; time
        constant with which what was carried fades, s.
    joints : array, shape (5, n)
        Gain; slope, 1/s, and offset of phi = 1 / (1 + exp(offset - slope t)); velocity, rad/s,
        and acceleration, rad/s2, that the arm had beyond the controller's as the law began.
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


@kernel
def controller_velocity(
    chain: ChainArrays,
    optimiser: OptimiserSettings,
    law: Law,
    seen: FloatArray,
    q: FloatArray,
    t: float,
    velocity: FloatArray,
) -> float:
    """Fill `velocity`, shape (n,), rad/s, with the controller's; return the hand's distance, m.

    `seen`, shape (n,), is the posture that the hand is judged by, `q` the one that is commanded;
    `t` is the time of phi, s.
    """
    rotation, translation, prismatic, lower, upper = chain
    hand, joints = law
    n = q.shape[0]
    # padded to whole vectors, as roll-outs are
    padded = np.zeros((n + 7) // 8 * 8)
    padded[:n] = seen
    sines, cosines = np.empty_like(padded), np.empty_like(padded)
    origins, axes, tip = np.empty((n + 1, 3)), np.empty((n, 3)), np.empty((0, 0))
    forward(rotation, translation, prismatic, padded, sines, cosines, origins, axes, tip)
    dX, J = np.empty(3), np.empty((3, n))
    distance = task_error(hand, tip, origins[n], tip, dX)
    jacobian(prismatic, origins, axes, J)
    change_of_posture(optimiser, J, dX, np.empty((3, 3)), np.empty((3, 3)), np.empty(3), velocity)
    factor = hand[RATE] * ramp_value(t, hand[RAMP])
    for i in range(n):
        phi = factor / (1.0 + math.exp(joints[OFFSET, i] - joints[SLOPE, i] * t))
        wanted = phi * joints[GAIN, i] * velocity[i]
        nearer = hand[LIMIT_RATE] * min(lower[i] - q[i], 0.0)
        farther = hand[LIMIT_RATE] * max(upper[i] - q[i], 0.0)
        velocity[i] = min(max(wanted, nearer), farther)
    return distance


@kernel
def carried_velocity(law: Law, joint: int, elapsed: float) -> float:
    """What is left of a joint's carried velocity, rad/s, `elapsed` s after the law began.

    It fades as what is critically damped does, which has no memory: a law that takes over from
    another on the way goes on with the same fading.
    """
    fade = law.hand[FADE]
    v = law.joints[CARRIED, joint]
    slope = law.joints[BENT, joint] + v / fade
    return float((v + slope * elapsed) * math.exp(-elapsed / fade))


@kernel
def stopping_speed(room: float, braking: float, step: float) -> float:
    """Greatest speed, rad/s, at which a joint still stops within `room`, rad, by `braking`, rad/s2.

    With steps of `step` s it goes on for one more at the speed that it has.
    """
    if room <= 0.0:
        return 0.0
    slip = braking * step
    return math.sqrt(slip * slip + 2.0 * braking * room) - slip


@kernel
def _advance(
    chain: ChainArrays,
    optimiser: OptimiserSettings,
    law: Law,
    bounds: FloatArray,
    off: FloatArray,
    moving: FloatArray,
    elapsed: float,
    step: float,
    steps: int,
    tolerance: float,
    guarded: bool,
    path: FloatArray,
) -> tuple[int, float, float, float]:
    """Let an arm follow a law; see `follow`."""
    n = moving.shape[1]
    seen, velocity = np.empty(n), np.empty(n)
    lower, upper = chain.lower, chain.upper
    distance, excess, fastest, made = math.inf, 0.0, 0.0, 0
    q, speeds, bends = moving[POSTURE], moving[VELOCITY], moving[BEND]
    while made < steps:
        elapsed += step
        made += 1
        for i in range(n):
            seen[i] = q[i] + off[i]
        t = law.hand[CLOCK] + elapsed
        distance = controller_velocity(chain, optimiser, law, seen, q, t, velocity)
        fastest = 0.0
        for i in range(n):
            v = velocity[i] + carried_velocity(law, i, elapsed)
            before = speeds[i]
            most = bounds[ACCELERATION, i]
            strain = abs(v - before) / (step * most)
            excess = max(excess, abs(v) / bounds[SPEED, i], math.sqrt(strain))
            if guarded:
                twist = bounds[JERK, i] * step
                a = min(max((v - before) / step, bends[i] - twist), bends[i] + twist)
                a = min(max(a, -most), most)
                v = min(max(before + a * step, -bounds[SPEED, i]), bounds[SPEED, i])
                v = min(v, stopping_speed(upper[i] - q[i], BRAKING * most, step))
                v = max(v, -stopping_speed(q[i] - lower[i], BRAKING * most, step))
            bends[i] = (v - before) / step
            speeds[i] = v
            q[i] += v * step
            fastest = max(fastest, abs(v))
        if path.shape[0] > 0:
            path[made - 1] = q
        if distance <= tolerance and 0.1 * fastest <= tolerance:
            break
    return made, distance, excess, fastest


@generated_kernel  # gives way to other threads of Python: one plans while another streams
def follow(
    chain: ChainArrays,
    optimiser: OptimiserSettings,
    law: Law,
    bounds: FloatArray,
    off: FloatArray,
    moving: FloatArray,
    elapsed: float,
    step: float,
    steps: int,
    tolerance: float,
    guarded: bool,
    path: FloatArray,
) -> tuple[int, float, float, float]:
    """Let an arm follow a law for up to `steps` steps of `step` seconds.

    Parameters
    ----------
    chain, optimiser, law
        As named.
    bounds : array, shape (3, n)
        Greatest speeds, rad/s, accelerations, rad/s2, and jerks, rad/s3.
    off : array, shape (n,)
        What the arm stands off the posture that it is commanded, rad.
    moving : array, shape (3, n)
        Posture, rad, velocity, rad/s, and acceleration, rad/s2; written to.
    elapsed : float
        Since the law began, s.
    step : float
        s.
    steps : int
    tolerance : float
        Stop once the hand is this near, m, and every joint slower than that, m, in a tenth of a
        second and radians; negative: never.
    guarded : bool
        Whether velocities are kept within `bounds` and joints within their ranges; without it the
        motion is as the law alone wants it.
    path : array, shape (steps, n) or (0, n)
        Filled with the posture after each step, rad.

    Returns
    -------
    tuple of (int, float, float, float)
        Steps made; the distance of the hand from its target before the last, m; by how much the
        law would have to be slowed to keep the bounds, at most 1 where it does; and the fastest
        joint's speed, rad/s.
    """
    return _advance(
        chain, optimiser, law, bounds, off, moving, elapsed, step, steps, tolerance, guarded, path
    )


@kernel
def _sense(
    sensed: FloatArray,
    posture: FloatArray,
    velocity: FloatArray,
    position: FloatArray,
    fresh: BoolArray,
    span: float,
    share: float,
) -> None:
    """Learn from what was measured, `span` seconds after the last time.

    A joint is taken to trail its commands by a first-order lag, which the measurements tell as
    they go: the slope of commanded less measured over the speed expected.

    Parameters
    ----------
    sensed : array, shape (4, n)
        What is known of how measured joints differ from commands; written to.
    posture, velocity : array, shape (n,)
        As commanded, rad, rad/s.
    position : array, shape (n,)
        Measured last, rad.
    fresh : array of bool, shape (n,)
        Which joints were.
    span : float
        s.
    share : float
        Of what a resting arm stands off, how much to learn a second, 1/s; 0 for nothing.
    """
    for i in range(posture.shape[0]):
        q = posture[i]
        lag = min(max(sensed[TRAILED, i] / sensed[MOVED, i], LAGS_S[0]), LAGS_S[1])
        behind = q - sensed[EXPECTED, i]
        known = fresh[i] and math.isfinite(position[i])
        if known:
            speed = behind / lag
            sensed[TRAILED, i] += span * speed * (q - position[i])
            sensed[MOVED, i] += span * speed * speed
        sensed[EXPECTED, i] += behind * (1.0 - math.exp(-span / lag))
        if known:
            gap = position[i] - sensed[EXPECTED, i] - sensed[OFF, i]
            slow = SLOW / (SLOW + abs(velocity[i]))
            off = sensed[OFF, i] + min(span * share * slow, 1.0) * gap
            sensed[OFF, i] = min(max(off, -LARGEST_OFF), LARGEST_OFF)


@generated_kernel
def tick(
    chain: ChainArrays,
    optimiser: OptimiserSettings,
    law: Law,
    bounds: FloatArray,
    sensed: FloatArray,
    moving: FloatArray,
    position: FloatArray,
    fresh: BoolArray,
    elapsed: float,
    span: float,
    longest: float,
    share: float,
) -> tuple[float, float]:
    """Learn from what was measured, then follow the law for `span` seconds, in one call.

    Each call costs a tick, and gives way to other threads: two are over the goal in a stream.

    Parameters
    ----------
    chain, optimiser, law, bounds, moving, elapsed
        As `follow`; velocities are kept within `bounds`.
    sensed, position, fresh, span, share
        As `_sense`.
    longest : float
        Longest step, s.

    Returns
    -------
    tuple of (float, float)
        Distance of the hand from its target, m, and the fastest joint's speed, rad/s.
    """
    _sense(sensed, moving[POSTURE], moving[VELOCITY], position, fresh, span, share)
    steps = max(1, math.ceil(span / longest - 1e-6))
    _, distance, _, fastest = _advance(
        chain, optimiser, law, bounds, sensed[OFF], moving,
        elapsed, span / steps, steps, -1.0, True, np.empty((0, moving.shape[1])),
    )  # fmt: skip
    return distance, fastest
