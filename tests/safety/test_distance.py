"""Distances of capsules, planes and boxes against closed forms, Coal and brute force."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from armsyn.arm.solids import Solids
from armsyn.kernels.distance import box_distance, segment_distance
from tests.kinematics.oracle import random_posture
from tests.safety.shaped import everything, oracle_clearances

Array = NDArray[np.float64]
ORIGIN, X, Y, Z = np.zeros(3), *np.eye(3)


@pytest.mark.parametrize(
    ("ends", "distance"),
    [
        ((ORIGIN, X, Z, X + Z), 1.0),  # parallel, side by side
        ((ORIGIN, X, 2 * X, 3 * X), 1.0),  # in one line
        ((ORIGIN, 2 * X, X, 3 * X), 0.0),  # in one line, overlapping
        ((ORIGIN, X, 3 * X + 4 * Y, 2 * X + 4 * Y), np.sqrt(17.0)),  # parallel, apart
        ((-X, X, 2 * Z - Y, 2 * Z + Y), 2.0),  # crossing
        ((-X, X, Y, 3 * Y), 1.0),  # a T
        ((ORIGIN, ORIGIN, X, X + Y), 1.0),  # a point and a segment
        ((X, X + Y, ORIGIN, ORIGIN), 1.0),
        ((X, X, Y, Y), np.sqrt(2.0)),  # two points
        ((X, X, X, X), 0.0),
        ((ORIGIN, X, 0.5 * X + Y, 0.5 * X + 3 * Y), 1.0),
    ],
)
def test_segments_by_closed_forms(ends: tuple[Array, ...], distance: float) -> None:
    p, q, u, v = ends
    for one in ((p, q), (q, p)):
        for other in ((u, v), (v, u)):
            assert segment_distance(*one, *other) == pytest.approx(distance, abs=1e-12)
            assert segment_distance(*other, *one) == pytest.approx(distance, abs=1e-12)


def test_nearly_parallel_segments() -> None:
    """The lines' nearest points lie far off or nowhere: by two nested scans of the segments."""
    rng = np.random.default_rng(1)
    shares = np.linspace(0.0, 1.0, 401)[:, None]
    for tilt in (1e-3, 1e-5, 1e-7, 1e-9, 0.0):
        p, along = rng.normal(size=3), rng.normal(size=3)
        q = p + along
        u = p + rng.uniform(-2.0, 2.0) * along + rng.normal(size=3)
        v = u + rng.uniform(0.2, 2.0) * along + tilt * rng.normal(size=3)
        points, others = p + shares * (q - p), u + shares * (v - u)
        scan = np.linalg.norm(points[:, None] - others[None], axis=2).min()
        assert segment_distance(p, q, u, v) == pytest.approx(scan, abs=2e-3)
        assert segment_distance(p, q, u, v) <= scan + 1e-12


def outside_or_depth(points: Array, half: Array) -> Array:
    """Signed distances of points, shape (m, 3), to a box about the origin, m."""
    beyond = np.abs(points) - half
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
    return outside + np.minimum(beyond.max(axis=1), 0.0)


coordinates = st.floats(-2.0, 2.0).map(lambda x: round(x, 3))
points = st.tuples(coordinates, coordinates, coordinates).map(np.array)


@given(points, points, st.tuples(*[st.floats(0.05, 1.5)] * 3).map(np.array))
def test_boxes_by_brute_force(start: Array, end: Array, half: Array) -> None:
    shares = np.linspace(0.0, 1.0, 2001)[:, None]
    scan = outside_or_depth(start + shares * (end - start), half).min()
    found = box_distance(start, end - start, half)
    step = np.linalg.norm(end - start) / 2000
    assert scan - step - 1e-9 <= found <= scan + 1e-9


def test_a_segment_through_a_box() -> None:
    half = np.array([0.1, 0.2, 0.3])
    assert box_distance(-X, 2 * X, half) == pytest.approx(-0.1)  # its middle is 0.1 from a face
    assert box_distance(0.15 * Y - X, 2 * X, half) == pytest.approx(-0.05)
    assert box_distance(-Z, 2 * Z, half) == pytest.approx(-0.1)
    assert box_distance(0.3 * Y - X, 2 * X, half) == pytest.approx(0.1)


def test_an_arm_against_pinocchio_and_coal() -> None:
    """Frames, placement, all kinds of pairs; also joints that are turned, oblique or slide."""
    arm = everything()
    solids = Solids(arm)
    assert {second for _, second in solids.names} >= {"wall", "block"}
    rng, compared = np.random.default_rng(7), 0
    for _ in range(200):
        q = random_posture(arm.chain, rng)
        expected = oracle_clearances(arm, q)
        found: dict[tuple[str, str], float] = {}
        for names, clearance in zip(solids.names, solids.clearances(q[None])[0], strict=True):
            found[names] = min(clearance, found.get(names, np.inf))
        for names, clearance in found.items():
            if expected[names] > 1e-3:
                assert clearance == pytest.approx(expected[names], abs=2e-6), names
                compared += 1
            else:
                assert clearance < 2e-3, names
    assert compared > 1000


def test_nothing_moves_further_than_reach_says() -> None:
    arm = everything()
    solids, rng = Solids(arm), np.random.default_rng(3)
    used = np.zeros(solids.reach.shape)
    for _ in range(2000):
        q = random_posture(arm.chain, rng)
        step = rng.normal(size=q.size) * rng.choice([0.0, 0.001, 0.1], size=q.size)
        step = np.clip(q + step, arm.chain.lower, arm.chain.upper) - q
        before, after = solids.clearances(np.array([q, q + step]))
        assert (np.abs(after - before) <= solids.reach @ np.abs(step) + 1e-12).all()
        alone = np.flatnonzero(step)
        if alone.size == 1:
            share = np.abs(after - before) / np.abs(step[alone[0]])
            used[:, alone[0]] = np.maximum(used[:, alone[0]], share)
    assert (used.max(axis=0) > 0.25 * solids.reach.max(axis=0)).all()  # and not much less far
