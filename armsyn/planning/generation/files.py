"""How a batch of reaches is written: one file (or folder) a chunk, in the format that is asked for.

npz holds many reaches in few arrays: ``index`` (of each reach), ``first`` (frame where each
begins, the last where all end), ``angles`` (all frames, one after another), and what is known of
each reach, such as ``evened`` (how much nearer it was brought to minimum jerk so that the hand
speeds up once), ``swivel_m`` (by which the elbow ends elsewhere than predicted) and
``orientation_error_rad`` (NaN where nothing was asked for). CSV is a table with a row a frame. Both
are read by `armsyn.motion.formats`, of which the other formats are, a reach an episode.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np

from armsyn.arm import ArmDescription
from armsyn.errors import InputError, meant
from armsyn.motion import Motion
from armsyn.motion.formats import (
    arm_bvh,
    csv_reaches,
    lerobot_format,
    mcap_format,
    parquet_format,
    write_episodes,
)
from armsyn.motion.formats.episodes import Episode
from armsyn.motion.formats.files import new_folder, replacing
from armsyn.motion.formats.reaches import episode_of, source_of
from armsyn.planning.generation.batch import Batch
from armsyn.planning.pacing import Paced

PLANNED = "planned, not measured: no arm or person moved so"

TASK = "reach to the target"
"""What every reach does, in words, unless it is told otherwise."""

PARTS = ".npz"
"""What a format that needs all reaches at once is gathered from."""


def write_npz(path: Path, batch: Batch, arm: ArmDescription, task: str = TASK) -> None:
    """Write a batch as a numpy archive.

    Parameters
    ----------
    path : Path
        It appears whole or not at all.
    batch : Batch
    arm : ArmDescription
    task : str
        What every reach does, in words.

    Raises
    ------
    InputError
        When it cannot be written.
    """
    paced = batch.paced
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.savez(
            file,
            allow_pickle=False,
            schema=np.array("armsyn-reaches-1"),
            what=np.array(PLANNED),
            arm=np.array(arm.name),
            task=np.array(task),
            joints=np.array(arm.joint_names),
            rate_hz=np.array(paced.rate_hz),
            landmarks=np.array(list(arm.landmarks)),
            landmark_rows=np.array(arm.landmark_frames),
            chain_rotation=arm.chain.arrays.rotation,
            chain_translation=arm.chain.arrays.translation,
            chain_prismatic=arm.chain.arrays.prismatic,
            index=batch.index,
            first=paced.first,
            angles=paced.paths,
            target_m=batch.targets,
            hand_m=batch.hands,
            predicted_time_s=batch.durations,
            time_scale=paced.scales,
            outside_m=batch.outside,
            evened=batch.evened,
            swivel_m=batch.swivels,
            orientation_error_rad=batch.turned,
        )


def read_npz(path: Path) -> Batch:
    """Read what `write_npz` wrote; reasons of changes and refusals are not in it."""
    with np.load(path, allow_pickle=False) as archive:
        paced = Paced(
            archive["angles"], archive["first"], archive["time_scale"], float(archive["rate_hz"])
        )
        return Batch(
            archive["index"],
            archive["target_m"],
            archive["hand_m"],
            archive["predicted_time_s"],
            archive["outside_m"],
            paced,
            archive["evened"],
            archive["swivel_m"],
            archive["orientation_error_rad"],
            changed=(),
            refused=(),
        )


def write_csv(path: Path, batch: Batch, arm: ArmDescription, task: str = TASK) -> None:
    """Write a batch as a table with a row a frame: see `armsyn.motion.formats.csv_reaches`."""
    paced, joints = batch.paced, [f"{name}:angle_rad" for name in arm.joint_names]
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        file.write(f"# {PLANNED}\n# arm: {arm.name}\n# task: {' '.join(task.split())}\n")
        file.write(",".join(["reach", "time_s", *joints, *csv_reaches.TARGET_COLUMNS]) + "\n")
        for row, index in enumerate(batch.index.tolist()):
            target = batch.targets[row].tolist()
            lines = [
                f"{index},{frame / paced.rate_hz:.10g},"
                + ",".join(f"{x:.10g}" for x in (*angles, *target))
                for frame, angles in enumerate(paced.path(row).tolist())
            ]
            file.write("\n".join(lines) + "\n")


def write_bvh(path: Path, batch: Batch, arm: ArmDescription, _task: str = TASK) -> None:
    """Write a folder with the arm's skeleton in a BVH file for every reach."""
    with new_folder(path) as folder:
        for index, episode in zip(batch.index.tolist(), episodes_of(batch, arm), strict=True):
            arm_bvh.write(folder / f"reach-{index:09d}.bvh", episode.motion, arm.chain)


def write_exported(path: Path, batch: Batch, arm: ArmDescription, task: str = TASK) -> None:
    """Write a batch as the episodes of one file; its suffix says the format."""
    write_episodes(path, episodes_of(batch, arm, task))


def episodes_of(batch: Batch, arm: ArmDescription, task: str = TASK) -> Iterator[Episode]:
    """Give the reaches of a batch one by one.

    Parameters
    ----------
    batch : Batch
    arm : ArmDescription
    task : str
        What every reach does, in words. The target is told in numbers: a policy that hears
        language would take a text for every target for as many tasks.

    Yields
    ------
    Episode
        With the arm's landmarks and its target; as facts the arm, the reach's index, and how it
        was changed, if it was.
    """
    rows = list(arm.landmark_frames)
    for row, index in enumerate(batch.index.tolist()):
        angles = batch.paced.path(row)
        x, y, z = batch.targets[row].tolist()
        motion = Motion(
            time=np.arange(len(angles)) / batch.paced.rate_hz,
            joint_names=arm.joint_names,
            angles=angles,
            landmark_names=tuple(arm.landmarks),
            landmarks=arm.chain.positions(angles)[:, rows],
            source=source_of(str(index), arm.name),
        )
        yield episode_of(
            motion,
            str(index),
            arm=arm.name,
            task=task,
            target=(x, y, z),
            evened=batch.evened[row],
            swivel_m=batch.swivels[row],
        )


FORMATS: Mapping[str, tuple[str, Callable[[Path, Batch, ArmDescription, str], None]]] = {
    "npz": (".npz", write_npz),
    "csv": (".csv", write_csv),
    "parquet": (".parquet", write_exported),
    "mcap": (".mcap", write_exported),
    "lerobot": (PARTS, write_npz),
    "bvh": ("", write_bvh),
}
"""Suffix of a chunk, and what writes it. A dataset of lerobot is gathered from parts at the end."""

_PACKAGES: Mapping[str, Callable[[Path], object]] = {
    "parquet": parquet_format.packages,
    "mcap": mcap_format.package,
    "lerobot": lerobot_format.tables_class,
}


def check_packages(name: str, folder: Path) -> None:
    """Refuse a format of `FORMATS` whose packages are missing, before anything is made for it.

    Raises
    ------
    FormatError
        With the name of the extra that has them.
    """
    if name in _PACKAGES:
        _PACKAGES[name](folder)


def checked_format(name: str) -> str:
    """Return the name of a format that is written; InputError for any other."""
    if name not in FORMATS:
        raise InputError(
            f"no format '{name[:40]}'{meant(name, FORMATS)}: use one of {', '.join(FORMATS)}"
        )
    return name
