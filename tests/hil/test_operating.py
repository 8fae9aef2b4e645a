"""What an operator does with an arm; the last test leaves it at rest, limp."""

from collections.abc import Iterator
from contextlib import closing, suppress

import numpy as np
import pytest

from armsyn.arm import ArmDescription, find_file
from armsyn.driver import ArmSession, Ending, still_posture, straight_way
from armsyn.driver.operate import torque_is_on
from armsyn.driver.operate_move import is_parked, jog, park
from armsyn.driver.servos import ServoGroup
from armsyn.driver.status import read_status
from armsyn.driver.status_findings import find
from armsyn.driver.transactions import Bus
from armsyn.errors import InputError, RefusedMotionError
from armsyn.planning import PlannedReach, SynergyPlanner
from armsyn.synergy import load_library

RATE = 50.0
JOG, SPEED = 0.1, 0.3
"""rad and rad/s of a jog."""

OFF = 0.03
"""rad that a joint may be off where it was jogged to."""

HAND_OFF = 0.015
"""m that the hand may be off its target."""

DISTANCE = 0.06
"""m that the hand reaches."""

DIRECTIONS = [
    np.array([x, y, z]) / np.linalg.norm([x, y, z])
    for z in (1.0, 0.0, -1.0)
    for x in (1.0, -1.0, 0.0)
    for y in (0.0, 1.0, -1.0)
    if (x, y, z) != (0.0, 0.0, 0.0)
]
"""Upwards first."""


@pytest.fixture
def session(port: str, arm: ArmDescription, consent: bool) -> Iterator[ArmSession]:
    with ArmSession.open(port, arm, RATE, accept_no_watchdog=consent) as opened:
        yield opened


def test_status_finds_no_problem(port: str, arm: ArmDescription) -> None:
    with closing(Bus(port, arm.servo[0].baud)) as bus:
        status = read_status(bus, arm)
    assert all(servo.answers for servo in status.servos)
    assert not status.unexpected
    problems = [str(finding) for finding in find(status) if finding.level == "problem"]
    assert not problems
    for servo in status.servos:
        assert servo.voltage == pytest.approx(servo.described.supply_voltage, rel=0.25)
        assert servo.temperature is not None
        assert 0.0 < servo.temperature < 70.0


def test_a_joint_is_jogged_and_back(session: ArmSession) -> None:
    arm = session.arm
    here = still_posture(session)
    middle = 0.5 * (arm.chain.lower[-1] + arm.chain.upper[-1])
    change = JOG if here[-1] < middle else -JOG
    for by in (change, -change):
        before = session.read_posture()
        recording = jog(session, arm.joint_names[-1], by, SPEED)
        assert recording.ending is Ending.COMPLETED
        assert session.read_posture()[-1] - before[-1] == pytest.approx(by, abs=OFF)
        assert np.abs(session.read_posture() - before)[:-1].max() < OFF


def test_a_small_reach_and_back(session: ArmSession) -> None:
    try:
        library = load_library(find_file(session.arm.name, ".synergies.json"))
    except InputError as error:
        pytest.skip(str(error))
    here = still_posture(session)
    planned, target = small_reach(SynergyPlanner(session.arm, library), here)
    assert session.run(planned.trajectory).ending is Ending.COMPLETED
    hand = session.arm.chain.forward(session.read_posture()).tip
    assert np.linalg.norm(hand - target) < HAND_OFF
    back = straight_way(still_posture(session), here, session.arm, RATE)
    assert session.run(back).ending is Ending.COMPLETED


def small_reach(planner: SynergyPlanner, here: np.ndarray) -> tuple[PlannedReach, np.ndarray]:
    """Return the first of many reaches that this arm can make from here, and its target."""
    hand = planner.arm.chain.forward(here).tip
    for direction in DIRECTIONS:
        target = hand + DISTANCE * direction
        with suppress(RefusedMotionError):
            return planner.plan(here, target, RATE), target
    raise AssertionError(f"no reach of {DISTANCE} m from {hand}")


def test_it_is_parked_and_let_go_at_the_end(session: ArmSession) -> None:
    assert park(session).ending is Ending.PARKED
    moving = (*session.arm.leaders, *session.arm.shadows)
    assert not any(torque_is_on(ServoGroup(session.bus, moving)).values())
    assert is_parked(session)
