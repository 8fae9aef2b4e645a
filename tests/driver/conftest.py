"""Arms for the driver's tests."""

import pytest

from armsyn.arm import ArmDescription, load_arm
from tests.driver.stepped import SteppedArm


@pytest.fixture(scope="session")
def human7() -> ArmDescription:
    return load_arm("human7")


@pytest.fixture
def stepped(human7: ArmDescription) -> SteppedArm:
    """The human-like arm, simulated in this process on a stepped clock."""
    return SteppedArm(human7)
