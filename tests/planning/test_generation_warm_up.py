"""What reaches need is compiled before work is spread, whatever the first of them need."""

import json
import subprocess
import sys

import pytest

from tests.cli.commands import PATIENCE

PROGRAM = """
import json, sys
import numpy as np
from numba.core.dispatcher import Dispatcher
from armsyn.arm import load_arm
from armsyn.planning.atlas import atlas_of
from armsyn.planning.generation.batch import Recipe, make_batch, warm_up
from armsyn.planning.generation.targets import ListedTargets

def compiled():
    rooms = [vars(room) for name, room in sys.modules.items() if name.startswith("armsyn.")]
    kernels = [(name, part) for room in rooms for name, part in room.items()]
    kernels = [(name, part) for name, part in kernels if isinstance(part, Dispatcher)]
    return {(name, str(one)) for name, kernel in kernels for one in kernel.signatures}

arm, rng = load_arm(sys.argv[1], calibrated=False), np.random.default_rng(0)
chain = arm.chain
goals = chain.positions(rng.uniform(chain.lower, chain.upper, (200, chain.dof)))[:, -1]
goals[::2] = chain.forward(arm.rest).tip + rng.uniform(-0.15, 0.15, (100, 3))
goals[0] = 9.0
recipe = Recipe(arm, atlas_of(arm).predictor("linear"), ListedTargets(goals), arm.rest, 200.0)
warm_up(recipe)
before = compiled()
batch = make_batch(recipe, 0, 200)
kinds = sorted({refusal.kind for refusal in batch.refused})
late = sorted(name for name, _ in compiled() - before)
swivels = bool(batch.swivels.any())
print(json.dumps([len(before) > 10, len(batch.changed) > 20, swivels, kinds, late]))
"""


@pytest.mark.parametrize("name", ["human7", "koch"])
def test_whatever_the_first_reach_is_nothing_is_left_to_compile(name: str) -> None:
    """The first is out of reach; among the others are all that there is."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, name],
        capture_output=True,
        text=True,
        check=True,
        timeout=PATIENCE,
    )
    known, changed, swivels, kinds, late = json.loads(done.stdout)
    assert known
    assert changed
    assert swivels
    assert {"collision", "unreachable"} <= set(kinds)
    assert late == []
