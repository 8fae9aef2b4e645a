"""`armsyn reach` that is interrupted or killed: how the arm is left, and what is left running."""

import json
import os
import select
import signal
from pathlib import Path

import numpy as np
import pytest

from armsyn.driver import load_recording
from armsyn.driver import registers as reg
from armsyn.driver.transactions import Bus
from armsyn.motion.formats import read_motion
from firmware_sim.testing import running
from tests.cli.commands import next_line, started

pytestmark = pytest.mark.usefixtures("compiled")

ARM = ("--arm", "human7", "--baud", "1000000", "--return-delay", "0")
TARGET = ("--target", "0.35", "-0.1", "-0.15", "--rate", "100")
IDS = tuple(range(1, 8))

MOVING = """
from armsyn.driver import ArmSession
run = ArmSession.run
def told(self, trajectory, park=None, on_tick=None):
    said = set()
    def tick(path_time, duration):
        word = "stopping" if self.stops.count else "moving"
        if path_time > 0.3 and word not in said:
            said.add(word)
            print(word, flush=True)
    return run(self, trajectory, park, tick)
ArmSession.run = told
"""


def registers(port: str, register: reg.Register) -> list[int]:
    bus = Bus(port, 1_000_000)
    try:
        return list(bus.read_all(register, IDS).values())
    finally:
        bus.close()


def test_one_interruption_stops_softly_and_keeps_the_recording(tmp_path: Path) -> None:
    record = tmp_path / "reach.npz"
    with (
        running(arguments=ARM) as port,
        started(
            *("reach", *TARGET, "--arm", "human7", "--port", port, "--json", "--record", record),
            hook=MOVING,
        ) as process,
    ):
        assert next_line(process) == "moving"
        process.send_signal(signal.SIGINT)
        assert next_line(process) == "stopping"
        rest, errors = process.communicate(timeout=60)
        assert process.returncode == 130, errors
        assert errors == f"human7 on {port}, not calibrated: the description's zeros\n"
        document = json.loads(rest)
        assert document["ending"].startswith("stopped on request")
        assert document["simulated"] is False
        assert document["hand_error_m"] is document["min_jerk_r"] is None
        assert document["not_measured"] == "the reach was stopped before its end"
        with np.load(record) as file:
            assert str(file["ending"]) in ("STOPPED_HOLDING", "STOPPED_PARKED")
            assert file["time_s"].size == document["ticks"]
        assert registers(port, reg.TORQUE_ENABLE) == [1] * 7
        assert registers(port, reg.BUS_WATCHDOG) == [0] * 7


def test_a_second_interruption_holds_at_once() -> None:
    with (
        running(arguments=ARM) as port,
        started(
            *("reach", *TARGET, "--arm", "human7", "--port", port, "--json"), hook=MOVING
        ) as process,
    ):
        assert next_line(process) == "moving"
        process.send_signal(signal.SIGINT)
        assert next_line(process) == "stopping"
        process.send_signal(signal.SIGINT)
        rest, errors = process.communicate(timeout=60)
        assert process.returncode == 130, errors
        assert json.loads(rest)["ending"].startswith("held at once")
        assert registers(port, reg.TORQUE_ENABLE) == [1] * 7


def children(process: int) -> list[int]:
    tasks = Path(f"/proc/{process}/task").iterdir()
    return [int(child) for task in tasks for child in (task / "children").read_text().split()]


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_a_command_that_is_ended_takes_its_simulator_along(number: signal.Signals) -> None:
    with started("reach", *TARGET, "--return", hook=MOVING) as process:
        assert next_line(process).startswith("simulated human7 on /dev/")
        assert next_line(process) == "moving"
        (simulator,) = children(process.pid)
        watch = os.pidfd_open(simulator)
        try:
            process.send_signal(number)
            said, _ = process.communicate(timeout=60)
            if number == signal.SIGINT:  # how it ended comes first, and nothing scores it
                assert said.startswith("stopping\nended: stopped on request")
                assert "its target" not in said
            assert process.returncode == (-9 if number == signal.SIGKILL else 130)
            ended, _, _ = select.select([watch], [], [], 20.0)
            assert ended, "the simulator still runs"
        finally:
            os.close(watch)


@pytest.mark.parametrize("suffix", ["csv", "npz"])
def test_a_fault_in_mid_reach_is_one_line_and_keeps_the_recording(
    tmp_path: Path, suffix: str
) -> None:
    record = tmp_path / f"reach.{suffix}"
    with started("reach", *TARGET, "--record", record, hook=MOVING) as process:
        next_line(process)
        assert next_line(process) == "moving"
        (simulator,) = children(process.pid)
        os.kill(simulator, signal.SIGKILL)
        _, errors = process.communicate(timeout=60)
        assert process.returncode == 3, errors
        said, error = errors.splitlines()
        assert said == f"what was recorded until then: {record}"
        assert error.startswith("armsyn: ")
        assert "the simulated arm ended by itself: status -9" in error
    assert read_motion(record).duration > 0.25
    if suffix == "npz":
        assert load_recording(record).target_m == (0.35, -0.1, -0.15)
