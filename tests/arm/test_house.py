"""The arms of the house against facts that stand elsewhere: makers' files and their programs."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from armsyn.arm import ArmDescription, arm_names, calibration_of, load_arm
from armsyn.driver.models import servo_model
from tests.arm.models import pinocchio_model, placement

CALIBRATION = Path(__file__).resolve().parents[2] / "calibration"
ARMS = [name for name in arm_names(CALIBRATION) if load_arm(name, CALIBRATION).servo]
INTERBOTIX = ["widowx_250s", "viperx_300s"]


def load(name: str) -> ArmDescription:
    return load_arm(name, CALIBRATION)


@pytest.mark.parametrize(
    ("name", "tip"),
    [
        ("openmanipulator_x", (0.286, 0.0, 0.1875)),
        ("widowx_250s", (0.458325, 0.0, 0.36065)),
        ("viperx_300s", (0.536494, 0.0, 0.42705)),
        ("reachy_right", (0.0, -0.202, -0.6475)),
        ("koch", (-0.22828, -0.0013, 0.1673)),
    ],
)
def test_the_hand_at_zero(name: str, tip: tuple[float, float, float]) -> None:
    arm = load(name)
    assert arm.chain.forward(np.zeros(arm.chain.dof)).tip == pytest.approx(tip, abs=1e-9)


@pytest.mark.parametrize("name", ARMS)
def test_kinematics_are_pinocchios(name: str) -> None:
    arm = load(name)
    model = pinocchio_model(arm)
    data = model.createData()
    tip = placement(arm.tip.xyz, arm.tip.rpy)
    generator = np.random.default_rng(5)
    for q in generator.uniform(arm.chain.lower, arm.chain.upper, size=(50, arm.chain.dof)):
        pin.forwardKinematics(model, data, q)
        frames = arm.chain.forward(q)
        expected = [
            *(place.translation for place in list(data.oMi)[1:]),
            (data.oMi[-1] * tip).translation,
        ]
        assert frames.positions == pytest.approx(np.array(expected), abs=1e-12)
        assert frames.orientations[-1] == pytest.approx((data.oMi[-1] * tip).rotation, abs=1e-12)


@pytest.mark.parametrize("name", ARMS)
def test_goals_of_every_posture_are_inside_one_turn(name: str) -> None:
    """Position mode takes goals from 0 to the end of one turn (AX: of 300 degrees) only."""
    arm = load(name)
    for servo in arm.leaders:
        joint = arm.joint[arm.joint_names.index(servo.joint)]
        ends = calibration_of((servo,)).to_ticks([[joint.lower], [joint.upper]])
        assert ends.min() >= 0
        assert ends.max() <= (1023 if servo.model.startswith("ax") else 4095)


@pytest.mark.parametrize("name", ARMS)
def test_the_driver_knows_every_servo(name: str) -> None:
    for servo in load(name).servo:
        assert servo_model(servo.model, servo.protocol).name == servo.model


@pytest.mark.parametrize("name", ARMS)
def test_a_gripper_opens_within_a_turn_and_is_wider_open(name: str) -> None:
    arm = load(name)
    if name == "human7":
        assert arm.gripper is None
        return
    gripper, servo = arm.gripper, arm.gripper_servo
    assert gripper is not None
    assert servo is not None
    assert gripper.width_open > gripper.width_closed
    ticks = calibration_of((servo,)).to_ticks([[gripper.open], [gripper.closed]])
    assert ticks.min() >= 0
    assert ticks.max() <= (1023 if servo.model.startswith("ax") else 4095)
    # the widest angle of a servo's current is known to those that measure it only
    measures = servo_model(servo.model, servo.protocol).current_unit is not None
    assert (gripper.max_current is not None) == measures


@pytest.mark.parametrize(
    ("name", "limits"),
    [
        # Min and Max Position Limit of the maker's configuration, by servo ID
        ("widowx_250s", {2: (819, 3345), 4: (648, 3094), 7: (910, 3447)}),
        ("viperx_300s", {2: (841, 2867), 4: (898, 3094), 7: (830, 3504)}),
    ],
)
def test_limits_are_those_that_the_maker_writes_into_the_servos(
    name: str, limits: dict[int, tuple[int, int]]
) -> None:
    """One mirrored elbow or wrist, or IDs 6 and 7 swapped, would not pass."""
    arm = load(name)
    for servo in arm.leaders:
        if servo.id not in limits:
            continue
        joint = arm.joint[arm.joint_names.index(servo.joint)]
        ticks = calibration_of((servo,)).to_ticks([[joint.lower], [joint.upper]])[:, 0]
        low, high = limits[servo.id]
        assert low - 1 <= ticks.min() <= low + 3
        assert high - 3 <= ticks.max() <= high + 1


@pytest.mark.parametrize("name", INTERBOTIX)
def test_dual_joints(name: str) -> None:
    arm = load(name)
    assert [servo.id for servo in arm.servo] == list(range(1, 10))
    assert [servo.id for servo in arm.leaders] == [1, 2, 4, 6, 7, 8]
    assert {servo.id: servo.shadow_of for servo in arm.shadows} == {3: 2, 5: 4}
    leaders = {servo.id: servo for servo in arm.leaders}
    for shadow in arm.shadows:
        assert shadow.shadow_of is not None
        leader = leaders[shadow.shadow_of]
        # the motors face each other: one of them counts the other way round
        assert {shadow.drive_mode & 1, leader.drive_mode & 1} == {0, 1}
        assert (shadow.direction, shadow.zero_tick) == (leader.direction, leader.zero_tick)
    reversed_ids = {servo.id for servo in arm.servo if servo.drive_mode & 1}
    assert reversed_ids == ({3, 5, 7} if name == "widowx_250s" else {2, 4, 7})


@pytest.mark.parametrize("name", INTERBOTIX)
def test_finger_travel_is_the_cranks(name: str) -> None:
    """Twice a finger's travel by the maker's crank: r sin a + sqrt(L2 - r2 cos2 a)."""
    radius, rod = (0.014, 0.024) if name == "widowx_250s" else (0.022, 0.036)
    gripper = load(name).gripper
    assert gripper is not None
    for angle, width in (
        (gripper.open, gripper.width_open),
        (gripper.closed, gripper.width_closed),
    ):
        travel = radius * np.sin(angle) + np.sqrt(rod**2 - (radius * np.cos(angle)) ** 2)
        assert 2.0 * travel == pytest.approx(width, abs=2e-4)


def test_reachys_ticks_are_its_own_programs() -> None:
    """reachy_pyluos_hal: raw = -(angle + offset) as a share of a turn of 4095 (1023) ticks."""
    arm = load("reachy_right")
    offsets = {10: 1.57, 11: 1.57}
    for servo in arm.servo:
        turn, last = (np.deg2rad(300), 1023) if "ax" in servo.model else (2 * np.pi, 4095)
        assert servo.protocol == (1 if "ax" in servo.model else 2)
        for angle in (-0.3, 0.0, 0.1):
            raw = -(angle + offsets.get(servo.id, 0.0))
            expected = (raw + turn / 2) / turn * last
            found = calibration_of((servo,)).to_ticks([angle])[0]
            assert found == pytest.approx(expected, abs=1.6)
    assert [servo.id for servo in arm.servo] == list(range(10, 18))


def test_kochs_two_supplies() -> None:
    volts = {servo.id: servo.supply_voltage for servo in load("koch").servo}
    assert volts == {1: 12.0, 2: 12.0, 3: 5.0, 4: 5.0, 5: 5.0, 6: 5.0}
