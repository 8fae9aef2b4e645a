"""What the tests of public clients need of the clients' own settings."""

import pytest
from dynamixel_sdk import port_handler

LATENCY = 50


@pytest.fixture(autouse=True)
def patient_sdk(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the SDK wait for answers for 100 ms, as behind a slow adapter; 32 ms by default.

    A machine that is busy with other tests may let a process sleep for longer than that.
    """
    monkeypatch.setattr(port_handler, "LATENCY_TIMER", LATENCY)
