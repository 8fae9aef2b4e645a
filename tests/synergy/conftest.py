"""Arms and a capture made of known parameters, for the synergy tests."""

import numpy as np
import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.motion import Motion
from armsyn.motion.captures import Capture
from armsyn.synergy import Controller, synergies

S_C = np.array([1.4, 0.7, 1.1, 0.9, 0.6, 1.2, 0.8, 4.0, 8.0])


@pytest.fixture(scope="session")
def human7() -> ArmDescription:
    return load_arm("human7")


@pytest.fixture(scope="session")
def played(human7: ArmDescription) -> Capture:
    """A capture that S_C with the parameters `S_C` explains but for where it ends."""
    target = (0.36, -0.12, -0.12)
    rolled = Controller(human7.chain, "svd", 6.0).synthesize(
        human7.rest, target, synergies("C", 7, S_C), dt=1 / 120, frames=180
    )
    motion = Motion(
        time=rolled.time,
        landmark_names=tuple(human7.landmarks),
        landmarks=rolled.positions[:, list(human7.landmark_frames)],
        source="played",
    )
    return Capture("made:played", "reach", motion, "made here")
