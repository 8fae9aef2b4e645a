"""Reaches at few frames a second: those of a finer one, within the limits between frames, too."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from armsyn.arm import load_arm
from armsyn.planning.generation.batch import Recipe, make_batch
from armsyn.planning.generation.targets import RandomTargets
from armsyn.planning.minimum_jerk import MinimumJerkPredictor
from armsyn.planning.pacing import LEAST_HZ, thinned, thinning

ASKED = 40


def recipe(rate_hz: float) -> Recipe:
    arm = load_arm("widowx_250s", calibrated=False)
    targets = RandomTargets(ASKED, 5, [0.2, -0.3, 0.1], [0.5, 0.3, 0.4])
    return Recipe(arm, MinimumJerkPredictor(arm.chain), targets, arm.rest, rate_hz)


@pytest.mark.parametrize(
    ("rate_hz", "step"), [(10.0, 20), (62.5, 4), (100.0, 2), (199.0, 2), (200.0, 1), (1000.0, 1)]
)
def test_what_is_planned_has_at_least_the_rate_that_limits_are_held_at(
    rate_hz: float, step: int
) -> None:
    assert thinning(rate_hz) == step
    assert step * rate_hz >= LEAST_HZ


@pytest.mark.parametrize(("frames", "kept"), [(1, [0]), (4, [0, 3]), (5, [0, 3, 4]), (2, [0, 1])])
def test_the_end_is_kept(frames: int, kept: list[int]) -> None:
    path = np.arange(frames, dtype=float)[:, None]
    assert thinned(path, 3)[:, 0].tolist() == kept
    assert thinned(path, 1) is path


@pytest.mark.parametrize("rate_hz", [10.0, 50.0])
def test_few_frames_are_every_so_manieth_of_a_finer_reach(rate_hz: float) -> None:
    fine, coarse = make_batch(recipe(200.0), 0, ASKED), make_batch(recipe(rate_hz), 0, ASKED)
    step = round(200.0 / rate_hz)
    assert coarse.index.tolist() == fine.index.tolist()
    assert coarse.index.size > 30
    np.testing.assert_array_equal(coarse.hands, fine.hands)
    for row in range(coarse.index.size):
        path, wanted = coarse.paced.path(row), fine.paced.path(row)
        assert len(path) == -(-(len(wanted) - 1) // step) + 1
        np.testing.assert_array_equal(path[:-1], wanted[::step][: len(path) - 1])
        np.testing.assert_array_equal(path[-1], wanted[-1])


@pytest.mark.parametrize("rate_hz", [10.0, 50.0])
def test_a_spline_through_few_frames_keeps_speed_and_acceleration(rate_hz: float) -> None:
    asked = recipe(rate_hz)
    paced = make_batch(asked, 0, ASKED).paced
    for row in range(len(paced.scales)):
        path = paced.path(row)
        rested = np.concatenate([path[:1], path[:1], path, path[-1:], path[-1:]])
        spline = CubicSpline(np.arange(len(rested)) / rate_hz, rested, bc_type="clamped")
        time = np.linspace(0.0, (len(rested) - 1) / rate_hz, 2000)
        assert (np.abs(spline(time, 1)) <= asked.arm.max_velocity).all()
        assert (np.abs(spline(time, 2)) <= asked.arm.max_acceleration).all()
