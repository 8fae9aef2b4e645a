"""Motions as one parquet table, through pyarrow (extra ``formats``).

One row a frame, episodes one after the other. Columns: ``episode_index`` (from 0), ``kind`` (see
`armsyn.motion.formats.episodes.KINDS`), ``task``, ``source``, ``facts`` (a JSON object: the port
that a recording came from, a seed), then those of `armsyn.motion.formats.csv_format` under the
same names and in the same units (``time_s``, ``NAME:angle_rad``, ``NAME:x_m``, ...; NaN is a gap),
and for recordings ``NAME:commanded_rad`` and ``NAME:velocity_rad_s``. Texts are strings, numbers
double precision. Marks of what was filled in are left out.

Files of this layout are read, too: one episode as ``FILE#INDEX``, without what was commanded.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from armsyn.errors import FormatError
from armsyn.motion.formats import csv_format
from armsyn.motion.formats.episodes import Episode, Episodes, episodes_of
from armsyn.motion.formats.files import check_size, replacing
from armsyn.motion.formats.npz_bodies import chosen
from armsyn.motion.formats.options import Reading, ReadOptions
from armsyn.motion.motion import FloatArray, Motion

LARGEST_FILE = 2**30
MOST_VALUES = 32 * 2**20
"""Of one episode that is read."""
ROWS_AT_ONCE = 65_536
"""A row group is written once it has as many."""
_TEXTS = ("kind", "task", "source", "facts")
_INDEX = "episode_index"


def write(path: Path, episodes: Episodes) -> None:
    """Write motions as a table; see the module for its columns.

    Parameters
    ----------
    path : Path
        Of the file; it appears whole or not at all.
    episodes : Motion, Episode, or an iterable of them
        All with the same joints and landmarks. A row group is held at a time.

    Raises
    ------
    FormatError
        When the package is missing, there is no motion, or one has other parts than the first.
    InputError
        When the file cannot be written.
    """
    pa, pq = _packages(path)
    with replacing(path) as temporary, contextlib.ExitStack() as files:
        writer: Any = None
        for group in _row_groups(pa, path, episodes):
            if writer is None:
                writer = files.enter_context(
                    pq.ParquetWriter(temporary, group.schema, write_page_checksum=True)
                )
            writer.write_table(group)


def _row_groups(pa: Any, path: Path, episodes: Episodes) -> Iterator[Any]:
    """Give the table in parts that fit into memory."""
    schema, waiting, rows = None, [], 0
    for number, episode in enumerate(episodes_of(episodes, path)):
        table = pa.table(_columns(number, episode))
        schema = schema or table.schema
        if table.schema != schema:
            raise FormatError(
                f"{path}: episode {number} ({episode.source or 'motion'}) has other columns"
                " than the first: write recordings and other motions, and other landmarks, apart"
            )
        waiting.append(table)
        rows += table.num_rows
        if rows >= ROWS_AT_ONCE:
            yield pa.concat_tables(waiting)
            waiting, rows = [], 0
    if waiting:
        yield pa.concat_tables(waiting)


def _packages(path: Path) -> tuple[Any, Any]:
    try:
        import pyarrow as pa  # noqa: PLC0415  an extra
        import pyarrow.parquet as pq  # noqa: PLC0415
    except ImportError:
        raise FormatError(
            f"{path}: parquet needs the package pyarrow: install it with pip install"
            " 'armsyn[formats]'"
        ) from None
    return pa, pq


def _columns(number: int, episode: Episode) -> dict[str, Any]:
    motion = dataclasses.replace(episode.motion, filled=None)
    said = {
        **{"kind": episode.kind, "task": episode.task, "source": episode.source},
        "facts": json.dumps(dict(episode.facts), ensure_ascii=False),
    }
    rows = csv_format.rows_of(motion)
    columns: dict[str, Any] = {_INDEX: np.full(motion.frames, number)}
    columns |= {name: [text] * motion.frames for name, text in said.items()}
    columns |= dict(zip(csv_format.header_of(motion), rows.T, strict=True))
    for quantity, values in (
        ("commanded_rad", episode.commanded),
        ("velocity_rad_s", episode.velocity),
    ):
        if values is not None:
            names = [f"{name}:{quantity}" for name in motion.joint_names]
            columns |= dict(zip(names, np.asarray(values).T, strict=True))
    return columns


def takes(path: Path) -> tuple[str, ...]:
    """Return the indices of the episodes in a file, as texts.

    Raises
    ------
    FormatError
        When it cannot be read.
    """
    with _reading(path) as (pa, pq):
        column = _read(pq, path, [_INDEX])[_INDEX]
        if not pa.types.is_integer(column.type) or column.null_count:
            raise FormatError(f"{path}: '{_INDEX}' holds {column.type}, expected whole numbers")
        return tuple(str(index) for index in sorted(column.unique().to_pylist()))


def read(path: Path, options: ReadOptions) -> Reading:
    """Read one episode.

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
        When the package is missing, the file is damaged or of another layout, no episode is named
        and there are several, or there is none of that name.
    """
    take = chosen(options.take, takes(path), path)
    with _reading(path) as (_, pq):
        header = pq.read_schema(path).names
        where = csv_format.find_columns(header, path)
        places = [where.time, *where.joints.values()]
        places += [place for three in where.landmarks.values() for place in three]
        wanted = [header[place] for place in places]
        table = _read(pq, path, [*wanted, *(set(_TEXTS) & set(header))], int(take))
        if table.num_rows * len(wanted) > MOST_VALUES:
            raise FormatError(f"{path}: episode {take} has {table.num_rows} rows: cut the motion")
        rows = np.column_stack([table[name].to_numpy().astype(np.float64) for name in wanted])
        texts = {name: str(table[name][0]) for name in _TEXTS if name in table.column_names}
    try:
        motion = _assembled(rows, where, texts.get("source", path.name))
    except FormatError as error:
        raise FormatError(f"{path}: episode {take}: {error}") from error
    said = {name: texts[name] for name in ("kind", "task") if texts.get(name)}
    return Reading(motion, {"episode": take} | said)


def _assembled(rows: FloatArray, where: csv_format.Columns, source: str) -> Motion:
    joints, landmarks = tuple(where.joints), tuple(where.landmarks)
    end = 1 + len(joints)
    return Motion(
        time=rows[:, 0],
        joint_names=joints,
        angles=rows[:, 1:end] if joints else None,
        landmark_names=landmarks,
        landmarks=rows[:, end:].reshape(len(rows), -1, 3) if landmarks else None,
        source=source,
    )


def _read(pq: Any, path: Path, columns: list[str], episode: int | None = None) -> Any:
    """Read columns of a file, of one episode or all."""
    check_size(path, LARGEST_FILE)
    where = None if episode is None else [(_INDEX, "=", episode)]
    return pq.read_table(path, columns=columns, filters=where, page_checksum_verification=True)


@contextlib.contextmanager
def _reading(path: Path) -> Iterator[tuple[Any, Any]]:
    """Give the package; what it raises on damaged and other files becomes a line of ours."""
    pa, pq = _packages(path)
    damage = (ValueError, LookupError, TypeError, ArithmeticError, OSError, RuntimeError)
    try:
        yield pa, pq
    except FormatError:
        raise
    except (pa.ArrowException, MemoryError, *damage) as error:
        said = " ".join(str(error).split())[:160]
        raise FormatError(f"{path}: no parquet table of armsyn, or damaged: {said}") from error
