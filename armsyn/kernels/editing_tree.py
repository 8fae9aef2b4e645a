"""Trees of bodies whose pose is one vector: forward kinematics and Jacobians of points.

A body turns and moves with columns of the pose vector, three (an exponential map, a translation)
or one (about, along an axis), or with none. Body j stands, relative to its parent p, at

    p_j = p_p + G_p (offset_j + move_j),    G_j = G_p before_j exp([turn_j]x)

so that a skeleton and a serial chain are the same thing here.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from armsyn.kernels.compiling import kernel
from armsyn.kernels.types import FloatArray, IntArray


class Tree(NamedTuple):
    """Constants of a tree; parents come before their children.

    Attributes
    ----------
    parent : array of int, shape (bodies,)
        -1 where a body hangs on the world.
    offset : array, shape (bodies, 3)
        In the parent's frame, m.
    before : array, shape (bodies, 3, 3)
        Turned before the body's own columns turn it.
    turns, turn_column : array of int, shape (bodies,)
        Number of columns that turn the body (0, 1 or 3), and the first of them.
    turn_axis : array, shape (bodies, 3)
        Unit axis in the body's frame, where one column turns it.
    moves, move_column : array of int, shape (bodies,)
        The same of translations.
    move_axis : array, shape (bodies, 3)
        Unit axis in the parent's frame, where one column moves it.
    """

    parent: IntArray
    offset: FloatArray
    before: FloatArray
    turns: IntArray
    turn_column: IntArray
    turn_axis: FloatArray
    moves: IntArray
    move_column: IntArray
    move_axis: FloatArray


@kernel
def _fill(first: float, second: float, w: FloatArray, M: FloatArray) -> None:
    """Fill M = I + first [w]x + second [w]x^2."""
    x = w[0]
    y = w[1]
    z = w[2]
    M[0, 0] = 1.0 - second * (y * y + z * z)
    M[1, 1] = 1.0 - second * (x * x + z * z)
    M[2, 2] = 1.0 - second * (x * x + y * y)
    M[0, 1] = second * x * y - first * z
    M[1, 0] = second * x * y + first * z
    M[0, 2] = second * x * z + first * y
    M[2, 0] = second * x * z - first * y
    M[1, 2] = second * y * z - first * x
    M[2, 1] = second * y * z + first * x


@kernel
def exponential(w: FloatArray, R: FloatArray) -> None:
    """Fill R = exp([w]x), shape (3, 3), by Rodrigues' formula."""
    square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    if square < 1e-8:
        first = 1.0 - square / 6.0
        second = 0.5 - square / 24.0
    else:
        angle = math.sqrt(square)
        half = math.sin(0.5 * angle)
        first = math.sin(angle) / angle
        second = 2.0 * half * half / square
    _fill(first, second, w, R)


@kernel
def left_jacobian(w: FloatArray, L: FloatArray) -> None:
    """Fill the left Jacobian of SO(3) at w, shape (3, 3): exp(w + dw) = exp(L dw) exp(w).

    L = I + (1 - cos a) / a^2 [w]x + (a - sin a) / a^3 [w]x^2 (Sola, Deray and Atchuthan,
    "A micro Lie theory", eq. 145), by its Taylor series near zero.
    """
    square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    if square < 1e-4:
        first = 0.5 - square / 24.0 * (1.0 - square / 30.0)
        second = 1.0 / 6.0 - square / 120.0 * (1.0 - square / 42.0)
    else:
        angle = math.sqrt(square)
        half = math.sin(0.5 * angle)
        first = 2.0 * half * half / square
        second = (angle - math.sin(angle)) / (square * angle)
    _fill(first, second, w, L)


@kernel
def _multiply(A: FloatArray, B: FloatArray, C: FloatArray) -> None:
    for i in range(3):
        for j in range(3):
            C[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]


@kernel
def place(
    tree: Tree, pose: FloatArray, positions: FloatArray, orientations: FloatArray, hung: FloatArray
) -> None:
    """Fill where the bodies are at one pose.

    Parameters
    ----------
    tree : Tree
    pose : array, shape (n,)
        rad and m.
    positions : array, shape (bodies, 3)
        Filled, m.
    orientations, hung : array, shape (bodies, 3, 3)
        Filled: G_j, and G_p before_j, the frame in which the body's own columns turn it.
    """
    world = np.eye(3)
    shift = np.empty(3)
    w = np.empty(3)
    R = np.empty((3, 3))
    for j in range(tree.parent.shape[0]):
        p = tree.parent[j]
        for i in range(3):
            shift[i] = tree.offset[j, i]
        if tree.moves[j] == 3:
            for i in range(3):
                shift[i] += pose[tree.move_column[j] + i]
        elif tree.moves[j] == 1:
            for i in range(3):
                shift[i] += tree.move_axis[j, i] * pose[tree.move_column[j]]
        above = world if p < 0 else orientations[p]
        for i in range(3):
            moved = above[i, 0] * shift[0] + above[i, 1] * shift[1] + above[i, 2] * shift[2]
            positions[j, i] = moved + (0.0 if p < 0 else positions[p, i])
        _multiply(above, tree.before[j], hung[j])
        if tree.turns[j] == 0:
            orientations[j] = hung[j]
            continue
        for i in range(3):
            if tree.turns[j] == 3:
                w[i] = pose[tree.turn_column[j] + i]
            else:
                w[i] = tree.turn_axis[j, i] * pose[tree.turn_column[j]]
        exponential(w, R)
        _multiply(hung[j], R, orientations[j])


@kernel
def place_all(tree: Tree, poses: FloatArray, positions: FloatArray) -> None:
    """Fill the bodies' positions at many poses: (frames, n) to (frames, bodies, 3), m."""
    bodies = tree.parent.shape[0]
    orientations = np.empty((bodies, 3, 3))
    hung = np.empty((bodies, 3, 3))
    for frame in range(poses.shape[0]):
        place(tree, poses[frame], positions[frame], orientations, hung)


@kernel
def _column(
    J: FloatArray, column: int, axis: FloatArray, along: bool, rx: float, ry: float, rz: float
) -> None:
    """Write what one column does to the point: moves it along, or turns it about, an axis."""
    if along:
        for i in range(3):
            J[i, column] = axis[i]
        return
    J[0, column] = axis[1] * rz - axis[2] * ry
    J[1, column] = axis[2] * rx - axis[0] * rz
    J[2, column] = axis[0] * ry - axis[1] * rx
    for i in range(3):
        J[3 + i, column] = axis[i]


@kernel
def point_jacobians(
    tree: Tree,
    pose: FloatArray,
    bodies: IntArray,
    points: FloatArray,
    places: FloatArray,
    orientations: FloatArray,
    J: FloatArray,
) -> None:
    """Fill where points fixed to bodies are at one pose, and how they move with it.

    Parameters
    ----------
    tree : Tree
    pose : array, shape (n,)
        rad and m.
    bodies : array of int, shape (points,)
    points : array, shape (points, 3)
        In their bodies' frames, m.
    places : array, shape (points, 3)
        Filled: global positions, m.
    orientations : array, shape (points, 3, 3)
        Filled: of their bodies.
    J : array, shape (points, 6, n)
        Filled: linear (m a unit of the column), then angular velocity (rad), both global.
    """
    count = tree.parent.shape[0]
    origins = np.empty((count, 3))
    frames = np.empty((count, 3, 3))
    hung = np.empty((count, 3, 3))
    L = np.empty((3, 3))
    A = np.empty((3, 3))
    axis = np.empty(3)
    world = np.eye(3)
    place(tree, pose, origins, frames, hung)
    for task in range(bodies.shape[0]):
        j = bodies[task]
        for i in range(3):
            places[task, i] = origins[j, i]
            for k in range(3):
                places[task, i] += frames[j, i, k] * points[task, k]
                orientations[task, i, k] = frames[j, i, k]
        J[task] = 0.0
        while j >= 0:
            p = tree.parent[j]
            rx = places[task, 0] - origins[j, 0]
            ry = places[task, 1] - origins[j, 1]
            rz = places[task, 2] - origins[j, 2]
            if tree.turns[j] == 3:
                left_jacobian(pose[tree.turn_column[j] : tree.turn_column[j] + 3], L)
                _multiply(hung[j], L, A)
                for k in range(3):
                    for i in range(3):
                        axis[i] = A[i, k]
                    _column(J[task], tree.turn_column[j] + k, axis, False, rx, ry, rz)
            elif tree.turns[j] == 1:
                for i in range(3):
                    axis[i] = 0.0
                    for k in range(3):
                        axis[i] += hung[j, i, k] * tree.turn_axis[j, k]
                _column(J[task], tree.turn_column[j], axis, False, rx, ry, rz)
            above = world if p < 0 else frames[p]
            if tree.moves[j] == 3:
                for k in range(3):
                    for i in range(3):
                        axis[i] = above[i, k]
                    _column(J[task], tree.move_column[j] + k, axis, True, 0.0, 0.0, 0.0)
            elif tree.moves[j] == 1:
                for i in range(3):
                    axis[i] = 0.0
                    for k in range(3):
                        axis[i] += above[i, k] * tree.move_axis[j, k]
                _column(J[task], tree.move_column[j], axis, True, 0.0, 0.0, 0.0)
            j = p
