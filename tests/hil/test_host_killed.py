"""A program that is killed while it moves the arm: the servos stop it, somebody clears it."""

import subprocess
import sys
import time
from contextlib import closing

import numpy as np
import pytest

from armsyn.arm import ArmDescription
from armsyn.driver import ArmMonitor, ArmSession, Ending, straight_way
from armsyn.driver import registers as reg
from armsyn.driver.operate import clear, read_latched
from armsyn.driver.servos import ServoGroup
from armsyn.driver.timing import WATCHDOG_SECONDS
from armsyn.driver.transactions import Bus
from armsyn.errors import HardwareFaultError

RATE = 50.0
HOST = """
import sys
from msgspec.structs import replace
from armsyn.arm import load_arm
from armsyn.driver import ArmSession, straight_way

port, name, consent, goal = sys.argv[1], sys.argv[2], sys.argv[3] == "True", float(sys.argv[4])
arm = load_arm(name)
slow = replace(arm, joint=tuple(replace(j, max_velocity=0.2) for j in arm.joint))

def on_tick(path_time, duration):
    if path_time > 0.3 * duration:
        print("moving", flush=True)

with ArmSession.open(port, slow, 50.0, accept_no_watchdog=consent) as session:
    here = session.read_posture()
    there = here.copy()
    there[0] = goal
    session.run(straight_way(here, there, slow, 50.0), on_tick=on_tick)
"""


def kill_in_mid_motion(*arguments: object) -> None:
    command = [sys.executable, "-c", HOST, *map(str, arguments)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as host:
        assert host.stdout is not None
        assert host.stdout.readline().strip() == "moving"
        host.kill()


def posture(port: str, arm: ArmDescription) -> np.ndarray:
    with ArmMonitor.open(port, arm) as monitor:
        return monitor.read_posture()


def test_a_killed_program_leaves_an_arm_that_holds_until_it_is_cleared(
    port: str, arm: ArmDescription, consent: bool
) -> None:
    here = posture(port, arm)
    middle = 0.5 * (arm.chain.lower[0] + arm.chain.upper[0])
    goal = here[0] + (0.3 if here[0] < middle else -0.3)
    kill_in_mid_motion(port, arm.name, consent, goal)
    time.sleep(2.0 * WATCHDOG_SECONDS)  # in silence: any packet would feed the watchdogs
    with closing(Bus(port, arm.servo[0].baud)) as bus:
        moving = ServoGroup(bus, (*arm.leaders, *arm.shadows))
        for servo in moving.servos:
            moving.firmware[servo.id] = bus.ping(servo.id)[1]
        assert set(moving.read("Torque Enable").values()) == {1}
        watchdogs = moving.read("Bus Watchdog")
        assert set(watchdogs.values()) <= {reg.WATCHDOG_EXPIRED}
    stopped = posture(port, arm)
    assert 0.01 < abs(stopped[0] - here[0]) < 0.29
    time.sleep(0.5)
    assert np.abs(posture(port, arm) - stopped).max() < 0.02
    if watchdogs:
        with pytest.raises(HardwareFaultError, match="armsyn clear"):
            ArmSession.open(port, arm, RATE, accept_no_watchdog=consent)
    with closing(Bus(port, arm.servo[0].baud)) as bus:
        everybody = ServoGroup(bus, arm.servo)
        assert set(clear(everybody)) == set(watchdogs)
        assert not read_latched(everybody).watchdogs
    with ArmSession.open(port, arm, RATE, accept_no_watchdog=consent) as session:
        back = straight_way(session.read_posture(), here, arm, RATE)
        assert session.run(back).ending is Ending.COMPLETED
