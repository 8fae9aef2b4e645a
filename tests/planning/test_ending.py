"""Motions carried over to other starts."""

from __future__ import annotations

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.kinematics import SerialChain
from armsyn.planning.ending import EASE, carried_to
from armsyn.planning.examples import PHASE
from armsyn.planning.postures import tips

FIRST = np.array([0.1, 0.2, -0.1, 0.6, 0.0, 0.1, 0.1])
LAST = np.array([-0.4, 0.7, 0.5, 1.2, -0.3, 0.4, -0.1])
BOW = np.array([0.10, -0.05, 0.12, 0.08, 0.0, 0.06, -0.04])


@pytest.fixture(scope="module")
def chain() -> SerialChain:
    return load_arm("human7", calibrated=False).chain


def minimum_jerk(first: np.ndarray, last: np.ndarray) -> np.ndarray:
    s = PHASE[:, None]
    return np.asarray(first + (10 * s**3 - 15 * s**4 + 6 * s**5) * (last - first))


def bowed() -> np.ndarray:
    return minimum_jerk(FIRST, LAST) + BOW * np.sin(np.pi * PHASE)[:, None] ** 2


def carried(chain: SerialChain, start: np.ndarray, target: np.ndarray) -> np.ndarray:
    angles, errors = carried_to(chain, bowed()[None], start[None], target[None])
    assert errors[0] <= 1e-3
    np.testing.assert_array_equal(angles[0, 0], start)
    return angles[0]


def test_from_its_own_start_to_its_own_end_a_motion_stays(chain: SerialChain) -> None:
    found = carried(chain, FIRST, tips(chain, LAST[None])[0])
    np.testing.assert_allclose(found, bowed(), atol=1e-12)


def test_the_way_back_is_minimum_jerk(chain: SerialChain) -> None:
    found = carried(chain, LAST, tips(chain, FIRST[None])[0])
    np.testing.assert_allclose(found, minimum_jerk(LAST, found[-1]), atol=1e-12)


@pytest.mark.parametrize("gone", [0.1, 0.4, 0.8])
def test_the_deviation_goes_with_the_part_of_the_way_that_is_left(
    chain: SerialChain, gone: float
) -> None:
    """Started somewhere on the way, the hand has less of it to go."""
    start = FIRST + gone * (LAST - FIRST)
    found = carried(chain, start, tips(chain, LAST[None])[0])
    first, here, last = tips(chain, np.array([FIRST, start, LAST]))
    length, left = np.linalg.norm(last - first), np.linalg.norm(last - here)
    cosine = (last - first) @ (last - here) / (length * left)
    share = left / length * cosine**3
    assert 0.0 < share < 1.0
    assert 0.5 < cosine < 1.0
    deviation = found - minimum_jerk(start, LAST)
    np.testing.assert_allclose(deviation, share * (bowed() - minimum_jerk(FIRST, LAST)), atol=1e-9)


def test_a_longer_way_has_no_more_of_it(chain: SerialChain) -> None:
    start = FIRST - 0.3 * (LAST - FIRST)
    found = carried(chain, start, tips(chain, LAST[None])[0])
    first, here, last = tips(chain, np.array([FIRST, start, LAST]))
    ways = last - first, last - here
    cosine = ways[0] @ ways[1] / np.linalg.norm(ways[0]) / np.linalg.norm(ways[1])
    assert np.linalg.norm(ways[1]) * cosine > np.linalg.norm(ways[0])
    deviation = found - minimum_jerk(start, LAST)
    wanted = cosine**2 * (bowed() - minimum_jerk(FIRST, LAST))
    np.testing.assert_allclose(deviation, wanted, atol=1e-9)


def test_a_hand_that_is_there_stays(chain: SerialChain) -> None:
    found = carried(chain, LAST, tips(chain, LAST[None])[0])
    np.testing.assert_allclose(found, np.repeat(LAST[None], len(EASE), axis=0), atol=1e-12)
