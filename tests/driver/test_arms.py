"""Every described arm that has servos, driven on a stepped clock."""

import numpy as np
import pytest

from armsyn.arm import arm_names, load_arm
from armsyn.driver import Ending
from armsyn.driver.models import servo_model
from tests.driver.stepped import SteppedArm

DRIVEN = [name for name in arm_names() if load_arm(name).servo]


def test_the_arms_of_the_house_are_there() -> None:
    assert {"human7", "openmanipulator_x", "koch"} <= set(DRIVEN)


@pytest.mark.parametrize("name", DRIVEN)
def test_it_goes_where_it_is_sent(name: str) -> None:
    arm = load_arm(name)
    stepped = SteppedArm(arm)
    middle = 0.5 * (arm.chain.lower + arm.chain.upper)
    change = np.clip(middle - arm.rest, -0.4, 0.4)
    way = stepped.way(*change)
    recording = stepped.session().run(way)
    assert recording.ending is Ending.COMPLETED
    assert way.angles is not None
    assert np.abs(stepped.positions() - way.angles[-1]).max() < 0.01
    # current where the servo measures it, and never a made-up value
    measures = [
        servo_model(servo.model, servo.protocol).current_unit is not None for servo in arm.servo
    ]
    assert np.isfinite(recording.current_a).all(axis=0).tolist() == measures


@pytest.mark.parametrize("name", DRIVEN)
def test_velocity_is_the_derivative_of_position(name: str) -> None:
    arm = load_arm(name)
    stepped = SteppedArm(arm)
    middle = 0.5 * (arm.chain.lower + arm.chain.upper)
    recording = stepped.session().run(stepped.way(*np.clip(middle - arm.rest, -0.4, 0.4)))
    moved = recording.measured_rad[-1] - recording.measured_rad[0]
    integral = np.trapezoid(recording.velocity_rad_s, recording.time_s, axis=0)
    # a servo with a differential gain is sampled just after the kick that each new goal gives it
    assert (np.abs(integral - moved) <= 0.02 + 0.2 * np.abs(moved)).all()
