"""With positive gains the loop converges; with negative ones it need not.

J G J^+ is similar to B^(-1/2) (J G J^T) B^(-1/2) with B = J J^T, so at full rank its eigenvalues
lie between the least and the greatest gain, and the hand's error shrinks in every direction while
lambda dt max(g) phi < 2. Limits are left out here: a joint that stands at one takes no part.
"""

import dataclasses

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.kinematics import SerialChain
from armsyn.motion.captures import load_captures
from armsyn.synergy import Controller, synergies
from armsyn.synergy.controller import ARM_RATES
from armsyn.synergy.learning import fit
from armsyn.synergy.models import parameter_bounds
from armsyn.synergy.options import LearningOptions
from armsyn.synergy.training import prepare
from tests.kinematics.oracle import Oracle, random_posture

DT = 0.01
LIMITED = load_arm("human7").chain


@pytest.fixture(scope="module")
def chain() -> SerialChain:
    """The human-like arm without limits."""
    free = tuple(dataclasses.replace(j, lower=-50.0, upper=50.0) for j in LIMITED.joints)
    return SerialChain(free, LIMITED.tip_xyz)


def far_from_singular(chain: SerialChain, rng: np.random.Generator) -> np.ndarray:
    """Return a posture within the arm's limits whose Jacobian is well of full rank."""
    oracle = Oracle(chain)
    while True:
        q = random_posture(LIMITED, rng)
        if np.linalg.svd(oracle.jacobian(q)[:3], compute_uv=False)[-1] > 0.1:
            return q


def test_eigenvalues_lie_between_the_least_and_the_greatest_gain(chain: SerialChain) -> None:
    rng, oracle = np.random.default_rng(1), Oracle(chain)
    spread = []
    for _ in range(500):
        J = oracle.jacobian(far_from_singular(chain, rng))[:3]
        gains = rng.uniform(0.25, 5.0, 7)
        eigenvalues = np.linalg.eigvals(J @ np.diag(gains) @ np.linalg.pinv(J))
        assert np.abs(eigenvalues.imag).max() < 1e-9
        assert eigenvalues.real.min() >= gains.min() - 1e-9
        assert eigenvalues.real.max() <= gains.max() + 1e-9
        spread.append(np.ptp(eigenvalues.real))
    assert np.median(spread) > 0.5  # the bound is not met for want of any difference


def test_motions_with_positive_gains_arrive(chain: SerialChain) -> None:
    """Any S_C within the bounds of arms, from anywhere to anywhere inside the workspace."""
    rng = np.random.default_rng(2)
    bounds = parameter_bounds("C", 7, stable=True)
    oracle = Oracle(chain)
    for _ in range(200):
        p = rng.uniform(*bounds)
        target = oracle.frames(far_from_singular(chain, rng))[0][-1]
        rolled = Controller(chain, "svd", ARM_RATES["svd"]).synthesize(
            far_from_singular(chain, rng),
            target,
            synergies("C", 7, p),
            dt=DT,
            frames=int((p[7] / p[8] + 12.0) / DT),  # 12 s after phi is one half
            tolerance=1e-3,
        )
        assert rolled.arrived, (p, target, rolled.distance)


def test_the_error_shrinks_no_slower_than_the_least_gain_allows(chain: SerialChain) -> None:
    """Near the target e' = -lambda J G J^+ e: in B's norm no slower than lambda min g."""
    rng, oracle = np.random.default_rng(3), Oracle(chain)
    for _ in range(50):
        q, gains = far_from_singular(chain, rng), rng.uniform(0.25, 5.0, 7)
        place, J = oracle.frames(q)[0][-1], oracle.jacobian(q)[:3]
        error = 1e-4 * rng.normal(size=3)
        rolled = Controller(chain, "svd", 1.0).synthesize(
            q, place + error, synergies("B", 7, gains), dt=1e-3, frames=501
        )
        left = place + error - rolled.positions[-1, -1]
        metric = np.linalg.inv(J @ J.T)
        shrunk = np.sqrt((left @ metric @ left) / (error @ metric @ error))
        assert np.exp(-0.5 * gains.max()) * 0.99 <= shrunk <= np.exp(-0.5 * gains.min()) * 1.01


@pytest.mark.parametrize(("gain", "converges"), [(1.0, True), (19.0, True), (21.0, False)])
def test_a_step_is_stable_while_lambda_dt_g_is_below_two(
    chain: SerialChain, gain: float, converges: bool
) -> None:
    q = far_from_singular(chain, np.random.default_rng(4))
    target = Oracle(chain).frames(q)[0][-1] + [1e-5, -1e-5, 2e-5]
    rolled = Controller(chain, "svd", 10.0).synthesize(
        q, target, synergies("A", 7, [gain]), dt=DT, frames=30
    )
    error = np.linalg.norm(rolled.positions[:, -1] - target, axis=1)
    factor = abs(1 - 10.0 * DT * gain)
    assert error[1] / error[0] == pytest.approx(factor, abs=0.01)
    assert (error[-1] < error[0]) == converges


def test_motions_with_negative_gains_may_leave(chain: SerialChain) -> None:
    rng, left = np.random.default_rng(5), 0
    lower, upper = parameter_bounds("C", 7, stable=False)
    for _ in range(50):
        start = far_from_singular(chain, rng)
        target = Oracle(chain).frames(far_from_singular(chain, rng))[0][-1]
        p = rng.uniform(lower, upper)
        p[7] = 0.0
        rolled = Controller(chain, "svd", 10.0).synthesize(
            start, target, synergies("C", 7, p), dt=DT, frames=600
        )
        began = np.linalg.norm(rolled.positions[0, -1] - target)
        left += rolled.distance > max(0.05, 0.5 * began)
    assert left > 25


@pytest.mark.parametrize("model", ["C", "D"])
@pytest.mark.usefixtures("captures")
def test_learned_motions_run_on_for_three_seconds_stay_at_their_target(model: str) -> None:
    """Captured reaches, each with its own positive gains, played beyond the capture's end."""
    arm, options = load_arm("hug_mp4"), LearningOptions(stable=True, budget=150)
    trainings = [prepare(arm, capture, 120.0) for capture in load_captures("hug_mp:S01")[:7]]
    fits = fit(arm, trainings, "svd", model, options)
    for training, parameters in zip(trainings, fits.parameters, strict=True):
        assert min(parameters[: arm.chain.dof]) >= 0.25
        rolled = Controller(arm.chain, "svd", options.rate_of("svd")).synthesize(
            training.start,
            training.target,
            synergies(model, arm.chain.dof, parameters),
            dt=1 / 120,
            frames=training.time.size + 360,
        )
        errors = np.linalg.norm(rolled.positions[-360:, -1] - training.target, axis=1)
        assert errors[-1] < 1e-3
        assert errors.argmax() < 120  # what is left when the capture ends only shrinks
