"""Dual joints: a shadow that follows, one that does not, and what torque does to either."""

import numpy as np
import pytest
from msgspec.structs import replace

from armsyn.arm import ArmDescription, load_arm
from armsyn.driver import Ending, straight_way
from armsyn.driver.checks import PAIR_TOLERANCE_TICKS
from armsyn.driver.timing import WATCHDOG_UNITS
from armsyn.errors import (
    ArmsynError,
    BusTimeoutError,
    FollowingError,
    HardwareFaultError,
    ServoMismatchError,
)
from firmware_sim.firmware.codes import HardwareError
from firmware_sim.rig.table import SECONDARY_ID
from tests.driver.stepped import SteppedArm, present_tick, without

MOVE = (0.0, 0.4, -0.4)
PAIRS = ((2, 3), (4, 5))


@pytest.fixture(scope="module")
def viperx() -> ArmDescription:
    return load_arm("viperx_300s")


@pytest.fixture
def dual(viperx: ArmDescription) -> SteppedArm:
    return SteppedArm(viperx)


def values(stepped: SteppedArm, register: str) -> dict[int, int]:
    stepped.value(register)
    return {i: servo.memory.value(register) for i, servo in stepped.by_id.items()}


def test_shadows_share_the_way_and_the_load(dual: SteppedArm) -> None:
    seen: list[dict[int, int]] = []
    way = dual.way(*MOVE)
    recording = dual.session().run(
        way, on_tick=lambda *_: seen.append(values(dual, "Bus Watchdog"))
    )
    assert recording.ending is Ending.COMPLETED
    assert way.angles is not None
    assert dual.positions() == pytest.approx(way.angles[-1], abs=0.01)
    goals, torque = values(dual, "Goal Position"), values(dual, "Torque Enable")
    for leader, shadow in PAIRS:
        assert goals[shadow] == goals[leader]
        assert abs(present_tick(dual.by_id[shadow]) - present_tick(dual.by_id[leader])) < 5
        assert torque[shadow] == 1
    assert all(now[i] == WATCHDOG_UNITS for now in seen for pair in PAIRS for i in pair)
    assert set(values(dual, "Bus Watchdog").values()) == {0}


@pytest.mark.parametrize("servo_id", [3, 9], ids=["shadow", "gripper"])
def test_a_servo_without_a_state_at_every_tick_is_missed(
    viperx: ArmDescription, servo_id: int
) -> None:
    dual = SteppedArm(viperx)
    session = dual.session(100.0)
    dual.at(0.3, lambda: setattr(dual, "damage", without(servo_id)))
    slow = viperx.slowed(4.0)
    goal = viperx.rest.copy()
    goal[0] += 0.6
    with pytest.raises(BusTimeoutError, match=rf"servo {servo_id} .* has not answered 3 rounds"):
        session.run(straight_way(viperx.rest, goal, slow, 100.0))
    assert session.recording is not None
    assert 0.7 < session.recording.time_s[-1] < 1.5


def test_goals_are_written_to_leaders_only(dual: SteppedArm) -> None:
    session = dual.session()
    dual.bus.serial_port.written.clear()
    session.run(dual.way(*MOVE))
    at_goal = [p for p in dual.bus.serial_port.written if p[7:10] == b"\x83\x74\x00"]
    ids = {packet[start] for packet in at_goal for start in range(12, 12 + 5 * 6, 5)}
    assert ids == {1, 2, 4, 6, 7, 8}


def test_parking_lets_both_go(dual: SteppedArm) -> None:
    out = dual.way(*MOVE)
    back = type(out)(time=out.time, joint_names=out.joint_names, angles=out.angles[::-1])
    assert dual.session().run(out, park=back).ending is Ending.PARKED
    torque = values(dual, "Torque Enable")
    assert [torque[i] for pair in PAIRS for i in pair] == [0] * 4


@pytest.mark.parametrize("secondary", [255, 7], ids=["nobody", "another"])
def test_a_shadow_that_follows_another_is_refused(dual: SteppedArm, secondary: int) -> None:
    dual.by_id[3].memory.store(SECONDARY_ID, secondary)
    with pytest.raises(ServoMismatchError) as caught:
        dual.session()
    whom = "nobody" if secondary == 255 else "servo 7"
    assert f"servo 3 (shoulder, shadow of 2) follows {whom}" in str(caught.value)
    assert "write 2 to register 12 (Secondary ID)" in str(caught.value)


def test_a_servo_that_is_no_shadow_must_follow_nobody(dual: SteppedArm) -> None:
    dual.by_id[7].memory.store(SECONDARY_ID, 2)
    with pytest.raises(ServoMismatchError, match=r"servo 7 \(wrist_angle\) follows the goals"):
        dual.session()


def test_a_shadow_that_counts_the_other_way_is_refused(dual: SteppedArm) -> None:
    mode = dual.by_id[5].memory.value("Drive Mode")
    dual.by_id[5].memory.store("Drive Mode", mode ^ 1)
    with pytest.raises(ServoMismatchError, match=r"servo 5 \(elbow, shadow of 4\) counts"):
        dual.session()


@pytest.mark.parametrize(("apart", "allowed"), [(15, True), (30, False)])
def test_servos_that_would_fight_get_no_torque(
    viperx: ArmDescription, apart: int, allowed: bool
) -> None:
    servos = tuple(
        replace(s, zero_tick=s.zero_tick + apart, rest_tick=s.rest_tick + apart) if s.id == 3 else s
        for s in viperx.servo
    )
    dual = SteppedArm(replace(viperx, servo=servos))
    session = dual.session()
    if allowed:
        assert session.run(dual.way(*MOVE)).ending is Ending.COMPLETED
        return
    with pytest.raises(ServoMismatchError) as caught:
        session.run(dual.way(*MOVE))
    assert f"reads {apart} ticks off servo 2" in str(caught.value)
    assert f"{PAIR_TOLERANCE_TICKS} are allowed" in str(caught.value)
    assert "armsyn calibrate" in str(caught.value)
    assert set(dual.torque()) == {0}
    assert session.fault is None


def ending(dual: SteppedArm, kind: type[ArmsynError]) -> str:
    session = dual.session()
    with pytest.raises(kind) as caught:
        session.run(dual.way(*MOVE))
    assert session.fault is caught.value
    return str(caught.value)


def test_a_shadows_hardware_error_stops_the_arm(dual: SteppedArm) -> None:
    dual.at(0.3, lambda: dual.by_id[5].raise_hardware_error(HardwareError.OVERHEATING))
    message = ending(dual, HardwareFaultError)
    assert "servo 5 (elbow, shadow of 4) reports a hardware error: overheating" in message
    assert dual.torque()[dual.servos.index(dual.by_id[4])] == 1  # the leader holds on


@pytest.mark.fault(10)
def test_a_shadow_that_restarts_stops_the_arm(dual: SteppedArm) -> None:
    dual.at(0.3, dual.by_id[3].reboot)
    message = ending(dual, HardwareFaultError)
    assert "servo 3 (shoulder, shadow of 2) has lost its torque: it restarted" in message


def test_a_shadow_that_no_longer_hears_goals_stops_the_arm(dual: SteppedArm) -> None:
    original = dual.by_id[3].write

    def deaf(at: int, data: bytes, **options: bool) -> object:
        return 0 if at == 116 else original(at, data, **options)

    dual.at(0.1, lambda: setattr(dual.by_id[3], "write", deaf))  # it holds where it is, and pulls
    session = dual.session()
    with pytest.raises(FollowingError) as caught:
        session.run(dual.way(*MOVE))
    assert caught.value.joint == "shoulder"
    assert session.recording is not None
    assert np.abs(session.recording.current_a[:, 1]).max() > 2.0  # they fight


def test_a_shadow_that_comes_apart_is_noticed(dual: SteppedArm) -> None:
    session = dual.session()
    present = dual.by_id[5].read

    def slipped(at: int, size: int) -> tuple[object, bytes]:
        error, data = present(at, size)
        if (at, size) != (126, 10):
            return error, data
        tick = int.from_bytes(data[6:], "little", signed=True) + 150
        return error, data[:6] + tick.to_bytes(4, "little", signed=True)

    dual.at(0.1, lambda: setattr(dual.by_id[5], "read", slipped))
    with pytest.raises(HardwareFaultError, match=r"servo 5 .* ticks off its leader, 100 are"):
        session.run(dual.way(*MOVE))


@pytest.mark.fault(42)
def test_what_was_found_is_put_back_for_shadows_too(dual: SteppedArm) -> None:
    for row, servo in enumerate(dual.servos):
        servo.memory.store("Profile Velocity", 50 + row)
    profiles = dual.value("Profile Velocity")
    deaf = dual.by_id[8]
    original = deaf.write
    deaf.write = lambda at, data, **options: 0 if at == 64 else original(at, data, **options)  # type: ignore[assignment, method-assign]
    session = dual.session()
    with pytest.raises(HardwareFaultError, match="servo 8"):
        session.run(dual.way(*MOVE))
    assert set(dual.torque()) == {0}
    assert set(dual.value("Bus Watchdog")) == {0}
    assert dual.value("Profile Velocity") == profiles
    assert session.fault is None


def test_profiles_of_a_pair_that_differ_are_put_back_each(dual: SteppedArm) -> None:
    for row, servo in enumerate(dual.servos):
        servo.memory.store("Profile Velocity", 50 + row)
    profiles = dual.value("Profile Velocity")
    dual.session().run(dual.way(*MOVE))
    assert dual.value("Profile Velocity") == profiles


def test_a_gripper_that_holds_keeps_holding(dual: SteppedArm) -> None:
    gripper = dual.by_id[9]
    gripper.write(64, b"\x01")
    goal = gripper.memory.value("Goal Position")
    out = dual.way(*MOVE)
    back = type(out)(time=out.time, joint_names=out.joint_names, angles=out.angles[::-1])
    assert dual.session().run(out, park=back).ending is Ending.PARKED
    assert gripper.memory.value("Torque Enable") == 1
    assert gripper.memory.value("Goal Position") == goal
    assert gripper.memory.value("Bus Watchdog") == 0


def test_a_gripper_that_lets_go_stops_the_arm(dual: SteppedArm) -> None:
    gripper = dual.by_id[9]
    gripper.write(64, b"\x01")
    dual.at(0.2, lambda: gripper.write(64, b"\x00"))
    assert "servo 9 (gripper) has lost its torque" in ending(dual, HardwareFaultError)


@pytest.mark.fault(9)
def test_a_silent_leader_is_named_by_itself(dual: SteppedArm) -> None:
    dual.at(0.3, lambda: setattr(dual, "damage", without(4)))
    assert "servo 4 (elbow) has been silent" in ending(dual, ArmsynError)
