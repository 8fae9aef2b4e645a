"""Collisions along whole paths: found between the samples too, with who, when and how deep."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import CollisionError, InputError
from armsyn.safety import MARGIN, check_collision, closest
from armsyn.safety.collision import LEAVING, RESOLUTION, Clearances
from tests.safety.shaped import everything, two_links

Array = NDArray[np.float64]

POST = '[[box]]\nname = "post"\ncentre = [0.0, 0.475, 0.0]\nsize = [0.01, 0.15, 1.0]\n'
EVERYTHING = everything()


def gap(angle: float) -> float:
    """Clearance of the straight arm at an angle from the post, as long as it is before it, m.

    The post's nearest corner, (0.005, 0.4), is that far from a line through the origin.
    """
    return float(0.4 * np.cos(angle) - 0.005 * np.sin(angle) - 0.02)


def angle_with(clearance: float) -> float:
    """Return the angle at which `gap` is a clearance, rad."""
    corner = 0.005 + 0.4j
    return float(np.arccos((clearance + 0.02) / abs(corner)) - (np.pi / 2 - np.angle(corner)))


@pytest.fixture(scope="module")
def arm() -> ArmDescription:
    """Two links in a plane, straight along x; a post of 1 cm stands on the y axis."""
    return two_links("", POST)


@pytest.mark.fault(34)
def test_a_post_between_two_samples(arm: ArmDescription) -> None:
    """Both ends are 0.3 m from the post; the arm sweeps through it between them."""
    path = np.array([[0.8, 0.0], [2.3, 0.0]])
    ends = closest(path, arm)
    assert ends is not None
    assert ends.distance > 0.1
    error = check_collision(path, arm, time=np.array([0.0, 3.0]))
    assert isinstance(error, CollisionError)
    assert error.exit_status == 4
    assert (error.first, error.second, error.frame) == ("lower_arm", "post", 0)
    assert "lower_arm would" in str(error)
    assert "\n" not in str(error)


def test_time_and_depth_by_closed_forms(arm: ArmDescription) -> None:
    angle = np.linspace(1.2, 1.55, 721)
    path = np.column_stack([angle, np.zeros_like(angle)])
    error = check_collision(path, arm, time=angle)
    assert error is not None
    touches = angle_with(MARGIN)
    assert angle[error.frame] <= touches <= angle[error.frame + 1]
    said = float(str(error).split(" from ")[1].split(" s")[0])
    assert said == pytest.approx(touches, abs=1e-3)
    assert error.depth == pytest.approx(-gap(1.55), abs=1e-9)


def test_too_near_is_said_as_such(arm: ArmDescription) -> None:
    angle = angle_with(0.003)
    error = check_collision(np.array([[angle, 0.0]]), arm)
    assert error is not None
    assert error.depth == pytest.approx(-0.003)
    assert "lower_arm would come 3.0 mm near to post, 5.0 mm must stay" in str(error)
    assert check_collision(np.array([[angle, 0.0]]), arm, 0.002) is None


@pytest.mark.fault(34)
def test_the_first_contact_is_named(arm: ArmDescription) -> None:
    """Back and forth twice, the second time at coarse samples."""
    out = np.linspace(0.8, 1.6, 200)
    path = np.column_stack([np.concatenate([out, out[::-1], [2.3, 0.8]]), np.zeros(402)])
    error = check_collision(path, arm)
    assert error is not None
    assert 0 < error.frame < 200
    turned = check_collision(path[::-1], arm)
    assert turned is not None
    assert turned.frame == 0  # between the first two


def test_an_arm_may_leave_a_contact_but_not_deepen_it(arm: ArmDescription) -> None:
    out = np.column_stack([np.linspace(1.54, 1.0, 100), np.zeros(100)])
    error = check_collision(out, arm)
    assert error is not None
    assert error.frame == 0
    assert check_collision(out, arm, leaving=True) is None
    further = np.concatenate([out[:1], out[:1] + np.array([[0.02, 0.0]]), out])
    deeper = check_collision(further, arm, leaving=True)
    assert deeper is not None
    assert deeper.depth > -float(Clearances.of(arm).solids.clearances(out[:1]).min()) + LEAVING
    # a contact at the start excuses no other
    through = np.column_stack([np.linspace(1.54, -4.75, 500), np.zeros(500)])
    again = check_collision(through, arm, leaving=True)
    assert again is not None
    assert again.depth > 0.0


postures = st.tuples(
    *(
        st.floats(float(low), float(high))
        for low, high in zip(EVERYTHING.chain.lower, EVERYTHING.chain.upper, strict=True)
    )
).map(list)


@pytest.mark.fault(34)
@settings(deadline=None)
@given(st.lists(postures, min_size=1, max_size=4), st.sampled_from([-0.02, 0.0, MARGIN, 0.03]))
def test_paths_by_brute_force(rows: list[list[float]], margin: float) -> None:
    """Coarse paths of an arm with everything: as a scan of 800 postures between samples finds."""
    path = np.array(rows)
    shares = np.arange(0.0, len(path) - 1 + 1e-9, 1 / 800)
    fine = np.column_stack([np.interp(shares, np.arange(len(path)), column) for column in path.T])
    required = np.minimum(margin, EVERYTHING.solids.at_rest)
    slack = EVERYTHING.solids.clearances(fine) - required
    error = check_collision(path, EVERYTHING, margin)
    if slack.min() < -RESOLUTION:
        assert error is not None
        first = int(np.argmax((slack < 0.0).any(axis=1)))
        assert error.frame <= shares[first]
        assert {error.first, error.second} != set()
        pairs = [k for k, pair in enumerate(EVERYTHING.solids.names) if pair[0] == error.first]
        assert slack[:, pairs].min() < 0.001
    elif error is not None:  # touched by a hair, between the scan's postures
        moved = np.abs(np.diff(fine, axis=0)) @ EVERYTHING.solids.reach.T
        assert slack.min() <= moved.max()


def test_closest_of_a_path(arm: ArmDescription) -> None:
    path = np.array([[0.0, 0.0], [1.4, 0.0], [0.5, 0.0]])
    found = closest(path, arm)
    assert found is not None
    assert found.frame == 1
    assert (found.first, found.second) == ("lower_arm", "post")
    assert found.distance == pytest.approx(gap(1.4))
    assert closest(path[1], arm) == found._replace(frame=0)
    assert closest(path, two_links()) is None  # neighbours only


@pytest.mark.parametrize(
    "path", [[[0.0]], [[0.0, 0.0, 0.0]], [0.0, 0.0], [[0.0, np.nan]], [[np.inf, 0.0]]]
)
def test_paths_that_are_not_this_arms(arm: ArmDescription, path: list[list[float]]) -> None:
    with pytest.raises(InputError, match="a path of made has 2 finite columns"):
        check_collision(path, arm)


def test_margins_that_are_none(arm: ArmDescription) -> None:
    with pytest.raises(InputError, match="a margin must be finite"):
        check_collision([[0.0, 0.0]], arm, np.nan)


def test_no_path_touches_nothing(arm: ArmDescription) -> None:
    assert check_collision(np.empty((0, 2)), arm) is None
    assert check_collision(np.empty((0, 2)), arm, leaving=True) is None
    assert closest(np.empty((0, 2)), arm) is None
