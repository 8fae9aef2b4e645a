"""What an arm gets of predicted reaches, and how far that is from people's."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.errors import RefusedMotionError
from armsyn.experiments.anytarget_driven import SAME_RAD, driven_table, over_phase, way_of
from armsyn.experiments.anytarget_people import People, load_garza
from armsyn.experiments.anytarget_rows import ROWS
from armsyn.experiments.anytarget_run import Group, Outcome, predict_all
from armsyn.kinematics import SerialChain
from armsyn.planning.finishing import finished
from armsyn.planning.minimum_jerk import MinimumJerkPredictor
from armsyn.planning.motion_planner import MotionPlanner
from armsyn.planning.posing import HandTask
from armsyn.planning.prediction import Predicted
from tests.experiments.conftest import silent

BY_KEY = {row.key: row for row in ROWS}


@pytest.fixture(scope="module")
def people(captures: Path) -> People:
    del captures
    return load_garza(10)


@pytest.fixture(scope="module")
def latent(people: People) -> Outcome:
    return predict_all([Group(people, "target")], [BY_KEY["latent"]], 1, silent)[0]["latent"]


def test_every_reach_is_counted_once_and_the_driven_ones_are_the_mean_of_theirs(
    latent: Outcome,
) -> None:
    rows = {row["what"]: row for row in driven_table(latent, "human7", 1, silent).as_dict()["rows"]}
    driven = rows.pop("all that are driven")
    refused = rows["refused"]["reaches"]
    assert sum(row["reaches"] for row in rows.values()) == 10
    assert driven["reaches"] == 10 - refused
    for key in ("held_m", "held_driven_m", "held_driven_time_given_m"):
        parts = [
            row["reaches"] * row[key]
            for what, row in rows.items()
            if what != "refused" and row["reaches"]
        ]
        assert driven[key] == pytest.approx(sum(parts) / driven["reaches"])
    assert driven["time_scale"] >= 1.0
    assert rows["refused"]["held_driven_m"] is None


@dataclasses.dataclass(frozen=True)
class Says:
    """Predicts what it was told, whatever is asked."""

    chain: SerialChain
    told: Predicted
    name = "told"

    def predict(self, starts: np.ndarray, targets: np.ndarray) -> Predicted:
        del starts, targets
        return self.told


def test_the_table_counts_what_the_planner_refuses_and_evens(
    people: People, latent: Outcome
) -> None:
    """By `MotionPlanner` itself, which is what the command line and the driver call."""
    arm, refused, evened, swivelled = load_arm("human7", calibrated=False), 0, 0, 0
    for row, (angles, duration) in enumerate(zip(latent.angles, latent.durations, strict=True)):
        told = Predicted(angles[None], duration[None], np.zeros(1), np.zeros(1))
        try:
            plan = MotionPlanner(arm, Says(arm.chain, told)).plan(
                people.examples.starts[row], people.examples.targets[row]
            )
        except RefusedMotionError:
            refused += 1
            continue
        swivelled += plan.swivel_m is not None
        evened += plan.swivel_m is None and plan.evened > 0
    rows = driven_table(latent, "human7", 1, silent).as_dict()["rows"]
    assert sum(row["reaches"] for row in rows if row["what"].startswith("evened")) == evened
    assert sum(row["reaches"] for row in rows if "swivel" in row["what"]) == swivelled
    assert sum(row["reaches"] for row in rows if row["what"] == "refused") == refused


def test_a_hand_that_speeds_up_twice_is_evened_and_said_to_be(people: People) -> None:
    arm, angles = load_arm("human7", calibrated=False), people.examples.angles[0]
    halfway = angles[50:51]
    twice = np.concatenate([angles[:51], halfway.repeat(50, axis=0)])
    twice[51:] += (angles[-1] - halfway) * np.linspace(0, 1, 50)[:, None] ** 4
    done = finished(arm, twice, 3.0, HandTask(people.examples.targets[0]), 200.0)
    assert done.evened > 0
    assert done.evened >= 0.5  # a halt half-way is more than hesitating
    assert way_of(done, twice) == "evened by 50 % and more"


def test_what_is_driven_as_predicted_is_the_prediction_over_normalised_time(
    people: People,
) -> None:
    arm = load_arm("human7", calibrated=False)
    start, target = people.examples.starts[:1], people.examples.targets[:1]
    found = MinimumJerkPredictor(arm.chain).predict(start, target)
    done = finished(arm, found.angles[0], 0.05, HandTask(target[0]), 200.0)
    assert done.time_scale > 2
    assert way_of(done, found.angles[0]) == "as predicted"
    np.testing.assert_allclose(over_phase(done), found.angles[0], atol=0.01)


def test_ramps_to_rest_leave_a_captured_reach_as_it_was_and_bending_does_not(
    people: People,
) -> None:
    arm, examples = load_arm("human7", calibrated=False), people.examples
    for angles, target in zip(examples.angles, examples.targets, strict=True):
        done = finished(arm, angles, 1.0, HandTask(target), 200.0)
        if not done.refused:  # nor changed
            break
    assert way_of(done, angles) == "as predicted"
    assert np.abs(over_phase(done) - angles).max() > SAME_RAD  # which is why phases are compared
    elsewhere = done._replace(angles=done.angles + 2 * SAME_RAD)
    assert way_of(elsewhere, angles) == "bent into its ranges, or to its target"


def test_a_reach_that_the_arm_may_not_follow_is_refused(latent: Outcome) -> None:
    examples = latent.people.examples
    targets = examples.targets.copy()
    targets[3] = (5.0, 0.0, 0.0)
    far = dataclasses.replace(
        latent.people, examples=dataclasses.replace(examples, targets=targets)
    )
    table = driven_table(dataclasses.replace(latent, people=far), "human7", 1, silent)
    before = driven_table(latent, "human7", 1, silent)
    counts = [
        {row["what"]: row["reaches"] for row in each.as_dict()["rows"]}["refused"]
        for each in (before, table)
    ]
    assert counts[1] == counts[0] + 1
