"""The controller with synergy as roll-outs for any chain (Aubry, Julliard, Gibet 2009, 3.1-3.2).

One step: dX = X_d - H(theta); dtheta = lambda dt O(J, dX); theta' = theta + phi(t) M dtheta,
clamped to the joints' limits.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from armsyn.kernels.chain import ChainArrays, forward, jacobian
from armsyn.kernels.compiling import kernel
from armsyn.kernels.optimisers import OptimiserSettings, change_of_posture, weigh_orientation
from armsyn.kernels.types import FloatArray, IntArray


class Synergies(NamedTuple):
    """Diagonal M and sigmoids phi of one or more synergies, a row each (a lane).

    Attributes
    ----------
    gains : array, shape (lanes, n)
        Diagonal of M.
    slopes, offsets : array, shape (lanes, 1) or (lanes, n)
        phi = 1 / (1 + exp(offset - slope t)), slope in 1/s; one for all joints or one each.
        An offset of minus infinity makes phi = 1 (phi_A).
    """

    gains: FloatArray
    slopes: FloatArray
    offsets: FloatArray


class Timing(NamedTuple):
    """Rates of a roll-out.

    Attributes
    ----------
    rate : float
        lambda, 1/s.
    dt : float
        Time between frames, s.
    ramp : float
        phi is multiplied by a minimum-jerk ramp of this duration, s; 0 for none.
    limit_rate : float
        A joint nears a limit at most at this rate times its distance to it, 1/s (a velocity
        damper, Faverjon and Tournassoud 1987); infinite: joints are clamped at their limits.
    """

    rate: float
    dt: float
    ramp: float
    limit_rate: float


class Task(NamedTuple):
    """Where the hand is to go.

    Attributes
    ----------
    position : array, shape (3,)
        m, base frame.
    orientation : array, shape (3, 3), or (0, 0) for a position task
        Of the tip in the base frame.
    """

    position: FloatArray
    orientation: FloatArray


class Captures(NamedTuple):
    """Captured landmark paths, a row each, padded to the longest.

    Attributes
    ----------
    landmarks : array, shape (motions, frames, landmarks, 3)
        m, base frame.
    frames : array of int, shape (motions,)
        How many frames each has.
    rows : array of int, shape (landmarks,)
        The chain's row (joint, or n for the tip) that each landmark is compared with.
    starts : array, shape (motions, n)
        Posture that each roll-out starts from.
    targets : array, shape (motions, 3)
        Position that each roll-out reaches for, m.
    """

    landmarks: FloatArray
    frames: IntArray
    rows: IntArray
    starts: FloatArray
    targets: FloatArray


@kernel
def task_error(
    position: FloatArray, orientation: FloatArray, hand: FloatArray, tip: FloatArray, dX: FloatArray
) -> float:
    """Fill dX, shape (3,) or (6,): position error, m, and rotation vector to the wanted pose, rad.

    Returns the distance of the positions, m.
    """
    for k in range(3):
        dX[k] = position[k] - hand[k]
    if dX.shape[0] == 6:
        _rotation_error(orientation, tip, dX)
    return math.sqrt(dX[0] * dX[0] + dX[1] * dX[1] + dX[2] * dX[2])


@kernel
def _rotation_error(wanted: FloatArray, present: FloatArray, dX: FloatArray) -> None:
    """Write the logarithm of wanted present^T (base frame) to dX[3:6]."""
    r = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(3):
                total += wanted[i, k] * present[j, k]
            r[i, j] = total
    x = r[2, 1] - r[1, 2]
    y = r[0, 2] - r[2, 0]
    z = r[1, 0] - r[0, 1]
    sine = 0.5 * math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (r[0, 0] + r[1, 1] + r[2, 2] - 1.0)
    angle = math.atan2(sine, cosine)
    if sine > 1e-6:
        scale = 0.5 * angle / sine
        dX[3] = x * scale
        dX[4] = y * scale
        dX[5] = z * scale
    elif cosine > 0.0:
        dX[3] = 0.5 * x
        dX[4] = 0.5 * y
        dX[5] = 0.5 * z
    else:
        # Half a turn: any column of r + 1 is along the axis; take the longest
        best = 0
        for k in range(1, 3):
            if r[k, k] > r[best, best]:
                best = k
        norm = math.sqrt(2.0 * (1.0 + r[best, best]))
        for k in range(3):
            dX[3 + k] = angle * (r[k, best] + (1.0 if k == best else 0.0)) / norm


@kernel
def ramp_value(t: float, duration: float) -> float:
    """Minimum-jerk rise from 0 to 1 over `duration` (Flash and Hogan 1985); 1 when it is 0."""
    if t >= duration:
        return 1.0
    s = t / duration
    return s * s * s * (10.0 + s * (6.0 * s - 15.0))


@kernel
def apply_synergy(
    gains: FloatArray,
    slopes: FloatArray,
    offsets: FloatArray,
    factor: float,
    t: float,
    lower: FloatArray,
    upper: FloatArray,
    share: float,
    dq: FloatArray,
    q: FloatArray,
) -> None:
    """Add factor phi(t) M dq to posture q, all of shape (n,), within the limits.

    No joint covers more than `share` of what is left to its limit.
    """
    shared = slopes.shape[0] == 1
    phi = 0.0
    for i in range(dq.shape[0]):
        if i == 0 or not shared:
            phi = factor / (1.0 + math.exp(offsets[i] - slopes[i] * t))
        change = phi * gains[i] * dq[i]
        q[i] += min(max(change, share * (lower[i] - q[i])), share * (upper[i] - q[i]))


@kernel
def roll_out(
    chain: ChainArrays,
    optimiser: OptimiserSettings,
    gains: FloatArray,
    slopes: FloatArray,
    offsets: FloatArray,
    timing: Timing,
    task: Task,
    tolerance: float,
    path: FloatArray,
    positions: FloatArray,
) -> tuple[int, float]:
    """Fill `path`, shape (frames, n), from the posture in its first row.

    Fills `positions`, shape (frames, n + 1, 3), too: every joint and the tip, m. Stops early
    once the hand is within `tolerance` (m) of the target's position and, for a pose, within
    `tolerance` rad of its orientation; a negative tolerance fills every frame.

    Returns
    -------
    tuple of (int, float)
        Frames filled, and the distance to the target at the last of them, m.
    """
    frames, n = path.shape
    m = 6 if task.orientation.shape[0] == 3 else 3
    rotation, translation, prismatic, lower, upper = chain
    position, orientation = task
    rate, dt, ramp, limit_rate = timing
    share = min(1.0, limit_rate * dt)
    # Padded to whole vectors, else seven sines are worked out one by one
    q = np.zeros((n + 7) // 8 * 8)
    q[:n] = path[0]
    sines, cosines = np.empty_like(q), np.empty_like(q)
    axes, tip = np.empty((n, 3)), np.empty((m - 3, m - 3))
    J, dX, dq = np.empty((m, n)), np.empty(m), np.empty(n)
    B, V, y = np.empty((m, m)), np.empty((m, m)), np.empty(m)
    distance = 0.0
    for frame in range(frames):
        for i in range(n):
            path[frame, i] = q[i]
        origins = positions[frame]
        forward(rotation, translation, prismatic, q, sines, cosines, origins, axes, tip)
        distance = task_error(position, orientation, origins[n], tip, dX)
        turn = 0.0
        for k in range(3, m):
            turn += dX[k] * dX[k]
        if distance <= tolerance and math.sqrt(turn) <= tolerance:
            return frame + 1, distance
        if frame + 1 < frames:
            t = frame * dt
            jacobian(prismatic, origins, axes, J)
            weigh_orientation(optimiser.radius, J, dX)
            change_of_posture(optimiser, J, dX, B, V, y, dq)
            factor = rate * dt * ramp_value(t, ramp)
            apply_synergy(gains, slopes, offsets, factor, t, lower, upper, share, dq, q)
    return frames, distance


@kernel
def paper_distance(positions: FloatArray, rows: IntArray, landmarks: FloatArray) -> float:
    """Paper 3.4: mean over frames and over landmarks (l joints and the hand) of distances, m.

    `positions`, shape (frames, n + 1, 3), at its `rows`, shape (landmarks,), against
    `landmarks`, shape (frames, landmarks, 3).
    """
    frames = positions.shape[0]
    total = 0.0
    for frame in range(frames):
        for mark in range(rows.shape[0]):
            row = rows[mark]
            dx = positions[frame, row, 0] - landmarks[frame, mark, 0]
            dy = positions[frame, row, 1] - landmarks[frame, mark, 1]
            dz = positions[frame, row, 2] - landmarks[frame, mark, 2]
            total += math.sqrt(dx * dx + dy * dy + dz * dz)
    return float(total / (frames * rows.shape[0]))
