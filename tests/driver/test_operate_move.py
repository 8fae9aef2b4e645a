"""Jogging a joint and parking, on a stepped clock."""

import math

import msgspec
import numpy as np
import pytest

from armsyn.driver import Ending
from armsyn.driver.operate_move import is_parked, jog, park
from armsyn.errors import HardwareFaultError, InputError, LimitError, RefusedMotionError
from tests.driver.stepped import SteppedArm

ELBOW = 3


def test_a_jog_moves_one_joint_and_holds(stepped: SteppedArm) -> None:
    before = stepped.positions()
    recording = jog(stepped.session(), "elbow_flexion", 0.2, 1.0)
    assert recording.ending is Ending.COMPLETED
    moved = stepped.positions() - before
    assert moved[ELBOW] == pytest.approx(0.2, abs=0.005)
    assert np.abs(np.delete(moved, ELBOW)).max() < 0.005
    assert stepped.torque() == [1] * 7


def test_a_jog_keeps_to_its_speed(stepped: SteppedArm) -> None:
    recording = jog(stepped.session(), "elbow_flexion", -0.3, math.radians(10.0))
    assert np.abs(recording.velocity_rad_s).max() < math.radians(11.0)
    assert recording.time_s[-1] > 0.3 / math.radians(10.0)


@pytest.mark.parametrize(
    ("joint", "change", "speed", "said"),
    [
        ("nose", 0.1, 1.0, "has no joint 'nose'; it has shoulder_flexion"),
        ("elbow_flexion", 1.0, 1.0, "up to 45 degrees, got 57"),
        ("elbow_flexion", 0.0, 1.0, "up to 45 degrees, got 0"),
        ("elbow_flexion", float("nan"), 1.0, "up to 45 degrees"),
        ("elbow_flexion", 0.1, 0.0, "a speed is above 0"),
        ("elbow_flexion", 0.1, float("inf"), "a speed is above 0"),
    ],
)
def test_what_is_no_jog_is_refused(
    stepped: SteppedArm, joint: str, change: float, speed: float, said: str
) -> None:
    with pytest.raises(InputError, match=said):
        jog(stepped.session(), joint, change, speed)
    assert stepped.torque() == [0] * 7


@pytest.mark.parametrize("speed", [1e-5, 1e-150])
def test_a_jog_that_would_take_hours_is_refused(stepped: SteppedArm, speed: float) -> None:
    with pytest.raises(RefusedMotionError, match="is the longest that is planned: move faster"):
        jog(stepped.session(), "elbow_flexion", 0.1, speed)
    assert stepped.torque() == [0] * 7


@pytest.mark.fault(33)
def test_a_jog_out_of_range_changes_nothing(stepped: SteppedArm) -> None:
    session = stepped.session()
    here = np.degrees(session.read_posture()[3])
    end = np.degrees(session.arm.chain.lower[3])
    said = f"{here:.2f} degrees, its limit is {end:.2f}: {here - end:.2f} degrees are left that way"
    with pytest.raises(LimitError, match=f"elbow_flexion is at {said}"):
        jog(session, "elbow_flexion", -0.7, 1.0)
    assert stepped.torque() == [0] * 7


def test_an_arm_is_parked_limp(stepped: SteppedArm) -> None:
    session = stepped.session()
    session.run(stepped.way(0.4, 0.2, 0.0, 0.5))
    assert not is_parked(session)
    assert park(session).ending is Ending.PARKED
    np.testing.assert_allclose(stepped.positions(), stepped.description.rest, atol=0.01)
    assert stepped.torque() == [0] * 7
    assert is_parked(session)


def test_an_arm_at_rest_under_torque_is_not_parked_yet(stepped: SteppedArm) -> None:
    session = stepped.session()
    park(session)
    session.run(stepped.way(0.01))
    assert not is_parked(session)
    assert park(session).ending is Ending.PARKED


def test_an_arm_that_does_not_get_there_holds(stepped: SteppedArm) -> None:
    session = stepped.session()
    session.run(stepped.way(0.4, 0.2, 0.0, 0.5))
    tick = int(stepped.description.calibration.to_ticks(stepped.description.rest)[ELBOW])
    stepped.port.simulation.inject(f"obstacle:id=4,tick={tick + 50},side=below")
    recording = park(session)
    assert recording.ending is Ending.PARK_MISSED
    assert stepped.torque() == [1] * 7


def test_a_stop_on_the_way_to_rest_leaves_torque_on(stepped: SteppedArm) -> None:
    session = stepped.session()
    session.run(stepped.way(0.4, 0.2, 0.0, 0.5))
    stepped.at(0.5, session.stops.request)
    assert park(session).ending in (Ending.STOPPED_PARKED, Ending.STOPPED_HOLDING)
    assert stepped.torque() == [1] * 7


def test_a_faulty_servo_keeps_the_arm_from_jogging(stepped: SteppedArm) -> None:
    session = stepped.session()
    stepped.by_id[2].memory.store("Hardware Error Status", 0x20)
    with pytest.raises(HardwareFaultError, match="overload"):
        jog(session, "elbow_flexion", 0.1, 1.0)
    assert stepped.torque() == [0] * 7


def test_a_jog_waits_until_a_limp_arm_is_still(stepped: SteppedArm) -> None:
    elbow = int(stepped.description.calibration.to_ticks(stepped.description.rest)[ELBOW])
    stepped.port.simulation.inject(f"hand:id=4,to={elbow + 300},speed=0.5,for=2")
    session = stepped.session()
    recording = jog(session, "elbow_flexion", 0.1, 1.0)
    assert recording.ending is Ending.COMPLETED
    moved = stepped.positions() - stepped.description.rest
    assert moved[ELBOW] == pytest.approx(300 * 2 * math.pi / 4096 + 0.1, abs=0.02)


def test_an_arm_that_is_never_still_is_not_moved(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = stepped.session()
    postures = (stepped.description.rest + 0.02 * (k % 2) for k in range(10**6))
    monkeypatch.setattr(session, "read_posture", lambda: next(postures))
    with pytest.raises(RefusedMotionError, match="has been moving for 8 s"):
        park(session)
    assert stepped.torque() == [0] * 7


def test_a_limp_joint_beyond_its_servos_own_limit_moves_back(stepped: SteppedArm) -> None:
    arm = stepped.description
    rest = int(arm.calibration.to_ticks(arm.rest)[ELBOW])
    stepped.by_id[4].memory.store("Max Position Limit", rest)
    joint = msgspec.structs.replace(arm.joint[ELBOW], upper=float(arm.rest[ELBOW]))
    joints = (*arm.joint[:ELBOW], joint, *arm.joint[ELBOW + 1 :])
    stepped.description = msgspec.structs.replace(arm, joint=joints)
    session = stepped.session()
    stepped.port.simulation.inject(f"hand:id=4,to={rest + 10},speed=0.5,for=1")
    stepped.sleep_until(stepped.now() + 1.5)
    beyond = stepped.positions()[ELBOW] - stepped.description.rest[ELBOW]
    assert beyond == pytest.approx(10 * 2 * math.pi / 4096, abs=0.004)
    recording = jog(session, "elbow_flexion", -0.2, 1.0)
    assert recording.ending is Ending.COMPLETED
    assert stepped.positions()[ELBOW] < stepped.description.rest[ELBOW] - 0.15


def test_an_arm_that_leans_on_its_stop_moves_off_it(stepped: SteppedArm) -> None:
    arm = stepped.description
    upper = float(arm.rest[ELBOW]) - 0.01
    joint = msgspec.structs.replace(arm.joint[ELBOW], upper=upper, rest=upper - 0.1)
    joints = (*arm.joint[:ELBOW], joint, *arm.joint[ELBOW + 1 :])
    stepped.description = msgspec.structs.replace(arm, joint=joints)
    assert jog(stepped.session(), "elbow_flexion", -0.2, 1.0).ending is Ending.COMPLETED
    assert stepped.positions()[ELBOW] == pytest.approx(upper - 0.2, abs=0.01)
