"""The seated reaches of ``captures/reach/hug_mp`` (MATLAB v5): four joint angles of a right arm.

Layout (the captures' README): one variable, ``cell[repetition, task][motion]``, each motion 4 x N
joint angles in degrees at 100 Hz. x forward, y left, z up; at zero the arm hangs;
G = Rx(q1) Ry(q2) R(-z of the humerus, q3), elbow = G (0, 0, -L1),
hand = elbow + G Ry(-q4) (0, 0, -L2), with L1 = 0.30 m and L2 = 0.38 m, which place the mean end
postures on the board of targets.
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import IO

import numpy as np

from armsyn.errors import FormatError
from armsyn.kinematics import Joint, SerialChain
from armsyn.motion.motion import Motion

RATE_HZ = 100.0
UPPER_ARM_M, FOREARM_M = 0.30, 0.38
JOINT_NAMES = ("shoulder_abduction", "shoulder_flexion", "shoulder_rotation", "elbow_flexion")
LANDMARK_NAMES = ("shoulder", "elbow", "hand")
_LANDMARK_ROWS = [0, 3, 4]

CHAIN = SerialChain(
    (
        Joint(JOINT_NAMES[0], axis=(1.0, 0.0, 0.0)),
        Joint(JOINT_NAMES[1], axis=(0.0, 1.0, 0.0)),
        Joint(JOINT_NAMES[2], axis=(0.0, 0.0, -1.0)),
        Joint(JOINT_NAMES[3], xyz=(0.0, 0.0, -UPPER_ARM_M), axis=(0.0, -1.0, 0.0)),
    ),
    tip_xyz=(0.0, 0.0, -FOREARM_M),
)
"""The exoskeleton's arm with the segment lengths of the captures' README."""

Key = tuple[int, int, int]
# A file of MATLAB 7.3 is a NotImplementedError
_DAMAGE = (
    *(OSError, ValueError, TypeError, LookupError, AttributeError, struct.error),
    *(EOFError, NotImplementedError, zlib.error, OverflowError, MemoryError),
    *(SystemError, NameError),  # slips of scipy's on damaged files
)
LARGEST_FILE = 64 * 2**20
LARGEST_INSIDE = 16 * 2**20
"""Bytes of everything in the file once it is inflated; the captures hold 1 MB, and every
small cell among them takes many times its bytes once it is an array."""
_HEADER, _TAG, _COMPRESSED = 128, 8, 15


def read_hug_mp(path: Path) -> dict[Key, Motion]:
    """Read every motion of one subject.

    Parameters
    ----------
    path : Path
        The MATLAB file.

    Returns
    -------
    dict of (repetition, task, motion), each from 1, to Motion
        With joint angles and the landmarks shoulder, elbow and hand, m.

    Raises
    ------
    FormatError
        When the file is not such a file.
    """
    from scipy.io import loadmat  # noqa: PLC0415  heavy, only this format needs it
    from scipy.io.matlab import MatReadError  # noqa: PLC0415

    try:
        with path.open("rb") as file:
            _check_inflated(file, path)
            file.seek(0)
            content = loadmat(file)  # type: ignore[arg-type]  # the stubs know paths only
        (variable,) = [name for name in content if not name.startswith("__")]
        cells = content[variable]
        motions = {
            (repetition + 1, task + 1, index + 1): np.asarray(values, dtype=np.float64)
            for (repetition, task), cell in np.ndenumerate(cells)
            for index, values in enumerate(cell.ravel())
        }
        return {
            key: _motion(np.deg2rad(angles.T), path, key)
            for key, angles in motions.items()
            if angles.size  # a repetition that was not recorded is an empty cell
        }
    except (FileNotFoundError, FormatError):
        raise
    except (MatReadError, *_DAMAGE) as error:
        raise FormatError(f"{path}: not a capture of the HuG-MP set: {error}") from error


def _check_inflated(file: IO[bytes], path: Path) -> None:
    """Add up what the file's compressed parts hold, a little at a time, before any is kept.

    A file of MATLAB 5 is a header, then elements: a tag (type and bytes), then so many bytes
    ("MAT-File Format", MathWorks, chapter 1).
    """
    order = "<" if file.read(_HEADER)[-2:] == b"IM" else ">"
    total = 0
    while len(tag := file.read(_TAG)) == _TAG:
        kind, size = struct.unpack(order + "II", tag)
        element = file.read(min(size, LARGEST_FILE))
        total += len(element)
        inflating = zlib.decompressobj()
        while kind == _COMPRESSED and element:
            total += len(inflating.decompress(element, 2**20))
            element = inflating.unconsumed_tail
            if total > LARGEST_INSIDE:
                break
        if total > LARGEST_INSIDE:
            raise FormatError(f"{path}: holds more than {LARGEST_INSIDE} bytes: cut it")


def _motion(angles: np.ndarray, path: Path, key: Key) -> Motion:
    source = f"{path.name} {key}"
    if angles.ndim != 2 or angles.shape[1] != len(JOINT_NAMES):
        raise ValueError(f"{source}: shape {angles.T.shape}, expected 4 x frames")
    try:
        return Motion(
            time=np.arange(angles.shape[0]) / RATE_HZ,
            joint_names=JOINT_NAMES,
            angles=angles,
            landmark_names=LANDMARK_NAMES,
            landmarks=CHAIN.positions(angles)[:, _LANDMARK_ROWS],
            source=source,
        )
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from error
