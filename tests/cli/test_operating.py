"""The commands of day one on one simulated arm, as a person gives them."""

from __future__ import annotations

import io
import math
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from typing import cast

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.driver import power
from armsyn.driver.servos import ServoGroup
from armsyn.driver.status import ArmStatus
from armsyn.driver.transactions import Bus
from firmware_sim.testing import RunningSimulator, simulated
from tests.cli.commands import Outcome, next_line, started

Call = Callable[..., Outcome]


@pytest.fixture(scope="module")
def omx() -> Iterator[RunningSimulator]:
    """An OpenManipulator-X that lies at rest at first."""
    with simulated(arguments=["--arm", "openmanipulator_x"]) as simulator:
        yield simulator


@pytest.fixture
def order(call: Call, omx: RunningSimulator) -> Iterator[Call]:
    """Give a command to that arm; it is limp and without faults before and afterwards."""

    def run(command: str, *arguments: object) -> Outcome:
        return call(command, *arguments, "--port", omx.link, "--arm", "openmanipulator_x")

    yield run
    if omx.status()["faults"]:
        omx.clear()
    if any(servo["error_bits"] for servo in omx.status()["servos"]):
        run("reboot", "--yes")
    if any(held(omx)):
        run("release", "--yes")


def answer(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO(text))


def refused(said: Outcome, status: int, text: str) -> None:
    """One line of error, after the line that says which arm."""
    assert said.status == status, said.err
    assert said.err.count("\n") == 1, said.err
    assert text in said.err
    assert said.out.count("\n") <= 1


def held(simulator: RunningSimulator) -> list[bool]:
    """Whether each servo's torque is on, as the simulator knows."""
    return [bool(s["registers"]["Torque Enable"]) for s in simulator.status()["servos"]]


def let_turn(simulator: RunningSimulator, hand: str) -> None:
    """Let a hand turn a joint, and wait until it has let go."""
    number = simulator.inject(hand)
    deadline = time.monotonic() + 30.0
    while any(fault["number"] == number for fault in simulator.status()["faults"]):
        assert time.monotonic() < deadline, "the hand does not let go"
        time.sleep(0.02)


def test_status_of_a_sound_arm(order: Call) -> None:
    said = order("status")
    assert said.status == 0, said.err
    lines = said.out.splitlines()
    assert lines[0].startswith("openmanipulator_x on ")
    assert [line.split()[:2] for line in lines[2:7]] == [
        *(["joint1", "11"], ["joint2", "12"], ["joint3", "13"], ["joint4", "14"]),
        ["gripper", "15"],
    ]
    assert any(line.startswith("hand: x 0.") for line in lines)
    assert any(line.startswith("bus: 1000000 baud") for line in lines)
    assert lines[-1] == "no problem found"
    document = order("status", "--json").document
    assert document["findings"] == []
    assert document["posture_rad"] == pytest.approx(load_arm("openmanipulator_x").rest, abs=0.002)
    assert document["servos"][0]["registers"]["Return Delay Time"] == 0


def test_no_number_is_minus_zero() -> None:
    from armsyn.cli.status_tables import hand_line

    class Found:
        hand = np.array([-1e-5, -0.0, 0.1])

    assert hand_line(cast(ArmStatus, Found())) == "hand: x 0.000, y 0.000, z 0.100 m (base frame)"


def test_status_of_a_damaged_arm_says_what_to_do(order: Call, omx: RunningSimulator) -> None:
    omx.inject("missing-servo:id=13")
    omx.inject("overload:id=12,for=0.1")
    said = order("status")
    assert said.status == 3
    assert [line.split()[0] for line in said.out.splitlines()[1:3]] == ["problem:", "problem:"]
    assert said.out.count("no reply: check") == 1
    problems = [line for line in said.out.splitlines() if line.startswith("problem: ")]
    assert any("servo 13 (joint3): no reply: check its power" in line for line in problems)
    assert any("servo 12 (joint2): hardware error: overload" in line for line in problems)
    document = order("status", "--json").document
    assert document["hand_m"] is None
    assert [servo["answers"] for servo in document["servos"]] == [True, True, False, True, True]


def test_a_wrong_baud_rate_points_to_the_scan(order: Call, omx: RunningSimulator) -> None:
    for servo_id in range(11, 16):
        omx.inject(f"wrong-baud:id={servo_id}")
    said = order("status")
    assert said.status == 3
    assert "no reply at 1000000 baud from any servo of openmanipulator_x" in said.out
    assert "hand:" not in said.out  # nor any table of what is not known
    said = order("release")
    assert said.status == 3
    assert "no reply at 1000000 baud" in said.err
    assert "armsyn scan" in said.err


def test_jog_and_park(order: Call, omx: RunningSimulator) -> None:
    before = order("status", "--json").document["posture_rad"]
    said = order("jog", "joint2", "6", "--speed", "30")
    assert said.status == 0, said.err
    assert said.out.splitlines()[-1].startswith("joint2: -68.")
    assert (
        said.out.endswith("degrees (+6.0); at the target, torque on, holding\n") or "(+" in said.out
    )
    document = order("jog", "joint2", "-2", "--speed", "30", "--json").document
    moved = document["after_rad"] - before[1]
    assert moved == pytest.approx(math.radians(4.0), abs=0.01)
    assert held(omx) == [True] * 4 + [False]
    said = order("park")
    assert said.status == 0, said.err
    last = said.out.splitlines()[-1]
    assert last.startswith("parked, torque off (")
    assert last.endswith(" degrees off rest, before the torque went off, the farthest)")
    assert held(omx) == [False] * 5
    assert "nothing has moved" in order("park").out
    assert order("park", "--json").document == {"ending": "already parked"}


def test_parking_is_measured_before_the_arm_is_let_go(
    order: Call, omx: RunningSimulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is released falls: how well it was parked shows before."""
    let_go = power.torque_off
    arm = load_arm("openmanipulator_x")
    fallen = arm.calibration.to_ticks(arm.rest)[0] + 200

    def falls(group: ServoGroup) -> None:
        let_go(group)
        let_turn(omx, f"hand:id=11,to={fallen},speed=5,for=0.5")

    order("jog", "joint2", "6", "--speed", "30")
    monkeypatch.setattr(power, "torque_off", falls)
    found = order("park", "--json").document
    assert found["ending"] == "parked, torque off"
    assert found["off_rest_rad"] < 0.05
    there = order("status", "--json").document["posture_rad"]
    let_turn(omx, f"hand:id=11,to={fallen - 200},speed=5,for=0.5")  # as the next one expects it
    assert there[0] - arm.rest[0] == pytest.approx(200 * 2 * math.pi / 4096, abs=0.05)


def test_a_joint_beyond_its_range_goes_back_only(order: Call, omx: RunningSimulator) -> None:
    arm = load_arm("openmanipulator_x")
    posture = arm.rest.copy()
    posture[3] = arm.chain.upper[3] + math.radians(1.0)
    tick = int(arm.calibration.to_ticks(posture)[3])
    let_turn(omx, f"hand:id=14,to={tick},speed=5,for=2")
    out = order("jog", "joint4", "2", "--speed", "30")
    assert out.status == 4
    assert "0.00 degrees are left that way" in out.err
    back = order("jog", "joint4", "-2", "--speed", "30")
    assert back.status == 0, back.err
    assert "joint4 is 1.0 degrees beyond its range: back from there only" in back.out
    assert back.err == ""


def test_a_misspelt_joint_is_named_before_any_port(call: Call) -> None:
    for command in (("jog", "elbow_flexon", "5"), ("release", "--joint", "elbow_flexon")):
        said = call(*command)
        assert said.status == 2
        assert "; did you mean 'elbow_flexion'?" in said.err
    call("jog", "elbow_flexon", "5", "--port", "/dev/none", "--arm", "human7").refused(
        2, "has no joint 'elbow_flexon'"
    )


def test_release_asks_and_says_what_falls(
    order: Call, omx: RunningSimulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    order("jog", "joint2", "20", "--speed", "60")
    answer(monkeypatch, "n\n")
    said = order("release")
    assert said.status == 130
    assert "what will fall: joint3 (holds 0." in said.out
    assert said.err.endswith("armsyn: nothing was done\n")
    answer(monkeypatch, "")
    said = order("release")
    assert said.status == 2
    assert "--yes says yes" in said.err
    assert held(omx) == [True] * 4 + [False]
    answer(monkeypatch, "y\n")
    assert order("release", "--joint", "joint2").out.endswith("torque off: servo 12\n")
    assert held(omx) == [True, False, True, True, False]
    refused(order("release", "--joint", "nose"), 2, "no joint 'nose'; it has joint1")
    assert order("release", "--yes", "--json").document == {
        "let_go": [11, 13, 14],
        "limp_before": [12, 15],
    }
    assert "off already" in order("release").out


def test_clear_and_reboot_after_faults(order: Call, omx: RunningSimulator) -> None:
    assert "no bus watchdog is armed or expired" in order("clear").out
    order("jog", "joint2", "6", "--speed", "60")
    omx.inject("overload:id=12,for=0.1")
    while not omx.status()["servos"][1]["error_bits"]:
        pass  # it strikes at the simulator's next tick
    said = order("jog", "joint2", "6")
    assert said.status == 3
    assert "armsyn reboot" in said.err
    said = order("clear", "--yes")
    assert said.status == 3
    assert "still there: servo 12 (joint2) reports a hardware error: overload" in said.out
    said = order("reboot", "--yes")
    assert said.status == 0, said.err
    assert "to be restarted: servo 12 (joint2), hardware error: overload" in said.out
    assert "without an error, torque off, RAM as at power-on" in said.out
    assert "no servo reports a hardware error" in order("reboot").out
    refused(order("reboot", "--servo", "99"), 3, "no servo 99 that answers")


def test_grip_holds_what_is_between_the_fingers(order: Call, omx: RunningSimulator) -> None:
    said = order("grip", "open")
    assert said.status == 0, said.err
    assert "mm apart, nothing held; torque on" in said.out
    omx.inject("obstacle:id=15,tick=2100,side=above")
    document = order("grip", "close", "--current", "0.3", "--json").document
    assert document["held"]
    assert document["width_m"] == pytest.approx(0.0366, abs=0.001)
    assert document["current_a"] == pytest.approx(0.3, rel=0.1)
    omx.clear()
    for width in ("wide", "nan", "inf", "-inf"):
        refused(order("grip", width), 2, f"'{width}' is neither open, close nor a width in mm")
    refused(order("grip", "-5"), 2, "20 to 75 mm, -5 mm are asked for")
    refused(order("grip", "200"), 2, "20 to 75 mm")


def test_grip_asks_before_it_drops_what_it_holds(
    order: Call, omx: RunningSimulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    order("grip", "40")
    order("release", "--yes", "--joint", "gripper")
    with closing(Bus(omx.link, 1_000_000)) as bus:  # as another program may leave it
        group = ServoGroup(bus, load_arm("openmanipulator_x").servo[-1:])
        group.set("Operating Mode", {15: 3})
        group.set("Torque Enable", {15: 1})
    answer(monkeypatch, "n\n")
    said = order("grip", "open")
    assert said.status == 130
    assert "its torque goes off for that: what it holds falls" in said.err
    answer(monkeypatch, "y\n")
    assert order("grip", "open").status == 0


@pytest.mark.parametrize(
    "arguments",
    [
        ("status",),
        ("park",),
        ("release",),
        ("clear",),
        ("reboot",),
        ("jog", "joint1", "1"),
        ("grip", "open"),
    ],
    ids=lambda arguments: arguments[0],
)
def test_every_command_refuses_what_is_no_arm(call: Call, arguments: tuple[str, ...]) -> None:
    call(*arguments, "--port", "/dev/nothing").refused(2, "--port needs --arm")
    said = call(*arguments, "--port", "/dev/nothing", "--arm", "openmanipulator_x")
    assert said.status == 3
    assert "/dev/nothing does not exist" in said.err
    assert said.err.count("\n") == 1
    call(*arguments, "--arm", "hug_mp4").refused(2, "has no servos")
    both = ("--port", "x", "--arm", "human7", "--plant", "mujoco")
    call(*arguments, *both).refused(2, "--plant is of simulated arms")


def test_the_watch_ends_with_ctrl_c(omx: RunningSimulator) -> None:
    process = started("status", "--watch", "--port", omx.link, "--arm", "openmanipulator_x")
    try:
        assert next_line(process).startswith("openmanipulator_x on ")
        while "joint2" not in next_line(process):
            pass
        os.kill(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=60)
    finally:
        process.kill()
        process.communicate()
    assert process.returncode == 0, err
    assert out.rstrip().endswith("no problem found")
