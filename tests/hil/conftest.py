"""The same tests on simulated and on real servos: ``pytest tests/hil --port PORT [--arm NAME]``.

Without ``--port`` a simulator is started. With it the arm on that port moves: by a third of a
radian in its first joint, from where it stands, and back. It must stand near its rest posture,
and have room.
"""

from collections.abc import Iterator

import pytest

from armsyn.arm import ArmDescription, load_arm
from firmware_sim.testing import running


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--port", default=None, help="serial port of a real arm (it will move)")
    parser.addoption("--arm", default="human7", help="name of the arm there")
    parser.addoption(
        "--accept-no-watchdog", action="store_true", help="move servos that have none, too"
    )


@pytest.fixture(scope="session")
def arm(request: pytest.FixtureRequest) -> ArmDescription:
    return load_arm(request.config.getoption("--arm", "human7"))


@pytest.fixture(scope="session")
def consent(request: pytest.FixtureRequest) -> bool:
    return bool(request.config.getoption("--accept-no-watchdog", False))


@pytest.fixture(scope="session")
def port(request: pytest.FixtureRequest, arm: ArmDescription) -> Iterator[str]:
    given = request.config.getoption("--port", None)
    if given:
        yield given
        return
    arguments = ("--arm", arm.name, "--baud", str(arm.servo[0].baud), "--return-delay", "0")
    with running(arguments=arguments) as path:
        yield path
