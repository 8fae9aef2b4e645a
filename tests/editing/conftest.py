"""Motions of our own making, and captured ones with the patterns learned from them."""

from pathlib import Path

import numpy as np
import pytest

from armsyn.editing import MotionModel, learn_model, load_clips
from armsyn.kinematics.rotation import from_expmap
from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion.body import BodyMotion

NAMES = ("root", "left_foot", "chest", "elbow", "hand")


def made_skeleton(scale: float = 1.0) -> Skeleton:
    offsets = np.array([[0, 0, 1], [0, 0.1, -1], [0, 0, 0.4], [0, -0.2, 0], [0.3, 0, 0]]) * scale
    return Skeleton(NAMES, (-1, 0, 0, 2, 3), offsets, from_expmap(0.2 * np.ones((5, 3))))


def made_clip(seed: int, frames: int = 30, skeleton: Skeleton | None = None) -> BodyMotion:
    """Swing all joints smoothly; amplitudes and durations depend on the seed."""
    rng = np.random.default_rng(seed)
    time = np.linspace(0.0, rng.uniform(0.8, 1.2), frames)
    u = (time / time[-1])[:, None]
    bump = np.concatenate([u**2 * (3 - 2 * u), np.sin(np.pi * u), u * (1 - u) ** 2], axis=1)
    turns = np.einsum("fb,bjc->fjc", bump, rng.normal(scale=0.4, size=(3, 5, 3)))
    root = bump @ rng.normal(scale=0.1, size=(3, 3)) + [0, 0, 1]
    return BodyMotion(time, skeleton or made_skeleton(), turns, root, source=f"made {seed}")


@pytest.fixture(scope="session")
def made() -> list[BodyMotion]:
    return [made_clip(seed, frames=20 + 2 * seed) for seed in range(10)]


@pytest.fixture(scope="session")
def made_model(made: list[BodyMotion]) -> MotionModel:
    return learn_model(made, frames=25, variance=1.0)


@pytest.fixture(scope="session")
def reaches(captures: Path) -> list[BodyMotion]:  # noqa: ARG001 - skips where they are absent
    return load_clips("garza")


@pytest.fixture(scope="session")
def reach_model(reaches: list[BodyMotion]) -> MotionModel:
    return learn_model(reaches, frames=50, variance=0.98)
