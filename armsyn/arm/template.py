"""A description to be filled in for one's own arm."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from armsyn.arm.calibration import RADIANS_PER_TICK
from armsyn.arm.search import check_name
from armsyn.arm.urdf import read_urdf, read_urdf_file
from armsyn.errors import InputError

_HEAD = """\
# Description of an arm for armsyn. What is marked CHECK is an example's or a guess: put in your
# arm's. Then `armsyn arms show {name}` says what was understood of it, and any slip by its name.
# Units: m, rad, kg, s, V, A. Keep the file as {name}.toml in a folder named `calibration`, or in
# one that $ARMSYN_CALIBRATION or --calibration names.
schema = "armsyn-arm-1"
name = "{name}"              # the file's name without .toml
title = "my own arm"
# What of a captured person it follows: "landmarks", if it is built like a person's arm and can
# hang; "hand", if it stands on a table.
follows = "hand"
# facing = 0.0               # direction it reaches in: angle from x about z
# gravity = [0.0, 0.0, -9.80665]   # in the base's frame, m/s2: otherwise if it hangs or leans

"""

_LANDMARKS = """\
# Which joint's frame is the shoulder, elbow and wrist (leave out what it has not); the hand, last,
# is always the tip.
[landmarks]
{landmarks}hand = "tip"

"""

_TIP = """\
# The hand in the last joint's frame; mass: what it always carries beyond the last link.
[tip]
xyz = [0.10, 0.0, 0.0]       # CHECK
mass = 0.0

"""

_JOINT_WORDS = """\
# One [[joint]] table a joint, from base to tip. xyz and rpy (fixed-axis roll, pitch, yaw): its
# frame in the joint's before, at zero; axis: in its own frame. lower and upper: where it may go;
# rest: where the arm may be let go. max_velocity: 80 % of the servo's no-load speed.
# [joint.link] is what the joint moves as far as the next one, with its servos, for the gravity
# feed-forward and the simulation: weigh it, or leave the table out. [[joint.shape]] capsules (from,
# to, radius; joint's frame) are what it fills; without any a thin one is taken.
"""

_URDF_WORDS = """\
# The chain from base to tip gives joints, limits, tip and masses. The file stands beside this one
# or in a folder below it.
[urdf]
file = {file}
base = {base}
tip = {tip}

"""

_URDF_JOINT_WORDS = """\
# What a URDF cannot say, by the joint's name. rest: where the arm may be let go. max_velocity (the
# URDF's <limit velocity>, if it is not given): 80 % of the servo's no-load speed. Any other key
# (lower, upper, axis, link, shape, ...) changes what the URDF says.
"""

_SERVO_WORDS = """\
# One [[servo]] table a joint, in the same order. zero_tick: Present Position where the joint is at
# zero; direction -1 where it counts against the joint; rest_tick: where it is at rest. `armsyn
# calibrate` finds zero, direction and range of your arm, and lays them over these. drive_mode: what
# the register holds (bit 0 turns the count round). supply_voltage: of this servo.
# A second motor on a joint has a table of its own with shadow_of = ID of the first.
# protocol = 1 for AX, and for MX with firmware 1.0.
"""

_TAIL = """\

# A gripper, if there is one, with its servo: its [[servo]] table has joint = "gripper".
# [gripper]
# open = 1.0                 # angles of its servo, rad
# closed = 0.0
# width_open = 0.07          # between the fingers, m
# width_closed = 0.0
# max_current = 0.3          # to grip with, A; leave out where the servo does not measure it

# What stands around it, in the base's frame: the arm does not go there.
# [[plane]]                  # all that lies behind it is solid
# name = "table"
# point = [0.0, 0.0, 0.0]
# normal = [0.0, 0.0, 1.0]
# [[box]]
# name = "camera"
# centre = [0.3, 0.6, 0.25]
# size = [0.05, 0.10, 0.50]    # edges
# rpy = [0.0, 0.0, 0.0]        # fixed-axis roll, pitch, yaw; may be left out
"""


def build_template(
    name: str,
    urdf: Path | None = None,
    base: str | None = None,
    tip: str | None = None,
    folder: Path | None = None,
) -> str:
    """Return a commented description to be filled in.

    Parameters
    ----------
    name : str
        Of the arm.
    urdf : Path, optional
        File to take joints from; the description belongs beside it.
    base, tip : str, optional
        Its links; by default the root, and the only leaf.
    folder : Path, optional
        Where the description goes, if not beside the URDF: the same folder, or one above.

    Returns
    -------
    str
        TOML that can be loaded as it is.

    Raises
    ------
    DescriptionError, InputError
        A name that is none, or a URDF that cannot be used, or is outside `folder`.
    """
    check_name(name)
    head = _HEAD.format(name=name)
    if urdf is None:
        names = ["shoulder", "elbow"]
        landmarks = _LANDMARKS.format(landmarks='shoulder = "shoulder"\nelbow = "elbow"\n')
        joints = "\n".join(_example(joint, 0.2 * row) for row, joint in enumerate(names))
        top = head + landmarks + _TIP + _JOINT_WORDS + joints
        return top + _servos(zip(names, (0.0, 0.0), strict=True)) + _TAIL
    text = read_urdf_file(urdf)
    found = read_urdf(text, str(urdf), base, tip)
    rests = [_rest(table) for table in found["joint"]]
    source = {"file": _below(folder, urdf), "base": base, "tip": tip}
    words = _URDF_WORDS.format(**{key: _quoted(value) for key, value in source.items()})
    words = "".join(line for line in words.splitlines(keepends=True) if "= None" not in line)
    joints = "\n".join(
        _urdf_joint(table, rest) for table, rest in zip(found["joint"], rests, strict=True)
    )
    names = [table["name"] for table in found["joint"]]
    top = head + words + _LANDMARKS.format(landmarks="") + _URDF_JOINT_WORDS + joints
    return top + _servos(zip(names, rests, strict=True)) + _TAIL


def _below(folder: Path | None, urdf: Path) -> str:
    """What a description calls its URDF: the way from its folder, which must hold that file."""
    if folder is None:
        return urdf.name
    try:
        return urdf.resolve().relative_to(folder.resolve()).as_posix()
    except ValueError:
        raise InputError(
            f"{urdf} is not in {folder}, nor below it, so a description there could not name it:"
            f" copy it into {folder} first, and give that copy"
        ) from None


def _example(name: str, height: float) -> str:
    return f"""\
[[joint]]
name = "{name}"
xyz = [0.0, 0.0, {max(height, 0.1):g}]        # CHECK, as all of this joint
axis = [0.0, 1.0, 0.0]
lower = -1.5
upper = 1.5
rest = 0.0
max_velocity = 3.8
max_acceleration = 15.0

[joint.link]
mass = 0.15
centre_of_mass = [0.0, 0.0, 0.1]
"""


def _urdf_joint(table: dict[str, Any], rest: float) -> str:
    unit = "rad" if table["kind"] == "revolute" else "m"
    weight = f"{table['link']['mass']:.4g} kg" if "link" in table else "no mass in the URDF"
    speed = "max_velocity = 3.8          # CHECK: the URDF gives none"
    if "max_velocity" in table:
        speed = f"# max_velocity = {table['max_velocity']:g}         # as the URDF says"
    return f"""\
[[joint]]                    # {table["lower"]:.4g} to {table["upper"]:.4g} {unit}; {weight}
name = {_quoted(table["name"])}
rest = {rest!r}                   # CHECK
{speed}
max_acceleration = 15.0      # CHECK
"""


def _rest(table: dict[str, Any]) -> float:
    """Zero, or the middle of a range that does not hold it."""
    low, high = table["lower"], table["upper"]
    return 0.0 if low <= 0.0 <= high else round(0.5 * (low + high), 6)


def _servos(joints: Iterable[tuple[str, float]]) -> str:
    tables = (
        f"""\
[[servo]]                    # CHECK all of it
joint = {_quoted(name)}
id = {number}
model = "xm430-w350"
direction = 1
zero_tick = 2048
rest_tick = {2048 + round(rest / RADIANS_PER_TICK)}
drive_mode = 0
supply_voltage = 12.0
"""
        for number, (name, rest) in enumerate(joints, 1)
    )
    return "\n" + _SERVO_WORDS + "\n".join(tables)


def _quoted(text: str | None) -> str:
    """A string of TOML, which takes JSON's."""
    if text is None:
        return "None"
    if not text.isprintable():
        raise InputError(f"{text!r}: this name cannot be written")
    return json.dumps(text, ensure_ascii=False)
