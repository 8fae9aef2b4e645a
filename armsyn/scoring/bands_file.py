"""Bands as a file: JSON with schema, way of measuring and the hash of the captures."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from armsyn.errors import FormatError
from armsyn.motion.formats.files import check_size, replacing
from armsyn.scoring.bands import PERCENTILES, Band, Bands
from armsyn.scoring.human_likeness import MEASURES, How
from armsyn.scoring.repeats import MeanFloor
from armsyn.scoring.report import FILTER

SCHEMA = "armsyn-bands-1"
LARGEST_FILE = 1 << 20
_SPEED_KEYS = ("p5", "median", "p95")


def bands_as_dict(bands: Bands) -> dict[str, Any]:
    """Return bands as a JSON document.

    Parameters
    ----------
    bands : Bands

    Returns
    -------
    dict
        Units stand in the names.
    """
    return {
        "schema": SCHEMA,
        "captures": bands.captures,
        "reaches": bands.reaches,
        "measured_how": {
            "rate_hz": bands.how.rate,
            "filter": None if bands.how.cutoff is None else FILTER,
            "cutoff_hz": bands.how.cutoff,
            "cut_fraction_of_peak": bands.how.fraction,
            "percentiles": list(PERCENTILES),
        },
        "measures": {
            key: {"median": band.median, "p5": band.low, "p95": band.high, "n": band.n}
            for key, band in bands.measures.items()
        },
        "speed_over_mean_speed": {
            key: np.round(row, 6).tolist()
            for key, row in zip(_SPEED_KEYS, bands.speed, strict=True)
        },
        "human_floor_m": None if bands.floor is None else bands.floor._asdict(),
        "left_out": bands.left_out,
        "inputs_sha256": bands.inputs_sha256,
    }


def save_bands(path: Path, bands: Bands) -> None:
    """Write bands; the file appears whole or not at all.

    Parameters
    ----------
    path : Path
    bands : Bands

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    lines = [
        f"{json.dumps(key)}: {json.dumps(value, allow_nan=False)}"
        for key, value in bands_as_dict(bands).items()
    ]
    text = "{\n" + ",\n".join(lines) + "\n}\n"
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def load_bands(path: Path) -> Bands:
    """Read bands.

    Parameters
    ----------
    path : Path
        As `save_bands` writes it.

    Returns
    -------
    Bands

    Raises
    ------
    FormatError
        When the file is missing, damaged or none of bands.
    """
    check_size(path, LARGEST_FILE)
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        return _bands(document)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        what = f"no {error}" if isinstance(error, KeyError) else str(error)
        raise FormatError(f"{path}: no bands of `armsyn bands`: {what}") from error


def _bands(document: dict[str, Any]) -> Bands:
    if document["schema"] != SCHEMA:
        raise ValueError(f"schema {str(document['schema'])[:40]!r}, expected {SCHEMA!r}")
    how = document["measured_how"]
    cutoff = how["cutoff_hz"]
    speed = np.array([document["speed_over_mean_speed"][key] for key in _SPEED_KEYS], dtype=float)
    if speed.shape != (3, 101) or not np.isfinite(speed).all():
        raise ValueError("speed_over_mean_speed is not 3 rows of 101 numbers")
    measures = {
        key: _band(document["measures"][key]) for key in MEASURES if key in document["measures"]
    }
    if not measures:
        raise ValueError("no measures")
    return Bands(
        captures=str(document["captures"]),
        how=How(
            None if cutoff is None else _number(cutoff, "cutoff_hz"),
            _number(how["cut_fraction_of_peak"], "cut_fraction_of_peak"),
            _number(how["rate_hz"], "rate_hz"),
        ),
        measures=measures,
        speed=speed,
        reaches=int(document["reaches"]),
        floor=_floor(document["human_floor_m"]),
        left_out={str(key): str(why) for key, why in document["left_out"].items()},
        inputs_sha256=str(document["inputs_sha256"]),
    )


def _floor(row: dict[str, Any] | None) -> MeanFloor | None:
    if row is None:
        return None
    values = {key: _number(row[key], key) for key in MeanFloor._fields if key != "reaches"}
    return MeanFloor(reaches=int(row["reaches"]), **values)


def _band(row: dict[str, Any]) -> Band:
    median, low, high = (_number(row[key], key) for key in ("median", "p5", "p95"))
    return Band(median, low, high, int(row["n"]))


def _number(value: object, key: str) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
        raise ValueError(f"{key}: {str(value)[:40]!r} is no number")
    return float(value)
