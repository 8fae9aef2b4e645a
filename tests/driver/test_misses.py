"""Arms that stop short of their goals: said in an event, and never dropped away from rest."""

import numpy as np
import pytest

from armsyn.driver import Ending
from armsyn.driver.run import PARK_TOLERANCE
from armsyn.driver.stream import LONGEST_SETTLING
from armsyn.motion import Motion
from tests.driver.stepped import SteppedArm

LARGE = (0.6, 0.3, -0.6, 0.9)
ELBOW = 3
LIGHT, HEAVY = 1.0, 5.0
"""N m on the elbow: half of the tolerance at rest, and twice as much."""


def reverse(way: Motion) -> Motion:
    assert way.angles is not None
    return Motion(time=way.time, joint_names=way.joint_names, angles=way.angles[::-1])


def load(stepped: SteppedArm, torque: float, delay: float = 0.3) -> None:
    stepped.at(delay, lambda: stepped.servos[ELBOW].apply_load(torque))


def test_a_target_that_is_missed_is_said(stepped: SteppedArm) -> None:
    load(stepped, HEAVY)
    way = stepped.way(*LARGE)
    recording = stepped.session().run(way)
    assert recording.ending is Ending.COMPLETED
    assert way.angles is not None
    off = abs(stepped.positions()[ELBOW] - way.angles[-1, ELBOW])
    assert off > PARK_TOLERANCE
    (time, text, _), _ = recording.events
    assert text.startswith(f"not at rest on its goals after {LONGEST_SETTLING:g} s: stands ")
    assert text.endswith("rad off its goal at elbow_flexion")
    assert float(text.split("stands ")[1].split()[0]) == pytest.approx(off, abs=2e-3)
    assert time == pytest.approx(recording.time_s[-1], abs=0.02)


def test_a_target_that_is_met_needs_no_words(stepped: SteppedArm) -> None:
    recording = stepped.session().run(stepped.way(*LARGE))
    assert [event.text for event in recording.events] == [Ending.COMPLETED.value]


def test_an_arm_that_does_not_reach_rest_is_not_let_go(stepped: SteppedArm) -> None:
    load(stepped, HEAVY)
    out = stepped.way(*LARGE)
    recording = stepped.session().run(out, park=reverse(out))
    assert recording.ending is Ending.PARK_MISSED
    assert stepped.torque() == [1] * 7
    assert stepped.value("Bus Watchdog") == [0] * 7
    off = np.abs(stepped.positions() - stepped.description.rest)
    assert np.flatnonzero(off > PARK_TOLERANCE).tolist() == [ELBOW]
    assert recording.events[-2][1].endswith("rad off its rest posture at elbow_flexion")
    assert recording.events[-1][1] == Ending.PARK_MISSED.value


def test_an_arm_that_droops_a_little_is_let_go(stepped: SteppedArm) -> None:
    load(stepped, LIGHT)
    out = stepped.way(*LARGE)
    recording = stepped.session().run(out, park=reverse(out))
    assert recording.ending is Ending.PARKED
    assert stepped.torque() == [0] * 7
    assert recording.events[-2][1].endswith("rad off its goal at elbow_flexion")


def test_a_way_that_does_not_end_at_rest_does_not_let_go(stepped: SteppedArm) -> None:
    out = stepped.way(*LARGE)
    assert out.angles is not None
    part = Motion(
        time=out.time,
        joint_names=out.joint_names,
        angles=0.5 * (out.angles[::-1] + out.angles[-1]),
    )
    assert stepped.session().run(out, park=part).ending is Ending.PARK_MISSED
    assert stepped.torque() == [1] * 7


def test_a_stop_that_does_not_reach_rest_does_not_say_so(stepped: SteppedArm) -> None:
    load(stepped, HEAVY)
    session = stepped.session()
    stepped.at(0.35, session.stops.request)
    recording = session.run(stepped.way(*LARGE))
    assert any(event.text == "moving to the rest posture" for event in recording.events)
    assert recording.ending is Ending.STOPPED_HOLDING
    assert stepped.torque() == [1] * 7
