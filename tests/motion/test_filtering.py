"""The filter against scipy's, and hand speed against a movement known in closed form."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import butter, filtfilt

from armsyn.errors import CaptureError, InputError
from armsyn.motion.filtering import hand_speed, low_pass
from armsyn.motion.resample import uniform_times
from armsyn.motion.segmentation import onset_and_offset


def straight_reach(time: np.ndarray, start: float, duration: float) -> np.ndarray:
    phase = np.clip((time - start) / duration, 0, 1)
    return np.outer(10 * phase**3 - 15 * phase**4 + 6 * phase**5, [0.2, 0.1, 0.2])


@pytest.mark.parametrize("rate", [30.0, 100.0, 200.0])
def test_low_pass_is_scipys_forward_backward_butterworth(rate: float) -> None:
    values = np.random.default_rng(1).normal(size=(300, 3))
    b, a = butter(2, 6, fs=rate)
    expected = filtfilt(b, a, values, axis=0, padlen=int(np.ceil(rate / 6)))
    np.testing.assert_allclose(low_pass(values, rate), expected, atol=1e-12)


def test_low_pass_leaves_half_the_amplitude_at_its_cutoff_without_lag() -> None:
    time = np.arange(0, 4, 1 / 200)
    wave = np.sin(2 * np.pi * 6 * time)
    middle = slice(200, 600)
    np.testing.assert_allclose(low_pass(wave, 200.0)[middle], wave[middle] / 2, atol=1e-3)


def test_low_pass_keeps_straight_lines_to_their_ends() -> None:
    line = np.linspace(0, 1, 50)[:, None] * [1.0, -2.0, 3.0]
    np.testing.assert_allclose(low_pass(line, 100.0), line, atol=5e-3)
    np.testing.assert_allclose(low_pass(np.full(7, 3.0), 100.0), 3.0, atol=1e-12)


@pytest.mark.parametrize("samples", [2, 3, 5, 24])
def test_low_pass_takes_short_signals(samples: int) -> None:
    filtered = low_pass(np.linspace(0, 1, samples), 100.0)
    assert filtered.shape == (samples,)
    assert np.isfinite(filtered).all()


def test_low_pass_refuses_what_it_cannot_filter() -> None:
    with pytest.raises(InputError, match="lower the cut-off"):
        low_pass(np.zeros(10), 10.0)
    with pytest.raises(InputError, match="low-pass"):
        low_pass(np.zeros(10), 100.0, -1.0)
    with pytest.raises(CaptureError, match="fewer than two"):
        low_pass(np.zeros(1), 100.0)
    with pytest.raises(CaptureError, match="gaps"):
        low_pass(np.array([0.0, np.nan, 1.0]), 100.0)


@pytest.mark.parametrize("rate", [30.0, 60.0, 100.0, 200.0])
def test_hand_speed_of_a_known_reach_at_any_rate(rate: float) -> None:
    time = np.arange(0, 1.8, 1 / rate)
    profile = hand_speed(time, straight_reach(time, 0.5, 0.8))
    assert profile.speed.max() == pytest.approx(1.875 * 0.3 / 0.8, rel=0.01)
    assert profile.time[np.argmax(profile.speed)] == pytest.approx(0.9, abs=0.006)
    onset, offset = onset_and_offset(profile.speed)
    moving = profile.time[offset] - profile.time[onset]
    assert moving == pytest.approx(0.88113 * 0.8, abs=2 / profile.rate)


def test_hand_speed_follows_uneven_time_stamps() -> None:
    generator = np.random.default_rng(2)
    time = np.sort(generator.uniform(0, 1.8, 360))
    profile = hand_speed(time, straight_reach(time, 0.5, 0.8))
    even = uniform_times(time[0], time[-1], profile.rate)
    expected = hand_speed(even, straight_reach(even, 0.5, 0.8)).speed
    assert np.abs(profile.speed - expected).max() < 0.02 * expected.max()


def test_encoder_ticks_become_one_peak() -> None:
    tick = 0.3 * 2 * np.pi / 4096
    time = np.arange(0, 1.8, 1 / 200)
    ticked = np.round(straight_reach(time, 0.5, 0.8) / tick) * tick

    def maxima(speed: np.ndarray) -> int:
        onset, offset = onset_and_offset(speed)
        inner = speed[onset : offset + 1]
        return int(((inner[1:-1] > inner[:-2]) & (inner[1:-1] > inner[2:])).sum())

    assert maxima(hand_speed(time, ticked, cutoff=None).speed) > 5
    assert maxima(hand_speed(time, ticked).speed) == 1


@given(before=st.integers(0, 100), after=st.integers(0, 100), cut=st.integers(0, 60))
def test_rest_added_to_a_record_changes_nothing(before: int, after: int, cut: int) -> None:
    time = np.arange(0, 0.8, 1 / 200)
    moving = straight_reach(time, 0.0, 0.8)[cut : time.size - cut]
    rested = np.concatenate(
        [moving[:1].repeat(before, axis=0), moving, moving[-1:].repeat(after, axis=0)]
    )
    short = hand_speed(time[: len(moving)], moving)
    long = hand_speed(np.arange(len(rested)) / 200, rested)
    inner = long.speed[before : before + short.speed.size]
    np.testing.assert_allclose(inner, short.speed, atol=1e-5)


def test_hand_speed_refuses_what_it_cannot_measure() -> None:
    time = np.arange(0, 1, 0.01)
    with pytest.raises(InputError, match="do not fit"):
        hand_speed(time, np.zeros((5, 3)))
    with pytest.raises(InputError, match="cannot carry"):
        hand_speed(np.arange(0, 5, 0.1), np.zeros((50, 3)))
    with pytest.raises(CaptureError, match="gaps"):
        hand_speed(time, np.full((100, 3), np.nan))
