"""Motions that a function makes as it goes, on the stepped clock."""

import threading

import numpy as np
import pytest

from armsyn.arm import ArmDescription
from armsyn.arm.calibration import RADIANS_PER_TICK as TICK
from armsyn.driver import Ending, Recording
from armsyn.driver.course import Coast
from armsyn.driver.joints import JointState
from armsyn.driver.path import minimum_jerk, straight_way
from armsyn.driver.setpoint_thread import PATIENCE, Setpoint
from armsyn.driver.timing import WATCHDOG_SECONDS, WATCHDOG_UNITS
from armsyn.errors import (
    ArmFaultError,
    CommandFaultError,
    FollowingError,
    InputError,
    LimitError,
    SetpointError,
)
from tests.driver.stepped import SteppedArm

ON, OFF = [1] * 7, [0] * 7
ARMED, DISARMED = [WATCHDOG_UNITS] * 7, [0] * 7
ELBOW = 3


def circle(arm: ArmDescription, size: float = 0.3, turns_per_second: float = 0.25) -> Setpoint:
    """Elbow and wrist go to and fro, from rest."""

    def wanted(t: float, _: JointState) -> np.ndarray:
        angle = 2.0 * np.pi * turns_per_second * t
        posture = arm.rest.copy()
        posture[ELBOW] += size * (1.0 - np.cos(angle)) * minimum_jerk(t)
        return posture

    return wanted


def test_a_function_of_time_is_followed(stepped: SteppedArm) -> None:
    wanted = circle(stepped.description)

    def finite(t: float, state: JointState) -> np.ndarray | None:
        return None if t > 4.0 else wanted(t, state)

    recording = stepped.session().run_setpoint(finite, 10.0)
    assert recording.ending is Ending.COMPLETED
    assert recording.command_success_rate == 1.0
    t = recording.time_s[200:700]
    by_hand = 0.3 * (1.0 - np.cos(0.5 * np.pi * (t + 0.005)))
    elbow = recording.commanded_rad[200:700, ELBOW] - stepped.description.rest[ELBOW]
    assert elbow == pytest.approx(by_hand, abs=0.003)
    assert stepped.torque() == ON
    assert stepped.value("Bus Watchdog") == DISARMED


def test_it_comes_to_rest_when_time_is_over(stepped: SteppedArm) -> None:
    recording = stepped.session().run_setpoint(circle(stepped.description), 1.5)
    assert recording.ending is Ending.COMPLETED
    speeds_fade(recording, stepped.description)
    assert np.abs(stepped.positions() - recording.commanded_rad[-1]).max() < 0.005


def test_the_state_is_what_was_measured_last(stepped: SteppedArm) -> None:
    seen: list[JointState] = []

    def wanted(t: float, state: JointState) -> np.ndarray | None:
        seen.append(state)
        return None if t > 0.5 else circle(stepped.description)(t, state)

    recording = stepped.session().run_setpoint(wanted, 10.0)
    assert len({id(state.position) for state in seen}) == len(seen)  # arrays of their own
    measured = np.array([state.position for state in seen[2:]])
    assert np.array_equal(measured, recording.measured_rad[: len(measured)])


def test_a_policy_may_follow_what_it_sees(stepped: SteppedArm) -> None:
    far = stepped.description.rest[ELBOW] + 0.3
    wanted = circle(stepped.description)

    def policy(t: float, state: JointState) -> np.ndarray | None:
        return None if state.position[ELBOW] > far else wanted(t, state)

    recording = stepped.session().run_setpoint(policy, 8.0)
    assert recording.ending is Ending.COMPLETED
    seen = recording.measured_rad[:, ELBOW]
    first = int(np.argmax(seen > far))
    assert recording.time_s[first] < 2.0
    speeds_fade(recording, stepped.description)
    assert far < seen[-1] < far + 0.15


def test_a_request_to_stop_decelerates(stepped: SteppedArm) -> None:
    session = stepped.session()
    stepped.at(1.5, session.stops.request)
    recording = session.run_setpoint(circle(stepped.description), 60.0)
    assert recording.ending is Ending.STOPPED_PARKED
    assert stepped.positions() == pytest.approx(stepped.description.rest, abs=0.005)


@pytest.mark.fault(21)
def test_a_setpoint_beyond_a_servos_own_limit_is_a_fault(stepped: SteppedArm) -> None:
    """Sync write would tell nobody that the servo does not take it; stopping keeps the limit."""
    elbow, arm = stepped.servos[ELBOW], stepped.description
    limit = int(arm.calibration.to_ticks(arm.rest + 0.2)[ELBOW])
    upwards = limit > elbow.memory.value("Present Position")
    elbow.memory.store("Max Position Limit" if upwards else "Min Position Limit", limit)
    with pytest.raises(CommandFaultError, match=r"elbow_flexion: the command .* outside its limit"):
        stepped.session().run_setpoint(circle(arm), 3.0)
    assert abs(elbow.memory.value("Goal Position") - limit) < 20  # one tick of the stream
    assert stepped.torque() == ON


@pytest.mark.fault(21)
@pytest.mark.parametrize("odd", [0, 1], ids=["even limit", "odd limit"])
def test_a_stop_comes_to_rest_within_a_servos_own_limit(stepped: SteppedArm, odd: int) -> None:
    elbow, arm = stepped.servos[ELBOW], stepped.description
    limit = int(arm.calibration.to_ticks(arm.rest + 0.2)[ELBOW]) // 2 * 2 + odd
    upwards = limit > elbow.memory.value("Present Position")
    elbow.memory.store("Max Position Limit" if upwards else "Min Position Limit", limit)
    near = arm.rest[ELBOW] + 0.19
    wanted = circle(arm)

    def ends(t: float, state: JointState) -> np.ndarray | None:
        posture = wanted(t, state)
        return None if posture[ELBOW] > near else posture

    recording = stepped.session().run_setpoint(ends, 3.0)
    assert recording.ending is Ending.COMPLETED
    assert near - 0.02 < recording.commanded_rad[-1, ELBOW] <= arm.rest[ELBOW] + 0.2 + TICK
    # it coasts to its limit, and the servo takes that: one beyond it would keep the goal before
    assert elbow.memory.value("Goal Position") == limit
    assert arm.calibration.to_ticks(recording.sent_rad[-1])[ELBOW] == limit


@pytest.mark.fault(21)
@pytest.mark.parametrize("odd", [0, 1], ids=["even limit", "odd limit"])
def test_a_joint_that_is_pushed_beyond_a_servos_own_limit_is_held_at_it(
    stepped: SteppedArm, odd: int
) -> None:
    elbow, arm = stepped.servos[ELBOW], stepped.description
    here = elbow.memory.value("Present Position")
    limit = int(arm.calibration.to_ticks(arm.rest + 0.2)[ELBOW]) // 2 * 2 + odd
    upwards = limit > here
    elbow.memory.store("Max Position Limit" if upwards else "Min Position Limit", limit)
    goal = arm.rest.copy()
    goal[ELBOW] += 0.15
    goal[0] += 0.6
    push = f"push:torque={-30 if upwards else 30},id=4,for=2"
    stepped.at(1.6, lambda: stepped.port.simulation.inject(push))
    with pytest.raises(FollowingError, match="elbow_flexion"):
        stepped.session().run(straight_way(arm.rest, goal, arm.slowed(4.0), 200.0))
    assert elbow.memory.value("Goal Position") == limit


def speeds_fade(recording: Recording, arm: ArmDescription) -> None:
    speed = np.diff(recording.commanded_rad, axis=0) * 200.0
    assert np.abs(speed[-20:]).max() < 1e-9
    acceleration = np.abs(np.diff(speed, axis=0) * 200.0).max(axis=0)
    assert (acceleration <= 1.05 * arm.max_acceleration).all()


@pytest.mark.fault(27)
def test_a_stall_is_followed_by_a_start_from_rest(stepped: SteppedArm) -> None:
    stepped.at(1.5, lambda: stepped.clock.advance(0.1))
    recording = stepped.session().run_setpoint(circle(stepped.description), 3.0)
    assert recording.ending is Ending.COMPLETED
    assert recording.missed_ticks in (19, 20)
    assert any("starting from rest again" in event.text for event in recording.events)
    stall = int(np.argmax(np.diff(recording.time_s)))
    commands = recording.commanded_rad[stall:]
    assert np.abs(commands[1] - commands[0]).max() < 1e-4  # not where it would be by now
    acceleration = np.diff(commands, 2, axis=0) * 200.0**2
    assert (np.abs(acceleration).max(axis=0) <= stepped.description.max_acceleration).all()


@pytest.mark.parametrize("stop_at", [1.5, 1.4], ids=["with the stall", "before it"])
def test_a_stop_with_a_stall_stays_where_the_arm_stands(
    stepped: SteppedArm, stop_at: float
) -> None:
    session = stepped.session()
    stepped.at(stop_at, session.stops.request)
    stepped.at(1.5, lambda: stepped.clock.advance(0.1))
    recording = session.run_setpoint(circle(stepped.description), 3.0)
    assert recording.ending in (Ending.STOPPED_PARKED, Ending.STOPPED_HOLDING)
    stall = int(np.argmax(np.diff(recording.time_s)))
    commands = recording.commanded_rad[stall:]
    assert np.abs(commands[1:20] - commands[0]).max() < 1e-12


@pytest.mark.parametrize(
    ("first", "kind", "said"),
    [
        (lambda arm: arm.rest + 0.2, LimitError, "the setpoints start at"),
        (lambda arm: arm.rest * np.nan, InputError, "is not finite"),
        (lambda _: None, InputError, "finished before it begins"),
        (lambda arm: arm.rest[:3], SetpointError, "7 joints: give one angle each"),
        (lambda _: "there", SetpointError, "is no posture"),
    ],
)
def test_what_must_not_begin_is_refused_before_torque(
    stepped: SteppedArm, first: object, kind: type[Exception], said: str
) -> None:
    session = stepped.session()
    with pytest.raises(kind, match=said):
        session.run_setpoint(lambda *_: first(stepped.description), 5.0)  # type: ignore[operator]
    assert stepped.torque() == OFF
    assert session.fault is None
    assert session.recording is None


@pytest.mark.parametrize("longest", [0.0, -1.0, float("nan"), float("inf")])
def test_a_duration_that_is_none_is_refused(stepped: SteppedArm, longest: float) -> None:
    with pytest.raises(InputError, match="longest duration"):
        stepped.session().run_setpoint(circle(stepped.description), longest)


@pytest.mark.fault(30)
@pytest.mark.parametrize("wrong", [np.nan, 0.3, np.inf], ids=["nan", "jump", "inf"])
def test_a_setpoint_that_must_not_be_sent_is_a_fault(stepped: SteppedArm, wrong: float) -> None:
    good = circle(stepped.description)

    def wanted(t: float, state: JointState) -> np.ndarray:
        return good(t, state) + (wrong if t > 1.2 else 0.0)

    session = stepped.session()
    with pytest.raises(CommandFaultError):
        session.run_setpoint(wanted, 5.0)
    held_with_watchdog(stepped, session.recording)


def held_with_watchdog(stepped: SteppedArm, recording: Recording | None) -> None:
    assert recording is not None
    assert recording.ending is Ending.FAULT
    last = stepped.description.calibration.to_ticks(recording.sent_rad[-1])
    assert stepped.value("Goal Position") == last.tolist()
    assert stepped.torque() == ON
    assert stepped.value("Bus Watchdog") == ARMED


def test_an_exception_of_the_function_is_raised_and_the_arm_held(stepped: SteppedArm) -> None:
    good = circle(stepped.description)

    def wanted(t: float, state: JointState) -> np.ndarray:
        if t > 1.2:
            raise KeyError("theirs")
        return good(t, state)

    session = stepped.session()
    with pytest.raises(KeyError) as caught:
        session.run_setpoint(wanted, 5.0)
    assert "holding, watchdog armed" in caught.value.__notes__[0]
    assert session.fault is caught.value
    held_with_watchdog(stepped, session.recording)
    with pytest.raises(ArmFaultError, match="ended with a fault"):
        session.run_setpoint(good, 5.0)


def test_a_function_that_never_returns_is_a_fault_with_the_arm_held(stepped: SteppedArm) -> None:
    good, forever = circle(stepped.description), threading.Event()
    stuck: list[threading.Thread] = []

    def wanted(t: float, state: JointState) -> np.ndarray:
        if t > 1.2:
            stuck.append(threading.current_thread())
            forever.wait()
        return good(t, state)

    session = stepped.session()
    try:
        with pytest.raises(SetpointError, match="the setpoint function took more than") as caught:
            session.run_setpoint(wanted, 5.0)
    finally:
        forever.set()
        for thread in stuck:
            thread.join()
    assert "holding, watchdog armed" in str(caught.value)
    held_with_watchdog(stepped, session.recording)


def test_a_function_may_not_take_long_even_if_it_returns(stepped: SteppedArm) -> None:
    good = circle(stepped.description)

    def wanted(t: float, state: JointState) -> np.ndarray:
        if t > 1.2:
            stepped.clock.advance(0.15)
        return good(t, state)

    with pytest.raises(SetpointError, match="the setpoint function took more than"):
        stepped.session().run_setpoint(wanted, 5.0)


def test_patience_ends_before_the_servos_watchdog() -> None:
    assert 2 * PATIENCE < WATCHDOG_SECONDS


def test_coasting_is_half_of_full_speed_long_and_stays_in_range() -> None:
    start, speed = np.zeros(3), np.array([1.0, -2.0, 1.0])
    coast = Coast(start, speed, np.full(3, 10.0), np.full(3, -9.0), np.array([9.0, 9.0, 0.05]))
    end = coast.at(coast.duration)
    assert coast.duration == pytest.approx(3.0 * 2.0 / 10.0)
    assert end[:2] == pytest.approx(0.5 * speed[:2] * coast.duration)
    assert end[2] == pytest.approx(0.05)
    first = coast.at(1e-6)
    assert first / 1e-6 == pytest.approx(speed, abs=1e-3)  # it goes on at the speed it has
    moments = np.array([coast.at(t) for t in np.linspace(0.0, coast.duration, 601)])
    bend = np.diff(moments[:, :2], 2, axis=0) / 0.001**2
    assert np.abs(bend).max() <= 0.5 * 10.0 * 1.01
