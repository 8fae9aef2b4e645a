"""The predictors by name: what a person's captured reaches say about any other reach."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from armsyn.errors import InputError
from armsyn.planning.examples import Examples
from armsyn.planning.joined import learn_joined
from armsyn.planning.latent import learn_latent
from armsyn.planning.linear import learn_linear
from armsyn.planning.minimum_jerk import learn_minimum_jerk, learn_straight_hand
from armsyn.planning.prediction import Predicted, Predictor, checked_reaches
from armsyn.planning.synergy_atlas import SYNERGY_PREDICTORS

PREDICTORS: Mapping[str, Callable[..., Predictor]] = {
    "linear": learn_linear,
    "latent": learn_latent,
    "minjerk": learn_minimum_jerk,
    "minjerk_hand": learn_straight_hand,
    **SYNERGY_PREDICTORS,
    "joined": learn_joined,
}
"""Each learns from `Examples` and its own options."""

__all__ = ["PREDICTORS", "Predicted", "Predictor", "checked_reaches", "learn_predictor"]


def learn_predictor(kind: str, examples: Examples, **options: Any) -> Predictor:
    """Learn a predictor by its name.

    Parameters
    ----------
    kind : str
        Of `PREDICTORS`.
    examples : Examples
    **options
        Of that kind; see its own function.

    Returns
    -------
    Predictor

    Raises
    ------
    InputError
        No such kind.
    CaptureError
        Too few examples for it.
    """
    if kind not in PREDICTORS:
        raise InputError(f"no predictor {kind!r}; known: {', '.join(PREDICTORS)}")
    return PREDICTORS[kind](examples, **options)
