"""Statistics of a LeRobotDataset's features, which training normalises by.

Of every episode those of its own frames; of a dataset, lerobot's own way of putting episodes
together: minimum and maximum, mean and standard deviation (of the population) are exact, quantiles
the means of the episodes' own, weighted by their frames.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
ENVIRONMENT = "observation.environment_state"
"""The target of a frame's episode, by lerobot's name of what is known of an arm's surroundings."""
Stats = dict[str, NDArray[Any]]


def stats_of(columns: Mapping[str, NDArray[Any]]) -> dict[str, Stats]:
    """Return the statistics of the features of one episode.

    Parameters
    ----------
    columns : mapping of str to array, shape (frames,) or (frames, size)
        By feature.

    Returns
    -------
    dict of str to dict of str to array, shape (size,)
        By feature: ``min``, ``max``, ``mean``, ``std``, ``count`` (shape (1,)) and `QUANTILES`.
    """
    parts = [values.reshape(len(values), -1) for values in columns.values()]
    rows = np.concatenate(parts, axis=1, dtype=np.float64)
    quantiles = np.quantile(rows, list(QUANTILES.values()), axis=0)
    found = {
        **{"min": rows.min(axis=0), "max": rows.max(axis=0)},
        **{"mean": rows.mean(axis=0), "std": rows.std(axis=0)},
        **dict(zip(QUANTILES, quantiles, strict=True)),
    }
    ends = np.cumsum([part.shape[1] for part in parts]).tolist()
    spans = [slice(first, last) for first, last in zip([0, *ends], ends, strict=False)]
    return {
        name: {what: values[span] for what, values in found.items()}
        | {"count": np.array([len(rows)])}
        for name, span in zip(columns, spans, strict=True)
    }


class DatasetStats:
    """Statistics of all episodes so far; memory does not grow with them."""

    def __init__(self) -> None:
        self._features: dict[str, Stats] = {}

    def add(self, episode: Mapping[str, Stats]) -> None:
        """Take in an episode's statistics, by feature."""
        for name, stats in episode.items():
            so_far = self._features.get(name)
            self._features[name] = stats if so_far is None else _together(so_far, stats)

    def as_json(self) -> dict[str, dict[str, list[float]]]:
        """Return them by feature and statistic."""
        return {
            name: {what: values.tolist() for what, values in stats.items()}
            for name, stats in self._features.items()
        }


def _together(first: Stats, second: Stats) -> Stats:
    """Statistics of both (Chan, Golub and LeVeque 1983, for the variance)."""
    total = first["count"] + second["count"]
    part = second["count"] / total
    apart = second["mean"] - first["mean"]
    variance = first["std"] ** 2 * (1 - part) + second["std"] ** 2 * part
    return {
        "min": np.minimum(first["min"], second["min"]),
        "max": np.maximum(first["max"], second["max"]),
        "mean": first["mean"] + apart * part,
        "std": np.sqrt(variance + apart**2 * part * (1 - part)),
        "count": total,
        **{name: first[name] * (1 - part) + second[name] * part for name in QUANTILES},
    }
