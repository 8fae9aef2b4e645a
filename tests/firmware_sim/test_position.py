"""How positions are counted: homing offset, reverse mode, turns, torque on and off."""

from collections.abc import Callable

import pytest

from .conftest import Bench

MakeBench = Callable[..., Bench]
TORQUE, GOAL, PRESENT = 64, 116, 132


STICKS = 2
"""How far from its goal friction may leave a horn with the factory's gains, ticks."""


def near(tick: int) -> object:
    return pytest.approx(tick, abs=STICKS)


def turn_to(rig: Bench, goal: int, seconds: float = 10.0) -> int:
    assert rig.write(GOAL, goal, 4) == 0
    rig.wait(seconds)
    return rig.read(PRESENT, 4)


def test_a_goal_does_nothing_without_torque(bench: MakeBench) -> None:
    rig = bench()
    assert turn_to(rig, 3000) == 2048
    assert rig.read(GOAL, 4) == 3000


def test_a_stale_goal_moves_the_servo_at_torque_on(bench: MakeBench) -> None:
    rig = bench()
    rig.write(GOAL, 3000, 4)
    rig.write(TORQUE, 1)
    rig.wait(3.0)
    assert rig.read(PRESENT, 4) == near(3000)


def test_after_a_boot_the_goal_is_where_the_horn_is(bench: MakeBench) -> None:
    rig = bench(start_tick=1234)
    assert rig.read(GOAL, 4) == 1234
    rig.write(TORQUE, 1)
    rig.wait(1.0)
    assert rig.read(PRESENT, 4) == 1234


def test_torque_off_lets_it_run_down(bench: MakeBench) -> None:
    rig = bench()
    rig.write(TORQUE, 1)
    rig.write(GOAL, 4000, 4)
    rig.wait(0.2)
    moving = rig.read(128, 4)
    rig.write(TORQUE, 0)
    rig.wait(0.5)
    assert moving > 100
    assert rig.read(128, 4) == rig.read(124, 2) == rig.read(126, 2) == 0
    halt = rig.read(PRESENT, 4)
    assert 2100 < halt < 3500
    rig.wait(1.0)
    assert rig.read(PRESENT, 4) == halt


def test_torque_on_by_goal_update(bench: MakeBench) -> None:
    rig = bench(Drive_Mode=8)
    assert turn_to(rig, 3000) == near(3000)
    assert rig.read(TORQUE) == 1


@pytest.mark.parametrize("offset", [-1024, -5, 100, 1024])
def test_the_homing_offset_is_added_to_the_actual_position(bench: MakeBench, offset: int) -> None:
    rig = bench()
    assert rig.write(20, offset, 4) == 0
    assert rig.read(PRESENT, 4) == 2048 + offset
    rig.write(TORQUE, 1)
    rig.write(GOAL, 2048 + offset, 4)
    rig.wait(1.0)
    assert rig.servos[0].axis.ticks == 2048


def test_a_large_homing_offset_is_ignored_in_position_mode_only(bench: MakeBench) -> None:
    rig = bench()
    assert rig.write(20, 1025, 4) == 0
    assert rig.read(PRESENT, 4) == 2048
    rig.write(11, 4)
    assert rig.read(PRESENT, 4) == 2048 + 1025


def test_reverse_mode_turns_position_velocity_and_pwm(bench: MakeBench) -> None:
    plain, reverse = bench(start_tick=1000), bench(start_tick=1000, Drive_Mode=1)
    for rig in (plain, reverse):
        assert rig.read(PRESENT, 4) == 1000
        rig.write(TORQUE, 1)
        rig.write(GOAL, 3000, 4)
        rig.wait(0.01)  # under way, not yet at full speed: there is still current
    seen = [
        [rig.read(a, s) for a, s in ((132, 4), (128, 4), (124, 2), (126, 2))]
        for rig in (plain, reverse)
    ]
    assert seen[0] == seen[1]
    assert all(value > 0 for value in seen[0])
    assert reverse.servos[0].axis.velocity < 0


def test_reverse_mode_counts_anew_within_a_turn(bench: MakeBench) -> None:
    rig = bench(start_tick=1000)
    rig.write(10, 1)
    for _ in range(2):
        assert rig.read(PRESENT, 4) == rig.read(GOAL, 4) == 4096 - 1000
        rig.ask(1, 0x08)
        rig.wait(0.2)
    rig.write(TORQUE, 1)
    rig.wait(1.0)
    assert rig.read(PRESENT, 4) == 4096 - 1000


def test_reverse_mode_does_not_turn_the_homing_offset(bench: MakeBench) -> None:
    rig = bench()
    rig.write(10, 1)
    assert rig.read(PRESENT, 4) == 4096 - 2048
    rig.write(20, 300, 4)
    assert rig.read(PRESENT, 4) == 4096 - 2048 + 300


def test_extended_mode_counts_turns_until_something_folds_them(bench: MakeBench) -> None:
    rig = bench()
    rig.write(11, 4)
    rig.write(TORQUE, 1)
    assert turn_to(rig, 10_000) == near(10_000)
    assert turn_to(rig, -5_000, 20.0) == near(-5_000)
    rig.write(TORQUE, 0)
    rig.write(TORQUE, 1)
    assert rig.read(PRESENT, 4) == near(-5_000)  # torque-on folds in position mode only
    rig.write(TORQUE, 0)
    rig.write(11, 3)
    assert rig.read(PRESENT, 4) == near(-5_000 % 4096)


def test_a_reboot_folds_the_position(bench: MakeBench) -> None:
    rig = bench()
    rig.write(11, 4)
    rig.write(TORQUE, 1)
    assert turn_to(rig, 9_000) == near(9_000)
    rig.ask(1, 0x08)
    rig.wait(0.2)
    assert rig.read(PRESENT, 4) == rig.read(GOAL, 4) == near(9_000 % 4096)


def test_torque_on_folds_in_position_mode(bench: MakeBench) -> None:
    rig = bench()
    servo = rig.servos[0]
    servo.apply_load(-2.0)  # somebody turns the horn by hand
    rig.wait(5.0)
    servo.apply_load(0.0)
    rig.wait(2.0)
    turned = rig.read(PRESENT, 4)
    assert turned > 3 * 4096
    rig.write(TORQUE, 1)
    assert rig.read(PRESENT, 4) == turned % 4096


def test_a_change_to_a_position_mode_folds(bench: MakeBench) -> None:
    """The manual's notes on Present Position name mode 3, those on Goal Position mode 4."""
    for mode in (3, 4):
        rig = bench(Operating_Mode=1)
        rig.write(TORQUE, 1)
        rig.write(104, 200, 4)
        rig.wait(5.0)
        rig.write(TORQUE, 0)
        rig.wait(2.0)
        turned = rig.read(PRESENT, 4)
        assert turned > 2 * 4096
        assert rig.write(11, mode) == 0
        assert rig.read(PRESENT, 4) == rig.read(GOAL, 4) == turned % 4096


def test_moving_status_tells_in_position_and_following_error(bench: MakeBench) -> None:
    rig = bench()
    rig.write(TORQUE, 1)
    assert rig.read(123) == 0x01
    rig.write(GOAL, 3000, 4)
    assert rig.read(123) == 0x08
    rig.wait(0.05)
    assert rig.read(122) == 1
    rig.wait(2.0)
    assert (rig.read(122), rig.read(123)) == (0, 0x01)
