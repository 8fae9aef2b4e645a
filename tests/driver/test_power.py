"""Profiles that are put back, and watchdogs that are switched off only if the servos say so."""

import dataclasses

import numpy as np
import pytest
from msgspec.structs import replace

from armsyn.arm import ArmDescription
from armsyn.arm.calibration import RADIANS_PER_TICK
from armsyn.driver import Ending
from armsyn.driver.facts import ServoFacts, read_facts
from armsyn.driver.models import VELOCITY_UNIT
from armsyn.driver.power import power_up, prepare, release_watchdogs
from armsyn.driver.profiles import streaming_profiles
from armsyn.driver.servos import ServoGroup
from armsyn.driver.timing import WATCHDOG_UNITS
from armsyn.errors import ArmFaultError, HardwareFaultError
from tests.driver.mixed_arm import AX, MX, mixed_arm
from tests.driver.stepped import SteppedArm, deafen, present_tick

LARGE = (0.6, 0.3, -0.6, 0.9)
ALL = tuple(range(1, 8))
BUS_WATCHDOG = 98
NET = [128] * 4 + [200] * 3
"""Profile velocities while streaming: the servos' Velocity Limit, or a little above the plan."""
PROFILE_VELOCITY = 112


def with_profiles(stepped: SteppedArm) -> None:
    for row, servo in enumerate(stepped.servos):
        servo.memory.store("Profile Velocity", 100 + row)
        servo.memory.store("Profile Acceleration", 20 + row)


def profiles(stepped: SteppedArm) -> list[int]:
    return stepped.value("Profile Velocity") + stepped.value("Profile Acceleration")


@pytest.mark.parametrize("stop", [False, True], ids=["completed", "stopped"])
def test_profiles_are_put_back_after_a_run(stepped: SteppedArm, stop: bool) -> None:
    with_profiles(stepped)
    before = profiles(stepped)
    session = stepped.session()
    if stop:
        stepped.at(0.3, session.stops.request)
    during = []
    recording = session.run(
        stepped.way(*LARGE), on_tick=lambda *_: during.append(profiles(stepped))
    )
    assert recording.ending in (Ending.COMPLETED, Ending.STOPPED_PARKED)
    assert during[0] == during[-1] == NET + [0] * 7
    assert profiles(stepped) == before


def test_a_profile_that_is_not_taken_back_is_said(stepped: SteppedArm) -> None:
    with_profiles(stepped)
    session = stepped.session()
    deafen(stepped.servos[4], PROFILE_VELOCITY, 104)
    with pytest.raises(HardwareFaultError) as caught:
        session.run(stepped.way(*LARGE))
    message = str(caught.value)
    assert "servo 5 (forearm_pronation) does not take 104 as its Profile Velocity" in message
    assert message.endswith("left with torque as the fault left it, holding, watchdog off")
    assert stepped.torque() == [1] * 7
    assert stepped.value("Bus Watchdog") == [0] * 7


def test_the_net_is_a_little_above_what_is_planned(human7: ArmDescription) -> None:
    slow = human7.slowed(4.0)
    stepped = SteppedArm(slow)
    seen: list[list[int]] = []
    recording = stepped.session().run(
        stepped.way(0.3, 0.2), on_tick=lambda *_: seen.append(stepped.value("Profile Velocity"))
    )
    net = np.array(seen[0]) * VELOCITY_UNIT
    assert (net >= 1.1 * slow.max_velocity + 1.0).all()
    assert (net <= 1.1 * slow.max_velocity + 1.0 + VELOCITY_UNIT).all()
    assert recording.ending is Ending.COMPLETED


@pytest.mark.parametrize(("drive_mode", "caught"), [(0, True), (4, False)])
def test_the_net_slows_a_goal_that_nobody_planned(
    human7: ArmDescription, drive_mode: int, caught: bool
) -> None:
    """In the time-based drive mode there is none."""
    slow = human7.slowed(4.0)
    servos = tuple(replace(servo, drive_mode=drive_mode) for servo in slow.servo)
    stepped = SteppedArm(replace(slow, servo=servos))
    session = stepped.session()
    session.run(stepped.way(0.1, 0.0, 0.0, 0.1))
    facts = read_facts(group := ServoGroup(stepped.bus, stepped.description.servo))
    power_up(group, prepare(group, facts, streaming_profiles(slow, facts, group)))
    wrist = stepped.servos[5]
    here = present_tick(wrist)
    group.write("Goal Position", {6: here + 400})
    before, fastest = here, 0.0
    for _ in range(30):
        stepped.clock.advance(0.02)
        stepped.bus.ping(1)  # feeds the watchdogs
        now = present_tick(wrist)
        fastest, before = max(fastest, (now - before) * RADIANS_PER_TICK / 0.02), now
    net = 1.1 * slow.max_velocity[5] + 1.0
    assert bool(fastest < 1.15 * net) is caught
    assert before > here + 100  # it went, only not at once


def test_profiles_stay_off_after_a_fault(stepped: SteppedArm) -> None:
    with_profiles(stepped)
    stepped.at(0.3, lambda: stepped.clock.advance(0.5))
    with pytest.raises(ArmFaultError, match="the host stalled"):
        stepped.session().run(stepped.way(*LARGE))
    assert profiles(stepped) == [0] * 14


def test_a_limp_arm_that_is_being_moved_gets_no_torque(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    with_profiles(stepped)
    before = profiles(stepped)
    session = stepped.session()

    def read_and_lower(group: ServoGroup) -> tuple[ServoFacts, ...]:
        facts = read_facts(group)
        stepped.port.simulation.catch_up(stepped.now())
        to = present_tick(stepped.by_id[4]) + 800
        stepped.port.simulation.inject(f"hand:id=4,to={to},speed=1,torque=0.5,for=5")
        stepped.clock.advance(0.2)
        return facts

    monkeypatch.setattr("armsyn.driver.run.read_facts", read_and_lower)
    with pytest.raises(HardwareFaultError, match=r"servo 4 .* before its torque came on"):
        session.run(stepped.way(*LARGE))
    assert stepped.torque() == [0] * 7
    assert stepped.value("Bus Watchdog") == [0] * 7
    assert profiles(stepped) == before


def expire(stepped: SteppedArm) -> None:
    """Leave a raised arm with its watchdogs expired."""
    session = stepped.session()
    stepped.at(0.4, lambda: stepped.clock.advance(0.5))
    with pytest.raises(ArmFaultError, match="the host stalled"):
        session.run(stepped.way(*LARGE))
    assert stepped.value("Bus Watchdog") == [255] * 7


@pytest.mark.fault(25)
def test_released_servos_stand_where_they_stood(stepped: SteppedArm) -> None:
    expire(stepped)
    group = ServoGroup(stepped.bus, stepped.description.servo)
    before = stepped.positions()
    assert release_watchdogs(group) == ALL
    assert stepped.value("Bus Watchdog") == [0] * 7
    stepped.clock.advance(1.0)
    assert np.abs(stepped.positions() - before).max() < 0.02
    assert release_watchdogs(group) == ()
    assert stepped.session().read_posture() == pytest.approx(stepped.positions(), abs=2e-3)


def test_a_watchdog_that_stays_on_is_said(stepped: SteppedArm) -> None:
    expire(stepped)
    group = ServoGroup(stepped.bus, stepped.description.servo)
    deafen(stepped.servos[1], BUS_WATCHDOG, 0)
    with pytest.raises(HardwareFaultError, match=r"servo 2 .* does not take 0 as its Bus Watchdog"):
        release_watchdogs(group)


@pytest.mark.fault(21)
def test_a_servo_that_keeps_an_old_goal_is_said(stepped: SteppedArm) -> None:
    expire(stepped)
    group = ServoGroup(stepped.bus, stepped.description.servo)
    elbow = stepped.servos[3]
    here = group.read("Present Position")[4]
    elbow.memory.store("Goal Position", here + 300)
    elbow.memory.store("Max Position Limit", here - 20)
    with pytest.raises(HardwareFaultError, match=r"servo 4 .* as its Goal Position"):
        release_watchdogs(group)


@pytest.mark.parametrize(
    ("servo_id", "off", "allowed"),
    [(AX, 46, False), (AX, 44, True), (MX, 150, False), (MX, 148, True)],
)
def test_servos_under_torque_may_be_off_their_goals_by_an_angle(
    servo_id: int, off: int, allowed: bool
) -> None:
    """An AX-12A's tick is 3.3 times that of an MX-28, or an X; 0.23 rad are allowed."""
    stepped = SteppedArm(mixed_arm())
    arm = stepped.description
    group = ServoGroup(stepped.bus, [s for s in arm.servo if s.joint in arm.joint_names])
    facts = [
        dataclasses.replace(f, torque_enabled=True, goal_position=f.present_position + off)
        if f.servo_id == servo_id
        else f
        for f in read_facts(group)
    ]
    if allowed:
        assert len(prepare(group, facts)) == len(facts)
    else:
        with pytest.raises(HardwareFaultError, match=f"servo {servo_id} .* {off} ticks from its"):
            prepare(group, facts)


def test_limp_servos_are_read_after_all_that_takes_time(stepped: SteppedArm) -> None:
    """They may be sinking meanwhile, and get torque where they are."""
    group = ServoGroup(stepped.bus, stepped.description.servo)
    facts = read_facts(group)
    before = facts[3].present_position
    armed: list[list[int]] = []

    def sink() -> None:
        armed.append(stepped.value("Bus Watchdog"))
        stepped.port.simulation.inject(f"hand:id=4,to={before + 20},speed=2,for=0.05")
        stepped.clock.advance(0.05)

    ready = prepare(group, facts, None, sink)
    assert armed == [[WATCHDOG_UNITS] * 7]
    here = group.read("Present Position")[4]
    assert abs(here - before) > 3
    assert ready[3].present_position == here
    power_up(group, ready)
    assert stepped.value("Goal Position")[3] == here
