"""Letting go, clearing and restarting. Rows 18, 19, 24 and 25 of the faults."""

import numpy as np
import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.arm.gravity import gravity_torque
from armsyn.driver.operate import (
    FALLING_TORQUE,
    clear,
    posture_of,
    read_latched,
    release,
    torque_is_on,
    what_falls,
)
from armsyn.driver.operate_reboot import SHORTEST_INTERVAL, Rebooter
from armsyn.driver.presence import Presence, find_present, require_somebody
from armsyn.errors import ArmFaultError, BusError, HardwareFaultError, ServoMissingError
from tests.driver.stepped import SteppedArm, deafen, without

TORQUE_ENABLE = 64
OVERLOAD = 0x20


def present(stepped: SteppedArm) -> Presence:
    return find_present(stepped.bus, stepped.description.servo)


def powered(stepped: SteppedArm) -> Presence:
    presence = present(stepped)
    presence.group.set("Torque Enable", dict.fromkeys(presence.group.ids, 1))
    return presence


def test_what_falls_is_what_the_weight_turns(human7: ArmDescription) -> None:
    raised = human7.rest.copy()
    raised[0] += 1.0
    torques = np.abs(gravity_torque(human7, raised))
    loads = what_falls(human7, raised)
    assert loads is not None
    assert [load.torque for load in loads] == sorted(torques[torques > FALLING_TORQUE])[::-1]
    assert loads[0].joint == "shoulder_flexion"
    only = what_falls(human7, raised, ["elbow_flexion"])
    assert only is not None
    assert [load.joint for load in only] == ["elbow_flexion"]


def test_nobody_says_what_falls_where_an_angle_is_unknown(human7: ArmDescription) -> None:
    assert what_falls(human7, np.full(7, np.nan)) is None


def test_all_servos_let_go_at_once(stepped: SteppedArm) -> None:
    group = powered(stepped).group
    group.set("Torque Enable", {3: 0})
    released = release(group)
    assert released.let_go == (1, 2, 4, 5, 6, 7)
    assert released.limp == (3,)
    assert stepped.torque() == [0] * 7


def test_one_joint_lets_go_with_its_shadow() -> None:
    stepped = SteppedArm(load_arm("viperx_300s"))
    group = powered(stepped).group
    assert release(group, ["shoulder"]).let_go == (2, 3)
    assert stepped.torque() == [1, 0, 0, 1, 1, 1, 1, 1, 1]
    assert release(group, ["gripper"]).let_go == (9,)
    assert stepped.torque() == [1, 0, 0, 1, 1, 1, 1, 1, 0]


def test_a_servo_that_overlooks_a_write_is_told_again(stepped: SteppedArm) -> None:
    group = powered(stepped).group
    deafen(stepped.by_id[2], TORQUE_ENABLE, 0, times=2)
    assert release(group).let_go == tuple(range(1, 8))
    assert stepped.torque() == [0] * 7


def test_a_servo_that_does_not_let_go_is_named_and_the_others_have(stepped: SteppedArm) -> None:
    group = powered(stepped).group
    deafen(stepped.by_id[2], TORQUE_ENABLE, 0)
    with pytest.raises(
        HardwareFaultError, match=r"servo 2 .* did not let go, all others"
    ) as caught:
        release(group)
    assert caught.value.servo_id == 2
    assert stepped.torque() == [0, 1, 0, 0, 0, 0, 0]


def test_an_arm_with_a_missing_servo_lets_go(stepped: SteppedArm) -> None:
    powered(stepped)
    stepped.damage = without(5)
    presence = present(stepped)
    assert presence.missing_titles == "5 (forearm_pronation)"
    assert release(presence.group).let_go == (1, 2, 3, 4, 6, 7)
    angles = posture_of(stepped.description, presence.group)
    assert np.isnan(angles).tolist() == [row == 4 for row in range(7)]


def test_a_servo_that_falls_silent_counts_as_holding(stepped: SteppedArm) -> None:
    group = powered(stepped).group
    stepped.damage = without(5)
    assert torque_is_on(group)[5]
    with pytest.raises(HardwareFaultError, match="servo 5"):
        release(group)


def test_nobody_there_points_to_the_scan(stepped: SteppedArm) -> None:
    stepped.damage = lambda _: b""
    presence = present(stepped)
    with pytest.raises(ServoMissingError, match=r"no reply at 1000000 baud .* armsyn scan"):
        require_somebody(presence, "human7")


@pytest.mark.fault(25)
def test_an_expired_watchdog_is_cleared_where_it_stopped_the_servo(stepped: SteppedArm) -> None:
    session = stepped.session()
    stepped.at(0.4, lambda: stepped.clock.advance(0.5))
    with pytest.raises(ArmFaultError, match="the host stalled"):
        session.run(stepped.way(0.6))
    group = present(stepped).group
    latched = read_latched(group)
    assert latched.expired == tuple(range(1, 8))
    assert (latched.armed, latched.errors) == ((), {})
    before = stepped.positions()
    assert clear(group) == tuple(range(1, 8))
    assert not read_latched(group).watchdogs
    stepped.clock.advance(1.0)
    np.testing.assert_allclose(stepped.positions(), before, atol=0.01)
    assert stepped.torque() == [1] * 7


def overload(stepped: SteppedArm) -> None:
    stepped.port.simulation.inject("overload:id=4,for=0.1")


def overloaded(stepped: SteppedArm) -> Rebooter:
    """One servo of an arm that has been on for a while."""
    stepped.clock.advance(SHORTEST_INTERVAL)
    group = powered(stepped).group
    overload(stepped)
    stepped.clock.advance(0.2)
    assert read_latched(group).errors == {4: OVERLOAD}
    return Rebooter(group, stepped)


@pytest.mark.fault(18)
def test_a_reboot_ends_a_latched_error(stepped: SteppedArm) -> None:
    done = overloaded(stepped).reboot(4)
    assert (done.before, done.after, done.turns) == (OVERLOAD, 0, 0)
    assert 0 < done.boot_time < 1
    assert stepped.torque() == [1, 1, 1, 0, 1, 1, 1]


@pytest.mark.fault(18)
def test_an_error_that_comes_back_is_said_and_not_rebooted_again(stepped: SteppedArm) -> None:
    rebooter = overloaded(stepped)
    stepped.at(0.6, lambda: overload(stepped))
    assert rebooter.reboot(4).after == OVERLOAD
    with pytest.raises(HardwareFaultError, match=r"was rebooted 1 s ago: see to the cause"):
        rebooter.reboot(4)
    stepped.clock.advance(SHORTEST_INTERVAL)
    assert rebooter.reboot(4).after == 0


def test_a_reboot_right_after_that_of_another_program_is_put_off(stepped: SteppedArm) -> None:
    overloaded(stepped).reboot(4)
    group, before = present(stepped).group, stepped.now()
    on_for = group.read("Realtime Tick", (4,))[4] * 1e-3
    another = Rebooter(group, stepped)
    assert another.pause(4) == pytest.approx(SHORTEST_INTERVAL - on_for, abs=0.01)
    another.reboot(4)
    restarted = stepped.now() - group.read("Realtime Tick", (4,))[4] * 1e-3
    assert restarted - before > SHORTEST_INTERVAL - on_for
    stepped.clock.advance(SHORTEST_INTERVAL)
    assert another.pause(4) == 0


@pytest.mark.fault(24)
def test_turns_that_a_reboot_forgets_are_counted(stepped: SteppedArm) -> None:
    group = present(stepped).group
    group.set("Operating Mode", {4: 4})
    group.set("Torque Enable", {4: 1})
    group.set("Goal Position", {4: 7000})
    stepped.clock.advance(4.0)
    assert group.read("Present Position", (4,))[4] > 6900
    assert Rebooter(group, stepped).reboot(4).turns == -1


def test_a_servo_that_does_not_come_back_is_named(stepped: SteppedArm) -> None:
    stepped.clock.advance(SHORTEST_INTERVAL)
    rebooter = Rebooter(present(stepped).group, stepped)
    stepped.port.simulation.inject("missing-servo:id=4,after=0.05")
    with pytest.raises(
        HardwareFaultError, match=r"servo 4 .* has not answered 3 s after its reboot"
    ):
        rebooter.reboot(4)


def test_protocol_1_says_that_its_supply_must_be_switched() -> None:
    stepped = SteppedArm(load_arm("reachy_right"))
    with pytest.raises(BusError, match="switch its power off and on"):
        Rebooter(present(stepped).group, stepped).reboot(14)
