"""What any arm must do, simulated or real. The tests leave it holding where it was."""

from collections.abc import Iterator

import numpy as np
import pytest

from armsyn.arm import ArmDescription
from armsyn.driver import ArmMonitor, ArmSession, Ending
from armsyn.driver.path import straight_way
from armsyn.driver.servos import ServoGroup
from armsyn.errors import BusRateError, PortError, RefusedMotionError
from armsyn.motion import Motion

RATE = 100.0
MOVED_BY = 0.3
DROOP = 0.05
"""rad that a real arm may be off its goal under its own weight."""


@pytest.fixture
def session(port: str, arm: ArmDescription, consent: bool) -> Iterator[ArmSession]:
    with ArmSession.open(port, arm, RATE, accept_no_watchdog=consent) as opened:
        yield opened


def out_and_back(session: ArmSession) -> tuple[Motion, Motion]:
    here = session.read_posture()
    there = here.copy()
    middle = 0.5 * (session.arm.chain.lower[0] + session.arm.chain.upper[0])
    there[0] += MOVED_BY if here[0] < middle else -MOVED_BY
    return (
        straight_way(here, there, session.arm, RATE),
        straight_way(there, here, session.arm, RATE),
    )


def read(session: ArmSession, register: str) -> set[int]:
    """Values of a register in the servos of all joints, shadows among them; no gripper's."""
    moving = (*session.arm.leaders, *session.arm.shadows)
    return set(ServoGroup(session.bus, moving).read(register).values())


def test_it_goes_there_and_back(session: ArmSession) -> None:
    out, back = out_and_back(session)
    for way in (out, back):
        recording = session.run(way)
        assert recording.ending is Ending.COMPLETED
        assert way.angles is not None
        assert np.abs(session.read_posture() - way.angles[-1]).max() < DROOP
        assert recording.ticks >= way.frames
        assert np.all(np.diff(recording.time_s) > 0.0)
    assert read(session, "Torque Enable") == {1}
    assert read(session, "Bus Watchdog") <= {0}


def test_a_request_to_stop_stops_it(session: ArmSession) -> None:
    out, back = out_and_back(session)

    def on_tick(path_time: float, _: float) -> None:
        if path_time > 0.3 * out.duration and session.stops.count == 0:
            session.stops.request()

    recording = session.run(out, on_tick=on_tick)
    assert recording.ending in (Ending.STOPPED_PARKED, Ending.STOPPED_HOLDING)
    assert recording.events[0][1] == "asked to stop: decelerating"
    assert back.angles is not None
    home = straight_way(session.read_posture(), back.angles[-1], session.arm, RATE)
    assert session.run(home).ending is Ending.COMPLETED


def test_a_wrong_start_moves_nothing(session: ArmSession) -> None:
    _, back = out_and_back(session)
    before = session.read_posture()
    with pytest.raises(RefusedMotionError, match="plan again from where the arm is"):
        session.run(back)
    assert np.abs(session.read_posture() - before).max() < 0.01


def test_a_rate_beyond_the_wire_is_refused(port: str, arm: ArmDescription, consent: bool) -> None:
    with pytest.raises(BusRateError, match="one cycle of"):
        ArmSession.open(port, arm, 5000.0, accept_no_watchdog=consent)


def test_looking_sees_what_a_session_sees(port: str, arm: ArmDescription) -> None:
    with ArmMonitor.open(port, arm) as monitor:
        assert monitor.missing == ()
        seen = monitor.read_posture()
        polled = [monitor.poll(turn) for turn in range(monitor.polls)]
        again = monitor.read_state()
        assert again.fresh.all()
        assert np.abs(again.position - seen).max() < DROOP
        assert np.isfinite(again.temperature).all()
    assert all(health is not None for health in polled)


def test_the_port_is_ours_alone(session: ArmSession, port: str, arm: ArmDescription) -> None:
    assert session.bus.is_open
    with pytest.raises(PortError, match="is taken"):
        ArmSession.open(port, arm, RATE)
