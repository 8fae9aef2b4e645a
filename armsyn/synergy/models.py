"""The four synergy models S_A to S_D and their named parameters.

Aubry, Julliard, Gibet 2009, section 4: a diagonal matrix of gains (M_A one for all degrees of
freedom, M_B one each) and a function of time (phi_A = 1, phi_B one sigmoid for all, phi_C one
each), sig(t) = 1 / (1 + e^t), phi = sig(-s t + o).

======= === ===== =====================================
model    M   phi   parameters
======= === ===== =====================================
``A``    A    A    g
``B``    B    A    g_1 .. g_n
``C``    B    B    g_1 .. g_n, o, s
``D``    B    C    g_1 .. g_n, o_1 .. o_n, s_1 .. s_n
======= === ===== =====================================

t is in seconds, so s is in 1/s and phi is one half at t = o / s.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import InputError
from armsyn.kernels.rollout import Synergies

FloatArray = NDArray[np.float64]

MODELS = ("A", "B", "C", "D")
GAINS = (-5.0, 5.0)
OFFSETS = (0.0, 20.0)
SLOPES = (1.0, 10.0)
STABLE_GAIN = 0.25
"""Least gain of an arm that moves: with every gain positive the closed loop contracts, for
J G J^+ is similar to B^(-1/2) (J G J^T) B^(-1/2), B = J J^T, whose eigenvalues lie between the
least and the greatest gain."""
STABLE_PACE = 0.1
"""The same for S_A, whose one gain sets nothing but the pace."""


def parameter_names(model: str, joint_names: tuple[str, ...]) -> tuple[str, ...]:
    """Names of the parameters of a model, in order.

    Parameters
    ----------
    model : {"A", "B", "C", "D"}
    joint_names : tuple of str

    Returns
    -------
    tuple of str
        Such as ``gain``, ``gain:elbow``, ``offset`` and ``slope``.

    Raises
    ------
    InputError
        Unknown model.
    """
    gains = tuple(f"gain:{joint}" for joint in joint_names)
    names = {
        "A": ("gain",),
        "B": gains,
        "C": (*gains, "offset", "slope"),
        "D": (
            *gains,
            *(f"offset:{joint}" for joint in joint_names),
            *(f"slope:{joint}" for joint in joint_names),
        ),
    }
    if model not in names:
        raise InputError(f"no synergy model {model!r}; known: {', '.join(MODELS)}")
    return names[model]


def parameter_bounds(model: str, dof: int, *, stable: bool) -> tuple[FloatArray, FloatArray]:
    """Bounds of the parameters: the paper's (section 4), or with positive gains.

    Parameters
    ----------
    model : {"A", "B", "C", "D"}
    dof : int
        Number of joints.
    stable : bool
        Bound the gains below by `STABLE_GAIN` (S_A: `STABLE_PACE`) instead of -5.

    Returns
    -------
    tuple of (array, array)
        Lower and upper bounds, each of shape (parameters,).

    Raises
    ------
    InputError
        Unknown model.
    """
    least = STABLE_PACE if model == "A" else STABLE_GAIN
    kinds = {
        "gain": (least, GAINS[1]) if stable else GAINS,
        "offset": OFFSETS,
        "slope": SLOPES,
    }
    names = parameter_names(model, tuple(str(joint) for joint in range(dof)))
    pairs = np.array([kinds[name.split(":")[0]] for name in names])
    return pairs[:, 0], pairs[:, 1]


def parameter_ties(model: str, dof: int) -> NDArray[np.int64]:
    """Return which parameter of the simpler model inside a model each of its parameters is.

    S_D with the same sigmoid for every joint is S_C; the others are taken as they are.

    Parameters
    ----------
    model : {"A", "B", "C", "D"}
    dof : int
        Number of joints.

    Returns
    -------
    array of int, shape (parameters,)
        A vector of the simpler model, indexed with it, is one of `model`.

    Raises
    ------
    InputError
        Unknown model.
    """
    count = len(parameter_names(model, tuple(str(joint) for joint in range(dof))))
    ties = np.arange(count)
    if model == "D":
        ties[dof : 2 * dof], ties[2 * dof :] = dof, dof + 1
    return ties


def synergies(model: str, dof: int, parameters: ArrayLike) -> Synergies:
    """Gains and sigmoids of parameter vectors, as the kernels take them.

    Parameters
    ----------
    model : {"A", "B", "C", "D"}
    dof : int
        Number of joints.
    parameters : array_like, shape (lanes, parameters)

    Returns
    -------
    Synergies
        One lane a row.

    Raises
    ------
    InputError
        Unknown model, wrong number of parameters, or not finite.
    """
    p = np.atleast_2d(np.asarray(parameters, dtype=np.float64))
    expected = len(parameter_names(model, tuple(str(joint) for joint in range(dof))))
    if p.ndim != 2 or p.shape[1] != expected or not np.isfinite(p).all():
        raise InputError(
            f"model {model} of {dof} joints has {expected} finite parameters, got {p.shape[1]}"
        )
    gains = np.ascontiguousarray(np.broadcast_to(p[:, :dof], (p.shape[0], dof)))
    if model in ("A", "B"):
        # phi = 1: a sigmoid whose half-way point lies infinitely long ago
        offsets, slopes = np.full((p.shape[0], 1), -np.inf), np.zeros((p.shape[0], 1))
    else:
        half = (p.shape[1] - dof) // 2
        offsets = np.ascontiguousarray(p[:, dof : dof + half])
        slopes = np.ascontiguousarray(p[:, dof + half :])
    return Synergies(gains, slopes, offsets)
