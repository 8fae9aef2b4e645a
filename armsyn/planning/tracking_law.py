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

from armsyn.kernels.chain import ChainArrays, forward, jacobian
from armsyn.kernels.compiling import generated_kernel, kernel
from armsyn.kernels.optimisers import OptimiserSettings, change_of_posture
from armsyn.kernels.plain import ramp_value, task_error
from armsyn.kernels.types import FloatArray

BRAKING = 0.8
"""Share of a joint's acceleration that it keeps for stopping before the end of its range."""


class Law(NamedTuple):
    """Which target the hand follows, and how.

    Attributes
    ----------
    target : array, shape (3,)
        m, base frame.
    gains : array, shape (n,)
        Diagonal of M.
    slopes, offsets : array, shape (1,) or (n,)
        phi = 1 / (1 + exp(offset - slope t)), slope in 1/s.
    carried : array, shape (2, n)
        Velocity, rad/s, and acceleration, rad/s2, that the arm had beyond the controller's when
        the target changed.
    clock : float
        Time of phi at which the law begins, s.
    rate : float
        lambda, 1/s.
    ramp : float
        phi is multiplied by a minimum-jerk rise of this duration, s.
    limit_rate : float
        The controller brings a joint nearer to a limit at most at this rate times its distance
        to it, 1/s.
    fade : float
        Time constant with which what was carried fades, s.
    """

    target: FloatArray
    gains: FloatArray
    slopes: FloatArray
    offsets: FloatArray
    carried: FloatArray
    clock: float
    rate: float
    ramp: float
    limit_rate: float
    fade: float


class Bounds(NamedTuple):
    """What joints may do.

    Attributes
    ----------
    speed, acceleration, jerk : array, shape (n,)
        rad/s, rad/s2 and rad/s3.
    """

    speed: FloatArray
    acceleration: FloatArray
    jerk: FloatArray


class Moving(NamedTuple):
    """How an arm moves at a moment; `follow` writes into it.

    Attributes
    ----------
    q, v, a : array, shape (n,)
        Posture, rad, velocity, rad/s, and acceleration, rad/s2.
    """

    q: FloatArray
    v: FloatArray
    a: FloatArray


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
    n = q.shape[0]
    # padded to whole vectors, as roll-outs are
    padded = np.zeros((n + 7) // 8 * 8)
    padded[:n] = seen
    sines, cosines = np.empty_like(padded), np.empty_like(padded)
    origins, axes, tip = np.empty((n + 1, 3)), np.empty((n, 3)), np.empty((0, 0))
    forward(rotation, translation, prismatic, padded, sines, cosines, origins, axes, tip)
    dX, J = np.empty(3), np.empty((3, n))
    distance = task_error(law.target, tip, origins[n], tip, dX)
    jacobian(prismatic, origins, axes, J)
    change_of_posture(optimiser, J, dX, np.empty((3, 3)), np.empty((3, 3)), np.empty(3), velocity)
    factor = law.rate * ramp_value(t, law.ramp)
    shared = law.slopes.shape[0] == 1
    phi = 0.0
    for i in range(n):
        if i == 0 or not shared:
            phi = factor / (1.0 + math.exp(law.offsets[i] - law.slopes[i] * t))
        wanted = phi * law.gains[i] * velocity[i]
        nearer = law.limit_rate * min(lower[i] - q[i], 0.0)
        farther = law.limit_rate * max(upper[i] - q[i], 0.0)
        velocity[i] = min(max(wanted, nearer), farther)
    return distance


@kernel
def carried_velocity(law: Law, joint: int, elapsed: float) -> float:
    """What is left of a joint's carried velocity, rad/s, `elapsed` s after the law began.

    It fades as what is critically damped does, which has no memory: a law that takes over from
    another on the way goes on with the same fading.
    """
    v = law.carried[0, joint]
    slope = law.carried[1, joint] + v / law.fade
    return float((v + slope * elapsed) * math.exp(-elapsed / law.fade))


@generated_kernel  # gives way to other threads of Python: one plans while another streams
def follow(
    chain: ChainArrays,
    optimiser: OptimiserSettings,
    law: Law,
    bounds: Bounds,
    correction: FloatArray,
    moving: Moving,
    elapsed: float,
    step: float,
    steps: int,
    tolerance: float,
    guarded: bool,
    path: FloatArray,
) -> tuple[int, float, float]:
    """Let an arm follow a law for up to `steps` steps of `step` seconds.

    Parameters
    ----------
    chain, optimiser, law, bounds
        As named.
    correction : array, shape (n,)
        What the arm stands off the posture that it is commanded, rad.
    moving : Moving
        Written to.
    elapsed : float
        Since the law began, s.
    step : float
        s.
    steps : int
    tolerance : float
        Stop once the hand is this near, m, and slower than that a step of 0.1 s; negative: never.
    guarded : bool
        Whether velocities are kept within `bounds` and joints within their ranges; without it the
        motion is as the law alone wants it.
    path : array, shape (steps, n) or (0, n)
        Filled with the posture after each step, rad.

    Returns
    -------
    tuple of (int, float, float)
        Steps made; the distance of the hand from its target before the last, m; and by how much
        the law would have to be slowed to keep the bounds, at most 1 where it does.
    """
    n = moving.q.shape[0]
    seen, velocity = np.empty(n), np.empty(n)
    lower, upper = chain.lower, chain.upper
    distance, excess, made = math.inf, 0.0, 0
    while made < steps:
        elapsed += step
        made += 1
        for i in range(n):
            seen[i] = moving.q[i] + correction[i]
        distance = controller_velocity(
            chain, optimiser, law, seen, moving.q, law.clock + elapsed, velocity
        )
        fastest = 0.0
        for i in range(n):
            v = velocity[i] + carried_velocity(law, i, elapsed)
            before = moving.v[i]
            strain = abs(v - before) / (step * bounds.acceleration[i])
            excess = max(excess, abs(v) / bounds.speed[i], math.sqrt(strain))
            if guarded:
                a = (v - before) / step
                twist = bounds.jerk[i] * step
                a = min(max(a, moving.a[i] - twist), moving.a[i] + twist)
                a = min(max(a, -bounds.acceleration[i]), bounds.acceleration[i])
                v = min(max(before + a * step, -bounds.speed[i]), bounds.speed[i])
                brake = BRAKING * bounds.acceleration[i]
                v = min(v, stopping_speed(upper[i] - moving.q[i], brake, step))
                v = max(v, -stopping_speed(moving.q[i] - lower[i], brake, step))
            moving.a[i] = (v - before) / step
            moving.v[i] = v
            moving.q[i] += v * step
            fastest = max(fastest, abs(v))
        if path.shape[0] > 0:
            path[made - 1] = moving.q
        if distance <= tolerance and 0.1 * fastest <= tolerance:
            break
    return made, distance, excess


@kernel
def stopping_speed(room: float, braking: float, step: float) -> float:
    """Greatest speed, rad/s, at which a joint still stops within `room`, rad, by `braking`, rad/s2.

    With steps of `step` s it goes on for one more at the speed that it has.
    """
    if room <= 0.0:
        return 0.0
    slip = braking * step
    return math.sqrt(slip * slip + 2.0 * braking * room) - slip
