"""Motions as one parquet table, through pyarrow (extra ``formats``).

One row a frame, episodes one after the other. Columns: ``episode_index`` (from 0), ``kind`` (see
`armsyn.motion.formats.episodes.KINDS`), ``task``, ``source``, ``facts`` (a JSON object: the port
that a recording came from, a seed, the target as three numbers ``target_m``), then those of
`armsyn.motion.formats.csv_format` under the same names and in the same units (``time_s``,
``NAME:angle_rad``, ``NAME:x_m``, ...; NaN is a gap), and for recordings ``NAME:commanded_rad`` and
``NAME:velocity_rad_s``. Texts are strings, numbers double precision. Marks of what was filled in
are left out.

Files of this layout are read, too (`armsyn.motion.formats.parquet_read`): one episode as
``FILE#INDEX``.
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
from armsyn.motion.formats.files import replacing

ROWS_AT_ONCE = 65_536
"""A row group is written once it has as many."""
TEXTS = ("kind", "task", "source", "facts")
INDEX = "episode_index"
QUANTITIES = ("commanded_rad", "velocity_rad_s")
RATE = "rate_hz"
"""Fact that is the rate an episode was asked for."""


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
    pa, pq = packages(path)
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


def packages(path: Path) -> tuple[Any, Any]:
    """Return pyarrow and its parquet module; FormatError with the extra's name without them."""
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
        "facts": json.dumps(_facts(episode), ensure_ascii=False),
    }
    rows = csv_format.rows_of(motion)
    columns: dict[str, Any] = {INDEX: np.full(motion.frames, number)}
    columns |= {name: [text] * motion.frames for name, text in said.items()}
    columns |= dict(zip(csv_format.header_of(motion), rows.T, strict=True))
    for quantity, values in zip(QUANTITIES, (episode.commanded, episode.velocity), strict=True):
        if values is not None:
            names = [f"{name}:{quantity}" for name in motion.joint_names]
            columns |= dict(zip(names, np.asarray(values).T, strict=True))
    return columns


def _facts(episode: Episode) -> dict[str, Any]:
    rate = {} if episode.rate_hz is None else {RATE: repr(float(episode.rate_hz))}
    return episode.all_facts | rate
