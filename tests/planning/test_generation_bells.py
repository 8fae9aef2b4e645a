"""Which of many reaches speed up more than once, against the measure of one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.arm import load_arm
from armsyn.kernels import bells
from armsyn.motion.filtering import LOWEST_RATE, hand_speed
from armsyn.motion.peaks import count_peaks
from armsyn.planning.allowed import tried
from armsyn.planning.evenness import uneven_speed
from tests.planning.apart import pace, uneven_reaches

ROWS = range(120)
PHASE = np.linspace(0.0, 1.0, 101)


def peaks_alone(hand: np.ndarray, rate_hz: float) -> int:
    """By what measures any motion."""
    profile = hand_speed(np.arange(len(hand)) / rate_hz, hand)
    return count_peaks(profile.speed, profile.rate)


def played_at(hand: np.ndarray, rate_hz: float, fine: float) -> np.ndarray:
    """A way whose samples come at one rate, at another."""
    frames = np.arange(0.0, len(hand) - 1 + 1e-3, rate_hz / fine)
    return np.stack([np.interp(frames, np.arange(len(hand)), part) for part in hand.T], axis=1)


@pytest.mark.parametrize("rate_hz", [20.0, 50.0, 100.0, 200.0])
@pytest.mark.parametrize("name", ["human7", "widowx_250s"])
def test_many_are_measured_as_one_alone(name: str, rate_hz: float) -> None:
    """Bells, two bells one after the other, and all that lies between."""
    arm, rng = load_arm(name, calibrated=False), np.random.default_rng(8)
    ways = rng.normal(0.0, 0.5, (120, 1, arm.chain.dof))
    waves = rng.normal(0.0, 0.15, (120, 3, arm.chain.dof)) * rng.uniform(0, 1, (120, 1, 1)) ** 3
    angles = arm.rest + ways * (PHASE**3 * (10.0 - 15.0 * PHASE + 6.0 * PHASE**2))[:, None]
    for k in range(3):
        angles = angles + waves[:, k, None] * np.sin(np.pi * (k + 1) * PHASE)[:, None] ** 2
    paced = pace(arm, angles, rng.uniform(0.3, 2.0, len(angles)), rate_hz)
    fine = max(rate_hz, LOWEST_RATE)
    hands = [arm.chain.positions(paced.path(row))[:, -1] for row in ROWS]
    alone = [
        max(
            peaks_alone(hand, rate_hz),
            peaks_alone(played_at(hand, scale * rate_hz, fine), fine),
        )
        for hand, scale in zip(hands, paced.scales, strict=True)
    ]
    assert uneven_reaches(arm.chain, paced).tolist() == [peaks > 1 for peaks in alone]
    assert 12 < np.count_nonzero(np.array(alone) > 1) < 108


def two_bells(stop: float) -> np.ndarray:
    """A hand at 200 Hz that goes 20 cm, all but stops, and goes 15 cm on, m."""
    bell = np.sin(np.pi * np.linspace(0.0, 1.0, 160)) ** 2
    speed = np.concatenate([0.30 * bell, np.full(40, stop), 0.24 * bell])
    return np.outer(np.concatenate([[0.0], np.cumsum(np.maximum(speed, stop)) / 200.0]), [1, 0, 0])


@pytest.mark.parametrize("stop", [0.0, 0.007, 0.03])
def test_a_second_bell_behind_a_stop_is_one(stop: float) -> None:
    """Also where the dip is so low that the movement's offset would be taken to be there."""
    refused = uneven_speed(two_bells(stop), 200.0)
    assert refused is not None
    assert refused.peaks == 2
    assert uneven_speed(two_bells(stop)[:161], 200.0) is None
    assert uneven_speed(two_bells(stop)[::20], 10.0) is not None


@pytest.mark.parametrize("slower", [1.0, 3.0, 20.0, 200.0])
def test_a_hand_that_stops_on_its_way_is_uneven_however_slow_the_arm_is(slower: float) -> None:
    """At 1/200 of the speed its two bells rise by less than what counts as a peak."""
    arm = load_arm("human7", calibrated=False).slowed(slower)
    way = np.clip(np.minimum(2.5 * PHASE, 0.5) + np.maximum(2.5 * PHASE - 1.5, 0.0), 0.0, 1.0)
    ways = np.array([0.6, 0.3, 0.0, 0.5, 0.0, 0.0, 0.0])
    found = tried(arm, (arm.rest + np.outer(way, ways))[None], np.array([1.2]), 200.0)
    assert found.uneven.tolist() == [True]
    assert found.paced.scales[0] > 0.9 * slower


@given(
    st.lists(st.integers(0, 6), min_size=1, max_size=40),
    st.integers(1, 4),
    st.floats(0.5, 9.0),
)
def test_peaks_of_any_profile_are_counted_as_in_plain_words(
    steps: list[int], rise: int, spacing: float
) -> None:
    """Whole numbers, so that levels, ties and plateaus come often."""
    speed = np.array(steps, dtype=float)
    assert bells.count_peaks(speed, float(rise), spacing) == count_peaks(speed, 1.0, rise, spacing)
