"""Servos that are read one by one and fall silent, beside others that a watchdog would stop."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace

from armsyn.arm import ArmDescription, load_arm
from armsyn.driver.blocks import Health
from armsyn.driver.exchanging import LEAST_MARGIN
from armsyn.driver.joints import JointState
from armsyn.driver.path import straight_way
from armsyn.driver.plans import ReadPlan
from armsyn.driver.registers import WATCHDOG_EXPIRED
from armsyn.driver.timing import WATCHDOG_UNITS
from armsyn.driver.watch import ArmWatch, WatchSettings
from armsyn.errors import BusTimeoutError, HardwareFaultError
from armsyn.safety import CommandLimits
from tests.driver.stepped import SteppedArm

WRIST = (6, 7, 8)


@pytest.fixture(scope="module")
def classic_wrist() -> ArmDescription:
    """ViperX-300s whose wrist has three AX-12A."""
    arm = load_arm("viperx_300s", calibrated=False)
    ax = {"model": "ax-12a", "protocol": 1, "zero_tick": 512, "rest_tick": 512, "drive_mode": 0}
    return replace(
        arm,
        name="classic_wrist",
        servo=tuple(replace(s, **ax) if s.id in WRIST else s for s in arm.servo),
        joint=tuple(
            replace(j, lower=max(j.lower, -2.5), upper=min(j.upper, 2.5)) for j in arm.joint
        ),
    )


@pytest.mark.fault(9)
@pytest.mark.parametrize("rate", [7.0, 10.0, 20.0])
@pytest.mark.parametrize("silent", [(8,), (7, 8), WRIST])
def test_servos_read_one_by_one_do_not_stop_the_others_by_their_silence(
    classic_wrist: ArmDescription, rate: float, silent: tuple[int, ...]
) -> None:
    stepped = SteppedArm(classic_wrist)
    session = stepped.session(rate, accept_no_watchdog=True)
    start = session.read_posture()
    goal = start.copy()
    goal[0] += 0.8

    def fall_silent() -> None:
        for servo_id in silent:
            stepped.by_id[servo_id].silenced = True

    stepped.at(0.5, fall_silent)
    with pytest.raises(BusTimeoutError, match="has been silent") as caught:
        session.run(straight_way(start, goal, classic_wrist, rate))
    assert caught.value.servo_ids == (silent[0],)
    for servo in classic_wrist.servo:
        if servo.joint in classic_wrist.joint_names and servo.id not in WRIST:
            assert stepped.by_id[servo.id].memory.value("Bus Watchdog") == WATCHDOG_UNITS


def test_a_cycle_waits_once_for_several_that_are_silent(classic_wrist: ArmDescription) -> None:
    stepped = SteppedArm(classic_wrist)
    bus = stepped.session(10.0, accept_no_watchdog=True).bus
    plan = ReadPlan("single", 1, 36, 2, WRIST)
    for servo_id in WRIST[:2]:
        stepped.by_id[servo_id].silenced = True
    before = stepped.now()
    assert bus.exchange(b"", [plan], 0.1).keys() == {8}
    assert 0.1 + LEAST_MARGIN < stepped.now() - before < 0.1 + LEAST_MARGIN + 0.01
    assert bus.late == pytest.approx(0.1 + LEAST_MARGIN, abs=1e-3)
    before = stepped.now()
    assert bus.exchange(b"", [plan]).keys() == {8}  # the bus's own margin is each one's
    assert stepped.now() - before > 2 * bus.margin


@pytest.mark.fault(9)
def test_who_is_silent_is_named_before_who_was_stopped_meanwhile(human7: ArmDescription) -> None:
    posture, none = human7.rest, np.zeros(7)
    limits = CommandLimits.of(human7, 0.15, posture)
    watch = ArmWatch(WatchSettings(period=0.15, limits=limits, servos=human7.servo), 0.0)
    stopped = Health(0, bus_watchdog=WATCHDOG_EXPIRED)
    fresh = np.array([True] * 5 + [False] * 2)
    heard = [fresh | True, fresh, fresh]
    alert = np.zeros(7, dtype=np.bool_)
    for tick, answered in enumerate(heard):
        fault = watch.poll_fault(stopped)
        assert isinstance(fault, HardwareFaultError)
        assert fault.servo_id == 1
        state = JointState(posture, none, none, answered, alert)
        watch.update(0.15 * tick, posture, posture, state)
    named = watch.poll_fault(stopped)
    assert isinstance(named, BusTimeoutError)
    assert named.servo_ids == (6, 7)
    assert "no answer from servo 6 (wrist_flexion), servo 7 (wrist_deviation)" in str(named)
    assert "servo 1 (shoulder_flexion) was stopped by its bus watchdog" in str(named)
