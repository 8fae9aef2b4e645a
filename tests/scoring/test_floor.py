"""The human floor: published figures on HuG-MP, and a person whose answer is known."""

import dataclasses

import numpy as np
import pytest

from armsyn.errors import CaptureError
from armsyn.motion import FloatArray, Motion
from armsyn.motion.captures import load_captures
from armsyn.scoring.floor import human_floor, mean_of_repeats
from armsyn.scoring.repeats import HUG_MP, mean_floor, repeats_in, repeats_of


def loaded(subject: str) -> list[tuple[str, Motion]]:
    return [(c.name, c.motion) for c in load_captures(f"hug_mp:{subject}:all")]


def person_reach(duration: float, *, noise: float = 0.0, start: float = 0.0) -> Motion:
    """Return a reach of the exoskeleton's arm, its joints moving by minimum jerk."""
    time = np.arange(round(duration * 100) + 1) / 100
    phase = time / time[-1]
    share = (10 * phase**3 - 15 * phase**4 + 6 * phase**5)[:, None]
    angles: FloatArray = np.array([0.1, -0.2, 0.1, 0.4]) + start
    angles = angles + share * np.array([0.2, -0.8, 0.3, 0.5])
    angles = angles + noise * np.sin(np.pi * phase)[:, None]
    return Motion(
        time=time,
        joint_names=("a", "b", "c", "d"),
        angles=angles,
        landmark_names=("shoulder", "elbow", "hand"),
        landmarks=HUG_MP.landmarks(angles),
        source="reach",
    )


def test_a_person_who_repeats_exactly_has_no_floor() -> None:
    same = person_reach(1.0)
    floor = human_floor(same, [same, same], HUG_MP)
    assert floor.distance == pytest.approx(0, abs=1e-4)
    assert floor.repeat_distance == 0
    assert floor.repeats == 2


def test_opposite_noise_cancels_in_the_mean_but_not_between_repeats() -> None:
    others = [person_reach(1.0, noise=0.2), person_reach(1.0, noise=-0.2)]
    floor = human_floor(person_reach(1.0), others, HUG_MP)
    assert floor.distance < 1e-3
    assert floor.repeat_distance > 0.03


def test_the_mean_starts_and_ends_where_the_reach_does() -> None:
    own = person_reach(1.0, start=0.15)
    mean = mean_of_repeats(own, [person_reach(1.2), person_reach(1.4)], HUG_MP)
    assert own.angles is not None
    assert mean.angles is not None
    assert mean.angles[0] == pytest.approx(own.angles[0])
    assert np.linalg.norm(mean.hand[-1] - own.hand[-1]) < 2e-4
    assert mean.duration == pytest.approx(1.3)


def test_one_other_repeat_or_angles_that_lack_make_no_floor() -> None:
    same = person_reach(1.0)
    with pytest.raises(CaptureError, match="a floor needs two"):
        human_floor(same, [same], HUG_MP)
    blind = dataclasses.replace(same, joint_names=(), angles=None)
    with pytest.raises(CaptureError, match="no joint angles"):
        human_floor(same, [blind, blind], HUG_MP)


def test_an_end_out_of_reach_is_said() -> None:
    same = person_reach(1.0)
    assert same.landmarks is not None
    far = dataclasses.replace(same, landmarks=same.landmarks + np.array([0, 0, -2.0]))
    with pytest.raises(CaptureError, match="cm short"):
        mean_of_repeats(far, [same, same], HUG_MP)


@pytest.mark.usefixtures("captures")
@pytest.mark.parametrize(
    ("subject", "floor_cm", "published_repeat_cm"),
    [("S01", 1.48, 2.73), ("S02", 2.42, 4.03), ("S03", 2.15, 3.79), ("S04", 2.40, 3.79)],
)
def test_floors_of_hug_mp_are_the_published_ones(
    subject: str, floor_cm: float, published_repeat_cm: float
) -> None:
    floors = [human_floor(*found, as_cut=True) for _, found in repeats_in(loaded(subject))]
    assert len(floors) >= 100
    assert 100 * np.mean([f.distance for f in floors]) == pytest.approx(floor_cm, abs=0.005)
    # Which of the ways to average over pairs was published is not said: ours is within 0.04 cm.
    repeat = 100 * np.mean([f.repeat_distance for f in floors])
    assert repeat == pytest.approx(published_repeat_cm, abs=0.04)


@pytest.mark.usefixtures("captures")
def test_repeats_are_one_persons_reaches_to_one_target() -> None:
    found = repeats_of("hug_mp:S01:2.4.5:R-9")
    assert found is not None
    assert len(found.others) == 19
    assert not any(other is found.captured for other in found.others)
    ends = np.array([other.hand[-1] for other in found.others])
    assert np.linalg.norm(ends - ends.mean(axis=0), axis=1).max() < 0.08
    # Taken as scores are, onset to offset, the floor hardly moves.
    as_cut = human_floor(*found, as_cut=True).distance
    assert human_floor(*found).distance == pytest.approx(as_cut, abs=0.003)


@pytest.mark.usefixtures("captures")
def test_sets_with_one_reach_a_target_and_files_have_no_repeats() -> None:
    assert repeats_of("garza:ForwardHigh") is None
    assert repeats_of("reach.npz") is None
    assert repeats_in([(c.name, c.motion) for c in load_captures("garza:all")]) == []


@pytest.mark.usefixtures("captures")
def test_the_mean_over_a_set_is_that_of_its_reaches() -> None:
    few = [named for named in loaded("S01") if named[0].endswith(":R-3")][:4]
    found = mean_floor(few)
    assert found is not None
    single = [human_floor(*repeats) for _, repeats in repeats_in(few)]
    assert found.reaches == 4
    assert found.floor == pytest.approx(np.mean([floor.distance for floor in single]))
    assert found.floor < found.repeat_distance
    assert mean_floor(few[:2]) is None
