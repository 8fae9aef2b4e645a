"""Episodes read from a parquet table: see `armsyn.motion.formats.parquet_format` for its columns.

Only the columns that are needed are read, and of a file of many episodes only the row groups that
hold the one that is asked for.
"""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from armsyn.errors import FormatError
from armsyn.motion.formats import csv_format
from armsyn.motion.formats.episodes import KINDS, TARGET, Episode
from armsyn.motion.formats.files import check_size
from armsyn.motion.formats.npz_bodies import chosen
from armsyn.motion.formats.options import Reading, ReadOptions
from armsyn.motion.formats.parquet_format import INDEX, QUANTITIES, RATE, TEXTS, packages
from armsyn.motion.motion import FloatArray, Motion

LARGEST_FILE = 2**30
MOST_VALUES = 32 * 2**20
"""Of one episode."""


def takes(path: Path) -> tuple[str, ...]:
    """Return the indices of the episodes in a file, as texts.

    Raises
    ------
    FormatError
        When it cannot be read.
    """
    with _reading(path) as (pa, pq):
        column = _read(pq, path, [INDEX])[INDEX]
        if not pa.types.is_integer(column.type) or column.null_count:
            raise FormatError(f"{path}: '{INDEX}' holds {column.type}, expected whole numbers")
        return tuple(str(index) for index in sorted(column.unique().to_pylist()))


def read(path: Path, options: ReadOptions) -> Reading:
    """Read the motion of one episode.

    Parameters
    ----------
    path : Path
    options : ReadOptions
        `take` is heard.

    Returns
    -------
    Reading

    Raises
    ------
    FormatError
        As `read_episode`.
    """
    take = chosen(options.take, takes(path), path)
    episode = read_episode(path, take)
    said = {"episode": take, "kind": episode.kind, "task": episode.task}
    facts = {name: value for name, value in said.items() if value}
    return Reading(episode.motion, facts, episode=episode)


def read_episode(path: Path, take: str) -> Episode:
    """Read one episode, with what was commanded and measured beside its motion.

    Parameters
    ----------
    path : Path
    take : str
        Its index; one of `takes`.

    Returns
    -------
    Episode
        Of a table that does not say its kind, `recorded` if something was commanded in it, else
        `motion`.

    Raises
    ------
    FormatError
        When the package is missing, or the file is damaged or of another layout; one line.
    """
    with _reading(path) as (_, pq):
        header = pq.read_schema(path).names
        where = csv_format.find_columns(header, path)
        motion_columns = [where.time, *where.joints.values()]
        motion_columns += [place for three in where.landmarks.values() for place in three]
        wanted = [header[place] for place in motion_columns]
        beside = {
            quantity: [f"{joint}:{quantity}" for joint in where.joints] for quantity in QUANTITIES
        }
        beside = {key: names for key, names in beside.items() if names and set(names) <= {*header}}
        texts = [name for name in TEXTS if name in header]
        more = [name for names in beside.values() for name in names]
        table = _read(pq, path, [*wanted, *more, *texts], int(take))
        if table.num_rows * len(table.column_names) > MOST_VALUES:
            raise FormatError(f"{path}: episode {take} has {table.num_rows} rows: cut the motion")
        rows = _numbers(table, wanted)
        extra = {quantity: _numbers(table, names) for quantity, names in beside.items()}
        said = {name: str(table[name][0]) for name in texts}
    try:
        return _assembled(rows, where, extra, {"source": path.name} | said)
    except FormatError as error:
        raise FormatError(f"{path}: episode {take}: {error}") from error


def _numbers(table: Any, names: list[str]) -> FloatArray:
    return np.column_stack([table[name].to_numpy().astype(np.float64) for name in names])


def _assembled(
    rows: FloatArray, where: csv_format.Columns, extra: dict[str, FloatArray], said: dict[str, str]
) -> Episode:
    joints, landmarks = tuple(where.joints), tuple(where.landmarks)
    end = 1 + len(joints)
    motion = Motion(
        time=rows[:, 0],
        joint_names=joints,
        angles=rows[:, 1:end] if joints else None,
        landmark_names=landmarks,
        landmarks=rows[:, end:].reshape(len(rows), -1, 3) if landmarks else None,
        source=said["source"],
    )
    commanded, velocity = (extra.get(quantity) for quantity in QUANTITIES)
    kind: Any = said.get("kind", "motion" if commanded is None else "recorded")
    if kind not in KINDS:
        raise FormatError(f"kind '{kind[:40]}', expected one of {', '.join(KINDS)}")
    facts = _facts(said.get("facts", "{}"))
    rate, target = _positive(facts.pop(RATE, "")), _target(facts.pop(TARGET, None))
    texts = {name: str(value) for name, value in facts.items()}
    return Episode(motion, kind, said.get("task", ""), commanded, velocity, texts, rate, target)


def _facts(text: str) -> dict[str, Any]:
    try:
        found = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise FormatError("'facts' is no JSON") from error
    if not isinstance(found, dict):
        raise FormatError("'facts' is no JSON object")
    return found


def _target(value: Any) -> tuple[float, float, float] | None:
    if value is None:
        return None
    try:
        x, y, z = map(float, value)
    except (ValueError, TypeError, OverflowError) as error:
        raise FormatError(f"fact '{TARGET}' is not three numbers") from error
    return x, y, z


def _positive(text: Any) -> float | None:
    try:
        value = float(text)
    except (ValueError, TypeError, OverflowError):
        return None
    return value if 0 < value < math.inf else None


def _read(pq: Any, path: Path, columns: list[str], episode: int | None = None) -> Any:
    """Read columns of a file, of one episode or all."""
    check_size(path, LARGEST_FILE)
    where = None if episode is None else [(INDEX, "=", episode)]
    return pq.read_table(path, columns=columns, filters=where, page_checksum_verification=True)


@contextlib.contextmanager
def _reading(path: Path) -> Iterator[tuple[Any, Any]]:
    """Give the package; what it raises on damaged and other files becomes a line of ours."""
    pa, pq = packages(path)
    damage = (ValueError, LookupError, TypeError, ArithmeticError, OSError, RuntimeError)
    try:
        yield pa, pq
    except FormatError:
        raise
    except (pa.ArrowException, MemoryError, *damage) as error:
        said = " ".join(str(error).split())[:160]
        raise FormatError(f"{path}: no parquet table of armsyn, or damaged: {said}") from error
