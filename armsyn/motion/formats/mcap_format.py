"""Motions of an arm as a ROS 2 bag in one MCAP file, written through rosbags (extra ``formats``).

Three topics, whose message definitions stand in the file:

- ``/joint_trajectory`` (trajectory_msgs/msg/JointTrajectory): what the arm was told (see
  `armsyn.motion.formats.episodes.KINDS`), one message an episode, stamped with its first frame.
  Points hold positions and ``time_from_start`` only: derived velocities would not be those of
  anything, and a controller refuses a trajectory whose last one is not zero. None for an arm that
  was only observed.
- ``/joint_states`` (sensor_msgs/msg/JointState): one message a frame; of a recording the measured
  angles and velocities, of a plan the plan. ``effort`` is empty: a servo's current is no torque.
- ``/episode`` (std_msgs/msg/String): one message an episode before its first frame: a JSON object
  with its number, ``kind`` (planned, recorded, observed, motion), ``source`` and other facts, such
  as the port that a recording came from.

Joint names are the arm's; positions are radians (metres for prismatic joints), times seconds from
the first frame of the first episode. A header's stamp is the time the message is logged at; a
second parts two episodes. Landmarks have no place here. The same episodes are the same bytes under
the same file name, with the same rosbags: it writes both into the file.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from armsyn.errors import FormatError
from armsyn.motion.formats.episodes import Episode, Episodes, episodes_of
from armsyn.motion.formats.files import folder_beside
from armsyn.motion.motion import FloatArray

TRAJECTORY, STATES, EPISODE = "/joint_trajectory", "/joint_states", "/episode"
BETWEEN_S = 1
"""s; between the last frame of an episode and the first of the next."""
_TYPES = {
    TRAJECTORY: "trajectory_msgs/msg/JointTrajectory",
    STATES: "sensor_msgs/msg/JointState",
    EPISODE: "std_msgs/msg/String",
}
_NANO = 1_000_000_000


def write(path: Path, episodes: Episodes) -> None:
    """Write motions as a bag; see the module for its topics.

    Parameters
    ----------
    path : Path
        Of the file; it appears whole or not at all.
    episodes : Motion, Episode, or an iterable of them
        With joint angles, all of the same joints. One is held at a time.

    Raises
    ------
    FormatError
        When the package is missing, there is no motion, or one cannot be said in the format.
    InputError
        When the file cannot be written.
    """
    try:
        from rosbags.rosbag2 import (  # noqa: PLC0415  an extra
            CompressionFormat,
            CompressionMode,
            StoragePlugin,
            Writer,
        )
    except ImportError:
        raise FormatError(
            f"{path}: MCAP needs the package rosbags: install it with pip install 'armsyn[formats]'"
        ) from None
    with folder_beside(path) as folder:
        bag = Writer(folder / path.stem, version=9, storage_plugin=StoragePlugin.MCAP)
        bag.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        with bag:
            topics = _Topics(bag)
            for episode in episodes_of(episodes, path):
                topics.write(episode)
        (folder / path.stem / f"{path.stem}.mcap").replace(path)


class _Topics:
    """The topics of an open bag, and the time up to which it is written."""

    def __init__(self, bag: Any) -> None:
        from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

        self._store = get_typestore(Stores.ROS2_HUMBLE)
        self._bag = bag
        self._connections = {
            topic: bag.add_connection(topic, kind, typestore=self._store)
            for topic, kind in _TYPES.items()
        }
        self._number = 0
        self._start = 0

    def write(self, episode: Episode) -> None:
        motion, state = episode.motion, episode.state
        since = np.rint((motion.time - motion.time[0]) * _NANO).astype(np.int64)
        said = {"episode": self._number, **episode.description(), "frames": motion.frames}
        self._say(EPISODE, self._start, data=json.dumps(said, ensure_ascii=False))
        names = list(motion.joint_names)
        if episode.kind != "observed":
            points = self._points(episode.action, since)
            self._say(TRAJECTORY, self._start, joint_names=names, points=points)
        nothing = np.empty(0)
        speeds = [nothing] * motion.frames if episode.velocity is None else episode.velocity
        for passed, angles, speed in zip(since.tolist(), state, speeds, strict=True):
            self._say(
                STATES,
                self._start + passed,
                name=names,
                position=angles,
                velocity=nothing if np.isnan(speed).any() else speed,
                effort=nothing,
            )
        self._number += 1
        self._start += int(since[-1]) + BETWEEN_S * _NANO

    def _points(self, positions: FloatArray, since: Any) -> list[Any]:
        types = self._store.types
        point = types["trajectory_msgs/msg/JointTrajectoryPoint"]
        duration = types["builtin_interfaces/msg/Duration"]
        nothing = np.empty(0)
        return [
            point(row, nothing, nothing, nothing, duration(*divmod(passed, _NANO)))
            for row, passed in zip(positions, since.tolist(), strict=True)
        ]

    def _say(self, topic: str, nanoseconds: int, **fields: Any) -> None:
        types, kind = self._store.types, _TYPES[topic]
        if topic != EPISODE:
            time = types["builtin_interfaces/msg/Time"](*divmod(nanoseconds, _NANO))
            fields["header"] = types["std_msgs/msg/Header"](stamp=time, frame_id="")
        raw = self._store.serialize_cdr(types[kind](**fields), kind)
        self._bag.write(self._connections[topic], nanoseconds, raw)
