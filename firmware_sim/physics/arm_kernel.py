"""Between servos' axes and MuJoCo's joints, compiled: torques one way, angles the other.

Nothing here calls `kernel` or uses its constants, which numba's cache on disk would not see change:
columns of the state come as an argument (`COLUMNS` names them), and so do all figures.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firmware_sim.physics import kernel
from firmware_sim.physics.kernel import compiled

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.intp]

COLUMNS = np.array(
    [
        kernel.LOAD,
        kernel.FRICTION,
        kernel.FRICTION_FACTOR,
        kernel.JAMMED,
        kernel.DEMAND,
        kernel.LAST_DEMAND,
        kernel.UNDER_WAY,
        kernel.STOP_LOW,
        kernel.STOP_HIGH,
    ],
    dtype=np.intp,
)
"""Columns of the state that these functions use, in this order."""


@compiled
def load_joints(
    state: FloatArray,
    columns: IndexArray,
    drives: FloatArray,
    dofs: IndexArray,
    directions: FloatArray,
    figures: FloatArray,
    velocities: FloatArray,
    forces: FloatArray,
    dampings: FloatArray,
    frictions: FloatArray,
) -> None:
    """Sum up what the servos of each joint do to it.

    Parameters
    ----------
    state : ndarray of float, shape (servos, kernel.COLUMNS)
    columns : ndarray of int
        `COLUMNS`.
    drives : ndarray of float, shape (2, servos)
        Torques, N m, and dampings, N m per rad/s, as `kernel.drive` leaves them.
    dofs : ndarray of int, shape (servos,)
        Each servo's place in the arrays of joints.
    directions : ndarray of float, shape (servos,)
        1 or -1.
    figures : ndarray of float, shape (3,)
        Speed below which a joint stands (rad/s), static over Coulomb friction, friction of a
        jammed joint (N m).
    velocities : ndarray of float, shape (nv,)
        Of the joints, rad/s.
    forces, dampings, frictions : ndarray of float, shape (nv,)
        Get the sums; those of joints without a servo stay as they are.
    """
    load, friction, factor, jammed = columns[0], columns[1], columns[2], columns[3]
    for i in range(len(state)):
        dof = dofs[i]
        forces[dof] = dampings[dof] = frictions[dof] = 0.0
    for i in range(len(state)):
        x = state[i]
        dof = dofs[i]
        forces[dof] += directions[i] * (drives[0, i] - x[load])
        dampings[dof] += drives[1, i]
        static = figures[1] if abs(velocities[dof]) < figures[0] else 1.0
        frictions[dof] += static * x[friction] * x[factor]
        if x[jammed]:
            frictions[dof] += figures[2]


@compiled
def find_stops(state: FloatArray, columns: IndexArray, known: FloatArray) -> bool:
    """Look where obstacles are.

    Parameters
    ----------
    state : ndarray of float, shape (servos, kernel.COLUMNS)
    columns : ndarray of int
        `COLUMNS`.
    known : ndarray of float, shape (servos, 2)
        Where they were, rad, clockwise and counter-clockwise; gets where they are.

    Returns
    -------
    bool
        Whether that is elsewhere.
    """
    changed = False
    for i in range(len(state)):
        low, high = state[i, columns[7]], state[i, columns[8]]
        if low != known[i, 0] or high != known[i, 1]:
            changed = True
            known[i, 0], known[i, 1] = low, high
    return changed


@compiled
def read_joints(
    state: FloatArray,
    columns: IndexArray,
    places: IndexArray,
    mounts: FloatArray,
    standing: float,
    same_duty: float,
    positions: FloatArray,
    velocities: FloatArray,
    motion: FloatArray,
) -> bool:
    """Turn joints' angles and speeds into those of the servos.

    Parameters
    ----------
    state : ndarray of float, shape (servos, kernel.COLUMNS)
    columns : ndarray of int
        `COLUMNS`.
    places : ndarray of int, shape (2, servos)
        Each servo's place in `positions` and in `velocities`.
    mounts : ndarray of float, shape (2, servos)
        Directions, 1 or -1, and angles of the horns at the joints' zeros, rad.
    standing : float
        Speed below which a joint stands, rad/s.
    same_duty : float
        Change of what a loop asks for that counts as none.
    positions, velocities : ndarray of float
        MuJoCo's ``qpos`` and ``qvel``.
    motion : ndarray of float, shape (2, servos)
        Gets angles, rad, and speeds, rad/s, of the servos.

    Returns
    -------
    bool
        Whether every joint stands and no loop changed what it asks for in this step.
    """
    still = True
    for i in range(len(state)):
        motion[0, i] = mounts[1, i] + mounts[0, i] * positions[places[0, i]]
        motion[1, i] = mounts[0, i] * velocities[places[1, i]]
        x = state[i]
        if x[columns[6]] or abs(x[columns[4]] - x[columns[5]]) > same_duty:
            still = False
    for speed in velocities:
        if abs(speed) >= standing:
            still = False
    return still
