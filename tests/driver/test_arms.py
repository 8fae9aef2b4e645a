"""Every described arm that has servos, driven on a stepped clock."""

import contextlib

import numpy as np
import pytest

from armsyn.arm import arm_names, load_arm
from armsyn.driver import Ending
from armsyn.driver.models import servo_model
from armsyn.errors import CollisionError
from armsyn.motion import Motion
from armsyn.safety import check_trajectory
from tests.driver.stepped import SteppedArm

DRIVEN = [name for name in arm_names() if load_arm(name).servo]


def free_way(stepped: SteppedArm) -> Motion:
    """Towards the middle of all joints, but for those at the tip where that meets the table."""
    arm = stepped.description
    middle = 0.5 * (arm.chain.lower + arm.chain.upper)
    change = np.clip(middle - arm.rest, -0.4, 0.4)
    for joints in range(change.size, 0, -1):
        way = stepped.way(*change[:joints])
        with contextlib.suppress(CollisionError):
            check_trajectory(way, arm, arm.rest)
            return way
    raise AssertionError(f"no free way of {arm.name}")


def test_the_arms_of_the_house_are_there() -> None:
    assert {
        "human7",
        "openmanipulator_x",
        "koch",
        "widowx_250s",
        "viperx_300s",
        "reachy_right",
    } <= set(DRIVEN)


@pytest.mark.parametrize("name", DRIVEN)
def test_it_goes_where_it_is_sent(name: str) -> None:
    arm = load_arm(name)
    stepped = SteppedArm(arm)
    way = free_way(stepped)
    recording = stepped.session(accept_no_watchdog=True).run(way)
    assert recording.ending is Ending.COMPLETED
    assert way.angles is not None
    assert np.abs(stepped.positions() - way.angles[-1]).max() < 0.01
    # current where the servo measures it, and never a made-up value
    measures = [
        servo_model(servo.model, servo.protocol).current_unit is not None for servo in arm.leaders
    ]
    assert np.isfinite(recording.current_a).all(axis=0).tolist() == measures


@pytest.mark.parametrize("name", DRIVEN)
def test_velocity_is_the_derivative_of_position(name: str) -> None:
    arm = load_arm(name)
    stepped = SteppedArm(arm)
    recording = stepped.session(accept_no_watchdog=True).run(free_way(stepped))
    moved = recording.measured_rad[-1] - recording.measured_rad[0]
    integral = np.trapezoid(recording.velocity_rad_s, recording.time_s, axis=0)
    # a servo with a differential gain is sampled just after the kick that each new goal gives it
    assert (np.abs(integral - moved) <= 0.02 + 0.2 * np.abs(moved)).all()
