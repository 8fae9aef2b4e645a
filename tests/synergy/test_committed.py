"""The synergies that come with the project: they belong to their arms and are what they say."""

from pathlib import Path

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.errors import CaptureError
from armsyn.motion.captures import load_captures
from armsyn.scoring import correlation, mean_distance, normalised_speed
from armsyn.synergy import Controller, SynergyLibrary, load_library
from armsyn.synergy.models import parameter_bounds
from armsyn.synergy.training import prepare

FOLDER = Path(__file__).resolve().parents[2] / "calibration"
ARMS = [
    "human7",
    "openmanipulator_x",
    "koch",
    "widowx_250s",
    "viperx_300s",
    "reachy_right",
]


@pytest.fixture(params=ARMS)
def library(request: pytest.FixtureRequest) -> SynergyLibrary:
    return load_library(FOLDER / f"{request.param}.synergies.json")


def test_they_belong_to_their_arms_and_are_finished(library: SynergyLibrary) -> None:
    arm = load_arm(library.arm, FOLDER)
    assert library.joint_names == arm.joint_names
    assert library.complete
    assert library.stable_gains
    assert len({reach.name for reach in library.reaches}) == len(library.reaches)
    assert {reach.kind for reach in library.reaches} == {"reach", "return"}  # for --return
    assert sum(not s.misfit for r in library.reaches for s in r.sets if s.model == "C") >= 10


def test_speed_profiles_are_shares_of_their_peak(library: SynergyLibrary) -> None:
    for reach in library.reaches:
        profile = np.array(reach.speed_profile)
        assert profile.shape == (101,)
        assert profile.max() == 1.0
        assert profile.min() >= 0.0
        assert max(profile[0], profile[-1]) < 0.1  # from onset to offset
        assert "frames" in reach.source


def test_gains_keep_the_loop_converging(library: SynergyLibrary) -> None:
    for reach in library.reaches:
        for learned in reach.sets:
            bounds = parameter_bounds(learned.model, len(library.joint_names), stable=True)
            assert (np.array(learned.parameters) >= bounds[0]).all()
            assert (np.array(learned.parameters) <= bounds[1]).all()
            if learned.ik in ("svd", "dls"):  # J G J^+ is bounded by the greatest gain
                most = max(learned.parameters[: len(library.joint_names)])
                assert library.lambdas[learned.ik] / library.rate_hz * most < 2


@pytest.mark.usefixtures("captures")
def test_recorded_distances_are_those_of_their_roll_outs(library: SynergyLibrary) -> None:
    arm = load_arm(library.arm, FOLDER)
    captured = {capture.name: capture for capture in load_captures(library.captures)}
    elsewhere, compared = [], 0
    assert set(captured) == {r.name for r in library.reaches} | set(library.left_out)
    for reach in library.reaches:
        training = prepare(arm, captured[reach.name], library.rate_hz)
        assert training.target == pytest.approx(reach.target_m, abs=2e-6)
        profile = normalised_speed(training.time, training.landmarks[:, -1])
        assert correlation(profile, np.array(reach.speed_profile)) > 0.9999
        for learned in reach.sets:
            rolled = Controller(arm.chain, learned.ik, library.lambdas[learned.ik]).synthesize(
                training.start,
                training.target,
                library.synergy(learned),
                dt=1 / library.rate_hz,
                frames=training.time.size,
            )
            landmarks = rolled.positions[:, list(arm.landmark_frames)]
            metric = mean_distance(training.landmarks, landmarks)
            compared += 1
            if learned.distance_m != pytest.approx(metric, abs=2e-6):
                elsewhere.append((reach.name, learned.ik, learned.model))
                assert learned.misfit, (reach.name, learned.ik, learned.model, metric)
    # near a straight arm or a truncated singular value rounding grows to millimetres: such
    # motions stay far from their targets, and nothing is planned by them
    assert len(elsewhere) <= 0.005 * compared, elsewhere


@pytest.mark.usefixtures("captures")
def test_what_was_left_out_still_cannot_be_used(library: SynergyLibrary) -> None:
    arm = load_arm(library.arm, FOLDER)
    for name, reason in library.left_out.items():
        (capture,) = load_captures(name)
        with pytest.raises(CaptureError) as caught:
            prepare(arm, capture, library.rate_hz)
        assert str(caught.value) == reason
