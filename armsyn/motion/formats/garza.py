"""The full-body reaches of ``captures/reach/garza`` (npz): the right arm in the chest's frame.

Layout of the file (its README): joint names, parent indices, offsets (m), pre-rotations, and for
each motion its time stamps, exponential maps (rad) and root positions (m). The local rotation of
a joint is its pre-rotation times the exponential of its channel. y is up, the person faces z.
"""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from armsyn.errors import FormatError
from armsyn.kinematics.rotation import from_expmap, from_quaternion_xyzw
from armsyn.motion.motion import FloatArray, Motion

LANDMARK_JOINTS = {
    "shoulder": "JtShoulderRt",
    "elbow": "JtElbowRt",
    "wrist": "JtWristRt",
    "hand": "JtMiddleARt",
}
CHEST = "JtSpineC"
# The capture's axes (x left, y up, z forward) seen from ours (x forward, y left, z up)
_TO_OUR_AXES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])

_DAMAGE = (OSError, ValueError, KeyError, IndexError, EOFError, zipfile.BadZipFile, zlib.error)


def read_garza(path: Path) -> dict[str, Motion]:
    """Read every motion of the file.

    Parameters
    ----------
    path : Path
        The npz file.

    Returns
    -------
    dict of str to Motion
        By the motion's name in the file. Landmarks shoulder, elbow, wrist and hand (the knuckle
        of the middle finger), relative to the shoulder, in the frame of the chest as it stands
        upright in the skeleton's zero pose: x forward, y left, z up, m. So neither the trunk's
        motion nor the clavicle's is in them.

    Raises
    ------
    FormatError
        When the file is not such a file.
    """
    try:
        # Opened here: numpy leaves a damaged file open
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            content = {key: file[key] for key in file.files}
        skeleton = _Skeleton(content)
        names = [str(name) for name in content["motions"]]
        return {name: _motion(skeleton, content, name, path) for name in names}
    except FileNotFoundError:
        raise
    except _DAMAGE as error:
        raise FormatError(f"{path}: not a capture of the garza set: {error}") from error


class _Skeleton:
    """The chain of joints from the root to the right hand, and the chest's branch of it."""

    def __init__(self, content: Mapping[str, Any]) -> None:
        names = [str(name) for name in content["joint"]]
        self.parent = [int(index) for index in content["parent"]]
        self.offset = content["offset"].astype(np.float64)
        self.before = from_quaternion_xyzw(content["prerot_xyzw"])
        self.chest = names.index(CHEST)
        self.landmarks = [names.index(joint) for joint in LANDMARK_JOINTS.values()]
        self.path = self._path_to(self.landmarks[-1])

    def _path_to(self, joint: int) -> list[int]:
        path = [joint]
        while self.parent[path[0]] >= 0:
            path.insert(0, self.parent[path[0]])
            if len(path) > len(self.parent):
                raise ValueError("the joints' parents go round in a circle")
        return path

    def frames(self, expmap: FloatArray) -> tuple[dict[int, FloatArray], dict[int, FloatArray]]:
        """Global positions (root at its offset) and orientations of the joints on the path."""
        count = expmap.shape[0]
        position = {-1: np.zeros((count, 3))}
        orientation = {-1: np.broadcast_to(np.eye(3), (count, 3, 3))}
        for joint in self.path:
            above = self.parent[joint]
            position[joint] = position[above] + orientation[above] @ self.offset[joint]
            turn = self.before[joint] @ from_expmap(expmap[:, joint])
            orientation[joint] = orientation[above] @ turn
        return position, orientation


def _motion(skeleton: _Skeleton, content: Mapping[str, Any], name: str, path: Path) -> Motion:
    expmap = content[f"{name}|expmap"].astype(np.float64)
    position, orientation = skeleton.frames(expmap)
    _, upright = skeleton.frames(np.zeros((1, *expmap.shape[1:])))
    global_points = np.stack([position[joint] for joint in skeleton.landmarks], axis=1)
    from_shoulder = global_points - global_points[:, :1]
    to_chest = orientation[skeleton.chest].transpose(0, 2, 1)
    turn = _TO_OUR_AXES @ upright[skeleton.chest][0] @ to_chest
    return Motion(
        time=content[f"{name}|t"],
        landmark_names=tuple(LANDMARK_JOINTS),
        landmarks=np.einsum("tij,tkj->tki", turn, from_shoulder),
        source=f"{path.name} {name}",
    )
