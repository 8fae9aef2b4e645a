"""What a fault says, and what it leaves when even putting things back fails."""

from collections.abc import Callable

import numpy as np
import pytest

from armsyn.driver import ArmSession, Ending, power, run, straight_way, stream
from armsyn.driver.course import PathCourse
from armsyn.driver.joints import JointState
from armsyn.driver.stream import Streamer
from armsyn.driver.timing import WATCHDOG_UNITS
from armsyn.errors import ArmFaultError, CommandFaultError, HardwareFaultError, PortLostError
from armsyn.safety import CommandLimits, TickState, Verdict, judge_tick
from tests.driver.stepped import SteppedArm, deafen, without

ON, OFF = [1] * 7, [0] * 7
LARGE = (0.6, 0.3, -0.6, 0.9)
TORQUE_ENABLE = 64
LEFT = "left with torque on (but where a servo lost it), holding, watchdog armed"
CURE = "armsyn clear"


@pytest.mark.fault(42)
def test_what_cannot_be_put_back_is_said(stepped: SteppedArm) -> None:
    session = stepped.session()
    deafen(stepped.servos[5], TORQUE_ENABLE, 1)
    for row in (1, 2):
        deafen(stepped.servos[row], TORQUE_ENABLE, 0)
    with pytest.raises(HardwareFaultError) as caught:
        session.run(stepped.way(*LARGE))
    message = str(caught.value)
    assert message.startswith("servo 6 (wrist_flexion) does not take 1 as its Torque Enable")
    assert (
        "; and 2 of 7 servos could not be restored: servo 2 (shoulder_abduction) (Torque Enable"
        " reads 1 instead of 0), servo 3 (shoulder_rotation) (Torque Enable reads 1 instead of 0); "
        in message
    )
    assert CURE in message
    assert stepped.torque() == [0, 1, 1, 0, 0, 0, 0]
    assert session.fault is caught.value
    assert session.recording is None  # nothing has moved
    with pytest.raises(ArmFaultError, match="ended with a fault"):
        session.run(stepped.way(*LARGE))


@pytest.mark.fault(42)
def test_putting_back_is_tried_again(stepped: SteppedArm) -> None:
    session = stepped.session()
    deafen(stepped.servos[5], TORQUE_ENABLE, 1, times=2)
    deafen(stepped.servos[2], TORQUE_ENABLE, 0, times=2)
    with pytest.raises(HardwareFaultError, match="servo 6") as caught:
        session.run(stepped.way(*LARGE))
    assert "restored" not in str(caught.value)
    assert stepped.torque() == OFF
    assert session.run(stepped.way(*LARGE)).ending is Ending.COMPLETED


def test_a_servo_that_falls_silent_as_torque_comes_on(stepped: SteppedArm) -> None:
    session = stepped.session()
    original = stepped.servos[3].write

    def write(at: int, data: bytes) -> object:
        if at == TORQUE_ENABLE:
            stepped.damage = without(4)
        return original(at, data)

    stepped.servos[3].write = write  # type: ignore[assignment, method-assign]
    with pytest.raises(ArmFaultError) as caught:
        session.run(stepped.way(*LARGE))
    assert "and 1 of 7 servos could not be restored: servo 4 (elbow_flexion)" in str(caught.value)
    assert "Torque Enable reads nothing instead of 0" in str(caught.value)
    assert stepped.torque() == OFF  # it took it, only nobody heard
    assert session.fault is caught.value


def test_a_port_lost_as_torque_comes_on(stepped: SteppedArm) -> None:
    session = stepped.session()
    original = stepped.servos[6].write

    def write(at: int, data: bytes) -> object:
        if at == TORQUE_ENABLE:
            stepped.bus.serial_port.close()
        return original(at, data)

    stepped.servos[6].write = write  # type: ignore[assignment, method-assign]
    with pytest.raises(PortLostError, match="and 7 of 7 servos could not be restored") as caught:
        session.run(stepped.way(*LARGE))
    assert session.fault is caught.value


def test_all_is_made_ready_before_torque(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_room(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(run, "StreamLog", no_room)
    session = stepped.session()
    stepped.bus.serial_port.written.clear()
    with pytest.raises(MemoryError):
        session.run(stepped.way(*LARGE))
    assert {packet[7] for packet in stepped.bus.serial_port.written} == {0x82}  # read only
    assert session.fault is None


def test_the_time_torque_takes_is_no_silence(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    power_up = power.power_up

    def slowly(*arguments: object) -> None:
        power_up(*arguments)  # type: ignore[arg-type]
        stepped.clock.advance(0.25)
        stepped.damage = without(4)
        stepped.at(0.05, lambda: setattr(stepped, "damage", lambda data: data))

    monkeypatch.setattr(power, "power_up", slowly)
    recording = stepped.session().run(stepped.way(*LARGE))
    assert recording.ending is Ending.COMPLETED
    assert recording.stale[0].any()


def test_a_tick_is_judged_by_what_the_arm_answered(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []

    def judged(state: TickState, wanted: np.ndarray, limits: CommandLimits) -> Verdict:
        seen.append((state.measured.copy(), state.speed.copy(), state.fresh.copy()))
        return judge_tick(state, wanted, limits)

    monkeypatch.setattr(stream, "judge_tick", judged)
    recording = stepped.session().run(stepped.way(*LARGE))
    measured, speed, fresh = (np.array(part) for part in zip(*seen[1:], strict=True))
    np.testing.assert_array_equal(measured, recording.measured_rad[:-1])
    assert fresh.all()
    fastest = np.abs(np.diff(recording.commanded_rad, axis=0)).max() * 200.0
    assert speed.max() == pytest.approx(fastest)


@pytest.mark.fault(27)
def test_a_stall_right_after_torque_is_the_hosts(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    follow = Streamer.follow

    def stalled(streamer: Streamer, *arguments: object) -> object:
        stepped.clock.advance(0.5)
        return follow(streamer, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(Streamer, "follow", stalled)
    with pytest.raises(ArmFaultError, match=r"the host stalled for 0\.5"):
        stepped.session().run(stepped.way(*LARGE))
    assert stepped.torque() == ON


def parked(stepped: SteppedArm) -> ArmSession:
    """Go to and fro, and park."""
    session, arm = stepped.session(), stepped.description
    way = stepped.way(0.1)
    back = straight_way(way.angles[-1], arm.rest, arm, 200.0)
    session.run(way, park=back)
    return session


def test_a_fault_after_parking_says_that_the_torque_is_off(stepped: SteppedArm) -> None:
    deafen(stepped.by_id[3], 98, 0)  # keeps its watchdog
    with pytest.raises(HardwareFaultError, match=r"servo 3 .* take 0 as its Bus") as caught:
        parked(stepped)
    assert f"left without torque, released at rest, watchdog armed: {run.CURE}" in str(caught.value)
    assert LEFT not in str(caught.value)
    assert stepped.torque() == OFF


def test_a_servo_that_keeps_its_torque_after_parking_is_named(stepped: SteppedArm) -> None:
    deafen(stepped.by_id[3], TORQUE_ENABLE, 0)
    with pytest.raises(HardwareFaultError, match="left with only servo 3 under torque, holding"):
        parked(stepped)
    assert stepped.torque() == [0, 0, 1, 0, 0, 0, 0]


@pytest.mark.fault(30)
@pytest.mark.parametrize("wrong", [np.nan, 0.3], ids=["nan", "jump"])
def test_a_goal_that_must_not_be_sent_is_a_fault_of_the_arm(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch, wrong: float
) -> None:
    advance: Callable[[PathCourse, JointState | None], np.ndarray] = PathCourse.advance
    spoil = np.array([0.0, 0.0, wrong, 0.0, 0.0, 0.0, 0.0])

    def spoilt(course: PathCourse, state: JointState | None) -> np.ndarray:
        posture = advance(course, state)
        return posture + (spoil if course.now > 0.3 else 0.0)

    monkeypatch.setattr(PathCourse, "advance", spoilt)
    session = stepped.session()
    with pytest.raises(CommandFaultError, match="joint shoulder_rotation: the command") as caught:
        session.run(stepped.way(*LARGE))
    assert caught.value.exit_status == 3  # 4 would say that nothing has moved
    assert caught.value.joint == "shoulder_rotation"
    assert LEFT in str(caught.value)
    recording = session.recording
    assert recording is not None
    last = stepped.description.calibration.to_ticks(recording.commanded_rad[-1])
    assert stepped.value("Goal Position") == last.tolist()
    assert stepped.torque() == ON
    assert stepped.value("Bus Watchdog") == [WATCHDOG_UNITS] * 7


def test_an_error_of_the_caller_holds_and_gets_a_note(stepped: SteppedArm) -> None:
    def on_tick(path_time: float, _: float) -> None:
        if path_time > 0.3:
            raise KeyError("theirs")

    session = stepped.session()
    with pytest.raises(KeyError) as caught:
        session.run(stepped.way(*LARGE), on_tick=on_tick)
    assert caught.value.__notes__ == [f"{LEFT}: {run.CURE}"]
    assert session.fault is caught.value
    assert stepped.torque() == ON
    assert stepped.value("Bus Watchdog") == [WATCHDOG_UNITS] * 7
