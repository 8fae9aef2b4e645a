"""The parquet tables of a LeRobotDataset v3.0: see `armsyn.motion.formats.lerobot_format`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from armsyn.motion.formats.episodes import Episode
from armsyn.motion.formats.lerobot_stats import ENVIRONMENT, Stats

EPISODES_AT_ONCE = 100
"""Rows of the table of episodes that are held before they are written."""
_MB = 2**20


class Tables:
    """Data and episodes, each a run of files that are closed at a size.

    Parameters
    ----------
    folder : Path
        Of the dataset.
    joints : int
    targets : bool
        Whether episodes have targets.
    file_mb : int
        A file that has as many MB takes no further episode.
    files_a_chunk : int
        Files in one folder.
    """

    indices = ("frame_index", "episode_index", "index", "task_index")

    def __init__(
        self, folder: Path, joints: int, targets: bool, file_mb: int, files_a_chunk: int
    ) -> None:
        vector = pa.list_(pa.float32(), joints)
        self._schema = pa.schema(
            [("action", vector), ("observation.state", vector)]
            + ([(ENVIRONMENT, pa.list_(pa.float32(), 3))] if targets else [])
            + [("timestamp", pa.float32())]
            + [(name, pa.int64()) for name in self.indices]
        )
        self._folder = folder
        self._data = _Files(folder / "data", file_mb, files_a_chunk)
        self._meta = _Files(folder / "meta" / "episodes", file_mb, files_a_chunk)
        self._rows: list[dict[str, Any]] = []
        self._frames = 0
        self._episodes = 0

    def add(
        self,
        columns: Mapping[str, NDArray[Any]],
        stats: Mapping[str, Stats],
        task: str,
        episode: Episode,
    ) -> None:
        """Write the frames of an episode, and note where they are."""
        count = len(columns["index"])
        table = pa.table(
            [_column(columns[field.name], field.type) for field in self._schema],
            schema=self._schema,
        )
        chunk, file = self._data.write(table)
        self._rows.append(
            {
                "episode_index": self._episodes,
                "tasks": [task],
                "length": count,
                "data/chunk_index": chunk,
                "data/file_index": file,
                "dataset_from_index": self._frames,
                "dataset_to_index": self._frames + count,
                **{
                    f"stats/{name}/{what}": values.tolist()
                    for name, own in stats.items()
                    for what, values in own.items()
                },
                "armsyn/kind": episode.kind,
                "armsyn/source": episode.source,
                "armsyn/facts": json.dumps(episode.all_facts, ensure_ascii=False),
            }
        )
        self._frames += count
        self._episodes += 1
        if len(self._rows) == EPISODES_AT_ONCE:
            self._write_rows()

    def _write_rows(self) -> None:
        if not self._rows:
            return
        chunk, file = self._meta.next()
        where = {"meta/episodes/chunk_index": chunk, "meta/episodes/file_index": file}
        self._meta.write(pa.Table.from_pylist([row | where for row in self._rows]))
        self._rows.clear()

    def close(self) -> None:
        """Write what is held, and close the files; also after a fault."""
        try:
            self._write_rows()
        finally:
            self._meta.close()
            self._data.close()

    def write_tasks(self, tasks: Mapping[str, int]) -> None:
        """Write the table of tasks, whose text pandas takes for its index."""
        table = pa.table(
            {
                "task_index": pa.array(list(tasks.values()), pa.int64()),
                "task": pa.array(list(tasks), pa.string()),
            }
        )
        pandas = {
            "index_columns": ["task"],
            "column_indexes": [],
            "columns": [
                _pandas_column("task_index", "int64", "int64"),
                _pandas_column("task", "unicode", "object"),
            ],
            "pandas_version": "2.0.0",
        }
        table = table.replace_schema_metadata({"pandas": json.dumps(pandas)})
        pq.write_table(table, self._folder / "meta" / "tasks.parquet")


def _pandas_column(name: str, kind: str, numpy_type: str) -> dict[str, str | None]:
    return {
        **{"name": name, "field_name": name, "pandas_type": kind, "numpy_type": numpy_type},
        "metadata": None,
    }


def _column(values: NDArray[Any], kind: pa.DataType) -> pa.Array:
    if values.ndim == 1:
        return pa.array(values, kind)
    flat = pa.array(np.ascontiguousarray(values).reshape(-1), kind.value_type)
    return pa.FixedSizeListArray.from_arrays(flat, type=kind)


class _Files:
    """Tables of one kind, in files of a size, as ``chunk-000/file-000.parquet``."""

    def __init__(self, folder: Path, file_mb: int, files_a_chunk: int) -> None:
        self._folder = folder
        self._most_bytes = file_mb * _MB
        self._files_a_chunk = files_a_chunk
        self._number = 0
        self._writer: pq.ParquetWriter | None = None
        self._path: Path | None = None

    def next(self) -> tuple[int, int]:
        """Chunk and file that the next table goes to."""
        if self._path is not None and self._path.stat().st_size >= self._most_bytes:
            self.close()
            self._number += 1
        return divmod(self._number, self._files_a_chunk)

    def write(self, table: pa.Table) -> tuple[int, int]:
        """Write a table as one row group; return its chunk and file."""
        chunk, file = self.next()
        if self._writer is None:
            self._path = self._folder / f"chunk-{chunk:03d}" / f"file-{file:03d}.parquet"
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._writer = pq.ParquetWriter(self._path, table.schema, compression="snappy")
        self._writer.write_table(table)
        return chunk, file

    def close(self) -> None:
        """Close the file that is open, if one is."""
        writer, self._writer, self._path = self._writer, None, None
        if writer is not None:
            writer.close()
