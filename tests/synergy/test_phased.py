"""Synergies over normalised time: they play as the controller does, and every one converges."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.arm import load_arm
from armsyn.errors import InputError
from armsyn.kernels.rollout import Synergies
from armsyn.synergy.controller import LIMIT_RATE, RAMP_S, Controller
from armsyn.synergy.models import GAINS, STABLE_GAIN
from armsyn.synergy.phased import PhasedSynergies

ARM = load_arm("human7", calibrated=False)
SHARES = st.lists(st.floats(-0.5, 1.5), min_size=21, max_size=21)
TARGET = np.array([0.4, -0.15, -0.05])


def coordinates(family: PhasedSynergies, shares: list[float]) -> np.ndarray:
    part = np.array(shares)[: family.lower.size]
    return np.asarray((family.lower + (family.upper - family.lower) * part)[None])


def test_they_play_what_the_controller_plays() -> None:
    family = PhasedSynergies(ARM.chain, "D", 1.2)
    at = coordinates(family, [0.3, 0.6, 0.5] * 7)
    played = family.play(at, ARM.rest[None], TARGET[None], 101)[0]
    synergy = family.synergies(at)
    rolled = Controller(ARM.chain, "svd", family.lambda_).synthesize(
        ARM.rest,
        TARGET,
        synergy,
        dt=1.2 / 200,
        frames=201,
        ramp=RAMP_S,
        limit_rate=LIMIT_RATE,
    )
    assert np.abs(played - rolled.angles[::2]).max() < 1e-6


@given(SHARES)
def test_parameters_stay_within_bounds_whatever_is_asked(shares: list[float]) -> None:
    family = PhasedSynergies(ARM.chain, "D", 0.9)
    gains, slopes, offsets = family.synergies(coordinates(family, shares))
    assert (gains >= STABLE_GAIN).all()
    assert (gains <= GAINS[1]).all()
    assert (offsets / slopes < 0.9).all()
    assert (slopes > 0).all()


@given(SHARES, st.integers(0, 1000))
def test_one_step_contracts_as_the_bound_says(shares: list[float], seed: int) -> None:
    """J G J^+ has its eigenvalues between the least and the greatest gain (performance.md)."""
    family = PhasedSynergies(ARM.chain, "C", 1.0)
    gains = family.synergies(coordinates(family, shares)).gains[0]
    draw = np.random.default_rng(seed)
    J = ARM.chain.jacobian(draw.uniform(ARM.chain.lower, ARM.chain.upper))
    if np.linalg.cond(J) > 1e4:
        return
    values = np.linalg.eigvals(J @ np.diag(gains) @ np.linalg.pinv(J))
    assert np.abs(values.imag).max() < 1e-6
    assert values.real.min() > gains.min() - 1e-6
    assert values.real.max() < gains.max() + 1e-6
    step = family.lambda_ * family.duration / 200
    assert np.abs(1.0 - step * values.real).max() < 1.0


@pytest.mark.parametrize("model", ["C", "D"])
def test_every_roll_out_comes_to_its_target(model: str) -> None:
    family = PhasedSynergies(ARM.chain, model, 1.0)
    draw = np.random.default_rng(7)
    at = family.lower + (family.upper - family.lower) * draw.random((200, family.lower.size))
    gains, slopes, offsets = family.synergies(at)
    controller = Controller(ARM.chain, "svd", family.lambda_)
    for lane in range(200):
        one = Synergies(*(part[lane : lane + 1] for part in (gains, slopes, offsets)))
        found = controller.synthesize(ARM.rest, TARGET, one, dt=0.005, frames=1000, tolerance=1e-3)
        assert found.arrived


def test_a_model_without_a_sigmoid_is_refused() -> None:
    with pytest.raises(InputError, match="model C or D"):
        PhasedSynergies(ARM.chain, "A", 1.0)
    with pytest.raises(InputError, match="positive"):
        PhasedSynergies(ARM.chain, "C", 0.0)
