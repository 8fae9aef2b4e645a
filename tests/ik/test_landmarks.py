"""Postures fitted to landmarks that forward kinematics made."""

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.errors import InputError
from armsyn.ik import fit_posture
from armsyn.kinematics import SerialChain
from tests.kinematics.oracle import Array, Oracle

REST = np.array([0.125, 0.374, 0.623, 0.562, 0.0, 0.06, -0.024])


def comfortable(chain: SerialChain, rng: np.random.Generator) -> Array:
    """Return a posture clear of the limits, with the elbow bent."""
    middle, half = 0.5 * (chain.lower + chain.upper), 0.5 * (chain.upper - chain.lower)
    return middle + 0.6 * half * rng.uniform(-1.0, 1.0, chain.dof)


def test_landmarks_are_found_again(human7: SerialChain, oracle: Oracle) -> None:
    arm = load_arm("human7")
    rng = np.random.default_rng(21)
    for _ in range(20):
        true = comfortable(human7, rng)
        landmarks = oracle.frames(true)[0][list(arm.landmark_frames)]
        near = np.clip(true + rng.normal(0.0, 0.3, 7), human7.lower, human7.upper)
        fit = fit_posture(human7, arm.landmark_frames, landmarks, near)
        found = oracle.frames(fit.posture)[0][list(arm.landmark_frames)]
        assert fit.residual < 2e-3
        assert fit.residual == pytest.approx(np.linalg.norm(found - landmarks, axis=1).mean())
        assert (human7.lower <= fit.posture).all()
        assert (fit.posture <= human7.upper).all()


def test_a_posture_is_its_own_fit(human7: SerialChain, oracle: Oracle) -> None:
    rows = (0, 3, 5, 7)
    landmarks = oracle.frames(REST)[0][list(rows)]
    fit = fit_posture(human7, rows, landmarks, REST)
    np.testing.assert_allclose(fit.posture, REST, rtol=0, atol=1e-6)
    assert fit.residual < 1e-9


def test_what_landmarks_leave_open_stays_near(human7: SerialChain, oracle: Oracle) -> None:
    # shoulder and elbow alone say nothing of the forearm and the wrist
    true = REST + np.array([0.5, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0])
    rows = (0, 3)
    fit = fit_posture(human7, rows, oracle.frames(true)[0][list(rows)], REST)
    np.testing.assert_allclose(fit.posture[3:], REST[3:], rtol=0, atol=1e-6)
    assert fit.residual < 1e-3


def test_landmarks_out_of_reach_are_missed_by_what_is_too_far(human7: SerialChain) -> None:
    fit = fit_posture(human7, (7,), [[0.86, 0.0, 0.0]], np.full(7, 0.3))
    assert fit.residual == pytest.approx(0.2, abs=2e-3)


@pytest.mark.parametrize(
    ("rows", "landmarks", "near", "says"),
    [
        ((3, 7), [[0.0, 0.0, 0.0]], REST, r"need shape \(2, 3\)"),
        ((7,), [[0.0, np.nan, 0.0]], REST, "finite"),
        ((7,), [[0.0, 0.0]], REST, r"need shape \(1, 3\)"),
        ((), np.empty((0, 3)), REST, "need rows 0 to 7"),
        ((8,), [[0.0, 0.0, 0.0]], REST, "need rows 0 to 7"),
        ((-1,), [[0.0, 0.0, 0.0]], REST, "need rows 0 to 7"),
        ((7,), [[0.0, 0.0, 0.0]], REST[:6], "7 finite numbers"),
    ],
)
def test_bad_input(
    human7: SerialChain, rows: tuple, landmarks: list, near: list, says: str
) -> None:
    with pytest.raises(InputError, match=says):
        fit_posture(human7, rows, landmarks, near)
