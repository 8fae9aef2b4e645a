"""Arms with weight: where they end, and by how much goals lead against gravity."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from armsyn.arm import ArmDescription, arm_names, gravity_torque, load_arm
from armsyn.arm.motors import position_stiffness
from armsyn.driver import Ending, Recording, straight_way
from armsyn.driver.gravity import (
    FASTEST_LEAD,
    GENTLE_LEAD,
    LARGEST_CORRECTION,
    LARGEST_FEEDFORWARD,
    GoalLead,
    LeadSettings,
)
from armsyn.driver.joints import JointState
from armsyn.driver.operate import clear
from armsyn.driver.servos import ServoGroup
from armsyn.driver.stillness import still_posture
from armsyn.errors import CollisionError
from armsyn.safety import check_trajectory
from firmware_sim.tables import find_model
from tests.driver.heavy import HeavyArm

pytest.importorskip("mujoco")

DRIVEN = [name for name in arm_names() if load_arm(name).servo]
TICK = 2.0 * np.pi / 4096


def goal_of(arm: ArmDescription) -> np.ndarray:
    """A posture on the way from rest to the middle of all ranges."""
    middle = 0.5 * (arm.chain.lower + arm.chain.upper)
    change = np.clip(middle - arm.rest, -0.4, 0.4)
    for part in (1.0, 0.5, 0.25, -0.5):  # the first that touches nothing
        goal = np.clip(arm.rest + part * change, arm.chain.lower, arm.chain.upper)
        try:
            check_trajectory(straight_way(arm.rest, goal, arm, 200.0), arm)
        except CollisionError:
            continue
        return goal
    raise AssertionError(f"no way from the rest of {arm.name}")


def go(heavy: HeavyArm, goal: np.ndarray, *, gravity: bool = True) -> Recording:
    session = heavy.session(accept_no_watchdog=True)
    session.gravity = gravity
    arm = heavy.description
    return session.run(straight_way(still_posture(session, heavy), goal, arm, 200.0))


def miss_mm(heavy: HeavyArm, goal: np.ndarray) -> float:
    chain = heavy.description.chain
    off = chain.forward(heavy.positions()[: goal.size]).tip - chain.forward(goal).tip
    return 1000.0 * float(np.linalg.norm(off))


@pytest.mark.parametrize("name", DRIVEN)
def test_every_arm_ends_where_it_should(name: str) -> None:
    arm = load_arm(name)
    heavy, goal = HeavyArm(arm), goal_of(arm)
    recording = go(heavy, goal)
    assert recording.ending is Ending.COMPLETED
    assert miss_mm(heavy, goal) < 2.5
    assert recording.commanded_rad[-1] == pytest.approx(goal)
    assert np.abs(recording.sent_rad - recording.commanded_rad).max() > 5 * TICK
    assert not [event for event in recording.events if event.level != "info"]


def test_without_it_the_arm_droops(human7: ArmDescription) -> None:
    heavy, goal = HeavyArm(human7), goal_of(human7)
    recording = go(heavy, goal, gravity=False)
    assert miss_mm(heavy, goal) > 10.0
    assert np.array_equal(recording.sent_rad, recording.commanded_rad)


def test_a_load_that_nobody_declared_is_corrected(human7: ArmDescription) -> None:
    tip = replace(human7.tip, mass=human7.tip.mass + 0.2)
    heavy, goal = HeavyArm(human7, real=replace(human7, tip=tip)), goal_of(human7)
    go(heavy, goal)
    assert miss_mm(heavy, goal) < 2.5


def test_an_arm_without_masses_is_corrected_and_its_droop_said(human7: ArmDescription) -> None:
    bare = replace(human7, joint=tuple(replace(joint, link=None) for joint in human7.joint))
    heavy, goal = HeavyArm(bare, real=human7), goal_of(human7)
    recording = go(heavy, goal)
    assert miss_mm(heavy, goal) < 2.5
    said = recording.events[0]
    # the softest joint is an XM430's: 1 rad is 800 / 128 / 885 of its 4.1 N m a tick
    assert said.level == "warning"
    assert said.text.startswith("no masses are declared: the arm droops until it is corrected")
    assert (
        f"{np.degrees(1.0 / (800 / 128 / 885 / TICK * 4.1)):.1f} degrees for each N m" in said.text
    )


@pytest.mark.fault(43)
def test_an_arm_that_holds_does_not_dip_as_it_goes_on(human7: ArmDescription) -> None:
    heavy, goal = HeavyArm(human7), goal_of(human7)
    go(heavy, goal)
    before = heavy.positions()
    recording = go(heavy, goal + np.array([0.05, 0, 0, 0, 0, 0, 0]))
    assert np.abs(recording.measured_rad[:20, 1:] - before[1:]).max() < 3 * TICK


def test_a_fault_holds_with_the_goals_that_carry_the_arm(human7: ArmDescription) -> None:
    heavy, goal = HeavyArm(human7), goal_of(human7)
    session = heavy.session()

    def on_tick(path_time: float, _: float) -> None:
        if path_time > 0.4:
            raise KeyError("theirs")

    with pytest.raises(KeyError):
        session.run(straight_way(session.read_posture(), goal, human7, 200.0), on_tick=on_tick)
    assert session.recording is not None
    held = human7.calibration.to_ticks(session.recording.sent_rad[-1])
    assert heavy.value("Goal Position")[:7] == held.tolist()
    assert np.abs(session.recording.sent_rad[-1] - session.recording.commanded_rad[-1]).max() > 0.01


@pytest.mark.parametrize("name", ["human7", "viperx_300s"])
def test_clearing_a_loaded_arm_does_not_let_it_sink(name: str) -> None:
    arm = load_arm(name)
    heavy, goal = HeavyArm(arm), goal_of(arm)
    session = heavy.session(accept_no_watchdog=True)

    def on_tick(path_time: float, duration: float) -> None:
        if path_time >= duration:
            raise KeyError("theirs")

    with pytest.raises(KeyError):
        session.run(straight_way(session.read_posture(), goal, arm, 200.0), on_tick=on_tick)
    heavy.clock.advance(1.5)
    assert 255 in heavy.value("Bus Watchdog")
    before = heavy.positions()
    assert clear(ServoGroup(heavy.bus, arm.servo)) != ()
    heavy.clock.advance(1.5)
    assert np.abs(heavy.positions() - before).max() < 2 * TICK


def test_the_lead_is_the_weight_over_the_stiffness(human7: ArmDescription) -> None:
    heavy, goal = HeavyArm(human7), goal_of(human7)
    recording = go(heavy, goal)
    motors = [find_model(servo.model).motor for servo in human7.servo]
    stiffness = 800 / 128 / 885 / TICK * np.array([motor.stall_torque for motor in motors])
    by_hand = gravity_torque(human7, goal) / stiffness
    lead = recording.sent_rad[-1] - recording.commanded_rad[-1]
    # static friction is 1.2 % of the stall torque; an encoder shows ticks; the supply sags
    band = 0.012 / (800 / 128 / 885 / TICK) + 2 * TICK
    assert np.abs(lead - by_hand).max() < band + 0.05 * np.abs(by_hand).max()


@pytest.mark.parametrize("model", ["xm540-w270", "xm430-w350", "xl430-w250", "xl330-m288"])
def test_stiffness_of_the_simulator_s_motors(model: str) -> None:
    motor = find_model(model).motor
    by_hand = 800 / 128 / 885 / TICK * motor.stall_torque
    assert position_stiffness(model, 2, motor.nominal_voltage, 800) == pytest.approx(by_hand)
    assert position_stiffness(model, 2, 0.5 * motor.nominal_voltage, 400) == pytest.approx(
        by_hand / 4
    )


def test_models_of_unknown_torque_have_no_stiffness() -> None:
    assert np.isnan(position_stiffness("xl-320", 2, 7.4, 32))


def settings_of(arm: ArmDescription, *, active: bool = True) -> LeadSettings:
    return LeadSettings(
        arm, np.full(7, 20.0), arm.chain.lower, arm.chain.upper, period=0.005, active=active
    )


def state_at(position: np.ndarray, speed: float = 0.0) -> JointState:
    n = position.size
    return JointState(
        position,
        np.full(n, speed),
        np.full(n, np.nan),
        np.ones(n, dtype=np.bool_),
        np.zeros(n, dtype=np.bool_),
    )


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.floats(0.0, 1.0), min_size=7, max_size=7),
    st.lists(st.floats(-0.3, 0.3), min_size=7, max_size=7),
    st.booleans(),
    st.booleans(),
)
def test_goals_stay_in_range_and_never_leap(
    human7: ArmDescription, where: list[float], off: list[float], holds: bool, active: bool
) -> None:
    lower, upper = human7.chain.lower, human7.chain.upper
    wanted = lower + np.array(where) * (upper - lower)
    sent = np.clip(wanted + 0.2 * np.array(off), lower, upper)
    lead = GoalLead(settings_of(human7, active=active), wanted, sent, np.full(7, holds))
    last = sent
    for _ in range(300):
        goals = lead.goals(wanted)
        assert (goals >= lower).all()
        assert (goals <= upper).all()
        assert np.abs(goals - last).max() <= FASTEST_LEAD * 0.005 + 1e-12
        lead.correct(wanted, state_at(wanted + np.array(off)))
        last = goals
    most = (LARGEST_CORRECTION + LARGEST_FEEDFORWARD) if active else 0.0
    assert np.abs(last - wanted).max() <= most + 1e-9


def test_the_lead_comes_up_gently_under_a_limp_arm(human7: ArmDescription) -> None:
    soft = dataclasses.replace(settings_of(human7), stiffness=np.full(7, 5.0))
    wanted = human7.chain.lower + 0.5 * (human7.chain.upper - human7.chain.lower)
    lead = GoalLead(soft, wanted, wanted, np.zeros(7, dtype=np.bool_))
    goals = np.array([wanted, *(lead.goals(wanted) for _ in range(400))])
    needed = soft.feedforward(wanted)
    assert np.abs(needed).max() > 0.08
    assert goals[-1] - wanted == pytest.approx(needed)
    # a minimum-jerk course is 15/8 of its average at most
    assert np.abs(np.diff(goals, axis=0)).max() / 0.005 < 1.9 * GENTLE_LEAD


def test_nothing_is_corrected_while_a_joint_moves_or_is_held(human7: ArmDescription) -> None:
    for off, speed in ((0.05, 0.2), (0.13, 0.0)):
        lead = GoalLead(settings_of(human7), human7.rest, human7.rest, np.zeros(7, dtype=np.bool_))
        for _ in range(200):
            goals = lead.goals(human7.rest)
            lead.correct(human7.rest, state_at(human7.rest - off, speed))
        weight = gravity_torque(human7, human7.rest) / 20.0
        assert goals - human7.rest == pytest.approx(weight, abs=1e-9)


def test_a_joint_at_the_end_of_its_range_sags(human7: ArmDescription) -> None:
    stop = human7.rest.copy()
    stop[0] = human7.chain.upper[0]
    lead = GoalLead(settings_of(human7), stop, stop, np.zeros(7, dtype=np.bool_))
    pulls = gravity_torque(human7, stop)[0]
    for _ in range(100):
        goals = lead.goals(stop)
    assert lead.limited[0] == (pulls > 0.0)
    assert goals[0] <= human7.chain.upper[0]
