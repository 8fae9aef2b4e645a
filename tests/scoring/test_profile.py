"""Profile measures against closed forms, the table of oracle values and monalysa."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from monalysa.quality import smoothness as oracle

from armsyn.errors import CaptureError, InputError
from armsyn.motion.peaks import count_peaks
from armsyn.scoring.profile import (
    correlation,
    minimum_jerk_fit,
    minimum_jerk_speed,
    path_length,
    peak_over_mean,
    time_to_peak,
)
from armsyn.scoring.smoothness import log_dimensionless_jerk, spectral_arc_length

from .profiles import PHASE, PROFILES, minimum_jerk

RATE = 100.0


@pytest.mark.parametrize("name", PROFILES)
def test_table_of_oracle_values(name: str) -> None:
    profile, peak_time, ratio, r, r2, sparc, ldlj = PROFILES[name]
    speed = 0.3 * profile
    if peak_time is not None:
        assert time_to_peak(speed) == pytest.approx(peak_time, abs=0.001)
    assert peak_over_mean(speed, RATE) == pytest.approx(ratio, abs=0.001)
    digits = 5e-5 if name not in {"decay", "two"} else 5e-3
    assert minimum_jerk_fit(speed, RATE) == pytest.approx((r, r2), abs=digits)
    assert spectral_arc_length(speed, RATE) == pytest.approx(sparc, abs=5e-5)
    assert log_dimensionless_jerk(speed, RATE) == pytest.approx(ldlj, abs=6e-5)


@pytest.mark.parametrize(("rate", "jerk"), [(30, 190.7), (100, 200.66), (1000, 204.4)])
def test_sampled_jerk_of_minimum_jerk_approaches_its_closed_form(rate: int, jerk: float) -> None:
    speed = minimum_jerk(np.linspace(0, 1, rate + 1))
    # The table's values are for T = N / fs; the closed form 720 / 1.875^2 is for T = 1 s.
    assert np.exp(-log_dimensionless_jerk(speed, rate)) == pytest.approx(jerk, rel=5e-4)
    with_exact_duration = log_dimensionless_jerk(speed, rate) + 3 * np.log((rate + 1) / rate)
    assert np.exp(-with_exact_duration) == pytest.approx(720 / 1.875**2, rel=5 / rate)


def test_ldlj_with_the_exact_duration_is_what_its_documentation_says() -> None:
    value = log_dimensionless_jerk(minimum_jerk(PHASE), RATE) + 3 * np.log(101 / 100)
    assert value == pytest.approx(-5.2718, abs=5e-5)


def test_sparc_is_near_its_quadrature_on_any_grid() -> None:
    for rate in (30, 100, 200, 1000):
        speed = minimum_jerk(np.linspace(0, 1, rate + 1))
        assert spectral_arc_length(speed, rate) == pytest.approx(-1.408, abs=0.015)


def test_rest_padding_moves_ldlj_and_leaves_sparc() -> None:
    padded = np.pad(0.3 * minimum_jerk(PHASE), 50)
    assert spectral_arc_length(padded, RATE) == pytest.approx(-1.4059, abs=5e-5)
    assert log_dimensionless_jerk(padded, RATE) == pytest.approx(-7.39, abs=5e-3)


smooth_speeds = arrays(
    np.float64, st.integers(10, 120), elements=st.floats(0.01, 2, allow_subnormal=False)
).filter(lambda speed: np.ptp(np.diff(speed)) > 1e-6)


@given(speed=smooth_speeds, rate=st.sampled_from([30.0, 100.0, 200.0]))
def test_smoothness_agrees_with_monalysa_on_any_profile(speed: np.ndarray, rate: float) -> None:
    expected, _, _ = oracle.sparc(speed, rate)
    assert spectral_arc_length(speed, rate) == pytest.approx(expected, abs=1e-9)
    assert log_dimensionless_jerk(speed, rate) == pytest.approx(
        oracle.log_dimensionless_jerk(speed, rate, "vel", rem_mean=False), abs=1e-6
    )


def test_minimum_jerk_speed_integrates_to_one() -> None:
    phase = np.linspace(0, 1, 2001)
    assert path_length(minimum_jerk_speed(phase), 2000) == pytest.approx(1, abs=1e-6)
    np.testing.assert_allclose(minimum_jerk_speed(phase), minimum_jerk(phase), atol=1e-12)


@pytest.mark.parametrize(
    ("name", "count"), [("minimum jerk", 1), ("trapezoid", 1), ("decay", 1), ("two", 2)]
)
def test_count_of_submovements(name: str, count: int) -> None:
    assert count_peaks(0.3 * PROFILES[name][0], RATE) == count


def test_peaks_must_rise_and_be_apart() -> None:
    base = 0.3 * minimum_jerk(np.linspace(0, 1, 201))
    late_bump = np.exp(-(((np.arange(201) - 150) / 5) ** 2))
    assert count_peaks(base + 0.15 * late_bump, 100.0) == 2
    assert count_peaks(base + 0.06 * late_bump, 100.0) == 1
    # The same shape 10 times as fast: the two peaks are 50 ms apart, one submovement.
    assert count_peaks(base + 0.15 * late_bump, 1000.0) == 1


def test_the_first_peak_rises_from_the_lowest_speed_before_it_too() -> None:
    # As garza:BackLow:return begins: it moves when it is first seen, and wavers before it speeds up
    frames, speeds = [0, 20, 30, 60, 100], np.array([0.050, 0.064, 0.057, 0.960, 0.0])
    wavering = np.interp(np.arange(101), frames, speeds)
    assert count_peaks(wavering, 100.0) == 1
    assert count_peaks(wavering, 100.0, rise=0.010) == 2
    assert count_peaks(wavering[20:], 100.0) == 2  # cut at its first peak, as if from rest


def test_a_slow_drift_has_no_peak() -> None:
    assert count_peaks(np.full(50, 0.01), 100.0) == 0


@given(scale=st.floats(0.1, 10), offset=st.floats(-1, 1), samples=st.integers(20, 300))
def test_correlation_ignores_size_and_sampling(scale: float, offset: float, samples: int) -> None:
    phase = np.linspace(0, 1, samples)
    other = offset + scale * minimum_jerk(phase)
    assert correlation(minimum_jerk(PHASE), other) == pytest.approx(1, abs=2e-3)
    assert correlation(minimum_jerk(PHASE), -other) == pytest.approx(-1, abs=2e-3)


def test_correlation_with_a_constant_is_undefined() -> None:
    assert np.isnan(correlation(minimum_jerk(PHASE), np.full(101, 0.1)))


def test_too_short_profiles_are_refused() -> None:
    with pytest.raises(InputError, match="two samples"):
        correlation(np.ones(1), np.ones(5))
    with pytest.raises(CaptureError, match="three samples"):
        minimum_jerk_fit(np.ones(2), RATE)
    for measure in (spectral_arc_length, log_dimensionless_jerk):
        with pytest.raises(CaptureError):
            measure(np.ones(1), RATE)
        with pytest.raises(CaptureError):
            measure(np.zeros(50), RATE)
        with pytest.raises(CaptureError):
            measure(np.full(50, np.nan), RATE)
    with pytest.raises(CaptureError, match="curvature"):
        log_dimensionless_jerk(np.arange(1.0, 9.0), RATE)
