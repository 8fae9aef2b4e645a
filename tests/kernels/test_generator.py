"""Generated roll-outs against the plain kernels, and where the plain ones take over."""

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.ik import optimiser_settings
from armsyn.kernels import plain, rollout
from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.rollout import Captures, Synergies, Timing

RATES = {"svd": 6.0, "dls": 6.0, "jt": 20.0, "njt": 3.0}
AGREEMENT = 1e-10


def lanes_of(
    chain: ChainArrays, lanes: int, *, shared: bool, rng: np.random.Generator
) -> Synergies:
    n = chain.lower.size
    sigmoids = (lanes, 1 if shared else n)
    return Synergies(
        rng.uniform(0.25, 2, (lanes, n)), rng.uniform(1, 10, sigmoids), rng.uniform(0, 6, sigmoids)
    )


@pytest.mark.parametrize("shared", [True, False])
@pytest.mark.parametrize("name", ["svd", "jt", "njt", "dls"])
def test_paths_are_those_of_the_plain_kernel(name: str, shared: bool) -> None:
    chain = load_arm("human7").chain.arrays
    rng = np.random.default_rng(1)
    lanes, frames = 61, 60
    played = lanes_of(chain, lanes, shared=shared, rng=rng)
    starts = rng.uniform(chain.lower, chain.upper, (lanes, 7))
    targets = rng.uniform(-0.4, 0.4, (lanes, 3))
    paths = np.zeros((2, lanes, frames, 7))
    paths[:, :, 0] = starts
    timing = Timing(RATES[name], 0.01, 0.1, np.inf)  # gains are positive: other paths are chaotic
    given = (chain, optimiser_settings(name), played, timing, targets)
    rollout.roll_out_lanes(*given, paths[0])
    plain.plain_roll_out_lanes(*given, paths[1])
    np.testing.assert_allclose(paths[0], paths[1], rtol=0, atol=AGREEMENT)
