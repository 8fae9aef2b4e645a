"""All measures of a hand's movement, from slow captures and noisy recordings alike."""

import dataclasses

import numpy as np
import pytest

from armsyn.errors import CaptureError, FormatError
from armsyn.motion import Motion
from armsyn.scoring import correlation, measure, movement, normalised_speed, profile_measures

from .profiles import minimum_jerk, reach


@pytest.mark.parametrize("rate", [30.0, 60.0, 100.0, 200.0])
def test_a_minimum_jerk_reach_measures_the_same_at_any_rate(rate: float) -> None:
    measures = profile_measures(*reach(rate))
    assert measures.movement_time == pytest.approx(0.88113 * 0.8, abs=0.02)
    assert measures.path == pytest.approx(0.99617 * 0.3, rel=0.005)
    assert measures.distance == pytest.approx(measures.path, rel=0.001)
    assert measures.peak_speed == pytest.approx(1.875 * 0.3 / 0.8, rel=0.01)
    assert measures.time_to_peak == pytest.approx(0.5, abs=0.015)
    assert measures.peak_over_mean == pytest.approx(1.65848, rel=0.02)
    assert measures.speed_peaks == 1
    assert measures.min_jerk_r > 0.99
    assert measures.sparc == pytest.approx(-1.4, abs=0.02)
    assert measures.path_over_distance == pytest.approx(1, abs=1e-6)
    assert measures.deviation_over_distance == pytest.approx(0, abs=1e-6)


def test_the_cut_reach_at_100_hz_has_the_known_jerk() -> None:
    # 89 samples at 100 Hz of a movement of 1 s, unfiltered: LDLJ -4.397 (T = N / fs).
    measures = profile_measures(*reach(1000.0, duration=1.0), cutoff=None, rate=100.0)
    assert round(measures.movement_time * 100) == 88
    assert measures.ldlj == pytest.approx(-4.397, abs=0.03)


def test_how_it_was_measured_is_part_of_the_result() -> None:
    time, positions = reach(200.0)
    measures = profile_measures(time + 7, positions, cutoff=5.0, fraction=0.1, rate=150.0)
    assert (measures.rate, measures.cutoff, measures.cut_fraction) == (150.0, 5.0, 0.1)
    assert measures.onset == pytest.approx(7.5 + 0.8 * 0.09, abs=0.02)
    assert measures.offset - measures.onset == pytest.approx(measures.movement_time)


def test_an_arc_has_the_straightness_of_a_half_circle() -> None:
    time, straight = reach(200.0)
    angle = np.pi * np.linalg.norm(straight, axis=1) / 0.3
    arc = 0.1 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    measures = profile_measures(time, arc, fraction=0.001)
    assert measures.path_over_distance == pytest.approx(np.pi / 2, rel=0.005)
    assert measures.deviation_over_distance == pytest.approx(0.5, rel=0.005)


def test_a_path_that_ends_where_it_began_has_no_straightness() -> None:
    time = np.arange(0, 1.0001, 0.005)
    turn = 2 * np.pi * (10 * time**3 - 15 * time**4 + 6 * time**5)
    circle = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    measures = profile_measures(time, circle, cutoff=None, fraction=1e-6)
    assert np.isnan(measures.path_over_distance)
    assert np.isnan(measures.deviation_over_distance)


def test_encoder_noise_at_200_hz_and_a_capture_at_30_hz_have_one_profile() -> None:
    time, positions = reach(200.0)
    noise = np.random.default_rng(4).uniform(-5e-4, 5e-4, positions.shape)
    recorded = normalised_speed(time, positions + noise)
    captured = normalised_speed(*reach(30.0))
    assert recorded.shape == captured.shape == (101,)
    assert correlation(recorded, captured) > 0.998
    assert profile_measures(time, positions + noise).speed_peaks == 1
    exact = 0.3 / 0.8 * minimum_jerk(np.linspace(0.05944, 1 - 0.05944, 101))
    assert np.abs(captured - exact).max() < 0.02 * exact.max()


def test_a_capture_cut_at_its_onset_still_measures() -> None:
    time, positions = reach(30.0, rest=0.0)
    assert time.size == 25
    assert profile_measures(time, positions).speed_peaks == 1
    assert correlation(normalised_speed(time, positions), normalised_speed(*reach(30.0))) > 0.99


def test_rest_around_a_reach_changes_nothing_that_is_measured() -> None:
    short, long = (profile_measures(*reach(200.0, rest=rest)) for rest in (0.5, 2.5))
    for name, value in dataclasses.asdict(short).items():
        if name not in {"onset", "offset"}:
            assert getattr(long, name) == pytest.approx(value, rel=1e-6, abs=1e-9), name


def test_motions_measure_their_last_landmark() -> None:
    time, positions = reach(100.0)
    landmarks = np.stack([np.zeros_like(positions), positions], axis=1)
    motion = Motion(time=time, landmark_names=("shoulder", "hand"), landmarks=landmarks)
    assert measure(motion) == profile_measures(time, positions)


def test_refusals() -> None:
    time = np.arange(0, 1, 0.01)
    with pytest.raises(FormatError, match="only angles"):
        measure(Motion(time=time, joint_names=("elbow",), angles=np.zeros((100, 1))))
    with pytest.raises(CaptureError, match="does not move"):
        profile_measures(time, np.ones((100, 3)), cutoff=None)
    jump = np.where(time[:, None] < 0.5, 0.0, [[0.3, 0.0, 0.0]])
    with pytest.raises(CaptureError, match="only"):
        movement(time, jump, cutoff=None)
