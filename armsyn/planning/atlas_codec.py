"""Learned models as JSON and back: frozen dataclasses of arrays, numbers and other such classes.

A document names its class and has exactly its fields. Small arrays are lists of numbers with six
significant digits; large ones (motions) are 16-bit shares of their greatest value, in base 64: an
error of at most 2e-5 of it. The chain is no part of a document: it is the arm's, and given when it
is read.
"""

from __future__ import annotations

import base64
import binascii
import dataclasses
import math
import typing
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import InputError
from armsyn.kinematics import SerialChain
from armsyn.planning.features import Regression
from armsyn.planning.generation.variability import Variability
from armsyn.planning.hull import Hull
from armsyn.planning.latent import LatentPredictor
from armsyn.planning.linear import LinearPredictor
from armsyn.planning.movement_time import MovementTime
from armsyn.planning.synergy_atlas import SynergyPredictor
from armsyn.planning.workspace import InverseDistance, LinearField, Nearest, ThinPlate
from armsyn.synergy.phased import PhasedSynergies

CLASSES: Mapping[str, type] = {
    one.__name__: one
    for one in (
        *(LinearPredictor, LatentPredictor, SynergyPredictor),
        *(LinearField, Nearest, InverseDistance, ThinPlate, Regression),
        *(MovementTime, PhasedSynergies, Hull, Variability),
    )
}
"""What a document may be of."""

DIGITS = 6
LARGE = 500
"""Numbers from which on an array is written in 16 bits each."""
_MOST_DIMENSIONS = 4
_STEPS = 32767
_LAYOUT = np.dtype("<i2")


def encoded(model: Any) -> dict[str, Any]:
    """Return a model as plain lists, numbers and dictionaries.

    Parameters
    ----------
    model : instance of one of `CLASSES`

    Returns
    -------
    dict
        With the name of the class under ``class``.
    """
    fields = {
        field.name: getattr(model, field.name)
        for field in dataclasses.fields(model)
        if not isinstance(getattr(model, field.name), SerialChain)
    }
    return {"class": type(model).__name__} | {key: _plain(value) for key, value in fields.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return {"shape": list(value.shape)} | _values(value.ravel())
    if isinstance(value, float):
        return _short(value)
    if dataclasses.is_dataclass(value):
        return encoded(value)
    return value


def _values(values: NDArray[np.float64]) -> dict[str, Any]:
    if values.size < LARGE:
        return {"values": [_short(value) for value in values.tolist()]}
    greatest = _short(float(np.abs(values).max())) or 1.0
    steps = np.clip(np.round(values / greatest * _STEPS), -_STEPS, _STEPS).astype(_LAYOUT)
    return {"greatest": greatest, "steps": base64.b64encode(steps.tobytes()).decode()}


def _short(value: float) -> float | int:
    rounded = float(f"{value:.{DIGITS}g}")
    return int(rounded) if rounded == int(rounded) else rounded


def decoded(document: Any, chain: SerialChain, where: str = "") -> Any:
    """Return the model of a document.

    Parameters
    ----------
    document : dict
        Of `encoded`.
    chain : SerialChain
        For the classes that have one.
    where : str
        The document's place in its file, for errors.

    Returns
    -------
    instance of one of `CLASSES`

    Raises
    ------
    InputError
        No such class, fields that are missing or unknown, or not of their kind; names the place.
    """
    if not isinstance(document, dict) or document.get("class") not in CLASSES:
        raise InputError(f"{where or 'document'}: no model of {', '.join(CLASSES)}")
    kind = CLASSES[document["class"]]
    types = typing.get_type_hints(kind)
    names = {
        field.name for field in dataclasses.fields(kind) if types[field.name] is not SerialChain
    }
    odd = sorted(names ^ (document.keys() - {"class"}))
    if odd:
        state = "missing" if odd[0] in names else "unknown"
        raise InputError(f"{where}: field {odd[0]!r} of {document['class']} is {state}")
    values = {
        name: _decoded(document[name], types[name], chain, f"{where}.{name}".lstrip("."))
        for name in names
    }
    values |= {name: chain for name, of in types.items() if of is SerialChain}
    return kind(**values)


def _decoded(value: Any, kind: Any, chain: SerialChain, where: str) -> Any:
    if kind == NDArray[np.float64]:
        return _array(value, where)
    if kind is float:
        return _number(value, where)
    if kind is int:
        if type(value) is not int:
            raise InputError(f"{where}: expected a whole number, got {_shown(value)}")
        return value
    if kind is str:
        if not isinstance(value, str):
            raise InputError(f"{where}: expected text, got {_shown(value)}")
        return value
    model = decoded(value, chain, where)
    if isinstance(kind, type) and kind in CLASSES.values() and not isinstance(model, kind):
        raise InputError(f"{where}: expected {kind.__name__}, got {type(model).__name__}")
    return model


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(f"{where}: expected a finite number, got {_shown(value)}")
    return float(value)


def _array(value: Any, where: str) -> NDArray[np.float64]:
    large = {"shape", "greatest", "steps"}
    if not isinstance(value, dict) or value.keys() not in ({"shape", "values"}, large):
        raise InputError(f"{where}: expected an array: its shape and its values")
    shape = value["shape"]
    whole = isinstance(shape, list) and all(type(size) is int and size >= 0 for size in shape)
    if not whole or len(shape) > _MOST_DIMENSIONS:
        raise InputError(f"{where}: a shape is up to {_MOST_DIMENSIONS} whole numbers")
    found = _large(value, where) if "steps" in value else _listed(value["values"], where)
    if found.size != math.prod(shape):
        raise InputError(f"{where}: {found.size} values do not fill the shape {shape}")
    return found.reshape(shape)


def _listed(values: Any, where: str) -> NDArray[np.float64]:
    if not isinstance(values, list):
        raise InputError(f"{where}: values are a list, got {_shown(values)}")
    return np.array([_number(one, where) for one in values], dtype=np.float64)


def _large(value: dict[str, Any], where: str) -> NDArray[np.float64]:
    greatest = _number(value["greatest"], f"{where}.greatest")
    try:
        content = base64.b64decode(value["steps"], validate=True)
        steps = np.frombuffer(content, dtype=_LAYOUT)
    except (TypeError, ValueError, binascii.Error) as error:
        raise InputError(f"{where}.steps: no 16-bit numbers in base 64") from error
    return steps.astype(np.float64) * (greatest / _STEPS)


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:37]}..."
