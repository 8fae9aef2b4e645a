"""Motions of an arm as a ROS 2 bag in one MCAP file, written through rosbags (extra ``formats``).

Three topics, whose message definitions stand in the file:

- ``/joint_trajectory`` (trajectory_msgs/msg/JointTrajectory): what the arm was told (see
  `armsyn.motion.formats.episodes.KINDS`), one message an episode, stamped with its first frame.
  Points hold positions and ``time_from_start``, those of a plan velocities, too: central
  differences, and 0 at both ends, where a plan is at rest (joint_trajectory_controller refuses a
  trajectory whose last velocity is not 0, and interpolates linearly without any). Of recordings and
  other motions none: derived velocities were never commanded. None at all for an arm that was only
  observed.
- ``/joint_states`` (sensor_msgs/msg/JointState): one message a frame; of a recording the measured
  angles and, where all are known, velocities; of a plan its angles, and the ``frame_id`` of the
  header is "planned, not measured", empty otherwise. ``effort`` is empty: a servo's current is no
  torque.
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
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import FormatError
from armsyn.motion.formats.episodes import Episode, Episodes, episodes_of
from armsyn.motion.formats.files import folder_beside
from armsyn.motion.motion import FloatArray

TRAJECTORY, STATES, EPISODE = "/joint_trajectory", "/joint_states", "/episode"
BETWEEN_S = 1
"""s; between the last frame of an episode and the first of the next."""
LONGEST_S = 2**31 - 1
"""s; a header's seconds are a signed 32-bit number."""
_TYPES = {
    TRAJECTORY: "trajectory_msgs/msg/JointTrajectory",
    STATES: "sensor_msgs/msg/JointState",
    EPISODE: "std_msgs/msg/String",
}
_NANO = 1_000_000_000
_NOTHING = np.empty(0)
PLANNED_FRAME = "planned, not measured"
"""Header's frame of a plan's states: joints have none, and the topic alone would say measured."""
_STAMP = slice(4, 12)
"""Of a message with a header: seconds and nanoseconds, after four bytes that say the encoding."""


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
    rosbag2 = package(path)
    with folder_beside(path) as folder:
        plugin = rosbag2.StoragePlugin.MCAP
        bag = rosbag2.Writer(folder / path.stem, version=9, storage_plugin=plugin)
        bag.set_compression(rosbag2.CompressionMode.STORAGE, rosbag2.CompressionFormat.ZSTD)
        with bag:
            topics = _Topics(bag)
            for episode in episodes_of(episodes, path):
                topics.write(episode)
        (folder / path.stem / f"{path.stem}.mcap").replace(path)


def package(path: Path) -> Any:
    """Return rosbags' module of bags; FormatError with the extra's name without it."""
    try:
        import rosbags.rosbag2  # noqa: PLC0415  an extra
    except ImportError:
        raise FormatError(
            f"{path}: MCAP needs the package rosbags: install it with pip install 'armsyn[formats]'"
        ) from None
    return rosbags.rosbag2


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
        """Write one episode after those before."""
        motion = episode.motion
        if self._start / _NANO + motion.duration > LONGEST_S:
            raise FormatError(
                f"{episode.source or 'motion'}: ends {motion.duration:g} s after it begins: ROS 2's"
                f" stamps hold {LONGEST_S} s in one file"
            )
        since = np.rint((motion.time - motion.time[0]) * _NANO).astype(np.int64)
        said = {"episode": self._number, **episode.description(), "frames": motion.frames}
        text = self._serialised(EPISODE, data=json.dumps(said, ensure_ascii=False))
        self._say(EPISODE, self._start, text)
        if episode.kind != "observed":
            self._say(TRAJECTORY, self._start, self._trajectory(episode, since))
        times = self._start + since
        for at, raw in zip(times.tolist(), self._states(episode, times), strict=True):
            self._say(STATES, at, raw)
        self._number += 1
        self._start = int(times[-1]) + BETWEEN_S * _NANO

    def _trajectory(self, episode: Episode, since: NDArray[np.int64]) -> bytes:
        types = self._store.types
        point = types["trajectory_msgs/msg/JointTrajectoryPoint"]
        duration = types["builtin_interfaces/msg/Duration"]
        points = [
            point(row, speed, _NOTHING, _NOTHING, duration(*divmod(passed, _NANO)))
            for row, speed, passed in zip(
                episode.action, _velocities(episode), since.tolist(), strict=True
            )
        ]
        names = list(episode.motion.joint_names)
        return self._serialised(TRAJECTORY, self._start, joint_names=names, points=points)

    def _states(self, episode: Episode, times: NDArray[np.int64]) -> Iterator[bytes]:
        """Give the message of every frame.

        Those of an episode differ in stamp and numbers only: one is serialised, twice, which shows
        where those stand, and the others are made of it.
        """
        state, names = episode.state, list(episode.motion.joint_names)
        speed = episode.velocity
        if speed is None or not np.isfinite(speed).all():
            speed = np.empty((len(state), 0))
        numbers = np.concatenate([state, speed], axis=1)
        first, second = (
            self._serialised(
                STATES,
                0,
                PLANNED_FRAME if episode.kind == "planned" else "",
                name=names,
                position=np.full(state.shape[1], one),
                velocity=np.full(speed.shape[1], one),
                effort=_NOTHING,
            )
            for one in (1.0, -1.0)
        )
        message = np.tile(np.frombuffer(first, np.uint8), (len(state), 1))
        differ = np.flatnonzero(message[0] != np.frombuffer(second, np.uint8))
        places = (differ - 7)[:, None] + np.arange(8)  # the sign is in the last byte of a double
        message[:, places.ravel()] = numbers.astype("<f8").view(np.uint8)
        stamps = np.stack(np.divmod(times, _NANO), axis=1).astype("<u4")
        message[:, _STAMP] = stamps.view(np.uint8)
        return (row.tobytes() for row in message)

    def _serialised(
        self, topic: str, nanoseconds: int | None = None, frame: str = "", **fields: Any
    ) -> bytes:
        types, kind = self._store.types, _TYPES[topic]
        if nanoseconds is not None:
            time = types["builtin_interfaces/msg/Time"](*divmod(nanoseconds, _NANO))
            fields["header"] = types["std_msgs/msg/Header"](stamp=time, frame_id=frame)
        return bytes(self._store.serialize_cdr(types[kind](**fields), kind))

    def _say(self, topic: str, nanoseconds: int, raw: bytes) -> None:
        self._bag.write(self._connections[topic], nanoseconds, raw)


def _velocities(episode: Episode) -> FloatArray:
    """Of every point, shape (frames, joints), rad/s; of what was not planned (frames, 0)."""
    time = episode.motion.time
    if episode.kind != "planned":
        return np.empty((time.size, 0))
    found = np.zeros_like(episode.action)
    if time.size > 2:
        found[1:-1] = np.gradient(episode.action, time, axis=0)[1:-1]
    return found
