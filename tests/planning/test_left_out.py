"""Reaches to targets left out, on real captures: what predicts them better."""

from pathlib import Path

import numpy as np
import pytest

from armsyn.planning.examples import FloatArray, examples_of_people
from armsyn.planning.predictor import learn_predictor


@pytest.mark.parametrize("subject", ["S01", "S03"])
def test_latent_predictions_of_a_target_left_out_beat_linear_ones(
    captures: Path, subject: str
) -> None:
    assert captures
    examples = examples_of_people(subject, "segment")
    chain, places = examples.chain, np.array(examples.places)

    def joints(angles: FloatArray) -> FloatArray:
        return np.asarray(chain.positions(angles.reshape(-1, chain.dof)))

    found = {}
    for kind in ("minjerk", "linear", "latent"):
        apart, late = [], []
        for place in sorted(set(examples.places)):
            out = examples.only(places == place)
            predictor = learn_predictor(kind, examples.only(places != place))
            predicted = predictor.predict(out.starts, out.targets)
            assert predicted.reached.all()
            apart.append(np.linalg.norm(joints(predicted.angles) - joints(out.angles), axis=2))
            late.append(predicted.durations - out.durations)
        found[kind] = np.concatenate(apart).mean(), np.square(np.concatenate(late)).mean()
    assert found["latent"][0] < 0.95 * found["linear"][0]
    assert found["linear"][0] < 0.7 * found["minjerk"][0]
    assert found["latent"][1] < 0.75 * examples.durations.var()
