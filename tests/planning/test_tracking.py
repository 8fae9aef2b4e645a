"""Targets that change while the hand moves: closed forms, limits, and what people do."""

from collections import deque
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armsyn.arm import load_arm
from armsyn.driver import Ending
from armsyn.driver.joints import JointState
from armsyn.driver.path import BLEND
from armsyn.errors import CollisionError, InputError, UnreachableError
from armsyn.ik import optimiser_settings
from armsyn.kernels.arm_numbers import packed
from armsyn.kernels.following import follow
from armsyn.kernels.law import (
    END,
    ENDS,
    FADE,
    GAIN,
    HAND,
    JOINTS,
    LATE,
    LIMIT_RATE,
    OFFSET,
    RAMP,
    RATE,
    Law,
    carried_velocity,
    stopping_speed,
)
from armsyn.motion.peaks import count_peaks
from armsyn.planning import Pointing, Turned, planner_for
from armsyn.planning.tracking import ReachTracker
from armsyn.planning.tracking_plan import HEADROOM, SLOWED_S, TOLERANCE_M, LawPlanner
from armsyn.planning.tracking_sources import sources_of
from armsyn.planning.tracking_state import Arrival, at_rest
from tests.driver.stepped import SteppedArm

ARM = load_arm("human7")
N = len(ARM.joint_names)
PERIOD = 0.005
RIGHT, LEFT = (0.42, -0.25, -0.05), (0.40, 0.15, 0.02)
LOW = (0.35, -0.10, -0.15)
PLANNER = LawPlanner(ARM, sources_of(ARM))


class Followed(NamedTuple):
    """What came of following targets: commands, a period apart, and the ends of the reaches."""

    angles: np.ndarray
    ends: list[Arrival]
    tracker: ReachTracker

    @property
    def hand(self) -> np.ndarray:
        hand: np.ndarray = ARM.chain.positions(self.angles)[:, -1]
        return hand

    @property
    def speed(self) -> np.ndarray:
        speed: np.ndarray = np.linalg.norm(np.diff(self.hand, axis=0), axis=1) / PERIOD
        return speed


def followed(
    *targets: tuple[float, tuple[float, ...]],
    seconds: float = 4.0,
    droop: float = 0.0,
    lag: float = 0.05,
    period: float = PERIOD,
    ahead: float = 0.0,
) -> Followed:
    """Follow (time, target) pairs on an arm whose joints trail and droop.

    The tracker is told of a target at its time, and to turn to it `ahead` seconds later.
    """
    ends: list[Arrival] = []
    tracker = ReachTracker(PLANNER, ARM.rest, ends.append)
    angles, measured, waiting = [ARM.rest], ARM.rest + droop, deque(targets)
    for k in range(1, round(seconds / period) + 1):
        while waiting and waiting[0][0] <= k * period:
            tracker.aim(waiting.popleft()[1], at=k * period + ahead)
        state = SimpleNamespace(position=measured.copy(), fresh=np.ones(N, dtype=bool))
        setpoint = tracker.setpoint(k * period, state)
        if setpoint is None:
            break
        angles.append(setpoint)
        measured = measured + (setpoint + droop - measured) * (1.0 - np.exp(-period / lag))
    return Followed(np.array(angles), ends, tracker)


def within_limits(angles: np.ndarray, period: float = PERIOD) -> None:
    """Every tick keeps ranges, speeds and accelerations."""
    assert (angles >= ARM.chain.lower - 1e-9).all()
    assert (angles <= ARM.chain.upper + 1e-9).all()
    velocity = np.diff(angles, axis=0, prepend=angles[:1]) / period
    acceleration = np.diff(velocity, axis=0, prepend=np.zeros((1, N))) / period
    assert (np.abs(velocity) <= ARM.max_velocity * 1.001).all()
    assert (np.abs(acceleration) <= ARM.max_acceleration * 1.001).all()


def one_gain(target: np.ndarray, gain: float, rate: float) -> Law:
    """The raw controller S_A, begun from rest."""
    hand, joints = np.zeros(HAND), np.zeros((JOINTS, N))
    hand[:3], hand[RATE], hand[RAMP], hand[LIMIT_RATE], hand[FADE] = target, rate, 0.2, np.inf, 0.1
    hand[LATE], joints[GAIN], joints[OFFSET] = np.inf, gain, -np.inf
    return Law(hand, joints)


@pytest.mark.parametrize("gain", [0.5, 1.0, 2.0])
def test_with_one_gain_the_hand_nears_its_target_as_the_closed_form_says(gain: float) -> None:
    """With M = g the error obeys e' = -lambda g ramp(t) e: straight, and e0 exp(-lambda g (..))."""
    start = ARM.rest + 0.3
    hand = ARM.chain.forward(start).tip
    target = hand + np.array([0.03, 0.05, -0.02])
    step, steps, rate = 1e-3, 800, 4.0
    path = np.empty((steps, N))
    arm = packed(ARM.chain.arrays, optimiser_settings("svd"), np.ones((3, N)))
    law = one_gain(target, gain, rate)
    follow(arm, *law, at_rest(start), 0.0, step, steps, -1.0, False, path)
    t = step * np.arange(1, steps + 1)
    risen = np.where(t < 0.2, 0.2 * ramp_integral(np.minimum(t / 0.2, 1.0)), 0.1 + t - 0.2)
    left = np.exp(-rate * gain * risen)
    hands = ARM.chain.positions(path)[:, -1]
    assert np.linalg.norm(hands - target, axis=1) / 0.0616441 == pytest.approx(left, abs=0.02)
    along = (hands - hand) @ (target - hand) / 0.0616441
    aside = np.linalg.norm(hands - hand - along[:, None] * (target - hand) / 0.0616441, axis=1)
    assert aside.max() < 5e-4


def test_gains_below_one_rise_to_it_and_those_above_stay() -> None:
    """With e' = -lambda g(t) e, g from 0.5 to 1 by minimum jerk from `late` on, as long again."""
    start, rate, late = ARM.rest + 0.3, 4.0, 0.3
    hand = ARM.chain.forward(start).tip
    target, step, steps = hand + np.array([0.03, 0.05, -0.02]), 1e-3, 800
    arm = packed(ARM.chain.arrays, optimiser_settings("svd"), np.ones((3, N)))
    t = step * np.arange(1, steps + 1)
    risen = late * ramp_integral(np.clip(t / late - 1.0, 0.0, 1.0)) + np.maximum(t - 2 * late, 0.0)
    for gain, mean in ((0.5, 0.5 * t + 0.5 * risen), (2.0, 2.0 * t)):
        law, path = one_gain(target, gain, rate), np.empty((steps, N))
        law.hand[RAMP], law.hand[LATE] = 0.0, late
        follow(arm, *law, at_rest(start), 0.0, step, steps, -1.0, False, path)
        left = np.linalg.norm(ARM.chain.positions(path)[:, -1] - target, axis=1)
        assert left / left[0] == pytest.approx(np.exp(-rate * (mean - mean[0])), abs=0.01)


def test_a_law_that_ends_in_a_posture_goes_over_to_nearing_it() -> None:
    """Once gains have risen every joint nears it by exp(-lambda t), whatever the hand is told."""
    start, rate, late, step, steps = ARM.rest + 0.3, 4.0, 0.1, 1e-3, 1200
    law, path = one_gain(ARM.chain.forward(start).tip, 1.0, rate), np.empty((steps, N))
    law.hand[LATE], law.hand[ENDS], law.joints[END] = late, 1.0, start - 0.2
    arm = packed(ARM.chain.arrays, optimiser_settings("svd"), np.ones((3, N)))
    follow(arm, *law, at_rest(start), 0.0, step, steps, -1.0, False, path)
    away = path[steps // 2 :] - law.joints[END]
    fall = np.exp(-rate * step * np.arange(away.shape[0]))
    assert away / away[0] == pytest.approx(np.tile(fall[:, None], N), abs=0.01)


def ramp_integral(x: np.ndarray) -> np.ndarray:
    """Integral of minimum jerk from 0 to x."""
    return np.asarray(2.5 * x**4 - 3.0 * x**5 + x**6)


@given(
    v=st.floats(-3.0, 3.0),
    a=st.floats(-15.0, 15.0),
    fade=st.floats(0.08, 0.2),
    between=st.floats(0.0, 0.5),
)
def test_what_is_carried_begins_as_it_was_and_fades_without_memory(
    v: float, a: float, fade: float, between: float
) -> None:
    def left(at: float) -> float:
        return carried_velocity(v, a, fade, at)

    def slope(at: float) -> float:
        return (left(at + 1e-6) - left(at - 1e-6)) / 2e-6

    assert left(0.0) == pytest.approx(v)
    assert slope(0.0) == pytest.approx(a, abs=1e-3)
    assert abs(left(12.0 * fade)) < 1e-3
    taken_over = carried_velocity(left(between), slope(between), fade, 0.1)
    assert taken_over == pytest.approx(left(between + 0.1), abs=1e-4)


@given(room=st.floats(1e-4, 3.0), braking=st.floats(1.0, 30.0), step=st.floats(1e-3, 5e-3))
def test_a_joint_that_brakes_in_time_stays_within_its_room(
    room: float, braking: float, step: float
) -> None:
    at, speed = 0.0, stopping_speed(room, braking, step)
    for _ in range(100_000):
        at += speed * step
        if speed <= 0.0:
            break
        allowed = stopping_speed(room - at, braking, step)
        assert allowed >= speed - braking * step * (1.0 + 1e-6) - 1e-9  # it can keep to it
        speed = max(0.0, min(speed - braking * step, allowed))
    assert at <= room * (1.0 + 1e-9)


def test_a_reach_from_rest_arrives_within_a_millimetre() -> None:
    found = followed((0.0, RIGHT))
    (end,) = found.ends
    assert end.how == "arrived"
    assert end.error < 1e-3
    assert np.linalg.norm(found.hand[-1] - RIGHT) < 1e-3
    assert count_peaks(found.speed, 1.0 / PERIOD) == 1
    within_limits(found.angles)


@pytest.mark.parametrize("change", [0.1, 0.3, 0.5, 0.7, 0.9, 1.2])
@pytest.mark.parametrize("second", [LEFT, LOW])
def test_a_double_step_is_smooth_and_has_two_peaks_at_most(
    change: float, second: tuple[float, ...]
) -> None:
    found = followed((0.0, RIGHT), (change, second))
    first, last = found.ends
    assert (first.how, last.how) == ("replaced", "arrived")
    assert last.error < 1e-3
    assert 1 <= count_peaks(found.speed, 1.0 / PERIOD) <= 2
    within_limits(found.angles)
    turn = round(last.aim.begin / PERIOD)
    velocity = np.diff(found.angles, axis=0) / PERIOD
    bend = np.diff(velocity, axis=0)[turn - 3 : turn + 3] / PERIOD
    assert (np.abs(np.diff(bend, axis=0)) <= 1.001 * ARM.max_jerk * PERIOD).all()
    # until the target changed, nobody knew of it
    alone = followed((0.0, RIGHT), seconds=0.9)
    before = min(turn, len(alone.angles))
    assert found.angles[:before] == pytest.approx(alone.angles[:before], abs=1e-12)


def test_to_hear_of_the_same_target_again_changes_nothing() -> None:
    alone = followed((0.0, RIGHT), seconds=2.5)
    again = followed((0.0, RIGHT), (0.4, RIGHT), (0.8, RIGHT), seconds=2.5)
    assert np.abs(again.hand - alone.hand).max() < 0.005
    assert count_peaks(again.speed, 1.0 / PERIOD) == 1


reachable = st.tuples(st.floats(0.28, 0.42), st.floats(-0.3, 0.15), st.floats(-0.25, 0.1))


@settings(max_examples=12, deadline=None)
@given(
    steps=st.lists(st.tuples(st.floats(0.01, 0.8), reachable), min_size=1, max_size=5),
    period=st.sampled_from([0.005, 0.02, 0.002]),
)
def test_whatever_comes_limits_hold_and_the_last_target_is_reached(
    steps: list[tuple[float, tuple[float, ...]]], period: float
) -> None:
    t, targets = 0.0, []
    for wait, target in steps:
        t += wait
        try:
            PLANNER.plan(at_rest(ARM.rest), target)
        except (UnreachableError, CollisionError):
            continue
        targets.append((t, target))
    try:
        found = followed(*targets, seconds=t + 6.0, period=period)
    except (UnreachableError, CollisionError):
        return  # reachable from rest, not from there
    within_limits(found.angles, period)
    if targets:
        assert np.linalg.norm(found.hand[-1] - targets[-1][1]) < 1e-3
        assert found.ends[-1].how == "arrived"


@pytest.mark.parametrize("ahead", [0.0, 0.1], ids=["at once", "told ahead of their time"])
def test_a_target_that_moves_on_is_followed_without_a_halt(ahead: float) -> None:
    times = np.arange(0.0, 4.0, 1.0 / 30.0)
    places = [(0.38, -0.1 + 0.1 * np.sin(1.5 * t), -0.1 + 0.05 * np.cos(1.5 * t)) for t in times]
    found = followed(*zip(times.tolist(), places, strict=True), seconds=4.0, ahead=ahead)
    within_limits(found.angles)
    later = slice(round(2.0 / PERIOD), None)
    assert found.speed[later].min() > 0.03  # the target's is 0.075 to 0.15 m/s
    wanted = np.array([np.interp(np.arange(801) * PERIOD, times, c) for c in np.transpose(places)])
    gap = np.linalg.norm(found.hand - wanted.T, axis=1)[later]
    assert gap.max() < 0.06 + 0.15 * ahead


def test_what_the_arm_stands_off_its_commands_is_made_up_for() -> None:
    found = followed((0.0, RIGHT), droop=-0.03, lag=0.08)
    (end,) = found.ends
    assert end.how == "arrived"
    assert end.error <= 1e-3
    measured = ARM.chain.forward(found.angles[-1] - 0.03).tip
    assert np.linalg.norm(measured - RIGHT) < 1.5e-3
    within_limits(found.angles)


@pytest.mark.parametrize(
    ("target", "kind", "said"),
    [
        ((5.0, 0.0, 0.0), UnreachableError, "cannot be reached by human7"),
        ((0.4, 0.0), InputError, "3 finite numbers"),
        ((np.nan, 0.0, 0.0), InputError, "3 finite numbers"),
    ],
)
def test_a_target_that_is_refused_leaves_the_last_good_one(
    target: tuple[float, ...], kind: type[Exception], said: str
) -> None:
    alone = followed((0.0, RIGHT), seconds=0.5)
    tracker = alone.tracker
    with pytest.raises(kind, match=said):
        tracker.aim(target)
    state = SimpleNamespace(position=alone.angles[-1], fresh=np.zeros(N, dtype=bool))
    angles = [tracker.setpoint(0.5 + k * PERIOD, state) for k in range(1, 500)]
    last = np.array(angles[-1])
    assert np.linalg.norm(ARM.chain.forward(last).tip - RIGHT) < 2e-3


def test_a_way_through_something_is_refused_before_the_arm_turns() -> None:
    inside_the_chest = (0.08, 0.28, -0.15)
    with pytest.raises(CollisionError, match="inside") as refused:
        PLANNER.plan(at_rest(ARM.rest), inside_the_chest)
    assert "base" in (refused.value.first, refused.value.second)


def test_a_hand_that_is_kept_away_is_given_up() -> None:
    """What pushes a joint a tenth of a radian off is not made up for without end."""
    found = followed((0.0, RIGHT), seconds=9.0, droop=-0.5)
    (end,) = found.ends
    assert end.how == "missed"
    assert end.error > 0.05
    within_limits(found.angles)
    found.tracker.finish()
    state = SimpleNamespace(position=found.angles[-1] - 0.5, fresh=np.ones(N, dtype=bool))
    assert found.tracker.setpoint(9.1, state) is None


def test_without_a_target_it_holds_and_ends_when_told() -> None:
    found = followed(seconds=1.0)
    assert np.array_equal(found.angles, np.tile(ARM.rest, (201, 1)))
    found.tracker.finish()
    state = SimpleNamespace(position=ARM.rest, fresh=np.ones(N, dtype=bool))
    assert found.tracker.setpoint(1.1, state) is None


def test_it_ends_only_after_the_last_arrival() -> None:
    ends: list[Arrival] = []
    tracker = ReachTracker(PLANNER, ARM.rest, ends.append)
    tracker.aim(LOW)
    tracker.finish()
    posture: np.ndarray | None = ARM.rest
    for k in range(1, 2000):
        state = SimpleNamespace(position=posture, fresh=np.ones(N, dtype=bool))
        last, posture = posture, tracker.setpoint(k * PERIOD, state)
        if posture is None:
            break
    assert posture is None
    assert last is not None
    assert ends[0].how == "arrived"
    assert np.linalg.norm(ARM.chain.forward(last).tip - LOW) < 1e-3


def test_a_target_is_turned_to_at_its_time() -> None:
    ends: list[Arrival] = []
    tracker = ReachTracker(PLANNER, ARM.rest, ends.append)
    aim = tracker.aim(RIGHT, at=0.5, tag="mine")
    assert (aim.begin, aim.tag) == (0.5, "mine")
    state = SimpleNamespace(position=ARM.rest, fresh=np.ones(N, dtype=bool))
    angles = np.array([tracker.setpoint(k * PERIOD, state) for k in range(1, 200)])
    moved = np.flatnonzero(np.abs(angles - ARM.rest).max(axis=1) > 0.0)
    assert moved[0] == 100  # the setpoint for 0.505 s is the first that is another


def test_a_target_that_comes_before_the_arm_turned_to_the_last_one_takes_its_place() -> None:
    ends: list[Arrival] = []
    tracker = ReachTracker(PLANNER, ARM.rest, ends.append, earliest=0.25)
    first, second = tracker.aim(RIGHT), tracker.aim(LOW)
    assert first.begin == second.begin == 0.25
    (end,) = ends
    assert (end.aim, end.how) == (first, "replaced")
    assert end.error == pytest.approx(np.linalg.norm(ARM.chain.forward(ARM.rest).tip - RIGHT))


def test_a_slower_clock_goes_the_same_way_later() -> None:
    """After a stall the driver lets path time run slowly: shorter steps, the same motion."""
    alone = followed((0.0, RIGHT), seconds=1.0)
    fine = followed((0.0, RIGHT), seconds=1.0, period=0.0025)
    assert fine.angles[::2] == pytest.approx(alone.angles, abs=0.02)


def test_the_driver_streams_a_double_step_and_finds_nothing_to_refuse() -> None:
    """On simulated servos that trail by 50 ms and round to ticks, with its own check of each."""
    stepped = SteppedArm(ARM)
    ends: list[Arrival] = []
    session = stepped.session()
    tracker = ReachTracker(PLANNER, session.read_posture(), ends.append, earliest=BLEND)
    waiting = deque([(0.1, RIGHT), (0.8, LEFT)])

    def setpoint(t: float, state: JointState) -> np.ndarray | None:
        while waiting and t >= waiting[0][0]:
            tracker.aim(waiting.popleft()[1])
            if not waiting:
                tracker.finish()
        return tracker.setpoint(t, state)

    recording = session.run_setpoint(setpoint, 10.0, recorded=5.0)
    assert recording.ending is Ending.COMPLETED
    assert recording.missed_ticks == 0
    assert [end.how for end in ends] == ["replaced", "arrived"]
    hand = ARM.chain.forward(stepped.positions()).tip
    assert np.linalg.norm(hand - LEFT) < 2e-3  # a tick is 0.9 mm at the length of the arm
    within_limits(recording.commanded_rad)
    speed = np.linalg.norm(
        np.diff(ARM.chain.positions(recording.commanded_rad)[:, -1], axis=0), axis=1
    )
    assert 1 <= count_peaks(speed / PERIOD, 1.0 / PERIOD) <= 2


def test_a_stop_on_the_way_decelerates() -> None:
    stepped = SteppedArm(ARM)
    session = stepped.session()
    tracker = ReachTracker(PLANNER, session.read_posture(), earliest=BLEND)
    tracker.aim(RIGHT)
    stepped.at(1.2, session.stops.request)
    recording = session.run_setpoint(tracker.setpoint, 60.0, recorded=10.0)
    assert recording.ending in (Ending.STOPPED_PARKED, Ending.STOPPED_HOLDING)
    within_limits(recording.commanded_rad)


def test_a_hand_is_turned_on_its_way_to_its_target() -> None:
    """To point down, then, in mid-motion, as its frame is in a known posture."""
    posture = ARM.chain.lower + 0.4 * (ARM.chain.upper - ARM.chain.lower)
    known = ARM.chain.forward(posture)
    tracker, angles = ReachTracker(PLANNER, ARM.rest, (ends := list[Arrival]()).append), [ARM.rest]
    aims = {1: (LOW, Pointing((0.0, 0.0, -1.0))), 80: (known.tip, Turned(known.orientations[-1]))}
    for k in range(1, 1200):
        if k in aims:
            tracker.aim(aims[k][0], orientation=aims[k][1])
        state = SimpleNamespace(position=angles[-1], fresh=np.ones(N, dtype=bool))
        setpoint = tracker.setpoint(k * PERIOD, state)
        assert setpoint is not None
        angles.append(setpoint)
    within_limits(np.array(angles))
    assert [end.how for end in ends] == ["replaced", "arrived"]
    there = ARM.chain.forward(angles[-1])
    turn = there.orientations[-1] @ known.orientations[-1].T
    assert np.linalg.norm(there.tip - known.tip) < 1e-3
    assert np.degrees(np.arccos((np.trace(turn) - 1.0) / 2.0)) < 2.0
    assert ends[1].turn < np.radians(2.0)


def test_a_hand_points_where_it_is_asked_to() -> None:
    planned = PLANNER.plan(at_rest(ARM.rest), LOW, orientation=Pointing((0.0, 0.0, -1.0)))
    joints = ARM.chain.positions(planned.path[-1:])[0]
    along = joints[-1] - joints[-2]  # the hand lies beyond the last joint
    assert np.linalg.norm(joints[-1] - LOW) < 1e-3
    assert np.degrees(np.arccos(-along[2] / np.linalg.norm(along))) < 2.0


def test_a_hand_that_cannot_be_turned_so_is_refused_and_told_why() -> None:
    arm = load_arm("openmanipulator_x")
    planner = LawPlanner(arm, sources_of(arm))
    with pytest.raises(UnreachableError, match="its 4 joints leave one of 2 angles"):
        planner.plan(at_rest(arm.rest), (0.2, 0.08, 0.15), orientation=Pointing((0.0, 1.0, 0.0)))


def test_reaches_take_the_synergy_and_the_pace_of_their_place() -> None:
    """A reach with room to spare takes as long as `reach --plan synergy` lets it take."""
    planner = planner_for(ARM, "synergy")
    for target in (RIGHT, LEFT, LOW):
        found = PLANNER.plan(at_rest(ARM.rest), target)
        whole = planner.plan(ARM.rest, target)
        assert found.chosen.learned is None
        assert found.chosen.outside == pytest.approx(whole.outside_m)
        longer = found.duration / (found.chosen.time_scale * whole.duration_s)
        assert 0.7 < longer < 1.6  # it settles, where the whole motion ends


def test_with_an_optimiser_or_a_model_they_take_the_nearest_learned_reach() -> None:
    planner = LawPlanner(ARM, sources_of(ARM, ik="jt"), "jt")
    found = planner.plan(at_rest(ARM.rest), RIGHT)
    assert found.chosen.learned is not None
    assert found.chosen.rank == 0


def test_a_slow_arm_goes_the_same_way_slower() -> None:
    """A law is slowed until the limits hold: a tenth of the speed, ten times the duration."""
    slow = LawPlanner(ARM.slowed(10.0), PLANNER.sources)
    found, usual = (p.plan(at_rest(ARM.rest), RIGHT) for p in (slow, PLANNER))
    assert found.chosen.scale == pytest.approx(10.0 * usual.chosen.scale, rel=0.05)
    assert np.linalg.norm(ARM.chain.forward(found.path[-1]).tip - RIGHT) < 1e-3


def test_what_would_take_minutes_whatever_the_synergy_is_refused_for_that() -> None:
    slow = LawPlanner(ARM.slowed(60.0), PLANNER.sources)
    with pytest.raises(UnreachableError, match="would take more than 60 s: allow it more") as told:
        slow.plan(at_rest(ARM.rest), RIGHT)
    assert told.value.miss_m == 0.0


def test_another_synergy_is_taken_where_one_would_need_minutes() -> None:
    """With the likeliest the hand passes a singular posture, and every step's own limits bend it.

    What a law that is slow enough asks for stays below those.
    """
    arm, goal = load_arm("viperx_300s"), (-0.381, 0.303, 0.139)
    planner = LawPlanner(arm, sources_of(arm))
    found = planner.plan(at_rest(arm.rest), goal)
    assert np.linalg.norm(arm.chain.forward(found.path[-1]).tip - goal) <= TOLERANCE_M
    velocity = np.diff(found.path, axis=0) / PERIOD
    assert (np.abs(velocity) <= (HEADROOM + 1e-6) * arm.max_velocity).all()


def test_no_reach_is_slowed_to_minutes_by_a_singular_posture() -> None:
    """The hand of 4 joints passes near the axis of the first, which would have to spin."""
    arm = load_arm("openmanipulator_x")
    planner = LawPlanner(arm, sources_of(arm))
    found = planner.plan(at_rest(arm.rest), (-0.03, 0.004, 0.42))
    assert found.duration < SLOWED_S
    velocity = np.diff(found.path, axis=0) / PERIOD
    assert (np.abs(velocity) <= arm.max_velocity).all()
    assert (np.abs(np.diff(velocity, axis=0)) <= arm.max_acceleration * PERIOD).all()
