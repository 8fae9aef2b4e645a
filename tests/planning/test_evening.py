"""Motions brought nearer to minimum jerk by as little as makes a bell of them."""

from __future__ import annotations

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.planning.evening import EVENINGS, WHOLLY, Evening, evened, nearer
from armsyn.planning.examples import PHASE
from armsyn.planning.finishing import finished
from armsyn.planning.posing import HandTask

START, WAY = np.array([0.2, -0.4]), np.array([0.9, 0.3])
AMPLITUDES = np.array([0.2, -0.1])


def plain() -> np.ndarray:
    s = PHASE[:, None]
    return np.asarray(START + (10 * s**3 - 15 * s**4 + 6 * s**5) * WAY)


def wave(k: int) -> np.ndarray:
    return np.asarray(AMPLITUDES * np.sin(k * np.pi * PHASE)[:, None])


@pytest.mark.parametrize("k", [1, 2, 3, 7])
@pytest.mark.parametrize("smoothing", [0.01, 0.09])
def test_half_waves_are_damped_as_by_diffusion(k: int, smoothing: float) -> None:
    how = Evening(smoothing, 0.0)
    left = np.exp(-smoothing * (k**2 - 1))
    motion = plain() + wave(k)
    np.testing.assert_allclose(evened(motion, how), plain() + left * wave(k), atol=1e-12)
    assert nearer(motion, how) == pytest.approx(1.0 - left, abs=1e-12)


def test_a_share_is_taken_of_all_of_it() -> None:
    motion, how = plain() + wave(1) + wave(5), Evening(0.0, 0.4)
    wanted = plain() + 0.6 * (wave(1) + wave(5))
    np.testing.assert_allclose(evened(motion, how), wanted, atol=1e-12)
    assert nearer(motion, how) == 0.4
    np.testing.assert_allclose(evened(motion, WHOLLY), plain(), atol=1e-12)


@pytest.mark.parametrize("how", EVENINGS)
def test_many_are_evened_each_as_alone_and_ends_stay(how: Evening) -> None:
    rng = np.random.default_rng(1)
    motions = plain() + rng.normal(0.0, 0.1, (4, len(PHASE), 2))
    together, amounts = evened(motions, how), nearer(motions, how)
    for motion, one, amount in zip(motions, together, amounts, strict=True):
        np.testing.assert_allclose(evened(motion, how), one, atol=1e-12)
        np.testing.assert_allclose(one[[0, -1]], motion[[0, -1]], rtol=0.0, atol=1e-15)
        assert nearer(motion, how) == pytest.approx(amount, abs=1e-12)
        assert 0.0 < amount <= 1.0


@pytest.mark.parametrize("how", EVENINGS)
def test_minimum_jerk_stays(how: Evening) -> None:
    np.testing.assert_allclose(evened(plain(), how), plain(), atol=1e-12)


def test_a_hand_that_hesitates_is_smoothed_and_its_bow_stays() -> None:
    """Of a motion that bows and hesitates only the hesitation goes."""
    arm = load_arm("human7", calibrated=False)
    end = np.array([-0.642, 0.752, 0.972, 1.339, -0.453, 1.073, -0.196])
    s = PHASE[:, None]
    bow = np.array([0.15, -0.1, 0.1, 0.1, 0.0, 0.0, 0.0]) * np.sin(np.pi * s)
    bell = arm.rest + (10 * s**3 - 15 * s**4 + 6 * s**5) * (end - arm.rest)
    bowed = bell + bow * s**2 * (1 - s) ** 2 * 16
    hesitates = bowed + 0.025 * (end - arm.rest) * np.sin(6 * np.pi * s)
    task = HandTask(arm.chain.forward(end).tip)
    assert finished(arm, bowed, 1.2, task, 200.0).evened == 0.0
    done = finished(arm, hesitates, 1.2, task, 200.0)
    assert 0.0 < done.evened < 0.5
    hands = [arm.chain.positions(motion)[:, -1] for motion in (done.angles, bowed)]
    furthest = max(np.linalg.norm(hands[1] - point, axis=1).min() for point in hands[0])
    assert furthest < 0.01
