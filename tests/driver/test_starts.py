"""Motions begin only where the arm is, however it has moved since they were checked."""

import numpy as np
import pytest
from msgspec.structs import replace

from armsyn.arm import ArmDescription
from armsyn.driver import Ending, session
from armsyn.driver.facts import ServoFacts, read_facts
from armsyn.driver.joints import JointState
from armsyn.driver.path import straight_way
from armsyn.driver.servos import ServoGroup
from armsyn.driver.setpoint import SetpointMotion
from armsyn.errors import LimitError
from armsyn.safety import START_TOLERANCE, check_trajectory
from tests.driver.stepped import SteppedArm

ELBOW = 3
OFF = [0] * 7
ELSEWHERE = r"joint elbow_flexion is at .* rad but the trajectory starts at .* rad"


def push(stepped: SteppedArm, offset: float) -> None:
    """Let a hand put the limp elbow `offset` rad off rest."""
    arm = stepped.description
    to = int(arm.calibration.to_ticks(arm.rest + offset)[ELBOW])
    stepped.port.simulation.inject(f"hand:id={ELBOW + 1},to={to},speed=2,for=1")
    stepped.clock.advance(1.2)
    assert stepped.positions()[ELBOW] == pytest.approx(arm.rest[ELBOW] + offset, abs=0.01)


def push_after_the_check(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch, offset: float
) -> None:
    def check(*args: object, **options: object) -> None:
        check_trajectory(*args, **options)  # type: ignore[arg-type]
        push(stepped, offset)

    monkeypatch.setattr(session, "check_trajectory", check)


def push_after_the_facts(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch, offset: float
) -> None:
    def read(group: ServoGroup) -> tuple[ServoFacts, ...]:
        facts = read_facts(group)
        push(stepped, offset)
        return facts

    monkeypatch.setattr("armsyn.driver.run.read_facts", read)


def with_profiles(stepped: SteppedArm) -> list[int]:
    for row, servo in enumerate(stepped.servos):
        servo.memory.store("Profile Velocity", 100 + row)
    return registers(stepped)


def registers(stepped: SteppedArm) -> list[int]:
    return stepped.value("Profile Velocity") + stepped.value("Bus Watchdog") + stepped.torque()


@pytest.mark.parametrize("offset", [0.07, -0.1, 0.3])
def test_an_arm_that_moved_after_the_check_is_not_pulled_back(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch, offset: float
) -> None:
    found = with_profiles(stepped)
    opened = stepped.session()
    push_after_the_check(stepped, monkeypatch, offset)
    with pytest.raises(LimitError, match=ELSEWHERE):
        opened.run(stepped.way(0.1))
    assert registers(stepped) == found
    assert opened.fault is None
    assert opened.recording is None


def test_what_it_moves_adds_up_until_torque(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each time by less than the tolerance: only both together are farther from the start."""
    found = with_profiles(stepped)
    opened = stepped.session()
    push_after_the_check(stepped, monkeypatch, 0.6 * START_TOLERANCE)
    push_after_the_facts(stepped, monkeypatch, 1.2 * START_TOLERANCE)
    with pytest.raises(LimitError, match=ELSEWHERE):
        opened.run(stepped.way(0.1))
    assert registers(stepped) == found
    assert opened.fault is None


def test_a_little_is_blended_into_the_motion(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = stepped.session()
    push_after_the_check(stepped, monkeypatch, 0.04)
    assert opened.run(stepped.way(0.1)).ending is Ending.COMPLETED


def test_setpoints_are_not_followed_from_elsewhere(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def wanted(t: float, _: JointState) -> np.ndarray:
        asked.append(t)
        return stepped.description.rest

    def check(*arguments: object) -> SetpointMotion:
        checked = of_the_driver(*arguments)  # type: ignore[arg-type]
        push(stepped, 0.2)
        return checked

    of_the_driver = SetpointMotion.check
    monkeypatch.setattr(SetpointMotion, "check", check)
    opened = stepped.session()
    with pytest.raises(LimitError, match=ELSEWHERE):
        opened.run_setpoint(wanted, 2.0)
    assert asked == [0.0]
    assert stepped.torque() == OFF


def test_goals_that_a_joint_is_held_off_are_judged_before_the_motion(
    human7: ArmDescription,
) -> None:
    """Without leads the stream begins at the goals: the way from them may be too fast."""
    slow = replace(human7, joint=tuple(replace(j, max_velocity=0.3) for j in human7.joint))
    stepped = SteppedArm(slow)
    opened = stepped.session()
    group = ServoGroup(stepped.bus, slow.servo)
    here = group.read("Present Position")
    group.write("Goal Position", here)
    group.write("Torque Enable", dict.fromkeys(here, 1))
    hand = f"hand:id={ELBOW + 1},to={here[ELBOW + 1]},speed=0.5,for=3"
    stepped.port.simulation.inject(hand)
    stepped.clock.advance(0.2)
    goals = here | {ELBOW + 1: here[ELBOW + 1] + 78}  # 0.12 rad
    group.write("Goal Position", goals)
    stepped.clock.advance(0.3)
    posture = opened.read_posture()
    goal = posture + np.eye(7)[0] * 0.1
    with pytest.raises(LimitError, match=r"elbow_flexion: the command jumps"):
        opened.run(straight_way(posture, goal, slow, 200.0))
    assert opened.fault is None
    assert group.read("Goal Position") == goals
    assert stepped.value("Bus Watchdog") == OFF
