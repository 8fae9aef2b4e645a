"""Joint mode of AX, MX and XL-320: speeds against the manual, loads against hand calculation.

Motors without load turn at the data sheet's speed; friction takes 1 % of the stall torque, a little
more from standstill (physics), so that loads carried are known to about that.
"""

import math

import pytest

from tests.firmware_sim.classic_bench import ClassicBench

STEP = 300.0 / 1024  # deg
TICK = 360.0 / 4096
FRICTION = 0.012  # of the stall torque, from standstill


def test_moving_speed_is_in_units_of_0_111_rpm() -> None:
    servo = ClassicBench("ax-12a", 100)
    servo.set(Moving_Speed=100, Goal_Position=900)
    servo.run(0.5)
    before = servo.read("Present Position")
    servo.run(1.0)
    covered = servo.read("Present Position") - before
    assert covered * STEP == pytest.approx(100 * 0.111 * 6.0, abs=2 * STEP)
    assert servo.read("Present Speed") == pytest.approx(100, abs=3)
    assert servo.read("Moving") == 1
    servo.set(Goal_Position=100)
    servo.run(0.5)
    assert servo.read("Present Speed") == pytest.approx(1024 + 100, abs=3)


@pytest.mark.parametrize(
    ("name", "rpm", "unit"),
    [
        ("ax-12a", 59.0, 0.111),
        ("ax-18a", 97.0, 0.111),
        ("mx-28", 55.0, 0.114),
        ("xl-320", 114.0, 0.111),
    ],
)
def test_moving_speed_0_is_no_control_of_speed(name: str, rpm: float, unit: float) -> None:
    servo = ClassicBench(name, 0)
    assert servo.read("Moving Speed") == 0
    servo.set(Torque_Limit=1023, Torque_Enable=1, Goal_Position=servo.read("CCW Angle Limit"))
    servo.run(0.1)
    # 30 mV are lost in the supply for each ampere, which is little at this speed.
    assert servo.read("Present Speed") == pytest.approx(rpm / unit, rel=0.01)


def test_a_speed_beyond_the_motor_is_the_motors() -> None:
    servo = ClassicBench("ax-12a", 0)
    servo.set(Moving_Speed=1023, Goal_Position=1023)  # 114 rev/min
    servo.run(0.2)
    assert servo.read("Present Speed") == pytest.approx(59.0 / 0.111, rel=0.02)


@pytest.mark.parametrize("name", ["ax-12a", "mx-28"])
def test_a_new_moving_speed_counts_on_the_way(name: str) -> None:
    servo = ClassicBench(name, 0)
    servo.set(Goal_Position=servo.read("CCW Angle Limit"))
    servo.run(0.2)
    assert servo.read("Present Speed") > 450
    for speed in (30, 100):
        servo.set(Moving_Speed=speed)
        servo.run(0.3)
        assert servo.read("Present Speed") == pytest.approx(speed, abs=4)
        assert servo.read("Moving") == 1


def test_it_stops_within_the_margin() -> None:
    servo = ClassicBench("ax-12a", 200, Max_Torque=1023)
    servo.set(CW_Compliance_Margin=20, CCW_Compliance_Margin=20, Moving_Speed=50)
    servo.set(Goal_Position=400)
    servo.run(3.0)
    assert servo.read("Moving") == 0
    assert 379 <= servo.read("Present Position") <= 400
    assert servo.read("Present Load") == 0


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize(("slope", "punch"), [(32, 32), (128, 32), (64, 100)])
def test_a_load_is_carried_where_the_curve_gives_its_torque(
    direction: int, slope: int, punch: int
) -> None:
    servo = ClassicBench("ax-12a")
    servo.set(CW_Compliance_Slope=slope, CCW_Compliance_Slope=slope, Punch=punch)
    servo.set(Goal_Position=512)
    share = 0.2  # of the stall torque of 1.5 N m at 12 V
    servo.servo.apply_load(direction * share * 1.5)
    servo.run(1.0)
    # output = punch + (1 - punch) (error - margin) / slope
    least, most = (
        1 + slope * (carried - punch / 1023) / (1 - punch / 1023)
        for carried in (share - FRICTION, share + FRICTION)
    )
    error = direction * (512 - servo.read("Present Position"))
    assert math.floor(least) <= error <= math.ceil(most)
    load = direction * servo.read_signed("Present Load")
    assert share - FRICTION - 1.0 / slope <= load / 1023 <= share + FRICTION + 1.0 / slope


def test_each_direction_yields_as_its_own_slope_says() -> None:
    servo = ClassicBench("ax-12a")
    servo.set(CW_Compliance_Slope=128, CCW_Compliance_Slope=8, Goal_Position=512)
    errors = []
    for load in (0.3, -0.3):
        servo.servo.apply_load(load)
        servo.run(1.0)
        errors.append(512 - servo.read("Present Position"))
    assert 2 <= errors[0] <= 4  # pushes counter-clockwise: 1 + 8 (0.2 - 0.03) = 2.4
    assert -26 <= errors[1] <= -21  # 1 + 128 (0.2 - 0.03) / 0.97 = 23.3


def test_new_compliance_counts_at_once_and_disturbs_no_motion() -> None:
    servo = ClassicBench("ax-12a", 100)
    servo.set(Moving_Speed=60, Goal_Position=700)
    servo.run(1.0)
    before = servo.read("Present Position")
    servo.set(CW_Compliance_Slope=16, CCW_Compliance_Slope=16)
    servo.run(1.0)
    assert (servo.read("Present Position") - before) * STEP == pytest.approx(40.0, abs=4 * STEP)


def test_torque_limit_caps_what_is_carried() -> None:
    servo = ClassicBench("ax-12a")
    servo.set(Goal_Position=512)
    servo.servo.apply_load(0.3)
    servo.run(0.2)
    servo.set(Torque_Limit=307)  # 30 %: carries 20 %
    servo.run(0.3)
    assert abs(servo.read("Present Position") - 512) < 10
    held = servo.read("Present Position")
    servo.set(Torque_Limit=102)  # 10 %: is driven away
    servo.run(0.3)
    # by 20 - 10 - 1 % of the torque, and so at 9 % of 59 rev/min, which is 354 deg/s
    assert (held - servo.read("Present Position")) * STEP == pytest.approx(9.5, abs=1.0)
    assert servo.read("Present Load") == 102


def test_it_runs_free_at_torque_limit_0() -> None:
    # AX-12 User's Manual: "When this value is set to 0, the actuator enters the Free Run mode".
    servo = ClassicBench("ax-12a")
    servo.set(Torque_Enable=1, Torque_Limit=0)
    servo.servo.apply_load(0.03 * 1.5)
    servo.run(0.3)
    # Friction leaves 2 of 3 %; a drag of 5 % of 1.5 N m at 354 deg/s brakes 0.0024 kg m^2 with a
    # time constant of 0.198 s towards 0.4 * 354 deg/s. With its winding shorted, 7 deg/s.
    free = 0.4 * 354.0 * (1.0 - math.exp(-0.3 / 0.198))
    assert math.degrees(-servo.axis.velocity) == pytest.approx(free, rel=0.01)


def test_an_mx_gives_way_as_its_p_gain_says() -> None:
    servo = ClassicBench("mx-28")
    servo.set(Goal_Position=2048)
    servo.servo.apply_load(0.2 * 2.5)
    servo.run(1.0)
    soft = (2048 - servo.read("Present Position")) * TICK
    # P gain 32 does what a slope of 32 steps did: full output at 9.375 degrees.
    assert soft == pytest.approx(0.2 * 32 * STEP, abs=FRICTION * 32 * STEP + TICK)
    servo.set(P_Gain=128)
    servo.run(1.0)
    stiff = (2048 - servo.read("Present Position")) * TICK
    assert stiff == pytest.approx(0.2 * 8 * STEP, abs=FRICTION * 8 * STEP + TICK)


def test_an_i_gain_takes_the_error_away() -> None:
    servo = ClassicBench("mx-64")
    servo.set(I_Gain=10, Goal_Position=2048)
    servo.servo.apply_load(0.2 * 6.0)
    servo.run(5.0)
    assert servo.read("Present Position") == pytest.approx(2048, abs=2)


def test_i_and_d_gains_put_out_what_the_manual_makes_of_them() -> None:
    # "PID Gains": Kp = P / 8, Ki = I * 1000 / 2048, Kd = D * 4 / 1000; with a P gain p for full
    # output at 1024 / p steps, an output of 128 is full.
    servo = ClassicBench("mx-28")
    servo.axis.jam(True)
    servo.set(P_Gain=0, I_Gain=10, Torque_Enable=1, Goal_Position=2048 + 100)
    servo.run(0.5)
    error = 100 * TICK / STEP  # steps
    assert servo.read("Present Load") == pytest.approx(
        1023 * 10 * 1000 / 2048 / 128 * error * 0.5, rel=0.01
    )
    servo = ClassicBench("mx-28")
    servo.axis.jam(True)
    servo.set(P_Gain=0, D_Gain=20, Moving_Speed=300, Goal_Position=4000)
    servo.run(0.3)
    speed = 300 * 0.114 * 6.0 / STEP  # steps/s
    assert servo.read("Present Load") == pytest.approx(1023 * 20 * 4 / 1000 / 128 * speed, rel=0.01)


def test_goal_acceleration_as_in_the_manuals_example() -> None:
    # "Goal Acceleration (73)": at 10, "the speed after 1 second will be 14.3 RPM".
    servo = ClassicBench("mx-28", 0)
    servo.set(Goal_Acceleration=10, Moving_Speed=400, Goal_Position=4000)
    servo.run(1.0)
    assert servo.read("Present Speed") * 0.114 == pytest.approx(14.3, rel=0.03)


def test_goal_acceleration_makes_a_trapezoid() -> None:
    # 90 degrees at 34.2 rev/min (205 deg/s) and 429 deg/s^2: 90/205.2 + 205.2/429.2 s.
    servo = ClassicBench("mx-28", 1000)
    servo.set(Goal_Acceleration=50, Moving_Speed=300, Goal_Position=1000 + 1024)
    duration = 90.0 / 205.2 + 205.2 / 429.15
    servo.run(duration - 0.05)
    assert servo.read("Moving") == 1
    servo.run(0.35)
    assert servo.read("Moving") == 0
    assert servo.read("Present Position") == pytest.approx(2024, abs=4)


def test_xl_320_reaches_its_goal_by_pid() -> None:
    servo = ClassicBench("xl-320", 100)
    servo.set(P_Gain=100, Moving_Speed=200, Torque_Enable=1, Goal_Position=600)
    servo.run(2.0)
    assert servo.read("Present Position") == pytest.approx(600, abs=2)
    assert servo.read("Moving") == 0


def test_a_goal_does_not_switch_the_torque_of_an_xl_320_on() -> None:
    servo = ClassicBench("xl-320")
    start = servo.read("Present Position")
    servo.set(Goal_Position=start + 50)
    servo.run(1.0)
    assert (servo.read("Torque Enable"), servo.read("Present Position")) == (0, start)


@pytest.mark.parametrize("name", ["ax-12a", "mx-28"])
def test_a_goal_switches_the_torque_on(name: str) -> None:
    servo = ClassicBench(name)
    goal = servo.read("Present Position") + 50
    assert servo.read("Torque Enable") == 0
    servo.set(Goal_Position=goal)
    assert servo.read("Torque Enable") == 1
    servo.run(1.0)
    assert servo.read("Present Position") == pytest.approx(goal, abs=8)


@pytest.mark.parametrize("name", ["ax-12a", "mx-28", "xl-320"])
@pytest.mark.parametrize("asked", [True, False])
def test_nothing_jumps_at_torque_on(name: str, asked: bool) -> None:
    servo = ClassicBench(name)
    start = servo.read("Present Position")
    servo.set(Torque_Enable=1, Goal_Position=start + 100)
    servo.run(1.0)
    servo.set(Torque_Enable=0)
    servo.servo.apply_load(0.02 * servo.model.motor.stall_torque)
    servo.run(0.2)
    servo.servo.apply_load(0.0)
    servo.run(0.5)
    moved = servo.read("Present Position")
    assert start - 300 < moved < start + 80  # a hand turned it
    assert not asked or servo.read("Goal Position") == moved
    servo.set(Torque_Enable=1)
    servo.run(1.0)
    assert servo.read("Goal Position") == moved
    assert servo.read("Present Position") == pytest.approx(moved, abs=1)
