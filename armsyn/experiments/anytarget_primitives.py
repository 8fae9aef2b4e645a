"""DMP and ProMP as baselines of the experiment `anytarget`, by the package movement_primitives."""

from __future__ import annotations

import importlib.util

import numpy as np

from armsyn.experiments.anytarget_baselines import PathPredictor, nearest_mean
from armsyn.motion import FloatArray
from armsyn.planning.ending import led_to
from armsyn.planning.examples import PHASE, Examples
from armsyn.planning.linear import learn_linear
from armsyn.planning.postures import postures_at

WEIGHTS = 10
"""Radial basis functions a joint, the package's own choice."""
_ROUNDS = 10
"""Of expectation maximisation, at most."""
_STRIDE = 4
"""Every so many phases are looked at: enough for ten functions, and a tenth of the work."""
_EXACT = 1e-8
"""rad^2: variance of a posture that a ProMP is conditioned on."""


def why_missing() -> str | None:
    """Say why there can be no such baseline; None when there can."""
    found = all(map(importlib.util.find_spec, ("movement_primitives", "pytransform3d")))
    return None if found else "not installed: movement_primitives (armsyn[test])"


def dmp(examples: Examples) -> PathPredictor:
    """Learn dynamic movement primitives in joint space from the mean reach of each target.

    A new reach takes the primitive of the nearest target, with its own start and with the posture
    that IK finds at the target for its goal; what is left at the end is led there.

    Parameters
    ----------
    examples : Examples

    Returns
    -------
    PathPredictor

    References
    ----------
    Ijspeert et al., Neural Computation 25:328 (2013).
    """
    nearest, chain = nearest_mean(examples), examples.chain

    def paths(starts: FloatArray, targets: FloatArray) -> FloatArray:
        shown = nearest(targets)
        goals, _ = postures_at(chain, shown[:, -1], targets)
        played = [_played(*one) for one in zip(shown, starts, goals, strict=True)]
        return led_to(chain, np.array(played), starts, targets)[0]

    return PathPredictor(learn_linear(examples), paths)


def _played(shown: FloatArray, start: FloatArray, goal: FloatArray) -> FloatArray:
    """Play the primitive of one motion, all (101, n), between other postures."""
    from movement_primitives.dmp import DMP  # noqa: PLC0415  a test extra

    primitive = DMP(len(start), execution_time=1.0, dt=0.01, n_weights_per_dim=WEIGHTS)
    primitive.imitate(PHASE, shown)
    primitive.configure(start_y=start, goal_y=goal)
    return np.asarray(primitive.open_loop()[1])


def promp(examples: Examples) -> PathPredictor:
    """Learn a probabilistic movement primitive in joint space from all examples.

    It is conditioned on the start, and then on the posture that IK finds at the target next to
    where its mean then ends; what is left at the end is led there.

    Parameters
    ----------
    examples : Examples

    Returns
    -------
    PathPredictor

    References
    ----------
    Paraschos et al., Advances in Neural Information Processing Systems 26 (2013).
    """
    from movement_primitives.promp import ProMP  # noqa: PLC0415  a test extra

    chain = examples.chain
    learned = ProMP(chain.dof, n_weights_per_dim=WEIGHTS)
    moments = np.repeat(PHASE[None, ::_STRIDE], examples.size, axis=0)
    learned.imitate(moments, examples.angles[:, ::_STRIDE], n_iter=_ROUNDS)
    exactly = _EXACT * np.eye(chain.dof)

    def paths(starts: FloatArray, targets: FloatArray) -> FloatArray:
        begun = [learned.condition_position(start, exactly, t=0.0) for start in starts]
        free = np.array([one.mean_trajectory(PHASE)[-1] for one in begun])
        goals, _ = postures_at(chain, free, targets)
        played = [
            one.condition_position(goal, exactly, t=1.0).mean_trajectory(PHASE)
            for one, goal in zip(begun, goals, strict=True)
        ]
        return led_to(chain, np.array(played), starts, targets)[0]

    return PathPredictor(learn_linear(examples), paths)
