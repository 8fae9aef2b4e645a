"""Shapes and tips of many postures, of any number of joints that turn or slide, as of one."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armsyn.kernels.chain import ChainArrays, positions_along
from armsyn.kernels.distance import BOX, CAPSULE, PLANE, ShapeArrays, clearances
from armsyn.kernels.placing import clearance_lanes, fill_tips

JOINTS, LANES = [1, 2, 5, 7, 8, 9, 17], 16


def chain_of(n: int) -> ChainArrays:
    """About a third of its joints slide."""
    rng, turns = np.random.default_rng(n), Rotation.random(n + 1, random_state=n).as_matrix()
    ends = np.full(n, 2.0)
    return ChainArrays(turns, rng.normal(0, 0.1, (n + 1, 3)), rng.random(n) < 0.3, -ends, ends)


def shapes_of(n: int) -> ShapeArrays:
    """A capsule on the base and on every joint, a plane and a box."""
    rng, count = np.random.default_rng(n), n + 1
    pairs = [(CAPSULE, i, j) for i in range(count) for j in range(i + 1, count)]
    pairs += [(kind, i, 0) for kind in (PLANE, BOX) for i in range(count)]
    return ShapeArrays(
        np.arange(-1, n),
        *rng.normal(0.0, 0.1, (2, count, 3)),
        rng.uniform(0.0, 0.03, count),
        np.array([[0.0, 0.0, 1.0, 0.2]]),
        Rotation.random(1, random_state=n).as_matrix(),
        np.array([[0.3, 0.1, 0.0]]),
        np.array([[0.1, 0.2, 0.05]]),
        np.array(pairs),
    )


@pytest.mark.parametrize("n", JOINTS)
def test_tips_are_where_those_of_one_posture_are(n: int) -> None:
    for frames in (1, 15, 16, 17, 40):
        path = np.random.default_rng(frames).uniform(-2.0, 2.0, (frames, n))
        tips = np.empty((3, frames))
        fill_tips(chain_of(n), path, tips)
        wanted = positions_along(chain_of(n), path)[:, -1]
        np.testing.assert_allclose(tips.T, wanted, rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("n", JOINTS)
def test_clearances_are_those_of_one_posture(n: int) -> None:
    chain, shapes = chain_of(n), shapes_of(n)
    for frames in (1, 7, 8, 9, LANES):
        path = np.random.default_rng(frames).uniform(-2.0, 2.0, (frames, n))
        found, wanted = (
            np.empty((len(shapes.pairs), LANES)),
            np.empty((frames, len(shapes.pairs))),
        )
        clearance_lanes(chain, shapes, path, found)
        clearances(chain, shapes, path, wanted)
        np.testing.assert_allclose(found[:, :frames].T, wanted, rtol=0.0, atol=1e-12)
