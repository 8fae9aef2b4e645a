"""How every ending leaves an arm with dual joints, a gripper and servos without a watchdog."""

import numpy as np
import pytest

from armsyn.driver import ArmSession, Ending
from armsyn.driver.path import straight_way
from armsyn.driver.timing import WATCHDOG_SECONDS, WATCHDOG_UNITS
from armsyn.errors import ArmFaultError, HardwareFaultError, LimitError
from armsyn.motion import Motion
from tests.driver.mixed_arm import AX, MX, mixed_arm
from tests.driver.stepped import SteppedArm

ARM = mixed_arm()
GRIPPER = 9
JOINTS = tuple(range(1, 9))
"""IDs of the servos that move joints, shadows among them."""

WATCHED = tuple(i for i in JOINTS if i not in (MX, AX))
RATE = 100.0
CHANGE = np.array([0.5, 0.5, -0.5, 0.4, -0.3, 0.4])
EXPIRED = 255


class Left:
    """How an arm was left."""

    def __init__(self, stepped: SteppedArm) -> None:
        self.torque = dict(zip(stepped.by_id, stepped.torque(), strict=True))
        watched = [i for i, s in stepped.by_id.items() if "Bus Watchdog" in s.model.table.by_name]
        self.watchdog = dict(zip(watched, stepped.value("Bus Watchdog"), strict=True))
        self.goals = dict(zip(stepped.by_id, stepped.value("Goal Position"), strict=True))


@pytest.fixture(params=[0, 1], ids=["gripper limp", "gripper holding"])
def stepped(request: pytest.FixtureRequest) -> SteppedArm:
    arm = SteppedArm(ARM)
    arm.by_id[GRIPPER].write(64, bytes([request.param]))
    return arm


def out(session: ArmSession) -> Motion:
    return straight_way(session.read_posture(), ARM.rest + CHANGE, ARM, RATE)


def back() -> Motion:
    return straight_way(ARM.rest + CHANGE, ARM.rest, ARM, RATE)


def check(
    stepped: SteppedArm, before: Left, torque: int, watchdog: int, joints: tuple[int, ...] = JOINTS
) -> Left:
    """Compare torque and watchdog of the joints; the gripper is as it was."""
    left = Left(stepped)
    assert {left.torque[i] for i in joints} == {torque}
    assert {left.watchdog[i] for i in WATCHED} == {watchdog}
    assert left.torque[GRIPPER] == before.torque[GRIPPER]
    assert left.watchdog[GRIPPER] == before.watchdog[GRIPPER] == 0
    assert left.goals[GRIPPER] == before.goals[GRIPPER]
    return left


def check_goals_stand_still(stepped: SteppedArm, left: Left) -> None:
    """Whatever time passes: the joints come to rest, and no goal moves but to where they stand."""
    stepped.clock.advance(WATCHDOG_SECONDS + 0.5)
    later = Left(stepped)
    here = stepped.positions()
    assert {later.watchdog[i] for i in WATCHED} == {EXPIRED}
    assert later.torque == left.torque
    assert max(abs(later.goals[i] - left.goals[i]) for i in JOINTS) <= 64  # where they were stopped
    assert {i: later.goals[i] for i in (MX, AX)} == {i: left.goals[i] for i in (MX, AX)}
    stepped.clock.advance(1.0)
    assert np.abs(stepped.positions() - here).max() < 0.002
    with pytest.raises(HardwareFaultError, match="armsyn clear"):
        stepped.session(RATE, accept_no_watchdog=True)


@pytest.mark.parametrize("wrong", ["motion", "servo"])
def test_an_error_before_motion_changes_nothing(stepped: SteppedArm, wrong: str) -> None:
    session, before = stepped.session(RATE, accept_no_watchdog=True), Left(stepped)
    way = out(session)
    if wrong == "servo":
        deafen_shadow(stepped)
    else:
        assert way.angles is not None
        angles = way.angles.copy()
        angles[5:] += 0.3
        way = Motion(time=way.time, joint_names=way.joint_names, angles=angles)
    with pytest.raises((LimitError, HardwareFaultError)):
        session.run(way)
    check(stepped, before, torque=0, watchdog=0)
    assert np.abs(stepped.positions() - ARM.rest).max() < 0.01


def deafen_shadow(stepped: SteppedArm) -> None:
    """Let the elbow's second servo overlook that its torque is to come on."""
    servo = stepped.by_id[5]
    original = servo.write

    def write(at: int, data: bytes, **how: bool) -> object:
        return original(at, b"\x00" if at == 64 else data, **how)

    servo.write = write  # type: ignore[assignment, method-assign]


def test_success_holds(stepped: SteppedArm) -> None:
    session, before = stepped.session(RATE, accept_no_watchdog=True), Left(stepped)
    assert session.run(out(session)).ending is Ending.COMPLETED
    check(stepped, before, torque=1, watchdog=0)
    assert np.abs(stepped.positions() - ARM.rest - CHANGE).max() < 0.01


def test_parking_lets_go(stepped: SteppedArm) -> None:
    session, before = stepped.session(RATE, accept_no_watchdog=True), Left(stepped)
    assert session.run(out(session), park=back()).ending is Ending.PARKED
    check(stepped, before, torque=0, watchdog=0)
    assert np.abs(stepped.positions() - ARM.rest).max() < 0.02


def test_the_first_request_parks_and_holds(stepped: SteppedArm) -> None:
    session, before = stepped.session(RATE, accept_no_watchdog=True), Left(stepped)
    stepped.at(0.3, session.stops.request)
    assert session.run(out(session)).ending is Ending.STOPPED_PARKED
    check(stepped, before, torque=1, watchdog=0)
    assert np.abs(stepped.positions() - ARM.rest).max() < 0.02


def test_the_second_request_holds_at_once(stepped: SteppedArm) -> None:
    session, before = stepped.session(RATE, accept_no_watchdog=True), Left(stepped)
    stepped.at(0.3, session.stops.request)
    stepped.at(0.35, session.stops.request)
    assert session.run(out(session)).ending is Ending.ABORTED
    left = check(stepped, before, torque=1, watchdog=WATCHDOG_UNITS)
    check_goals_stand_still(stepped, left)


def test_a_fault_holds_at_once(stepped: SteppedArm) -> None:
    """A shadow has lost its torque: the others hold, its leader too."""
    session, before = stepped.session(RATE, accept_no_watchdog=True), Left(stepped)
    shadow = stepped.by_id[3]
    stepped.at(0.3, lambda: shadow.write(64, b"\x00"))
    with pytest.raises(HardwareFaultError, match=r"servo 3 .* lost its torque") as caught:
        session.run(out(session))
    assert "armsyn clear" in str(caught.value)
    assert f"servo {MX}, {AX} has none" in str(caught.value)
    others = tuple(i for i in JOINTS if i != 3)
    left = check(stepped, before, torque=1, watchdog=WATCHDOG_UNITS, joints=others)
    assert left.torque[3] == 0
    stepped.clock.advance(WATCHDOG_SECONDS + 0.5)
    assert {Left(stepped).torque[i] for i in others} == {1}
    with pytest.raises(ArmFaultError, match="ended with a fault"):
        session.run(back())


def test_a_lost_port_leaves_it_to_the_watchdogs(stepped: SteppedArm) -> None:
    session, before = stepped.session(RATE, accept_no_watchdog=True), Left(stepped)
    stepped.at(0.3, stepped.bus.serial_port.close)
    with pytest.raises(ArmFaultError, match="lost"):
        session.run(out(session))
    left = check(stepped, before, torque=1, watchdog=WATCHDOG_UNITS)
    stepped.bus.reopen()
    check_goals_stand_still(stepped, left)
