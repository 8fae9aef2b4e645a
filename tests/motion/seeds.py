"""Small valid files of every format that is read, for tests that damage them."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion import Motion
from armsyn.motion.body import BodyMotion
from armsyn.motion.formats import bvh_write, npz_bodies, parquet_format, trc

FRAMES = 4
ASF = """# a body of two bones
:version 1.10
:name body
:units
  mass 1.0
  length 0.5
  angle deg
:root
  order TX TY TZ RX RY RZ
  axis XYZ
  position 0 0 0
  orientation 0 0 0
:bonedata
  begin
    id 1
    name arm
    direction 1 0 0
    length 10
    axis 0 0 20 XYZ
    dof rx ry rz
    limits (-160.0 20.0)
           (-70.0 70.0)
           (-60.0 70.0)
  end
  begin
    id 2
    name hand
    direction 0 1 0
    length 5
    axis 0 0 0 XYZ
    dof rz tx
  end
:hierarchy
  begin
    root arm
    arm hand
  end
"""
AMC = ":FULLY-SPECIFIED\n:DEGREES\n" + "".join(
    f"{frame}\nroot 0 {frame} 0 0 0 0\narm {frame} 20 30\nhand 5 0.5\n"
    for frame in range(1, FRAMES + 1)
)
TABLE = "t;hand x;hand y;hand z;elbow\n" + "".join(
    f"{frame};{frame}.5;{'' if frame == 2 else 2};3;{frame * 10}\n" for frame in range(FRAMES)
)
COLUMNS = """delimiter = ";"
time = "t"
time_unit = "ms"
length_unit = "cm"
angle_unit = "deg"
up = "y"
[landmarks]
hand = ["hand x", "hand y", "hand z"]
[joints]
elbow = 5
"""
BVH_OF = "HIERARCHY\nROOT hips\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n"
URDF = """<robot name="r"><link name="base"/><link name="upper"/><link name="fore"/>
<joint name="shoulder_lift" type="revolute"><parent link="base"/><child link="upper"/>
<axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/>
<origin xyz="0.3 0 0"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/>
</joint></robot>
"""
LOG = "time,shoulder_lift,elbow\n" + "".join(f"0.{frame},{frame},1\n" for frame in range(FRAMES))


def body() -> BodyMotion:
    """A body of three joints and an end."""
    random = np.random.default_rng(3)
    skeleton = Skeleton(
        ("hips", "arm", "hand", "hand_end"), (-1, 0, 1, 2), random.normal(size=(4, 3))
    )
    rotations = random.normal(size=(FRAMES, 4, 3))
    rotations[:, 3] = 0
    return BodyMotion(np.arange(FRAMES) / 50, skeleton, rotations, rotations[:, 0] + 1)


def markers() -> Motion:
    """Two markers, one with a gap."""
    positions = np.random.default_rng(4).normal(size=(FRAMES, 2, 3))
    positions[1, 0] = np.nan
    return Motion(
        np.arange(FRAMES) / 100,
        landmark_names=("elbow", "hand"),
        landmarks=positions,
        source="markers",
    )


def golf() -> bytes:
    """An archive of quaternions and markers."""
    arrays = {
        "parent": np.array([-1, 0]),
        "marker_label": np.array(["a"]),
        "s|t": np.arange(FRAMES) / 240,
        "s|local_pos": np.random.default_rng(5).normal(size=(FRAMES, 2, 3)),
        "s|quat_xyzw": np.broadcast_to([0.0, 0, 0.6, 0.8], (FRAMES, 2, 4)),
        "s|markers": np.zeros((FRAMES, 1, 3)),
    }
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


def hug_mp() -> bytes:
    """A MATLAB file of one repetition of one task of two motions."""
    from scipy.io import savemat

    cell = np.empty((1, 1), dtype=object)
    inner = np.empty((1, 2), dtype=object)
    inner[0, 0], inner[0, 1] = np.ones((4, FRAMES)), np.zeros((4, FRAMES))
    cell[0, 0] = inner
    stream = io.BytesIO()
    savemat(stream, {"S01": cell}, do_compression=True)
    return stream.getvalue()


@cache
def c3d() -> bytes:
    """A C3D file of two markers, one with a gap, and one angle; written by ezc3d."""
    import ezc3d

    file = ezc3d.c3d()
    parameters = file["parameters"]["POINT"]
    parameters["RATE"]["value"] = [50]
    parameters["LABELS"]["value"] = ("elbow", "hand", "bend")
    file.add_parameter("POINT", "ANGLES", ["bend"])
    file.add_parameter("POINT", "UNITS", ["cm"])
    file.add_parameter("POINT", "Y_SCREEN", ["+Y"])
    points = np.ones((4, 3, FRAMES))
    points[:3] = np.arange(9 * FRAMES).reshape(3, 3, FRAMES)
    points[:3, 0, 1] = np.nan
    file["data"]["points"] = points
    return written(lambda path: file.write(str(path)), ".c3d")


def written(write: Callable[[Path], object], suffix: str) -> bytes:
    """Bytes of a file that a function writes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{suffix}"
        write(path)
        return path.read_bytes()


@cache
def seeds() -> dict[str, bytes]:
    """By name; the suffix of each says its format."""
    return {
        "skeleton.asf": ASF.encode(),
        "a.amc": AMC.encode(),
        "a.bvh": written(lambda path: bvh_write.write(path, body()), ".bvh"),
        "a.c3d": c3d(),
        "a.trc": written(lambda path: trc.write(path, markers()), ".trc"),
        "table.txt": TABLE.encode(),
        "columns.toml": COLUMNS.encode(),
        "a.parquet": written(lambda path: parquet_format.write(path, markers()), ".parquet"),
        "body.npz": written(lambda path: npz_bodies.write(path, body()), ".npz"),
        "golf.npz": golf(),
        "a.mat": hug_mp(),
        "log.csv": LOG.encode(),
        "robot.urdf": URDF.encode(),
    }
