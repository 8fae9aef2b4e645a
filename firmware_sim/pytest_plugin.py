r"""Fixtures for the tests of any project that talks to Dynamixel servos.

Installed with the package: pytest finds them by itself. On a real (pseudo-terminal) port, for
whatever opens one by its path::

    def test_survives_noise(dynamixel_simulator):
        servos = dynamixel_simulator("xm430-w350:1", "xm430-w350:2", baud=1_000_000)
        driver = MyDriver(servos.port)
        servos.inject("crc-error:id=2,probability=0.1")
        driver.move_to(...)
        assert servos.strikes()                     # what struck, and when
        assert "ERROR" not in servos.trace          # every packet, for people to read

In this process and on a clock that moves only by waiting, for code that takes any port: the same
requests give the same bytes, however slow the machine::

    def test_ping(stepped_bus):
        bus = stepped_bus("ax-12a:1", faults=["lost-replies:count=1"])
        ping = b"\xff\xff\x01\x02\x01\xfb"
        assert bus.exchange(ping) == b""            # the fault
        bus.clock.advance(0.5)
        assert bus.exchange(ping) == b"\xff\xff\x01\x02\x00\xfc"

`firmware_sim.testing` says what the fixtures' arguments are, and ``firmware-sim --list-faults``
which faults there are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from firmware_sim.stepped import SteppedPort
    from firmware_sim.testing import RunningSimulator


@pytest.fixture
def dynamixel_simulator() -> Iterator[Callable[..., RunningSimulator]]:
    """Start simulators that end with the test; arguments as of `firmware_sim.testing.simulated`."""
    from firmware_sim.testing import simulated  # noqa: PLC0415 - only tests that use it pay

    with ExitStack() as stack:

        def start(*servos: str, **options: Any) -> RunningSimulator:
            return stack.enter_context(simulated(*servos, **options))

        yield start


@pytest.fixture
def stepped_bus() -> Callable[..., SteppedPort]:
    """Make ports on a stepped clock; arguments as of `firmware_sim.testing.stepped`."""
    from firmware_sim.testing import stepped  # noqa: PLC0415 - only tests that use it pay

    return stepped
