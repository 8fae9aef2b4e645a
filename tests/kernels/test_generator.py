"""Generated roll-outs against the plain kernels, and where the plain ones take over."""

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.ik import optimiser_settings
from armsyn.kernels import lanes as room
from armsyn.kernels import residuals, rollout
from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.generator import Plan, generate
from armsyn.kernels.plain import Captures, Synergies, Task, Timing, roll_out
from armsyn.kinematics import Joint, SerialChain

RATES = {"svd": 6.0, "dls": 6.0, "jt": 20.0, "njt": 3.0}
AGREEMENT = 1e-10
CRANE = SerialChain(
    (
        Joint("slew", axis=(0.1, 0.2, 1.0), lower=-9.0, upper=9.0),
        Joint("boom", xyz=(0.1, 0.0, 0.3), rpy=(0.3, 0.2, 0.1), axis=(0.0, 1.0, 0.0)),
        Joint("trolley", "prismatic", (0.2, 0.0, 0.1), axis=(1.0, 0.0, 0.2), lower=0.0, upper=0.6),
    ),
    tip_xyz=(0.2, 0.1, -0.3),
)


KNOWN_OPERATIONS = {"*": 366, "+": 299}
"""Of another generated step for a human-like arm of seven joints, sines and cosines included."""


@pytest.fixture(scope="module")
def human7() -> ChainArrays:
    return load_arm("human7").chain.arrays


def some_synergies(
    chain: ChainArrays, lanes: int, rng: np.random.Generator, *, shared: bool
) -> Synergies:
    """Gains are positive: with negative ones a path is chaotic, and rounding grows without end."""
    n = chain.lower.size
    sigmoids = (lanes, 1 if shared else n)
    return Synergies(
        rng.uniform(0.25, 2, (lanes, n)), rng.uniform(1, 10, sigmoids), rng.uniform(0, 6, sigmoids)
    )


def plainly(
    chain: ChainArrays,
    name: str,
    synergies: Synergies,
    timing: Timing,
    starts: np.ndarray,
    targets: np.ndarray,
    frames: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Return paths, and positions of joints and tip, of every lane by the plain kernel."""
    lanes, n = starts.shape
    paths, positions = np.zeros((lanes, frames, n)), np.zeros((lanes, frames, n + 1, 3))
    paths[:, 0] = starts
    for lane in range(lanes):
        roll_out(
            chain,
            optimiser_settings(name),
            *(part[lane] for part in synergies),
            timing,
            Task(targets[lane], np.empty((0, 0))),
            -1.0,
            paths[lane],
            positions[lane],
        )
    return paths, positions


def both_paths(
    chain: ChainArrays,
    name: str,
    synergies: Synergies,
    timing: Timing,
    starts: np.ndarray,
    targets: np.ndarray,
    frames: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the paths of generated code, with the plain kernel behind it, and of that alone."""
    expected, _ = plainly(chain, name, synergies, timing, starts, targets, frames)
    paths = np.zeros_like(expected)
    paths[:, 0] = starts
    rollout.roll_out_lanes(chain, optimiser_settings(name), synergies, timing, targets, paths)
    return paths, expected


@pytest.fixture
def doubted(monkeypatch: pytest.MonkeyPatch) -> list[np.ndarray]:
    """Which lanes the generated code left to the plain kernels, call by call."""
    seen: list[np.ndarray] = []

    def noting(*given: object) -> room.Played:
        played = room.play_lanes(*given)  # type: ignore[arg-type]
        seen.append(played.doubtful)
        return played

    monkeypatch.setattr(rollout, "play_lanes", noting)
    return seen


@pytest.mark.parametrize(
    ("name", "shared"),
    [("svd", True), ("svd", False), ("jt", True), ("njt", False), ("dls", True)],
)
def test_paths_are_those_of_the_plain_kernel(
    name: str, shared: bool, human7: ChainArrays, doubted: list[np.ndarray]
) -> None:
    rng = np.random.default_rng(1)
    synergies = some_synergies(human7, 61, rng, shared=shared)
    starts = rng.uniform(human7.lower, human7.upper, (61, 7))
    targets = rng.uniform(-0.35, 0.35, (61, 3))
    timing = Timing(RATES[name], 0.01, 0.1, np.inf)
    found, expected = both_paths(human7, name, synergies, timing, starts, targets, 80)
    np.testing.assert_allclose(found, expected, rtol=0, atol=AGREEMENT)
    assert doubted[0].mean() < 0.2
    at_a_limit = (found <= human7.lower) | (found >= human7.upper)
    assert at_a_limit[:, 1:].any(axis=(1, 2)).sum() > 5


@pytest.mark.parametrize("limit_rate", [5.0, np.inf])
def test_sliding_endless_and_oblique_joints(limit_rate: float, doubted: list[np.ndarray]) -> None:
    chain, rng = CRANE.arrays, np.random.default_rng(2)
    synergies = some_synergies(chain, 30, rng, shared=True)
    starts = rng.uniform(chain.lower, chain.upper, (30, 3))
    targets = rng.uniform(-0.6, 0.6, (30, 3))
    timing = Timing(6.0, 0.01, 0.0, limit_rate)
    found, expected = both_paths(chain, "dls", synergies, timing, starts, targets, 80)
    np.testing.assert_allclose(found, expected, rtol=0, atol=AGREEMENT)
    assert not doubted[0].any()
    assert np.ptp(found[:, :, 2], axis=1).max() > 0.05


@pytest.mark.parametrize("elbow", [1e-1, 1e-2, 3e-3, 1e-3, 1e-4, 1e-6, 0.0])
def test_next_to_a_singular_posture_one_step_is_the_plain_kernels(
    elbow: float, human7: ChainArrays, doubted: list[np.ndarray]
) -> None:
    """The arm stretched out but for the elbow; the target asks it to shorten."""
    rng = np.random.default_rng(3)
    starts = np.tile([0.4, 0.2, 0.1, elbow, 0.1, 0.0, 0.0], (16, 1))
    synergies = some_synergies(human7, 16, rng, shared=True)
    targets = rng.uniform(-0.3, 0.3, (16, 3))
    found, expected = both_paths(
        human7, "svd", synergies, Timing(6.0, 1e-3, 0.0, np.inf), starts, targets, 2
    )
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=AGREEMENT)
    assert doubted[0].all() == (elbow <= 3e-3)


def test_what_generated_code_cannot_carry_is_left_to_the_plain_kernel(
    human7: ChainArrays, doubted: list[np.ndarray]
) -> None:
    """Sigmoids that overflow, and starts beyond the joints' ranges; their neighbours go on."""
    starts = np.tile([0.1, 0.4, 0.6, 0.6, 0.0, 0.1, 0.0], (5, 1))
    starts[4, 3] = 3.5
    slopes = np.array([[8.0], [900.0], [-900.0], [0.0], [8.0]])
    offsets = np.array([[4.0], [710.0], [-800.0], [-np.inf], [4.0]])
    synergies = Synergies(np.ones((5, 7)), slopes, offsets)
    targets = np.tile([0.35, -0.1, -0.15], (5, 1))
    timing = Timing(6.0, 0.01, 0.0, np.inf)
    found, expected = both_paths(human7, "svd", synergies, timing, starts, targets, 90)
    np.testing.assert_allclose(found, expected, rtol=0, atol=AGREEMENT)
    assert doubted[0].tolist() == [False, True, True, False, True]


def test_distances_and_residuals_are_those_of_the_plain_kernel(human7: ChainArrays) -> None:
    """Motions of 50, 31 and 1 frames; lane 5 must be played plainly, for its sigmoid overflows."""
    rng = np.random.default_rng(4)
    captures = Captures(
        rng.uniform(-0.3, 0.3, (3, 50, 3, 3)),
        np.array([50, 31, 1]),
        np.array([0, 3, 7]),
        rng.uniform(human7.lower, human7.upper, (3, 7)),
        rng.uniform(-0.3, 0.3, (3, 3)),
    )
    which = rng.permutation(np.repeat([0, 1, 2], [9, 16, 4]))
    synergies = some_synergies(human7, which.size, rng, shared=True)
    synergies.offsets[5], synergies.slopes[5] = 710.0, 2000.0
    timing = Timing(6.0, 0.01, 0.0, np.inf)
    starts, targets = captures.starts[which], captures.targets[which]
    _, positions = plainly(human7, "svd", synergies, timing, starts, targets, 50)
    gaps = positions[:, :, captures.rows] - captures.landmarks[which]
    norms = np.linalg.norm(gaps, axis=3).mean(axis=2)
    expected = [norms[lane, : captures.frames[row]].mean() for lane, row in enumerate(which)]
    given = (human7, optimiser_settings("svd"), synergies, timing, captures)
    distances = np.empty(which.size)
    rollout.distance_lanes(*given, which, distances)
    np.testing.assert_allclose(distances, expected, rtol=0, atol=AGREEMENT)
    residual = np.empty((which.size, 31, 3, 3))
    residuals.residual_lanes(*given, 1, residual)
    ours = which == 1
    np.testing.assert_allclose(residual[ours], gaps[ours, :31], rtol=0, atol=AGREEMENT)


def test_no_lane_depends_on_its_company_or_on_threads(
    human7: ChainArrays, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(5)
    synergies = some_synergies(human7, 50, rng, shared=True)
    paths = np.zeros((50, 40, 7))
    paths[:, 0] = rng.uniform(human7.lower, human7.upper, (50, 7))
    targets = rng.uniform(-0.3, 0.3, (50, 3))
    given = (human7, optimiser_settings("jt"))
    timing = Timing(20.0, 0.01, 0.0, np.inf)
    threaded, alone = paths.copy(), paths[17:18].copy()
    rollout.roll_out_lanes(*given, synergies, timing, targets, paths)
    monkeypatch.setattr(room, "_LEAST_SHARE", 1)
    rollout.roll_out_lanes(*given, synergies, timing, targets, threaded)
    np.testing.assert_array_equal(threaded, paths)
    one = Synergies(*(part[17:18] for part in synergies))
    rollout.roll_out_lanes(*given, one, timing, targets[17:18], alone)
    np.testing.assert_array_equal(alone[0], paths[17])


def test_no_lanes_are_no_work(human7: ChainArrays) -> None:
    none = Synergies(np.empty((0, 7)), np.empty((0, 1)), np.empty((0, 1)))
    timing = Timing(6.0, 0.01, 0.0, np.inf)
    empty = np.empty((0, 5, 7))
    rollout.roll_out_lanes(human7, optimiser_settings("svd"), none, timing, np.empty((0, 3)), empty)


@pytest.mark.parametrize("greatest", [0.3, 1.5, 2.6, np.pi, 9.0])
def test_sines_are_right_over_the_whole_range_of_a_joint(greatest: float) -> None:
    """A joint of one metre: its hand moves on the circle. Whole turns come off without loss."""
    chain = SerialChain((Joint("one", lower=-greatest, upper=greatest),), tip_xyz=(1.0, 0.0, 0.0))
    angles = np.linspace(-greatest, greatest, 201)
    captures = Captures(
        np.zeros((201, 1, 1, 3)),
        np.ones(201, int),
        np.array([1]),
        angles[:, None],
        np.ones((201, 3)),
    )
    idle = Synergies(np.zeros((1, 1)), np.zeros((1, 1)), np.full((1, 1), -np.inf))
    hands = np.empty((201, 3))
    timing = Timing(1.0, 0.01, 0.0, np.inf)
    for row in range(201):
        gap = np.empty((1, 1, 1, 3))
        settings = optimiser_settings("jt")
        residuals.residual_lanes(chain.arrays, settings, idle, timing, captures, row, gap)
        hands[row] = gap[0, 0, 0]
    circle = np.stack([np.cos(angles), np.sin(angles), np.zeros(201)], axis=1)
    np.testing.assert_allclose(hands, circle, rtol=0, atol=1e-14)


def test_a_step_takes_no_more_arithmetic_than_is_known_to_do(human7: ChainArrays) -> None:
    counted = generate(Plan(human7, optimiser_settings("svd"), True, False, "paths", ())).operations
    assert counted["*"] <= KNOWN_OPERATIONS["*"]
    assert counted["+"] <= KNOWN_OPERATIONS["+"]
    assert counted["/"] == 1
