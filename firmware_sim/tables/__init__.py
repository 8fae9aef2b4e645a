"""The models that can be simulated, one file each.

A file is read when its model is first asked for, so that a start costs only what it needs.
"""

from __future__ import annotations

from importlib import import_module

from firmware_sim.errors import RigError
from firmware_sim.model import ServoModel

MODEL_NAMES = ("xl330-m288", "xl430-w250", "xm430-w350", "xm540-w270")
"""The maker's names in lower case."""


def find_model(name: str) -> ServoModel:
    """Return a model by its maker's name.

    Parameters
    ----------
    name : str
        For instance ``"xm430-w350"``; upper case is taken too.

    Returns
    -------
    ServoModel
        The model with its control table.

    Raises
    ------
    RigError
        If no such model can be simulated.
    """
    lower = name.lower()
    if lower not in MODEL_NAMES:
        raise RigError(
            f"unknown servo model {name!r}: use one of {', '.join(MODEL_NAMES)}", field="model"
        )
    model: ServoModel = import_module(f"firmware_sim.tables.{lower.replace('-', '_')}").MODEL
    return model
