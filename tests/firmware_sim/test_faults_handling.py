"""A person's hand on a joint, and obstacles in its way: what a client reads then."""

import pytest

from firmware_sim.errors import FaultError
from firmware_sim.faults.handling import hands
from firmware_sim.faults.parsing import parse_fault
from firmware_sim.firmware.servo import Servo
from firmware_sim.physics import kernel
from tests.firmware_sim.faults_bench import FaultBench

MODE, TORQUE, ERROR, GOAL_CURRENT, GOAL = 11, 64, 70, 102, 116
CURRENT, VELOCITY, POSITION = 126, 128, 132
TURN = 6.283185307179586
SMALL = ("xl330-m288:1",)


def peak_speed(bench: FaultBench, duration: float) -> float:
    """The fastest that the first horn turns within a time, rad/s."""
    axis, fastest = bench.servos[0].axis, 0.0
    for _ in range(round(duration / 0.01)):
        bench.wait(0.01)
        fastest = max(fastest, abs(axis.velocity))
    return fastest


def gripping(*faults: str, milliamperes: int) -> FaultBench:
    """A gripper's servo under position control with a limited current."""
    bench = FaultBench(*faults, servos=SMALL)
    for address, value, size in ((MODE, 5, 1), (TORQUE, 1, 1), (GOAL_CURRENT, milliamperes, 2)):
        assert bench.write(address, value, size) == 0
    return bench


def pull(servo: Servo) -> float:
    """What a hand gives at present, N m."""
    row = servo.axis._row
    return float(row[kernel.HAND_GRIP] * (row[kernel.HAND_RATE] - row[kernel.MOTOR_SPEED]))


@pytest.mark.parametrize("goal", [3000, 1000, 2040])
def test_a_hand_turns_a_limp_joint_to_a_tick_and_lets_go(goal: int) -> None:
    bench = FaultBench(f"hand:id=1,to={goal},speed=2,for=3")
    way = abs(goal - 2048) / 4096 * TURN
    assert peak_speed(bench, 2.9) <= min(2.0, way / kernel.HAND_LAG) + 1e-9
    assert bench.register(POSITION, 4) == pytest.approx(goal, abs=1)
    bench.wait(0.2)
    assert not bench.simulation.faults
    bench.servos[0].apply_load(0.5)
    bench.wait(0.3)
    assert bench.register(POSITION, 4) < goal - 20


def test_it_takes_as_long_as_its_speed_says() -> None:
    bench = FaultBench("hand:id=1,to=3048,speed=0.5")
    way = 1000 / 4096 * TURN
    bench.wait(1.0)
    # a ramp of 10 rad/s^2 costs half of 50 ms
    moved = bench.register(POSITION, 4) - 2048
    assert moved == pytest.approx(0.5 * (1.0 - 0.025) / TURN * 4096, abs=4)
    bench.wait(way / 0.5 - 1.0 + 1.5)
    assert bench.register(POSITION, 4) == pytest.approx(3048, abs=1)
    assert not bench.simulation.moving


def test_hands_turn_several_joints_at_once() -> None:
    bench = FaultBench(servos=("xm430-w350:1", "xm430-w350:2"))
    for text in hands({1: 2500, 2: 1500}, speed=3.0):
        bench.simulation.inject(text)
    bench.wait(1.5)
    assert bench.register(POSITION, 4, 1) == pytest.approx(2500, abs=1)
    assert bench.register(POSITION, 4, 2) == pytest.approx(1500, abs=1)


def test_a_joint_with_torque_resists() -> None:
    """With 1 N m of hand the current rises to that of 1 N m, less or more friction; no further."""
    bench = FaultBench()
    assert bench.write(TORQUE, 1) == 0
    bench.simulation.inject("hand:id=1,to=2800,torque=1")
    bench.wait(1.5)
    torque = -bench.register(CURRENT, 2) * 0.00269 / 2.3 * 4.1
    friction = bench.servos[0].model.motor.friction * 4.1 * kernel.STATIC_FRICTION
    assert torque == pytest.approx(1.0, abs=friction + 0.03)
    assert pull(bench.servos[0]) == pytest.approx(1.0, rel=1e-6)
    assert 2060 < bench.register(POSITION, 4) < 2100
    bench.simulation.clear("hand")
    bench.wait(0.5)
    assert bench.register(POSITION, 4) == pytest.approx(2048, abs=4)


def test_a_strong_hand_overloads_a_small_servo() -> None:
    bench = FaultBench(servos=SMALL)
    assert bench.write(TORQUE, 1) == 0
    bench.simulation.inject("hand:id=1,to=2800")
    bench.wait(2.0)
    assert bench.register(POSITION, 4) == pytest.approx(2800, abs=2)
    bench.wait(6.0)
    assert bench.register(ERROR) == 0x20
    assert bench.register(TORQUE) == 0


def test_a_hand_goes_to_what_the_position_register_reads() -> None:
    bench = FaultBench()
    assert bench.write(10, 1) == 0  # reverse
    assert bench.write(20, 100, 4) == 0  # homing offset
    bench.simulation.inject("hand:id=1,to=700,speed=5")
    bench.wait(2.5)
    assert bench.register(POSITION, 4) == pytest.approx(700, abs=1)


def test_one_hand_takes_over_from_another() -> None:
    bench = FaultBench("hand:id=1,to=2500,speed=5", "hand:id=1,to=2300,speed=5,at=2,for=2")
    for goal in (2500, 2300, 2500):
        bench.wait(1.9)
        assert bench.register(POSITION, 4) == pytest.approx(goal, abs=1)


def test_an_obstacle_stops_fingers_and_the_current_is_as_set() -> None:
    """100 mA of current for 600 ticks that cannot be gone; then for none, without the object."""
    bench = gripping("obstacle:id=1,tick=2400", milliamperes=100)
    assert bench.write(GOAL, 3000, 4) == 0
    bench.wait(2.0)
    assert bench.register(POSITION, 4) == 2400
    assert bench.register(CURRENT, 2) == pytest.approx(100, abs=2)
    assert bench.register(VELOCITY, 4) == 0
    bench.wait(5.0)
    assert bench.register(ERROR) == 0
    bench.simulation.clear("obstacle")
    bench.wait(2.0)
    assert bench.register(POSITION, 4) == pytest.approx(3000, abs=4)


def test_an_obstacle_lets_the_horn_go_back() -> None:
    bench = gripping("obstacle:id=1,tick=1800,side=below", milliamperes=200)
    for goal, found in ((1500, 1800), (2200, 2200)):
        assert bench.write(GOAL, goal, 4) == 0
        bench.wait(1.5)
        assert bench.register(POSITION, 4) == pytest.approx(found, abs=4)


def test_a_servo_that_cannot_give_in_overloads_at_an_obstacle() -> None:
    bench = FaultBench("obstacle:id=1,tick=2100")
    assert bench.write(TORQUE, 1) == 0
    assert bench.write(GOAL, 3000, 4) == 0
    bench.wait(8.0)
    assert bench.register(ERROR) == 0x20
    assert bench.register(POSITION, 4) == pytest.approx(2100, abs=1)


def test_obstacles_on_both_sides_and_one_taken_away() -> None:
    bench = FaultBench("obstacle:id=1,tick=2200", "obstacle:id=1,tick=2000,side=below,for=4")
    for goal, found, at in ((3000, 2200, 1.9), (1000, 2000, 3.9), (1000, 1000, 7.0)):
        bench.simulation.inject(f"hand:id=1,to={goal},speed=5")
        bench.wait_until(at)
        assert bench.register(POSITION, 4) == pytest.approx(found, abs=1)
    bench.simulation.inject("hand:id=1,to=3000,speed=5")
    bench.wait(2.0)
    assert bench.register(POSITION, 4) == pytest.approx(2200, abs=1)


def test_a_horn_past_an_obstacle_goes_no_further() -> None:
    bench = FaultBench("obstacle:id=1,tick=1900")
    bench.simulation.inject("hand:id=1,to=2500,speed=5,for=1")
    bench.wait(1.2)
    assert bench.register(POSITION, 4) == 2048
    bench.simulation.inject("hand:id=1,to=1500,speed=5")
    bench.wait(2.0)
    assert bench.register(POSITION, 4) == pytest.approx(1500, abs=1)


@pytest.mark.parametrize("text", ["hand:to=1", "hand:id=1", "obstacle:id=1,side=left,tick=1"])
def test_hands_and_obstacles_need_to_be_somewhere(text: str) -> None:
    with pytest.raises(FaultError):
        parse_fault(text)
