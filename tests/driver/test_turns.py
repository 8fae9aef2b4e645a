"""Counts of turns: what is refused when they are lost, or cannot be known."""

import numpy as np
import pytest
from msgspec.structs import replace

from armsyn.arm import ArmDescription, load_arm
from armsyn.driver import Ending, straight_way
from armsyn.driver.facts import read_facts
from armsyn.driver.limits import check_position_limits, with_servo_limits
from armsyn.driver.power import release_watchdogs
from armsyn.driver.servos import ServoGroup
from armsyn.errors import HardwareFaultError, LimitError, ServoLoadError, ServoMismatchError
from armsyn.safety import CommandLimits
from tests.driver.stepped import SteppedArm

ELBOW = 4
EXTENDED = 4


def extended(stepped: SteppedArm, turns: int = 0) -> None:
    """Put the elbow into extended position mode and let it have counted whole turns."""
    servo = stepped.by_id[ELBOW]
    assert servo.write(11, bytes([EXTENDED])) == 0
    offset = turns * 4096
    assert servo.write(20, offset.to_bytes(4, "little", signed=True)) == 0  # as turns count


def test_extended_mode_within_the_described_turn_moves(stepped: SteppedArm) -> None:
    extended(stepped)
    assert stepped.session().run(stepped.way(0.2, 0, 0, 0.3)).ending is Ending.COMPLETED


@pytest.mark.fault(24)
@pytest.mark.parametrize("turns", [1, -2])
def test_another_turn_than_described_is_refused(stepped: SteppedArm, turns: int) -> None:
    extended(stepped, turns)
    with pytest.raises(ServoMismatchError) as caught:
        stepped.session()
    message = str(caught.value)
    assert "servo 4 (elbow_flexion) reads tick" in message
    assert "has lost count of its turns" in message
    assert "armsyn calibrate" in message


@pytest.mark.fault(24)
def test_after_a_restart_the_described_turn_is_back(stepped: SteppedArm) -> None:
    extended(stepped)
    stepped.by_id[ELBOW].reboot()
    stepped.clock.advance(0.3)
    assert stepped.session().run(stepped.way(0.2, 0, 0, 0.3)).ending is Ending.COMPLETED


@pytest.mark.fault(24)
@pytest.mark.parametrize("mode", [3, EXTENDED])
def test_a_joint_of_several_turns_is_refused_where_turns_are_forgotten(
    human7: ArmDescription, mode: int
) -> None:
    joints = tuple(
        replace(j, lower=-6.0, upper=6.0) if j.name == "elbow_flexion" else j for j in human7.joint
    )
    stepped = SteppedArm(replace(human7, joint=joints))
    stepped.by_id[ELBOW].write(11, bytes([mode]))
    if mode == EXTENDED:
        with pytest.raises(ServoMismatchError, match="is more than a turn"):
            stepped.session()
    else:  # position mode has one turn only: goals beyond it are refused instead
        stepped.session()


def test_position_mode_ends_with_the_turn(human7: ArmDescription) -> None:
    servos = tuple(
        replace(s, zero_tick=s.zero_tick + 1500, rest_tick=s.rest_tick + 1500) if s.id == 1 else s
        for s in human7.servo
    )
    stepped = SteppedArm(replace(human7, servo=servos))
    group = ServoGroup(stepped.bus, servos)
    way = stepped.way(1.5)
    with pytest.raises(LimitError, match="its own limits are 0 to 4095") as caught:
        check_position_limits(way, read_facts(group), stepped.description)
    assert caught.value.limit == 4095
    stepped.by_id[1].write(11, bytes([EXTENDED]))
    check_position_limits(way, read_facts(group), stepped.description)


@pytest.mark.fault(21)
def test_a_shadows_own_limits_count() -> None:
    stepped = SteppedArm(load_arm("viperx_300s"))
    stepped.by_id[5].memory.store("Min Position Limit", 2900)
    with pytest.raises(LimitError, match=r"servo 5 \(elbow, shadow of 4\) would be sent to tick"):
        stepped.session().run(stepped.way(0.0, 0.4, -0.4))
    assert set(stepped.torque()) == {0}


@pytest.mark.fault(19)
def test_limits_of_temperature_and_voltage_are_the_servos(stepped: SteppedArm) -> None:
    arm = stepped.description
    stepped.by_id[2].memory.store("Temperature Limit", 61)
    stepped.by_id[3].memory.store("Min Voltage Limit", 110)
    group = ServoGroup(stepped.bus, stepped.description.servo)
    limits = with_servo_limits(CommandLimits.of(arm, 0.005), read_facts(group), arm, arm.rest)
    assert limits.max_temperature.tolist() == [80, 61, 80, 80, 80, 80, 80]
    assert limits.min_voltage[2] == pytest.approx(11.0)
    assert np.isfinite(limits.max_voltage).all()


@pytest.mark.fault(19)
def test_currents_beyond_a_servos_own_limit_are_a_fault_when_they_last(
    stepped: SteppedArm,
) -> None:
    """Position mode does not keep the Current Limit; 200 units of 2.69 mA are 0.54 A."""
    stepped.by_id[ELBOW].memory.store("Current Limit", 200)
    stepped.by_id[1].memory.store("Current Limit", 0)  # nobody has set it
    peak = "push:torque=4,for=0.1,id=4"
    stepped.at(0.3, lambda: stepped.port.simulation.inject(peak))
    session = stepped.session()
    recording = session.run(stepped.way(0.6, 0.3, -0.6, 0.9))
    assert recording.ending is Ending.COMPLETED
    assert np.abs(recording.current_a[:, 3]).max() > 1.0  # a short peak
    again = "push:torque=4,id=4"
    stepped.at(0.1, lambda: stepped.port.simulation.inject(again))
    here, rest = session.read_posture(), stepped.description.rest
    with pytest.raises(ServoLoadError, match=r"elbow_flexion: its servo takes 0\.5.* 0\.54 A"):
        session.run(straight_way(here, rest, stepped.description, 200.0))


@pytest.mark.fault(19)
def test_currents_to_and_fro_are_a_fault_too(stepped: SteppedArm) -> None:
    """Whoever shakes a joint costs as much current as who holds it."""
    stepped.by_id[ELBOW].memory.store("Current Limit", 200)
    simulation = stepped.port.simulation
    pushes = [f"push:torque={torque},for=0.08,id=4" for torque in (4, -4)]
    for number in range(30):
        push = pushes[number % 2]
        stepped.at(0.1 + 0.08 * number, lambda push=push: simulation.inject(push))
    with pytest.raises(ServoLoadError, match=r"elbow_flexion: its servo takes 0\.5.* 0\.54 A"):
        stepped.session().run(stepped.way(0.6, 0.3, -0.6, 0.9))


def test_the_stricter_of_two_current_limits_counts() -> None:
    arm = load_arm("viperx_300s")
    stepped = SteppedArm(arm)
    stepped.by_id[3].memory.store("Current Limit", 1000)  # a shadow
    moving = [servo for servo in arm.servo if servo.joint in arm.joint_names]
    facts = read_facts(ServoGroup(stepped.bus, moving))
    limits = with_servo_limits(CommandLimits.of(arm, 0.005), facts, arm, arm.rest)
    assert limits.max_current[1] == pytest.approx(2.69)
    assert limits.max_current[2] == pytest.approx(2047 * 2.69e-3)
    arm = load_arm("koch")
    facts = read_facts(ServoGroup(SteppedArm(arm).bus, arm.leaders))
    limits = with_servo_limits(CommandLimits.of(arm, 0.005), facts, arm, arm.rest)
    assert np.isnan(limits.max_current[:2]).all()  # XL430 measure none
    assert limits.max_current[2] == pytest.approx(1.75)


@pytest.mark.fault(10)
def test_restarted_servos_get_everything_anew(stepped: SteppedArm) -> None:
    """Row 10: after the fault, a reboot and a clearing, RAM is written and read back again."""
    session = stepped.session()
    stepped.at(0.3, stepped.by_id[ELBOW].reboot)
    with pytest.raises(HardwareFaultError, match="it restarted"):
        session.run(stepped.way(0.6, 0.3, -0.6, 0.9))
    stepped.clock.advance(0.5)
    assert release_watchdogs(ServoGroup(stepped.bus, stepped.description.servo)) != ()
    seen = []
    again = stepped.session()
    here = again.read_posture()
    way = straight_way(here, stepped.description.rest, stepped.description, 200.0)
    recording = again.run(
        way,
        on_tick=lambda *_: seen.append(
            [stepped.value(name) for name in ("Bus Watchdog", "Torque Enable", "Profile Velocity")]
        ),
    )
    assert recording.ending is Ending.COMPLETED
    watchdogs, torque, profiles = seen[0]
    assert watchdogs == [15] * 7
    assert torque == [1] * 7
    assert all(profiles)
    assert np.abs(recording.commanded_rad[0] - here).max() < 0.01
