"""Synergies with what they leave: nearer to the examples than synergies alone."""

import numpy as np

from armsyn.planning.joined import learn_joined
from tests.planning.people import made_examples


def test_what_synergies_leave_is_learned_from_the_target() -> None:
    examples = made_examples()
    joined = learn_joined(examples, model="C", ridge=0.3)
    asked = examples.starts, examples.targets
    rolled, found = joined.synergy.predict(*asked), joined.predict(*asked)
    left, more = (np.abs(one.angles - examples.angles).mean() for one in (found, rolled))
    assert left < 0.6 * more
    assert found.reached.all()
    assert (found.angles[:, 0] == examples.starts).all()
    assert (found.durations == rolled.durations).all()
