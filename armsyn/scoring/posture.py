"""Directions of the arm's segments and the swivel of its plane."""

from __future__ import annotations

import numpy as np

from armsyn.motion import FloatArray

DOWN = np.array([0.0, 0.0, -1.0])
STRAIGHT = 0.1
"""Sine of the angle at the shoulder below which elbow (or reference) and wrist are in line."""


def angles_between(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the angles between vectors.

    Parameters
    ----------
    first, second : array, shape (samples, 3)
        Any length above zero.

    Returns
    -------
    array, shape (samples,)
        rad, 0 to pi.
    """
    across = np.linalg.norm(np.cross(first, second), axis=1)
    return np.asarray(np.arctan2(across, (first * second).sum(axis=1)))


def swivel_angles(
    shoulder: FloatArray, elbow: FloatArray, wrist: FloatArray, reference: FloatArray = DOWN
) -> FloatArray:
    """Return the angle of the plane shoulder-elbow-wrist about the line shoulder-wrist.

    Parameters
    ----------
    shoulder, elbow, wrist : array, shape (samples, 3)
        m.
    reference : array, shape (3,)
        Where the elbow points at angle zero; down by default. The angle is positive towards
        (wrist - shoulder) x reference.

    Returns
    -------
    array, shape (samples,)
        rad, -pi to pi; NaN where the elbow is nearly straight or the arm points along the
        reference, for there the plane means nothing.

    References
    ----------
    Front Hum Neurosci (2016): within people the final swivel varies by 3.5-4.2 deg (SD).
    """
    line = wrist - shoulder
    with np.errstate(invalid="ignore", divide="ignore"):
        axis = line / np.linalg.norm(line, axis=1, keepdims=True)
        side, side_sine = _across(elbow - shoulder, axis)
        zero, zero_sine = _across(np.broadcast_to(reference, line.shape), axis)
        sine = (side * np.cross(axis, zero)).sum(axis=1)
        angle = np.arctan2(sine, (side * zero).sum(axis=1))
        # A NaN of the division compares false, too.
        known = (side_sine > STRAIGHT) & (zero_sine > STRAIGHT)
    return np.asarray(np.where(known, angle, np.nan))


def _across(vectors: FloatArray, axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the part of vectors across an axis, and the sine of their angle to it."""
    across = vectors - (vectors * axis).sum(axis=1, keepdims=True) * axis
    return across, np.linalg.norm(across, axis=1) / np.linalg.norm(vectors, axis=1)


def swivel_differences(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return second minus first, the short way round.

    Parameters
    ----------
    first, second : array, shape (samples,)
        rad.

    Returns
    -------
    array, shape (samples,)
        rad, -pi to pi; NaN where one of them is.
    """
    return np.asarray((second - first + np.pi) % (2 * np.pi) - np.pi)
