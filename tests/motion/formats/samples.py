"""Motions of an arm to write: a plan and a recording."""

from __future__ import annotations

import contextlib
import resource
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from armsyn.motion import Motion
from armsyn.motion.formats import Episode

JOINTS = ("shoulder_pan", "shoulder_lift", "elbow_flex")


def motion(number: int = 0, frames: int = 30, rate: float = 50.0) -> Motion:
    """A motion that differs from any of another number."""
    time = np.arange(frames) / rate
    angles = np.sin(3 * time[:, None] + np.arange(3) + 0.1 * number)
    hand = np.stack([0.3 + 0.1 * time, 0.1 * time, 0.0 * time + number], axis=1)
    return Motion(
        time,
        JOINTS,
        angles,
        ("elbow", "hand"),
        np.stack([hand / 2, hand], axis=1),
        f"motion {number}",
    )


def plan(number: int = 0, frames: int = 30) -> Episode:
    """A planned reach."""
    return Episode(
        motion(number, frames), "planned", f"reach target {number % 2}", facts={"seed": "7"}
    )


def aimed(number: int = 0) -> Episode:
    """A planned reach that says where its target is."""
    target = (0.3, -0.1, 0.05 * number)
    return Episode(motion(number), "planned", "reach", facts={"seed": "7"}, target=target)


def recording(number: int = 0, frames: int = 30) -> Episode:
    """A driven reach, whose joints lag behind what they were told."""
    measured = motion(number, frames)
    assert measured.angles is not None
    return Episode(
        measured,
        "recorded",
        commanded=measured.angles + 0.01,
        velocity=np.cos(measured.angles),
        facts={"arm": "koch", "port": "/dev/pts/7", "simulated": "yes"},
    )


def contents(path: Path) -> dict[str, bytes]:
    """Bytes of a file, or of all files of a folder, by name."""
    files = [path] if path.is_file() else sorted(p for p in path.rglob("*") if p.is_file())
    return {str(file.relative_to(path.parent)): file.read_bytes() for file in files}


@contextlib.contextmanager
def full_disk(left: int) -> Iterator[None]:
    """Let no file grow beyond so many bytes, as on a disk with no more left."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (left, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
