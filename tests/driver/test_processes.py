"""Hosts that are interrupted or killed, ports that vanish: real processes on a real clock."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from armsyn.arm import ArmDescription
from armsyn.driver import ArmSession, Ending, clear_watchdogs
from armsyn.driver import registers as reg
from armsyn.driver.path import straight_way
from armsyn.driver.timing import WATCHDOG_SECONDS, WATCHDOG_UNITS
from armsyn.driver.transactions import Bus
from armsyn.errors import ArmFaultError, HardwareFaultError, PortError, PortLostError
from firmware_sim.testing import SimulatorProcess, running

ARM = ("--arm", "human7", "--baud", "1000000", "--return-delay", "0")
IDS = tuple(range(1, 8))

HOST = """
import sys
from msgspec.structs import replace
from armsyn.arm import load_arm
from armsyn.driver import ArmSession
from armsyn.driver.path import straight_way

said = set()
def say(word):
    if word not in said:
        said.add(word)
        print(word, flush=True)

def on_tick(path_time, _duration):
    if path_time > 0.3:
        say("moving")
    if session.stops.count:
        say("stopping")

arm = load_arm("human7")
slow = replace(arm, joint=tuple(replace(j, max_velocity=0.5) for j in arm.joint))
with ArmSession.open(sys.argv[1], slow, 100.0) as session:
    goal = arm.rest.copy()
    goal[3] += 1.0
    recording = session.run(straight_way(arm.rest, goal, slow, 100.0), on_tick=on_tick)
    print(recording.ending.name, flush=True)
    print(*arm.calibration.to_ticks(recording.sent_rad[-1]), flush=True)
"""


@pytest.fixture
def port() -> Iterator[str]:
    with running(arguments=ARM) as path:
        yield path


@contextmanager
def moving_host(port: str) -> Iterator[subprocess.Popen[str]]:
    """A program that streams a slow motion and is in the middle of it."""
    with subprocess.Popen(
        [sys.executable, "-c", HOST, port], stdout=subprocess.PIPE, text=True
    ) as host:
        try:
            assert said_by(host) == "moving"
            yield host
        finally:
            host.kill()


def said_by(host: subprocess.Popen[str]) -> str:
    assert host.stdout is not None
    return host.stdout.readline().strip()


def registers(port: str, register: reg.Register) -> list[int]:
    bus = Bus(port, 1_000_000)
    try:
        return list(bus.read_all(register, IDS).values())
    finally:
        bus.close()


@pytest.mark.fault(26)
def test_a_killed_host_leaves_the_watchdog_to_stop_the_arm(
    port: str, human7: ArmDescription
) -> None:
    with moving_host(port) as host:
        host.send_signal(signal.SIGKILL)
        host.wait()
    time.sleep(2.0 * WATCHDOG_SECONDS)  # in silence: any packet would feed the watchdogs
    assert registers(port, reg.BUS_WATCHDOG) == [reg.WATCHDOG_EXPIRED] * 7
    assert registers(port, reg.TORQUE_ENABLE) == [1] * 7
    with pytest.raises(HardwareFaultError, match="was stopped by its bus watchdog"):
        ArmSession.open(port, human7, 100.0)
    assert clear_watchdogs(port, human7) == IDS
    with ArmSession.open(port, human7, 100.0) as session:
        way = straight_way(session.read_posture(), human7.rest, human7, 100.0)
        assert session.run(way).ending is Ending.COMPLETED
    assert registers(port, reg.TORQUE_ENABLE) == [1] * 7
    assert clear_watchdogs(port, human7) == ()


@pytest.mark.fault(41)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_one_signal_decelerates_and_sees_to_the_arm(port: str, number: signal.Signals) -> None:
    with moving_host(port) as host:
        host.send_signal(number)
        assert said_by(host) == "stopping"
        assert said_by(host) in ("STOPPED_PARKED", "STOPPED_HOLDING")
        assert host.wait() == 0
    assert registers(port, reg.TORQUE_ENABLE) == [1] * 7
    assert registers(port, reg.BUS_WATCHDOG) == [0] * 7


@pytest.mark.fault(41)
def test_two_signals_hold_at_once(port: str) -> None:
    with moving_host(port) as host:
        host.send_signal(signal.SIGINT)
        assert said_by(host) == "stopping"
        host.send_signal(signal.SIGINT)
        assert said_by(host) == "ABORTED"
        held = [int(tick) for tick in said_by(host).split()]
        assert host.wait() == 0
    assert registers(port, reg.GOAL_POSITION) == pytest.approx(held, abs=4)
    # armed until it expires, in the silence since the host ended; then the servo refuses goals
    watchdogs = registers(port, reg.BUS_WATCHDOG)
    assert set(watchdogs) <= {WATCHDOG_UNITS, reg.WATCHDOG_EXPIRED}
    assert registers(port, reg.TORQUE_ENABLE) == [1] * 7
    time.sleep(2.0 * WATCHDOG_SECONDS)  # in silence: any packet would feed the watchdogs
    assert registers(port, reg.BUS_WATCHDOG) == [reg.WATCHDOG_EXPIRED] * 7
    # at its expiry each watchdog makes the horn's place the goal, which friction holds off the old
    assert registers(port, reg.GOAL_POSITION) == pytest.approx(held, abs=4)
    assert max(map(abs, registers(port, reg.PRESENT_VELOCITY))) <= 1


@pytest.mark.fault(40)
def test_a_second_program_is_refused(port: str, human7: ArmDescription) -> None:
    with moving_host(port) as host:
        with pytest.raises(PortError, match=f"is taken by process {host.pid}"):
            ArmSession.open(port, human7, 100.0)
        assert said_by(host) == "COMPLETED"  # and the first goes on undisturbed


@pytest.mark.fault(12)
def test_a_port_that_vanishes_in_mid_stream(human7: ArmDescription) -> None:
    simulator = SimulatorProcess(*ARM)
    stopped = []

    def on_tick(path_time: float, _: float) -> None:
        if path_time > 0.2 and not stopped:
            stopped.append(simulator.stop())

    goal = human7.rest.copy()
    goal[3] += 0.6
    with ArmSession.open(simulator.port, human7, 100.0) as session:
        with pytest.raises(PortLostError, match="was lost while in use"):
            session.run(straight_way(human7.rest, goal, human7, 100.0), on_tick=on_tick)
        assert session.recording is not None
        assert session.recording.ending is Ending.FAULT
        with pytest.raises(ArmFaultError):
            session.run(straight_way(human7.rest, goal, human7, 100.0))


def test_errors_leave_no_lock_behind(human7: ArmDescription) -> None:
    with running("xm430-w350:1", arguments=("--baud", "1000000")) as port:
        for _ in range(2):
            with pytest.raises(ArmFaultError, match="no answer from servo 2"):
                ArmSession.open(port, human7, 100.0)
