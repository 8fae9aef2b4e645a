"""One tick of a stream, judged alone: what is allowed is within all limits, and nothing else is."""

import dataclasses

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from armsyn.arm import load_arm
from armsyn.errors import (
    CollisionError,
    CommandFaultError,
    FollowingError,
    InputError,
    LimitError,
    ServoLoadError,
)
from armsyn.safety import (
    CommandLimits,
    TickState,
    averaged_current,
    check_commands,
    check_load,
    check_rates,
    judge_tick,
    warm_joints,
)
from tests.safety.shaped import two_links

Array = NDArray[np.float64]

PERIOD = 0.01
LIMITS = CommandLimits(
    names=("a", "b"),
    lower=np.array([-1.0, -1.0]),
    upper=np.array([1.0, 1.0]),
    max_step=np.array([0.02, 0.02]),
    period=PERIOD,
    max_acceleration=np.array([50.0, 50.0]),  # 0.005 rad of second difference
    max_jerk=np.array([8000.0, 8000.0]),  # 0.008 rad of third difference
    max_temperature=np.array([70.0, 70.0]),
    max_current=np.array([1.5, 1.5]),
    min_voltage=np.array([9.5, 9.5]),
    max_voltage=np.array([14.8, 14.8]),
)
REST = TickState.at_rest([0.0, 0.0])
steps = st.floats(-0.03, 0.03)
numbers = st.floats(-1.3, 1.3)
bad = st.sampled_from([np.nan, np.inf, -np.inf])


def state_of(commands: Array, **more: Array) -> TickState:
    """Return a state with commands, shape (3, n), whose joints follow exactly."""
    return TickState(commands, commands[-1], np.zeros(2), np.array([True, True]), **more)


@st.composite
def commands(draw: st.DrawFn) -> Array:
    """Draw three commands a few steps apart, anywhere, also in and about the range's ends."""
    start = np.array(draw(st.tuples(numbers, numbers)))
    way = np.array(draw(st.lists(st.tuples(steps, steps), min_size=2, max_size=2)))
    return np.vstack([start, start + np.cumsum(way, axis=0)])


@pytest.mark.fault(33)
@given(commands(), st.tuples(steps, steps))
def test_what_is_allowed_is_within_all_limits(before: Array, step: tuple[float, float]) -> None:
    wanted = before[-1] + np.array(step)
    command, fault = judge_tick(state_of(before), wanted, LIMITS)
    path = np.vstack([before, wanted])
    move = np.abs(wanted - before[-1])
    acceleration, jerk = (
        np.abs(np.diff(path, order, axis=0)[-1]) / PERIOD**order for order in (2, 3)
    )
    inside = (
        (np.abs(wanted) <= 1.0 + 1e-6).all()
        and (move <= LIMITS.max_step).all()
        and (acceleration <= LIMITS.max_acceleration * (1 + 1e-9)).all()
        and (jerk <= LIMITS.max_jerk * (1 + 1e-9)).all()
    )
    assert (command is None) == (fault is not None)
    if command is not None:
        assert inside
        assert (command >= LIMITS.lower).all()
        assert (command <= LIMITS.upper).all()
        np.testing.assert_allclose(command, wanted, rtol=0.0, atol=1e-6)
        if (np.abs(wanted) <= 1.0).all():
            np.testing.assert_array_equal(command, wanted)
    else:
        assert isinstance(fault, CommandFaultError)
        assert isinstance(fault.__cause__, LimitError)
        near = [move / LIMITS.max_step, acceleration / LIMITS.max_acceleration]
        near += [jerk / LIMITS.max_jerk, np.abs(wanted)]
        assert np.max(near) > 1.0 - 1e-9  # a limit is broken, or met to rounding


@pytest.mark.fault(30)
@given(st.integers(0, 4), st.integers(0, 1), bad)
def test_what_is_no_number_is_never_allowed(row: int, joint: int, value: float) -> None:
    """In the command, in the three before it, and in what was measured."""
    rows = np.zeros((5, 2))
    rows[row, joint] = value
    state = state_of(rows[:3])._replace(measured=rows[4])
    assert judge_tick(state, rows[3], LIMITS).command is None
    assert judge_tick(state_of(np.zeros((3, 2))), np.zeros(2), LIMITS).fault is None


@given(commands(), st.tuples(steps, steps), st.floats(1.0, 10.0))
def test_wider_limits_allow_no_less(
    before: Array, step: tuple[float, float], factor: float
) -> None:
    wanted = before[-1] + np.array(step)
    assume(judge_tick(state_of(before), wanted, LIMITS).command is not None)
    for name in ("lower", "upper", "max_step", "max_acceleration", "max_jerk"):
        wider = dataclasses.replace(LIMITS, **{name: factor * getattr(LIMITS, name)})
        assert judge_tick(state_of(before), wanted, wider).command is not None
    unknown = dataclasses.replace(
        LIMITS, max_acceleration=np.array(np.nan), max_jerk=np.array(np.nan)
    )
    assert judge_tick(state_of(before), wanted, unknown).command is not None


@given(st.tuples(steps, steps), st.floats(0.0, 1.0))
def test_less_of_an_allowed_step_is_allowed(step: tuple[float, float], share: float) -> None:
    wanted = np.array(step)
    assume(judge_tick(REST, wanted, LIMITS).command is not None)
    assert judge_tick(REST, share * wanted, LIMITS).command is not None


loads = st.floats(-200.0, 200.0, allow_nan=False) | st.just(np.nan)


@given(loads, loads, loads)
def test_loads_by_their_limits(temperature: float, current: float, voltage: float) -> None:
    """Unknown ones are not judged."""
    at = [np.array([20.0, temperature]), np.array([0.0, current]), np.array([12.0, voltage])]
    state = REST._replace(temperature=at[0], current=at[1], voltage=at[2])
    broken = temperature > 70.0 or abs(current) > 1.5 or voltage < 9.5 or voltage > 14.8
    command, fault = judge_tick(state, np.zeros(2), LIMITS)
    assert (fault is not None) == broken
    assert (command is None) == broken
    if fault is not None:
        assert isinstance(fault, ServoLoadError)
        assert fault.exit_status == 3
        assert fault.joint == "b"
    blind = dataclasses.replace(
        LIMITS,
        **dict.fromkeys(
            ("max_temperature", "max_current", "min_voltage", "max_voltage"), np.array(np.nan)
        ),
    )
    assert check_load(state, blind) is None


@pytest.mark.fault(19)
@pytest.mark.parametrize(
    ("more", "text", "value", "limit"),
    [
        ({"temperature": [75.0, 20.0]}, "a: its servo is 75 degrees Celsius hot, 70", 75.0, 70.0),
        ({"current": [0.0, -1.7]}, "b: its servo takes -1.70 A, 1.50 A are allowed", -1.7, 1.5),
        ({"voltage": [np.nan, 9.0]}, "b: its servo is supplied with 9.0 V, at least 9.5", 9.0, 9.5),
        ({"voltage": [15.5, 12.0]}, "a: its servo is supplied with 15.5 V, at most", 15.5, 14.8),
    ],
)
def test_what_an_overloaded_servo_says(
    more: dict[str, list[float]], text: str, value: float, limit: float
) -> None:
    fault = check_load(REST._replace(**{k: np.array(v) for k, v in more.items()}), LIMITS)
    assert fault is not None
    assert text in str(fault)
    assert (fault.value, fault.limit) == (value, limit)


@pytest.mark.fault(19)
def test_servos_are_warned_of_before_they_are_too_hot() -> None:
    assert warm_joints(REST, LIMITS) == ()
    assert warm_joints(REST._replace(temperature=np.array([64.9, 65.1])), LIMITS) == ("b",)
    assert warm_joints(REST._replace(temperature=np.array([90.0, np.nan])), LIMITS) == ("a",)


def test_faults_of_the_arm_come_before_those_of_the_command() -> None:
    hot = state_of(np.zeros((3, 2)), temperature=np.array([80.0, 20.0]))
    lost = hot._replace(measured=np.array([0.0, 0.4]))
    wild = np.array([np.nan, 0.0])
    assert isinstance(judge_tick(lost, wild, LIMITS).fault, FollowingError)
    assert isinstance(judge_tick(hot, wild, LIMITS).fault, ServoLoadError)
    stale = lost._replace(fresh=np.array([True, False]), temperature=np.array(np.nan))
    assert isinstance(judge_tick(stale, wild, LIMITS).fault, CommandFaultError)
    assert judge_tick(stale, np.zeros(2), LIMITS).fault is None


@pytest.mark.parametrize(
    ("before", "wanted", "text"),
    [
        ([0.0, 0.0, 0.0], 1.5, "joint b: the command 1.500 rad is outside its limit 1.000 rad"),
        ([0.0, 0.0, 0.0], 0.03, "joint b: the command jumps by 0.0300 rad"),
        (
            [0.0, 0.0, 0.0],
            0.006,
            "joint b: the command asks for an acceleration of 60.0 rad/s2, 50",
        ),
        ([0.0, 0.0, 0.0045], 0.0045, "joint b: the command asks for a jerk of 9000 rad/s3, 8000"),
    ],
)
def test_what_a_refused_command_says(before: list[float], wanted: float, text: str) -> None:
    rows = np.column_stack([np.zeros(3), before])
    fault = judge_tick(state_of(rows), np.array([0.0, wanted]), LIMITS).fault
    assert isinstance(fault, CommandFaultError)
    assert fault.joint == "b"
    assert text in str(fault)
    assert str(fault).endswith("the motion went wrong on its way and was stopped; plan it again")


@pytest.mark.parametrize("wanted", [0.0, [0.0], [0.0, 0.0, 0.0], [[0.0, 0.0]], "no", None, [{}]])
def test_commands_that_are_none(wanted: object) -> None:
    """A callable may return anything; one number must not become everybody's goal."""
    command, fault = judge_tick(REST, wanted, LIMITS)  # type: ignore[arg-type]
    assert command is None
    assert isinstance(fault, CommandFaultError)
    assert "\n" not in str(fault)
    assert "the command is not 2 numbers" in str(fault)


@pytest.mark.fault(33)
def test_rounding_past_a_limit_is_taken_off() -> None:
    state = TickState.at_rest([1.0, -1.0])
    command, _ = judge_tick(state, [1.0 + 5e-7, -1.0 - 5e-7], LIMITS)
    assert command is not None
    np.testing.assert_array_equal(command, [1.0, -1.0])


def minimum_jerk(start: Array, goal: Array, duration: float, period: float) -> Array:
    u = np.clip(np.arange(0.0, duration + 5 * period, period) / duration, 0.0, 1.0)[:, None]
    return start + (u**3 * (10.0 - 15.0 * u + 6.0 * u**2)) * (goal - start)


@pytest.mark.parametrize("rate", [50.0, 200.0, 1000.0])
def test_a_stream_at_an_arms_limits_passes_and_a_faster_one_does_not(rate: float) -> None:
    """Minimum jerk: peak speed 15/8 way/T, acceleration 5.77 way/T2 (Flash and Hogan, 1985)."""
    arm = load_arm("human7")
    limits = CommandLimits.of(arm, 1.0 / rate, arm.rest)
    goal = arm.rest.copy()
    goal[3] += 1.0
    shortest = 15.0 / 8.0 / arm.max_velocity[3]
    for duration, passes in ((1.01 * shortest, True), (0.9 * shortest, False)):
        state, faults = TickState.at_rest(arm.rest), []
        for wanted in minimum_jerk(arm.rest, goal, duration, 1.0 / rate):
            command, fault = judge_tick(state, wanted, limits)
            if command is None:
                faults.append(fault)
                break
            state = state.after(command)
        assert (not faults) == passes
        if not passes:
            assert "elbow_flexion: the command jumps" in str(faults[0])


@pytest.mark.fault(31)
def test_a_spike_is_found_by_its_acceleration() -> None:
    """A command 0.003 rad off the path, which speed alone lets pass."""
    arm = load_arm("human7")
    limits = CommandLimits.of(arm, 0.005, arm.rest)
    spike = arm.rest + np.array([0.0, 0.0, 0.0, 0.003, 0.0, 0.0, 0.0])
    fault = judge_tick(TickState.at_rest(arm.rest), spike, limits).fault
    assert fault is not None
    assert "acceleration" in str(fault)
    assert check_rates(spike, TickState.at_rest(arm.rest).commands, limits) is not None


@pytest.mark.fault(34)
def test_a_command_into_a_post() -> None:
    post = '[[box]]\nname = "post"\ncentre = [0.0, 0.475, 0.0]\nsize = [0.01, 0.15, 1.0]\n'
    arm = two_links("", post)
    free, near = np.array([1.4, 0.0]), np.array([1.52, 0.0])
    limits = CommandLimits.of(arm, PERIOD, free)
    assert judge_tick(TickState.at_rest(free), free, limits).fault is None
    fault = judge_tick(TickState.at_rest(near), near, limits).fault
    assert isinstance(fault, CommandFaultError)
    assert fault.joint == "lower_arm"
    assert isinstance(fault.__cause__, CollisionError)
    assert "m inside post" in str(fault)
    # it may stay where it already is, and leave
    there = CommandLimits.of(arm, PERIOD, near)
    assert judge_tick(TickState.at_rest(near), near, there).fault is None
    assert judge_tick(TickState.at_rest(near), near - np.array([0.001, 0.0]), there).fault is None
    deeper = near + np.array([0.01, 0.0])
    assert judge_tick(TickState.at_rest(deeper), deeper, there).fault is not None
    either = CommandLimits.of(arm, PERIOD, [free, near])
    assert judge_tick(TickState.at_rest(near), near, either).fault is None
    assert there.clearances is not None
    assert there.clearances.broken_by(np.array([np.nan, 0.0])) is not None
    with pytest.raises(InputError, match="2 finite columns"):
        CommandLimits.of(arm, PERIOD, [0.0])


def test_currents_are_averaged() -> None:
    """A step is taken in by 63 % in the time of the memory, and an unknown one not at all."""
    average = averaged_current(np.array([np.nan, np.nan]), np.array([0.0, np.nan]), 0.005)
    np.testing.assert_array_equal(average, [0.0, np.nan])
    for _ in range(100):
        average = averaged_current(average, np.array([1.0, 2.0]), 0.005)
    np.testing.assert_allclose(average, [1.0 - np.exp(-1.0), 2.0], atol=0.005)
    np.testing.assert_array_equal(averaged_current(average, np.full(2, np.nan), 0.005), average)


def test_currents_to_and_fro_do_not_cancel() -> None:
    """As of a joint that swings about its goal: 8 Hz at 3 A are 3 A."""
    average = np.zeros(1)
    for tick in range(600):
        sign = -1.0 if (tick // 12) % 2 else 1.0
        average = averaged_current(average, np.array([3.0 * sign]), 0.005)
    np.testing.assert_allclose(average, 3.0 * (1.0 - np.exp(-3.0 / 0.5)), atol=0.005)


@given(st.lists(st.tuples(steps, steps), max_size=12))
def test_a_whole_stream_is_refused_where_its_ticks_are(moves: list[tuple[float, float]]) -> None:
    stream = np.cumsum([(0.0, 0.0), *(0.2 * np.array(move) for move in moves)], axis=0)
    rows = [stream[0]] * 3 + [*stream] + [stream[-1]] * 3
    refused = None
    for row in range(len(rows) - 3):
        before = np.array(rows[row : row + 3])
        if judge_tick(state_of(before), rows[row + 3], LIMITS).command is None:
            refused = row
            break
    found = check_commands(stream, LIMITS)
    assert (found and found[0]) == refused


@given(st.lists(st.tuples(steps, steps), min_size=4, max_size=12), st.integers(3, 10))
def test_a_stream_may_be_judged_in_parts(moves: list[tuple[float, float]], cut: int) -> None:
    stream = np.cumsum([(0.0, 0.0), *(0.2 * np.array(move) for move in moves)], axis=0)
    cut = min(cut, len(stream) - 1)
    found = check_commands(stream[:cut], LIMITS, rests=False)
    if found is None:
        found = check_commands(stream[cut:], LIMITS, before=stream[cut - 3 : cut])
        found = found and (found[0] + cut, found[1])
    whole = check_commands(stream, LIMITS)
    assert (found and (found[0], str(found[1]))) == (whole and (whole[0], str(whole[1])))
