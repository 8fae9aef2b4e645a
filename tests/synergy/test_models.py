"""The four models against the formulas of the paper's section 4."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.errors import InputError
from armsyn.kernels.rollout import Synergies
from armsyn.synergy import MODELS, parameter_names, synergies
from armsyn.synergy.models import GAINS, OFFSETS, SLOPES, STABLE_GAIN, parameter_bounds
from tests.synergy.plain import Sigmoids

JOINTS = ("shoulder", "elbow", "wrist")


def count(model: str, dof: int) -> int:
    return {"A": 1, "B": dof, "C": dof + 2, "D": 3 * dof}[model]


def phi(synergy: Synergies, t: float) -> np.ndarray:
    """Return what the kernels make of slopes and offsets."""
    return 1.0 / (1.0 + np.exp(synergy.offsets[0] - synergy.slopes[0] * t))


@pytest.mark.parametrize("dof", [1, 3, 7])
@pytest.mark.parametrize("model", MODELS)
def test_counts_names_and_bounds_agree(model: str, dof: int) -> None:
    names = parameter_names(model, tuple(f"joint{i}" for i in range(dof)))
    assert len(names) == len(set(names)) == count(model, dof)
    for stable, least in ((False, -5.0), (True, 0.1 if model == "A" else 0.25)):
        lower, upper = parameter_bounds(model, dof, stable=stable)
        assert lower.shape == upper.shape == (len(names),)
        for name, low, high in zip(names, lower, upper, strict=True):
            paper = {"gain": (least, 5), "offset": (0, 20), "slope": (1, 10)}
            assert (low, high) == paper[name.split(":")[0]]


def test_names_say_joint_and_kind() -> None:
    assert parameter_names("A", JOINTS) == ("gain",)
    assert parameter_names("C", JOINTS)[2:] == ("gain:wrist", "offset", "slope")
    assert parameter_names("D", JOINTS)[3:5] == ("offset:shoulder", "offset:elbow")
    assert parameter_names("D", JOINTS)[-1] == "slope:wrist"


def test_the_papers_bounds() -> None:
    assert (GAINS, OFFSETS, SLOPES) == ((-5, 5), (0, 20), (1, 10))
    assert STABLE_GAIN > 0


@pytest.mark.parametrize("model", MODELS)
@given(seed=st.integers(0, 10_000), dof=st.integers(1, 8), t=st.floats(0, 5))
def test_gains_and_sigmoids_are_the_papers(model: str, seed: int, dof: int, t: float) -> None:
    lower, upper = parameter_bounds(model, dof, stable=False)
    vector = np.random.default_rng(seed).uniform(lower, upper)
    synergy, plain = synergies(model, dof, vector), Sigmoids(model, dof, vector)
    np.testing.assert_array_equal(np.diag(synergy.gains[0]), plain.gains)
    np.testing.assert_allclose(
        np.broadcast_to(phi(synergy, t), (dof,)), plain.phi(t), rtol=0, atol=1e-14
    )


def test_phi_is_half_at_offset_over_slope_and_one_without_sigmoid() -> None:
    assert phi(synergies("C", 3, [1, 1, 1, 6.0, 4.0]), 1.5) == pytest.approx([0.5])
    own = synergies("D", 2, [1, 1, 3.0, 8.0, 2.0, 10.0])
    assert phi(own, 1.5)[0] == pytest.approx(0.5)
    assert phi(own, 0.8)[1] == pytest.approx(0.5)
    for model, vector in (("A", [2.0]), ("B", [1.0, -3.0])):
        assert [phi(synergies(model, 2, vector), t).item() for t in (0.0, 0.1, 9.0)] == [1.0] * 3


def test_lanes_are_rows() -> None:
    vectors = np.random.default_rng(1).uniform(1, 5, (4, 21))
    together = synergies("D", 7, vectors)
    for lane, vector in enumerate(vectors):
        alone = synergies("D", 7, vector)
        for part, own in zip(together, alone, strict=True):
            np.testing.assert_array_equal(part[lane], own[0])


@pytest.mark.parametrize(
    ("model", "vector", "said"),
    [
        ("E", [1.0], "no synergy model 'E'; known: A, B, C, D"),
        ("C", [1.0] * 4, "model C of 3 joints has 5 finite parameters, got 4"),
        ("A", [np.nan], "finite"),
        ("B", [1.0, np.inf, 0.0], "finite"),
        ("A", np.zeros((1, 1, 1)), "finite"),
    ],
)
def test_bad_vectors_are_refused(model: str, vector: list[float], said: str) -> None:
    with pytest.raises(InputError, match=said):
        synergies(model, 3, vector)
    if model == "E":
        with pytest.raises(InputError, match=said):
            parameter_bounds(model, 3, stable=True)
