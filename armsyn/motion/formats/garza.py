"""The full-body reaches of ``captures/reach/garza`` (npz): the right arm in the chest's frame.

`armsyn.motion.formats.npz_bodies` has the layout of the file. The person faces x there.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from armsyn.errors import FormatError, InputError
from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion.body import BodyMotion
from armsyn.motion.formats.npz_bodies import read_bodies
from armsyn.motion.motion import Motion

LANDMARK_JOINTS = {
    "shoulder": "JtShoulderRt",
    "elbow": "JtElbowRt",
    "wrist": "JtWristRt",
    "hand": "JtMiddleARt",
}
CHEST = "JtSpineC"


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
    FileNotFoundError
        When there is no such file.
    FormatError
        When the file is not such a file.
    """
    path.stat()
    try:
        return {name: _in_chest_frame(body) for name, body in read_bodies(path).items()}
    except FormatError:
        raise
    except InputError as error:
        raise FormatError(f"{path}: not a capture of the garza set: {error}") from error


def _in_chest_frame(body: BodyMotion) -> Motion:
    path = body.skeleton.path_to(body.skeleton.index(LANDMARK_JOINTS["hand"]))
    arm = _chain(body.skeleton, path)
    found = arm.frames(body.root, body.rotations[:, path])
    upright = arm.frames(np.zeros((1, 3)), np.zeros((1, arm.joints, 3)))
    chest = arm.index(CHEST)
    marks = [arm.index(joint) for joint in LANDMARK_JOINTS.values()]
    from_shoulder = found.positions[:, marks] - found.positions[:, marks[:1]]
    to_chest = found.orientations[:, chest].transpose(0, 2, 1)
    turn = upright.orientations[0, chest] @ to_chest
    return Motion(
        time=body.time,
        landmark_names=tuple(LANDMARK_JOINTS),
        landmarks=np.einsum("tij,tkj->tki", turn, from_shoulder),
        source=body.source,
    )


def _chain(skeleton: Skeleton, path: list[int]) -> Skeleton:
    """Return the joints on a path from the root alone: the other limbs need not be computed."""
    return Skeleton(
        tuple(skeleton.names[joint] for joint in path),
        tuple(range(-1, len(path) - 1)),
        skeleton.offsets[path],
        np.asarray(skeleton.prerotations)[path],
    )
