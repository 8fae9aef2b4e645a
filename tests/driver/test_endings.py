"""How every ending leaves the arm: torque, motion and watchdog, on a stepped clock."""

import numpy as np
import pytest
from msgspec.structs import replace

from armsyn.arm import ArmDescription
from armsyn.driver import ArmSession, Ending, Recording, path
from armsyn.driver.joints import JointGroup
from armsyn.driver.stream import HEALTH_INTERVAL
from armsyn.driver.timing import WATCHDOG_UNITS
from armsyn.errors import (
    ArmFaultError,
    ArmsynError,
    BusError,
    BusTimeoutError,
    FollowingError,
    HardwareFaultError,
    LimitError,
    PortLostError,
)
from armsyn.motion import Motion
from firmware_sim.firmware.codes import HardwareError
from tests.driver.stepped import SteppedArm, without

ON, OFF = [1] * 7, [0] * 7
ARMED, DISARMED, EXPIRED = [WATCHDOG_UNITS] * 7, [0] * 7, [255] * 7
SMALL = (0.3, 0.0, 0.0, 0.4)
LARGE = (0.6, 0.3, -0.6, 0.9)


def fault_at(stepped: SteppedArm, kind: type[ArmsynError]) -> ArmsynError:
    """Run a large motion that must end in a fault of one kind."""
    return fault_of(stepped.session(), stepped, kind)


def fault_of(session: ArmSession, stepped: SteppedArm, kind: type[ArmsynError]) -> ArmsynError:
    with pytest.raises(kind) as caught:
        session.run(stepped.way(*LARGE))
    assert session.fault is caught.value
    assert session.recording is not None
    assert session.recording.ending is Ending.FAULT
    with pytest.raises(ArmFaultError, match="ended with a fault"):  # latched
        session.run(stepped.way(*LARGE))
    message = str(caught.value)  # one line says what is left, and how to clear it
    assert "left with torque on (but where a servo lost it), holding, watchdog armed" in message
    assert message.count("armsyn clear") == 1
    assert "\n" not in message
    return caught.value


def goals_after(stepped: SteppedArm, seconds: float) -> list[int]:
    stepped.clock.advance(seconds)
    return stepped.value("Goal Position")


def last_goals(stepped: SteppedArm, recording: Recording | None) -> list[int]:
    assert recording is not None
    ticks: list[int] = stepped.description.calibration.to_ticks(
        recording.commanded_rad[-1]
    ).tolist()
    return ticks


def test_success_holds_at_the_target(stepped: SteppedArm) -> None:
    way = stepped.way(*LARGE)
    recording = stepped.session().run(way)
    assert recording.ending is Ending.COMPLETED
    assert stepped.torque() == ON
    assert stepped.value("Bus Watchdog") == DISARMED
    assert np.abs(stepped.positions() - way.angles[-1]).max() < 0.005
    assert recording.command_success_rate == 1.0
    assert recording.missed_ticks == 0
    stepped.clock.advance(5.0)  # nothing feeds a watchdog any more, and nothing needs it
    assert stepped.value("Bus Watchdog") == DISARMED


def test_parking_lets_go_at_the_end(stepped: SteppedArm) -> None:
    out = stepped.way(*SMALL)
    back = type(out)(time=out.time, joint_names=out.joint_names, angles=out.angles[::-1])
    recording = stepped.session().run(out, park=back)
    assert recording.ending is Ending.PARKED
    assert stepped.torque() == OFF
    assert stepped.value("Bus Watchdog") == DISARMED
    assert np.abs(stepped.positions() - stepped.description.rest).max() < 0.005


@pytest.mark.fault(11)
def test_torque_comes_on_without_a_jerk(stepped: SteppedArm) -> None:
    for servo in stepped.servos:
        servo.memory.store("Goal Position", 2600)  # stale goals
    session = stepped.session()
    where = stepped.positions()
    seen = []
    session.run(stepped.way(*SMALL), on_tick=lambda *_: seen.append(stepped.positions()))
    assert np.abs(seen[0] - where).max() < 0.01


@pytest.mark.fault(41)
def test_first_request_decelerates_and_parks(stepped: SteppedArm) -> None:
    session = stepped.session()
    stepped.at(0.3, session.stops.request)
    recording = session.run(stepped.way(*LARGE))
    assert recording.ending is Ending.STOPPED_PARKED
    assert recording.events[0][1] == "asked to stop: decelerating"
    assert np.abs(stepped.positions() - stepped.description.rest).max() < 0.005
    assert stepped.torque() == ON
    assert stepped.value("Bus Watchdog") == DISARMED
    limit = stepped.description.max_acceleration
    speed = np.diff(recording.commanded_rad, axis=0) * 200.0
    assert (np.abs(np.diff(speed, axis=0) * 200.0).max(axis=0) <= 1.1 * limit).all()


def test_a_request_without_parking_holds_where_the_arm_stands(stepped: SteppedArm) -> None:
    session = stepped.session()
    session.stops.park = False
    stepped.at(0.3, session.stops.request)
    assert session.run(stepped.way(0.6)).ending is Ending.STOPPED_HOLDING
    assert stepped.positions()[0] - stepped.description.rest[0] > 0.1
    assert stepped.torque() == [1] * 7


def test_a_request_with_no_way_to_rest_holds(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    session, way = stepped.session(), stepped.way(0.6)
    monkeypatch.setattr(path, "MOST_FRAMES", 10)
    stepped.at(0.3, session.stops.request)
    assert session.run(way).ending is Ending.STOPPED_HOLDING


@pytest.mark.fault(41)
def test_first_request_far_from_rest_holds(human7: ArmDescription) -> None:
    slow = replace(human7, joint=tuple(replace(j, max_velocity=0.4) for j in human7.joint))
    stepped = SteppedArm(slow)
    session = stepped.session()
    way = stepped.way(1.0)
    assert way.duration > 4.5
    stepped.at(4.0, session.stops.request)  # the way back takes longer than three seconds
    recording = session.run(way)
    assert recording.ending is Ending.STOPPED_HOLDING
    assert stepped.torque() == ON
    assert stepped.value("Bus Watchdog") == DISARMED
    still = recording.commanded_rad[-1]
    assert np.abs(stepped.positions() - still).max() < 0.005
    assert 0.5 < still[0] - slow.rest[0] < 1.0


@pytest.mark.fault(41)
def test_second_request_holds_at_once(stepped: SteppedArm) -> None:
    session = stepped.session()
    stepped.at(0.30, session.stops.request)
    stepped.at(0.35, session.stops.request)
    recording = session.run(stepped.way(*LARGE))
    assert recording.ending is Ending.ABORTED
    assert stepped.torque() == ON
    assert stepped.value("Bus Watchdog") == ARMED
    goals = stepped.value("Goal Position")
    assert goals == last_goals(stepped, recording)
    assert "armsyn clear" in recording.ending.value
    with pytest.raises(ArmFaultError, match="second request"):
        session.run(stepped.way(*LARGE))
    with pytest.raises(HardwareFaultError, match="bus watchdog armed"):  # nor another program
        stepped.session()
    # at its expiry each watchdog makes the horn's place the goal, which friction holds off the old
    assert goals_after(stepped, 1.0) == pytest.approx(goals, abs=4)
    assert stepped.value("Bus Watchdog") == EXPIRED


def test_second_request_while_parking_holds_at_once(stepped: SteppedArm) -> None:
    session = stepped.session()
    stepped.at(0.3, session.stops.request)
    stepped.at(0.9, session.stops.request)
    recording = session.run(stepped.way(*LARGE))
    assert recording.ending is Ending.ABORTED
    assert recording.events[1][1] == "moving to the rest posture"


@pytest.mark.fault(18)
def test_a_hardware_error_stops_all_joints(stepped: SteppedArm) -> None:
    stepped.at(0.3, lambda: stepped.servos[2].raise_hardware_error(HardwareError.OVERLOAD))
    session = stepped.session()
    error = fault_of(session, stepped, HardwareFaultError)
    assert isinstance(error, HardwareFaultError)
    assert error.servo_id == 3
    assert "servo 3 (shoulder_rotation) reports a hardware error: overload" in str(error)
    assert stepped.torque() == [1, 1, 0, 1, 1, 1, 1]  # what the fault left; the others hold
    assert stepped.value("Bus Watchdog") == ARMED
    goals = last_goals(stepped, session.recording)
    assert goals_after(stepped, 0.2) == goals  # the watchdog has not yet expired
    assert stepped.value("Bus Watchdog") == ARMED
    still = stepped.positions()
    assert goals_after(stepped, 0.05) == goals
    holding = [row for row in range(7) if row != 2]
    assert np.abs(stepped.positions() - still)[holding].max() < 0.002
    off = stepped.positions() - stepped.description.calibration.to_radians(goals)
    assert np.abs(off)[holding].max() < 0.005


@pytest.mark.fault(19)
def test_the_hardware_error_is_in_the_record(stepped: SteppedArm) -> None:
    stepped.at(0.3, lambda: stepped.servos[2].raise_hardware_error(HardwareError.OVERHEATING))
    session = stepped.session()
    with pytest.raises(HardwareFaultError, match="overheating"):
        session.run(stepped.way(*LARGE))
    assert session.recording is not None
    assert session.recording.hardware_error[-1].tolist() == [0, 0, 4, 0, 0, 0, 0]
    assert "held: " in session.recording.events[-1][1]


@pytest.mark.fault(10)
def test_a_servo_that_restarts_is_a_fault(stepped: SteppedArm) -> None:
    stepped.at(0.3, stepped.servos[4].reboot)
    error = fault_at(stepped, ArmFaultError)
    assert "servo 5 (forearm_pronation)" in str(error)


def hold(session: ArmSession) -> None:
    """Let all servos hold where they are: their indirect addresses cannot be written then."""
    group = session._joints.group
    group.set("Goal Position", group.read("Present Position"))
    group.set("Torque Enable", dict.fromkeys(group.ids, 1))


@pytest.mark.fault(10, 25)
@pytest.mark.parametrize(
    ("baud", "rate", "longest"),
    [
        *((1_000_000, rate, HEALTH_INTERVAL + 1.0 / rate) for rate in (10.0, 50.0, 100.0, 200.0)),
        (57_600, 20.0, 0.31),  # a period has no time for more
    ],
)
@pytest.mark.parametrize("held", [False, True])
def test_every_servo_is_looked_at_within_the_promised_time(
    human7: ArmDescription,
    monkeypatch: pytest.MonkeyPatch,
    baud: int,
    rate: float,
    longest: float,
    *,
    held: bool,
) -> None:
    stepped = SteppedArm(human7, baud=baud)
    session = stepped.session(rate)
    if held:
        hold(session)
    looked: dict[int, list[float]] = {}
    poll = JointGroup.poll

    def noted(group: JointGroup, turn: int) -> object:
        looked.setdefault(turn % group.polls, []).append(stepped.now())
        return poll(group, turn)

    monkeypatch.setattr(JointGroup, "poll", noted)
    ticks: list[float] = []
    recording = session.run(stepped.way(*LARGE), on_tick=lambda *_: ticks.append(stepped.now()))
    assert recording.missed_ticks == 0
    assert len(looked) == (3 if held else 1) * len(stepped.servos)
    for times in looked.values():
        assert np.diff([ticks[0], *times]).max() <= longest


def test_torque_switched_off_by_another_is_a_fault(stepped: SteppedArm) -> None:
    stepped.at(0.2, lambda: stepped.servos[6].write(64, b"\x00"))
    assert "servo 7 (wrist_deviation) has lost its torque" in str(
        fault_at(stepped, HardwareFaultError)
    )


def lost_for(stepped: SteppedArm, after: float, duration: float) -> None:
    """Lose servo 4's replies for a time."""
    stepped.at(after, lambda: setattr(stepped, "damage", without(4)))
    stepped.at(after + duration, lambda: setattr(stepped, "damage", lambda data: data))


@pytest.mark.fault(9)
@pytest.mark.parametrize("rate", [7.0, 10.0, 200.0])
def test_one_lost_reply_is_no_silence(stepped: SteppedArm, rate: float) -> None:
    """At a slow rate, and after a stall."""
    lost_for(stepped, 0.5, 1.2 / rate)
    stepped.at(0.5, lambda: stepped.clock.advance(0.2 if rate > 10.0 else 0.0))
    recording = stepped.session(rate).run(stepped.way(*LARGE))
    assert recording.ending is Ending.COMPLETED
    assert 1 <= recording.stale[:, 3].sum() <= 2


@pytest.mark.fault(9)
def test_a_silent_servo_is_found_at_a_slow_rate(stepped: SteppedArm) -> None:
    stepped.at(0.3, lambda: setattr(stepped, "damage", without(7)))
    with pytest.raises(BusTimeoutError, match=r"servo 7 \(wrist_deviation\) has been silent"):
        stepped.session(10.0).run(stepped.way(*LARGE))


@pytest.mark.fault(9)
def test_a_silent_servo_stops_the_others(stepped: SteppedArm) -> None:
    stepped.at(0.3, lambda: setattr(stepped, "damage", without(4)))
    error = fault_at(stepped, BusTimeoutError)
    assert isinstance(error, BusTimeoutError)
    assert error.servo_ids == (4,)
    assert "servo 4 (elbow_flexion) has been silent" in str(error)
    assert stepped.value("Bus Watchdog") == ARMED


@pytest.mark.fault(2)
def test_a_few_lost_replies_are_no_fault(stepped: SteppedArm) -> None:
    count = iter(range(10**6))
    lose = without(2)
    stepped.damage = lambda data: lose(data) if next(count) % 97 == 0 else data
    recording = stepped.session().run(stepped.way(*LARGE))
    assert recording.ending is Ending.COMPLETED
    assert recording.stale.any()
    motion = recording.measured_motion(stepped.description)
    assert np.isfinite(motion.angles).all()


@pytest.mark.fault(3)
def test_too_many_lost_replies_are_a_fault(stepped: SteppedArm) -> None:
    count = iter(range(10**6))
    lose = without(2)

    def start_losing() -> None:
        stepped.damage = lambda data: lose(data) if next(count) % 3 else data

    stepped.at(0.1, start_losing)
    error = fault_at(stepped, BusError)
    assert "of the last 100 commands" in str(error)


@pytest.mark.fault(12)
def test_a_lost_port_ends_the_run(stepped: SteppedArm) -> None:
    session = stepped.session()
    stepped.at(0.3, stepped.bus.serial_port.close)
    with pytest.raises(PortLostError):
        session.run(stepped.way(*LARGE))
    assert stepped.torque() == ON
    stepped.clock.advance(1.0)
    assert stepped.value("Bus Watchdog") == EXPIRED  # nobody else is left to stop the arm


@pytest.mark.fault(35)
def test_a_held_joint_gives_way(stepped: SteppedArm) -> None:
    stepped.at(0.2, lambda: stepped.servos[3].apply_load(30.0))
    error = fault_at(stepped, FollowingError)
    assert isinstance(error, FollowingError)
    assert error.joint == "elbow_flexion"
    goal = stepped.description.calibration.to_radians(stepped.value("Goal Position"))[3]
    assert abs(goal - stepped.positions()[3]) < 0.2


@pytest.mark.fault(27)
def test_a_host_that_stalls_past_the_watchdog_holds(stepped: SteppedArm) -> None:
    stepped.at(0.3, lambda: stepped.clock.advance(0.5))
    assert "the host stalled for 0.5" in str(fault_at(stepped, ArmFaultError))


@pytest.mark.fault(27)
def test_a_short_stall_starts_from_rest_again(stepped: SteppedArm) -> None:
    stepped.at(0.3, lambda: stepped.clock.advance(0.1))
    recording = stepped.session().run(stepped.way(*LARGE))
    assert recording.ending is Ending.COMPLETED
    assert recording.missed_ticks in (19, 20)
    assert any("starting from rest" in event.text for event in recording.events)
    steps = np.abs(np.diff(recording.commanded_rad, axis=0))
    assert (steps <= stepped.description.max_velocity / 200.0 * 1.05).all()  # never a jump


@pytest.mark.fault(30, 31)
@pytest.mark.parametrize("wrong", ["start", "nan", "limit", "speed", "joints"])
def test_a_refused_trajectory_changes_nothing(stepped: SteppedArm, wrong: str) -> None:
    way = stepped.way(*LARGE)
    angles, names, time = way.angles.copy(), way.joint_names, way.time
    if wrong == "start":
        angles += 0.2
    elif wrong == "nan":
        angles[40, 2] = np.nan
    elif wrong == "limit":
        angles[:, 3] *= 10.0
    elif wrong == "speed":
        time = time / 2
    else:
        names = names[::-1]
    bad = type(way)(time=time, joint_names=names, angles=angles)
    session = stepped.session()
    sent = len(stepped.bus.serial_port.written)
    with pytest.raises(ArmsynError) as caught:
        session.run(bad)
    assert caught.value.exit_status in (2, 4)
    assert stepped.torque() == OFF
    assert session.fault is None
    instructions = [p[7] for p in stepped.bus.serial_port.written[sent:]]
    assert set(instructions) <= {0x82}  # read only
    session.run(way)  # the session is as good as before


@pytest.mark.fault(21)
def test_a_goal_the_servo_would_refuse_is_not_sent(stepped: SteppedArm) -> None:
    stepped.servos[3].write(48, (2500).to_bytes(4, "little"))  # Max Position Limit
    session = stepped.session()
    with pytest.raises(LimitError, match=r"servo 4 \(elbow_flexion\) would be sent to tick"):
        session.run(stepped.way(*LARGE))
    assert stepped.torque() == OFF


def sampled(stepped: SteppedArm, step: float, *elbow: float) -> Motion:
    """Motion of the elbow through these changes from rest, `step` seconds apart."""
    arm = stepped.description
    angles = np.tile(arm.rest, (len(elbow), 1))
    angles[:, 3] += elbow
    time = step * np.arange(len(elbow))
    return Motion(time=time, joint_names=arm.joint_names, angles=angles)


def test_a_motion_of_few_samples_is_followed(stepped: SteppedArm) -> None:
    way = sampled(stepped, 0.2, 0.0, 0.2, 0.4, 0.6, 0.6)
    assert stepped.session().run(way).ending is Ending.COMPLETED


@pytest.mark.fault(31)
def test_a_motion_that_would_be_a_fault_between_its_samples_is_refused(
    stepped: SteppedArm,
) -> None:
    """1.1 rad in 0.5 s are within 2.45 rad/s on average, but from rest to rest not at most."""
    session = stepped.session()
    with pytest.raises(LimitError, match=r"elbow_flexion: .* s \(row 1 of 3\): .* more of them"):
        session.run(sampled(stepped, 0.5, 0.0, 1.1, 1.1))
    assert stepped.torque() == OFF
    assert session.fault is None


@pytest.mark.fault(42)
def test_a_servo_without_torque_is_found_before_motion(stepped: SteppedArm) -> None:
    session = stepped.session()
    deaf = stepped.servos[5]
    original = deaf.write
    deaf.write = lambda address, data: original(address, b"\x00" if address == 64 else data)
    for servo in stepped.servos:
        servo.memory.store("Profile Velocity", 100)
    with pytest.raises(HardwareFaultError, match=r"servo 6 .* does not take 1 as its Torque"):
        session.run(stepped.way(*LARGE))
    assert stepped.torque() == OFF
    assert stepped.value("Bus Watchdog") == DISARMED
    assert stepped.value("Profile Velocity") == [100] * 7
    assert session.fault is None


@pytest.mark.fault(43)
def test_an_arm_that_holds_itself_is_not_dropped(stepped: SteppedArm) -> None:
    first = stepped.session()
    first.run(stepped.way(*SMALL))
    states = []
    second = stepped.session()
    back = stepped.way(*SMALL)
    reverse = type(back)(time=back.time, joint_names=back.joint_names, angles=back.angles[::-1])
    recording = second.run(reverse, on_tick=lambda *_: states.append(stepped.torque()))
    assert recording.ending is Ending.COMPLETED
    assert all(state == ON for state in states)


@pytest.mark.parametrize("stop_at", [0.4, 0.3], ids=["with the stall", "before it"])
def test_a_stop_with_a_stall_stops_where_the_arm_stands(
    stepped: SteppedArm, stop_at: float
) -> None:
    session = stepped.session()
    stepped.at(stop_at, session.stops.request)
    stepped.at(0.4, lambda: stepped.clock.advance(0.1))
    recording = session.run(stepped.way(0.6, 0.3, -0.6, 0.9))
    assert recording.ending is Ending.STOPPED_PARKED
    stall = int(np.argmax(np.diff(recording.time_s)))
    commands = recording.commanded_rad[stall:]
    assert np.abs(commands[1:20] - commands[0]).max() == 0.0
    texts = [event.text for event in recording.events]
    assert any("stopped where it stands" in text for text in texts)


@pytest.mark.parametrize(
    ("register", "what"), [("Torque Enable", "torque"), ("Bus Watchdog", "bus watchdog")]
)
def test_a_run_with_a_limp_joint_at_its_end_is_not_completed(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch, register: str, what: str
) -> None:
    def lose(*_: object) -> None:
        stepped.by_id[4].memory.store(register, 0)

    monkeypatch.setattr("armsyn.driver.run.ArmRun._note_strangers", lose)
    session = stepped.session()
    with pytest.raises(HardwareFaultError, match=f"servo 4 .* has lost its {what}"):
        session.run(stepped.way(0.3))
    assert session.recording is not None
    assert session.recording.ending is Ending.FAULT
