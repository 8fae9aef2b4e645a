"""The arm that inverse kinematics is tested on, and its independent kinematics."""

import pytest

from armsyn.arm import load_arm
from armsyn.kinematics import SerialChain
from tests.kinematics.oracle import Oracle


@pytest.fixture(scope="session")
def human7() -> SerialChain:
    return load_arm("human7").chain


@pytest.fixture(scope="session")
def oracle(human7: SerialChain) -> Oracle:
    return Oracle(human7)
