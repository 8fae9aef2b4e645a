"""Motions of an arm as a LeRobotDataset v3.0, a folder, written with pyarrow (extra ``formats``).

::

    meta/info.json                                version, fps, features, totals
    meta/stats.json                               of every feature, over all frames
    meta/tasks.parquet                            task (text, the pandas index), task_index
    meta/episodes/chunk-000/file-000.parquet      one row an episode: where its frames are
    meta/armsyn.json                              units and kinds: lerobot ignores it
    data/chunk-000/file-000.parquet               one row a frame, one row group an episode

A frame has ``observation.state`` (the measured posture; of a plan the plan) and ``action`` (what
the arm was told; see `ACTIONS`), both with elements ``JOINT.pos``, as lerobot's own robots name
them; ``timestamp`` (s from the episode's first frame: frame_index / fps) and the indices. A plan's
action is the posture of its next frame, the last one's its own: what a loop by position sends when
it sees the state, so that a policy does not learn to stay where it is. Where episodes have targets,
``observation.environment_state`` is theirs in every frame: x, y, z in the base frame, always m. An
episode's row also has its ``armsyn/kind``, ``armsyn/source`` and, as JSON, ``armsyn/facts``, such
as the port that a recording came from. Landmarks and measured velocities have no place here.

Units. lerobot's robots with servos give degrees about the middle of the calibrated range
(``use_degrees``, which its SO-100 and SO-101 arms always do since February 2026) or, as
``koch_follower`` still does unless told, -100 to 100 from one end of that range to the other; the
dataset itself does not say which. Here: ``degrees`` (the default) about the zero of the arm's
description; ``normalised``, -100 to 100 over the ranges given; or ``radians``. Prismatic joints
stay metres but for ``normalised``. A gripper is no joint of a motion.

fps is a whole number, and frames lie at its multiples: a motion sampled otherwise (a recording's
ticks are late by some microseconds, or missed) is interpolated linearly, and ``meta/armsyn.json``
says how many episodes were.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import CaptureError, FormatError
from armsyn.motion.formats.episodes import KINDS, Episode, Episodes, Kind, episodes_of
from armsyn.motion.formats.files import new_folder
from armsyn.motion.formats.lerobot_stats import ENVIRONMENT, DatasetStats, stats_of
from armsyn.motion.motion import FloatArray
from armsyn.motion.resample import interpolate, uniform_times

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.motion.formats.lerobot_tables import Tables

SCHEMA = "armsyn-lerobot-1"
VERSION = "v3.0"
FILE_MB = 100
"""A data file is closed once it is that large, MB."""
FILES_A_CHUNK = 1000
Units = Literal["degrees", "radians", "normalised"]
UNITS: tuple[str, ...] = get_args(Units)
NO_TASK = "move the arm"
"""Task of an episode that names none: policies that hear language need one."""
ACTIONS: dict[Kind, str] = KINDS | {
    "planned": "the plan's posture at the next frame (at the last, its own): nothing was driven"
}
"""What the action of an episode is, by its kind; ``meta/armsyn.json`` says it."""
_ON_TIME_S = 1e-6
_NEAR_WHOLE = 0.01
"""Part of a rate by which it may miss a whole number that is taken for it."""


def write(
    path: Path,
    episodes: Episodes,
    *,
    fps: int | None = None,
    robot_type: str | None = None,
    units: Units = "degrees",
    ranges: Mapping[str, tuple[float, float]] | None = None,
    prismatic: Iterable[str] = (),
) -> None:
    """Write motions as a dataset; see the module for its layout.

    Parameters
    ----------
    path : Path
        The folder to make; it appears whole or not at all.
    episodes : Motion, Episode, or an iterable of them
        With joint angles, all of the same joints. One is held at a time.
    fps : int, optional
        Frames a second; the first episode's rate, if that is near a whole number.
    robot_type : str, optional
        What lerobot calls the robot; the first episode's fact ``arm`` by default.
    units : {"degrees", "radians", "normalised"}
    ranges : mapping of str to (float, float), optional
        The ends of each joint's range, rad or m; for ``normalised``.
    prismatic : iterable of str
        Joints whose values are metres.

    Raises
    ------
    FormatError
        When the package is missing, there is no motion, or one cannot be said in the format.
    InputError
        When the folder is there already or cannot be written.
    """
    tables_of = tables_class(path)
    given = episodes_of(episodes, path)
    with new_folder(path) as folder:
        first = next(given)
        rate = _whole_rate(path, first, fps)
        scale = _Scale(path, first.motion.joint_names, units, ranges, frozenset(prismatic))
        targets = first.target is not None
        tables = tables_of(folder, len(scale.joints), targets, FILE_MB, FILES_A_CHUNK)
        dataset = _Dataset(folder, tables, scale, rate, targets)
        try:
            dataset.add(first)
            for episode in given:
                dataset.add(episode)
        finally:
            tables.close()
        dataset.write_meta(robot_type or first.facts.get("arm"))


def tables_class(path: Path) -> Any:
    """Return what writes the tables; FormatError with the extra's name without its package."""
    try:
        from armsyn.motion.formats.lerobot_tables import Tables  # noqa: PLC0415  an extra
    except ImportError:
        raise FormatError(
            f"{path}: a LeRobotDataset needs the package pyarrow: install it with pip install"
            " 'armsyn[formats]'"
        ) from None
    return Tables


def options_of(arm: ArmDescription) -> dict[str, Any]:
    """Return the options of `write` that follow from an arm: its name, ranges, sliding joints.

    Parameters
    ----------
    arm : ArmDescription

    Returns
    -------
    dict
        ``robot_type``, ``ranges`` and ``prismatic``.
    """
    return {
        "robot_type": arm.name,
        "ranges": {joint.name: (joint.lower, joint.upper) for joint in arm.joint},
        "prismatic": [joint.name for joint in arm.joint if joint.kind == "prismatic"],
    }


def _whole_rate(path: Path, first: Episode, fps: int | None) -> int:
    if fps is not None:
        if not 0 < fps < 1e6 or int(fps) != fps:
            raise FormatError(f"{path}: {fps} frames a second: give a whole number, more than 0")
        return int(fps)
    # The median step: whatever ticks were missed
    rate = first.rate_hz or 1 / float(np.median(np.diff(first.motion.time)))
    whole = round(rate)
    if whole < 1 or abs(rate - whole) > _NEAR_WHOLE * rate:
        raise FormatError(
            f"{path}: a rate of {rate:.6g} Hz is no whole number of frames a second: resample the"
            " motion to one"
        )
    return whole


class _Scale:
    """From radians and metres to the units of the dataset."""

    def __init__(
        self,
        path: Path,
        joints: tuple[str, ...],
        units: str,
        ranges: Mapping[str, tuple[float, float]] | None,
        prismatic: frozenset[str],
    ) -> None:
        if units not in UNITS:
            raise FormatError(f"{path}: units '{units}': give one of {', '.join(UNITS)}")
        for name in joints:
            if "/" in name:
                raise FormatError(
                    f"{path}: a LeRobotDataset takes no '/' in names: rename '{name[:40]}'"
                )
        self.joints = joints
        self.units = {name: "metres" if name in prismatic else units for name in joints}
        self._zero = np.zeros(len(joints))
        self._factor = np.array(
            [1.0 if units == "radians" or name in prismatic else 180 / np.pi for name in joints]
        )
        self.ranges: dict[str, list[float]] | None = None
        if units == "normalised":
            self._normalise(path, ranges)

    def _normalise(self, path: Path, ranges: Mapping[str, tuple[float, float]] | None) -> None:
        missing = [name for name in self.joints if name not in (ranges or {})]
        if ranges is None or missing:
            raise FormatError(
                f"{path}: normalised units need the range of every joint: name the arm"
                f" (no range of '{missing[0]}')"
            )
        ends = np.array([ranges[name] for name in self.joints])
        if not (np.isfinite(ends).all() and (ends[:, 0] < ends[:, 1]).all()):
            raise FormatError(
                f"{path}: a joint's range must be two finite numbers, the lower first"
            )
        self.units = dict.fromkeys(self.joints, "normalised")
        self._zero = ends.mean(axis=1)
        self._factor = 200 / (ends[:, 1] - ends[:, 0])
        self.ranges = {name: list(map(float, ranges[name])) for name in self.joints}

    def __call__(self, values: FloatArray) -> NDArray[np.float32]:
        """Return values in the dataset's units; infinite where single precision ends."""
        with np.errstate(over="ignore"):
            return np.asarray((values - self._zero) * self._factor, dtype=np.float32)


class _Dataset:
    """A dataset as far as it is written."""

    def __init__(
        self, folder: Path, tables: Tables, scale: _Scale, fps: int, targets: bool
    ) -> None:
        self._folder = folder
        self._tables = tables
        self._scale = scale
        self._fps = fps
        self._targets = targets
        self._stats = DatasetStats()
        self._tasks: dict[str, int] = {}
        self._kinds: dict[Kind, int] = {}
        self._interpolated = 0
        self._frames = 0
        self._episodes = 0

    def add(self, episode: Episode) -> None:
        """Write an episode's frames."""
        action, state = self._sampled(episode)
        count = len(state)
        task = episode.task or NO_TASK
        columns: dict[str, NDArray[Any]] = {
            "action": self._scale(action),
            "observation.state": self._scale(state),
            **self._environment(episode, count),
            "timestamp": (np.arange(count) / self._fps).astype(np.float32),
            "frame_index": np.arange(count),
            "episode_index": np.full(count, self._episodes),
            "index": np.arange(self._frames, self._frames + count),
            "task_index": np.full(count, self._tasks.setdefault(task, len(self._tasks))),
        }
        for name, values in columns.items():
            if not np.isfinite(values).all():
                raise FormatError(
                    f"{episode.source or 'motion'}: {name} is too large for single precision"
                )
        stats = stats_of(columns)
        self._tables.add(columns, stats, task, episode)
        self._stats.add(stats)
        self._kinds[episode.kind] = self._kinds.get(episode.kind, 0) + 1
        self._frames += count
        self._episodes += 1

    def _environment(self, episode: Episode, count: int) -> dict[str, NDArray[Any]]:
        """The target of every frame, where this dataset has them."""
        if (episode.target is not None) != self._targets:
            has = "no" if episode.target is None else "a"
            raise FormatError(
                f"{episode.source or 'motion'}: has {has} target, unlike the first motion:"
                " write motions with targets and without apart"
            )
        if episode.target is None:
            return {}
        with np.errstate(over="ignore"):
            return {ENVIRONMENT: np.tile(np.array(episode.target, np.float32), (count, 1))}

    def _sampled(self, episode: Episode) -> tuple[FloatArray, FloatArray]:
        """What was told and what was measured, at multiples of 1 / fps; see `ACTIONS`."""
        time = episode.motion.time
        try:
            at = uniform_times(float(time[0]), float(time[-1]), self._fps)
        except CaptureError as error:
            raise FormatError(f"{episode.source or 'motion'}: {error}") from error
        action, state = episode.action, episode.state
        if at.size != time.size or np.abs(at - time).max() >= _ON_TIME_S:
            self._interpolated += 1
            action, state = interpolate(time, action, at), interpolate(time, state, at)
        if episode.kind == "planned":
            action = np.concatenate([state[1:], state[-1:]])
        return action, state

    def write_meta(self, robot_type: str | None) -> None:
        """Write what is known once all frames are."""
        self._tables.write_tasks(self._tasks)
        names = [f"{joint}.pos" for joint in self._scale.joints]
        vector = {"dtype": "float32", "shape": [len(names)], "names": names}
        place = {"dtype": "float32", "shape": [3], "names": ["x", "y", "z"]}
        single = {"shape": [1], "names": None}
        info = {
            "codebase_version": VERSION,
            "robot_type": robot_type,
            **{"total_episodes": self._episodes, "total_frames": self._frames},
            "total_tasks": len(self._tasks),
            "chunks_size": FILES_A_CHUNK,
            "data_files_size_in_mb": FILE_MB,
            "video_files_size_in_mb": 200,
            "fps": self._fps,
            "splits": {"train": f"0:{self._episodes}"},
            "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
            "video_path": None,
            "features": {
                **{"action": vector, "observation.state": vector},
                **({ENVIRONMENT: place} if self._targets else {}),
                "timestamp": {"dtype": "float32", **single},
                **{name: {"dtype": "int64", **single} for name in self._tables.indices},
            },
        }
        origin = {
            "schema": SCHEMA,
            "units": self._scale.units,
            "ranges": self._scale.ranges,
            "episodes_of_kind": self._kinds,
            "action": {kind: ACTIONS[kind] for kind in self._kinds},
            "interpolated_episodes": self._interpolated,
        }
        for name, document in (
            *(("info", info), ("stats", self._stats.as_json()), ("armsyn", origin)),
        ):
            text = json.dumps(document, indent=4, ensure_ascii=False, allow_nan=False)
            (self._folder / "meta" / f"{name}.json").write_text(text + "\n", encoding="utf-8")
