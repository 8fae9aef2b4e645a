"""The full-body reaches of ``captures/reach/garza`` (npz): the right arm in the chest's frame.

`armsyn.motion.formats.npz_bodies` has the layout of the file. The person faces x there.
"""

from __future__ import annotations

from pathlib import Path

from armsyn.errors import FormatError, InputError
from armsyn.motion.formats.npz_bodies import read_bodies
from armsyn.motion.landmarks import LAYOUTS, arm_of_body
from armsyn.motion.motion import Motion

KIND = "garza, right arm"


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
        bodies = read_bodies(path)
        return {name: arm_of_body(body, *LAYOUTS[KIND]) for name, body in bodies.items()}
    except FormatError:
        raise
    except InputError as error:
        raise FormatError(f"{path}: not a capture of the garza set: {error}") from error
