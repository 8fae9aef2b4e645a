"""A host that is killed while it moves an arm of dual joints, or of servos without a watchdog."""

from __future__ import annotations

import subprocess
import sys
import time
from contextlib import closing

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.driver import ArmSession, Ending, straight_way
from armsyn.driver import registers as reg
from armsyn.driver.operate import clear
from armsyn.driver.servos import ServoGroup
from armsyn.driver.timing import WATCHDOG_SECONDS
from armsyn.driver.transactions import Bus
from armsyn.errors import HardwareFaultError
from firmware_sim.testing import running

RATE = 50.0
HOST = """
import sys
from msgspec.structs import replace
from armsyn.arm import load_arm
from armsyn.driver import ArmSession, straight_way

arm = load_arm(sys.argv[2])
slow = replace(arm, joint=tuple(replace(j, max_velocity=0.3) for j in arm.joint))

def on_tick(path_time, _duration):
    if path_time > 1.2:
        print("moving", flush=True)

with ArmSession.open(sys.argv[1], slow, 50.0, accept_no_watchdog=True) as session:
    goal = arm.rest.copy()
    goal[0] += 0.8 if goal[0] < arm.chain.lower[0] + arm.chain.upper[0] - goal[0] else -0.8
    session.run(straight_way(session.read_posture(), goal, slow, 50.0), on_tick=on_tick)
"""


def kill_in_mid_motion(port: str, arm: str) -> None:
    command = [sys.executable, "-c", HOST, port, arm]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as host:
        assert host.stdout is not None
        assert host.stdout.readline().strip() == "moving"
        host.kill()


@pytest.mark.fault(26)
@pytest.mark.parametrize("name", ["viperx_300s", "reachy_right"])
def test_a_killed_host_leaves_arms_of_all_kinds_holding(name: str) -> None:
    arm = load_arm(name)
    gripper = arm.gripper_servo
    moving = [servo for servo in arm.servo if servo is not gripper]
    with running(arguments=("--arm", name)) as port:
        kill_in_mid_motion(port, name)
        time.sleep(2.0 * WATCHDOG_SECONDS)  # in silence: any packet would feed the watchdogs
        with closing(Bus(port, arm.servo[0].baud)) as bus:
            group = ServoGroup(bus, moving, {servo.id: 99 for servo in moving})
            expired = group.read("Bus Watchdog")
            assert set(expired.values()) == {reg.WATCHDOG_EXPIRED}
            assert set(expired) == {servo.id for servo in moving if servo.protocol == 2}
            assert set(group.read("Torque Enable").values()) == {1}
            leaders = group.only(arm.leaders)
            before = arm.calibration.to_radians(list(leaders.read("Present Position").values()))
            assert 0.02 < abs(before[0] - arm.rest[0]) < 0.7  # on its way, and stopped there
            time.sleep(0.3)
            after = arm.calibration.to_radians(list(leaders.read("Present Position").values()))
            assert np.abs(after - before).max() < 0.01
            assert gripper is not None
            assert set(ServoGroup(bus, (gripper,)).read("Torque Enable").values()) == {0}
        with pytest.raises(HardwareFaultError, match=r"bus watchdog.*armsyn clear"):
            ArmSession.open(port, arm, RATE, accept_no_watchdog=True)
        with closing(Bus(port, arm.servo[0].baud)) as bus:
            assert clear(ServoGroup(bus, arm.servo)) == tuple(expired)
        with ArmSession.open(port, arm, RATE, accept_no_watchdog=True) as session:
            way = straight_way(session.read_posture(), arm.rest, arm, RATE)
            assert session.run(way).ending is Ending.COMPLETED
