"""How a run must have gone, and how it must have left the arm: judged from outside the driver."""

from __future__ import annotations

import numpy as np
import pytest

from armsyn.driver import ArmSession, Recording
from armsyn.driver.path import straight_way
from armsyn.driver.timing import WATCHDOG_SECONDS
from armsyn.errors import ArmFaultError, FollowingError, PortLostError
from tests.driver.witness import Witness

BRAKING = 0.5
"""Seconds beyond the watchdog's in which an arm has come to rest after any fault."""

LOOK = 0.1
AT_REST = 0.005
"""rad that a joint at rest may move in `LOOK` seconds."""

NEAR_REST = 0.06
"""rad off rest at which an arm may be let go: what parking allows, and rounding."""


def check_recording(witness: Witness, recording: Recording, error: BaseException | None) -> None:
    """The record has every goal that went over the wire, in order, and nothing else."""
    arm = witness.stepped.description
    sent = arm.calibration.to_ticks(recording.sent_rad).tolist()
    rows = [dict(zip(witness.range, row, strict=True)) for row in sent]
    streamed = witness.streamed
    if isinstance(error, PortLostError) and len(streamed) == len(rows) + 1:
        streamed = streamed[:-1]  # the port went away in its midst
    assert streamed == rows
    assert recording.ticks == len(rows)
    assert recording.dropped_rows == 0
    assert np.isfinite(recording.measured_rad).all()
    assert (np.diff(recording.time_s) > 0.0).all()
    if error is not None:
        assert any(event.level == "fault" for event in recording.events)


def check_latch(witness: Witness, session: ArmSession, error: BaseException | None) -> None:
    """After a fault goals stand still, nothing runs, and the arm is at rest within its bound."""
    arm, stepped = witness.stepped.description, witness.stepped
    assert len(witness.after) <= 1
    for goals in witness.after:
        last = witness.streamed[-1]
        moved = {servo_id for servo_id, goal in goals.items() if goal != last[servo_id]}
        joint = error.joint if isinstance(error, FollowingError) else None
        assert moved <= {servo.id for servo in arm.leaders if servo.joint == joint}
    witness.begin("")  # no goal is asked for any more
    with pytest.raises(ArmFaultError, match="ended with a fault"):
        session.run(straight_way(arm.rest, arm.rest, arm, session.rate_hz))
    disturbed = witness.disturbed
    stepped.port.wait_until(stepped.now() + WATCHDOG_SECONDS + BRAKING)
    before = stepped.positions()
    stepped.port.wait_until(stepped.now() + LOOK)
    moved_by = np.abs(stepped.positions() - before)
    assert disturbed or witness.disturbed or moved_by.max() < AT_REST, moved_by
