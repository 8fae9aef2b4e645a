"""Reaches in a chunk of `armsyn generate`, a numpy archive: one is read as ``FILE#INDEX``.

Keys: ``schema`` ("armsyn-reaches-1"), ``joints``, ``rate_hz``, ``index`` (of each reach), ``first``
(frame where each begins, the last where all end) and ``angles`` (all frames, rad or m); what is
said of them (any may be missing): ``arm``, ``task``, ``target_m`` (reaches x 3), ``evened`` and
``swivel_m`` (of each); and, for landmarks: their names (``landmarks``) and the rows of joints and
tip that they are at (``landmark_rows``), and the chain as `armsyn.kernels.chain.ChainArrays` has it
(``chain_rotation``, ``chain_translation``, ``chain_prismatic``).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from armsyn.errors import FormatError
from armsyn.kernels.chain import ChainArrays, positions_along
from armsyn.motion.formats.archive import Archive, opened
from armsyn.motion.formats.npz_bodies import chosen
from armsyn.motion.formats.options import Reading, ReadOptions
from armsyn.motion.formats.reaches import episode_of, reading_of, source_of
from armsyn.motion.motion import Motion

SCHEMA = "armsyn-reaches-1"


def is_reaches(archive: Archive) -> bool:
    """Return whether an archive is a chunk of reaches."""
    return {"schema", "angles", "first"} <= archive.keys and archive.text("schema") == SCHEMA


def takes(archive: Archive) -> tuple[str, ...]:
    """Return the indices of the reaches in it, as texts."""
    return tuple(f"{index:.0f}" for index in archive.numbers("index").ravel())


def read(path: Path, options: ReadOptions) -> Reading:
    """Read one reach.

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
        When it is damaged, or the reach is not in it; the message names some that are.
    """
    with opened(path) as archive:
        there = takes(archive)
        take = chosen(options.take, there, path)
        row, first = there.index(take), archive.numbers("first").ravel()
        rate, angles = archive.numbers("rate_hz").ravel(), archive.numbers("angles")
        joints, chain = archive.names("joints"), _chain(archive)
        names, rows = archive.names("landmarks"), archive.numbers("landmark_rows")
        said = _said(archive, row, len(there))
    if first.size != len(there) + 1 or not (
        rate.size == 1 and rate[0] > 0.0 and 0 <= first[row] < first[row + 1] <= len(angles)
    ):
        raise FormatError(f"{path}: 'first' or 'rate_hz' does not fit the reaches: it is damaged")
    part = angles[int(first[row]) : int(first[row + 1])]
    fits = part.ndim == 2 and part.shape[1] == len(joints) == len(chain.prismatic)
    if not (fits and rows.shape == (len(names),) and {*rows.tolist()} <= {*range(len(joints) + 1)}):
        raise FormatError(f"{path}: joints, chain and landmarks do not fit: it is damaged")
    try:
        motion = Motion(
            np.arange(len(part)) / rate[0],
            joints,
            part,
            names,
            positions_along(chain, part)[:, rows.astype(np.intp)],
            source_of(take, said["arm"]) if said["arm"] else f"{path.name}#{take}",
        )
        return reading_of(episode_of(motion, take, **said))
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from error


def _said(archive: Archive, row: int, count: int) -> dict[str, Any]:
    """Return what is said of one of `count` reaches, by the parameters of `episode_of`."""
    said: dict[str, Any] = {
        key: archive.text(key) if key in archive.keys else "" for key in ("arm", "task")
    }
    for key, shape in (("target_m", (count, 3)), ("evened", (count,)), ("swivel_m", (count,))):
        if key in archive.keys:
            values = archive.numbers(key)
            if values.shape != shape:
                raise FormatError(
                    f"{archive.path}: '{key}' does not fit the reaches: it is damaged"
                )
            said[key] = values[row].tolist()
    target = said.pop("target_m", None)
    return said | {"target": None if target is None else tuple(target)}


def _chain(archive: Archive) -> ChainArrays:
    """Return the arm's chain; its limits are not in the file."""
    rotation, translation = archive.numbers("chain_rotation"), archive.numbers("chain_translation")
    prismatic = archive.flags("chain_prismatic")
    n = prismatic.size
    if (prismatic.shape, rotation.shape, translation.shape) != ((n,), (n + 1, 3, 3), (n + 1, 3)):
        raise FormatError(
            f"{archive.path}: 'chain_rotation' and the like do not fit: it is damaged"
        )
    return ChainArrays(rotation, translation, prismatic, np.zeros(n), np.zeros(n))
