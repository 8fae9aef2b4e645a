"""The same tests on simulated and on real arms: ``pytest tests/hil --port PORT [--arm NAME]``.

Without ``--port`` a simulator is started. With it, whatever is on that port is an arm: nothing here
knows or asks whether it is simulated. Any described arm may be named, also one's own (a file in
the folder that ``ARMSYN_CALIBRATION`` names). Servos without a bus watchdog ask for
``--accept-no-watchdog``.

Before: the arm is set up and calibrated (``armsyn status`` has nothing to say), stands near its
rest posture, limp or holding, with room on all sides; somebody has a hand at the supply's switch.

What moves, in this order: the first joint by a third of a radian and back, several times, once
interrupted; the same with the program that moves it killed (``kill -9``), after which the servos'
watchdogs stop the arm, and it is cleared; the last joint by a tenth of a radian and back; the hand
by six centimetres and back; all of it to the rest posture, **where the torque goes off**. If a
test fails, the arm holds: look at it, then ``armsyn clear`` and ``armsyn park``.
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
