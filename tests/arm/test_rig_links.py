"""Masses and inertias of links: what is refused, and the shape that stands in."""

import numpy as np
import pytest

from armsyn.arm import ArmDescription
from armsyn.arm.description import parse_arm
from armsyn.arm.link import STAND_IN_RADIUS, stand_in_inertia
from armsyn.errors import DescriptionError

ARM = """
schema = "armsyn-arm-1"
name = "one"
title = "one joint"
gravity = [0.0, -9.8, 0.0]

[landmarks]
hand = "tip"

[tip]
xyz = [0.1, 0.0, 0.0]
mass = 0.02

[[joint]]
name = "a"
axis = [0.0, 0.0, 1.0]
lower = -1.0
upper = 1.0
rest = 0.5
max_velocity = 2.0
max_acceleration = 10.0

[joint.link]
mass = 0.2
centre_of_mass = [0.05, 0.0, 0.0]
inertia = { xx = 1e-4, yy = 2e-4, zz = 2e-4, xy = 1e-5 }
"""

SPOILED = {
    "no mass": ("mass = 0.2", "", "mass"),
    "weightless": ("mass = 0.2", "mass = 0.0", "mass"),
    "endless mass": ("mass = 0.2", "mass = inf", "joint a: link: mass must be finite"),
    "no centre": ("centre_of_mass = [0.05, 0.0, 0.0]", "", "centre_of_mass"),
    "centre nowhere": ("[0.05, 0.0, 0.0]", "[nan, 0.0, 0.0]", "link: centre_of_mass must be"),
    "half an inertia": (", zz = 2e-4", "", "zz"),
    "inertia of none": ("zz = 2e-4", "zz = 9e-4", "joint a: link: inertia: no body has"),
    "turned inside out": ("xy = 1e-5", "xy = 9e-4", "joint a: link: inertia: no body has"),
    "inertia without end": ("xy = 1e-5", "xy = nan", "link: inertia: xy must be finite"),
    "negative payload": ("mass = 0.02", "mass = -1.0", "mass"),
    "gravity to nowhere": ("-9.8", "inf", "gravity must be finite"),
    "unknown field": ("mass = 0.2", "mass = 0.2\ncolour = 1", "colour"),
}


def arm(text: str) -> ArmDescription:
    return parse_arm(text, "one.toml")


def test_what_is_read() -> None:
    found = arm(ARM)
    link = found.joint[0].link
    assert link is not None
    assert link.inertia is not None
    assert (link.mass, link.centre_of_mass, found.tip.mass) == (0.2, (0.05, 0.0, 0.0), 0.02)
    expected = [[1e-4, 1e-5, 0.0], [1e-5, 2e-4, 0.0], [0.0, 0.0, 2e-4]]
    assert link.inertia.matrix.tolist() == expected
    assert found.gravity == (0.0, -9.8, 0.0)


def test_without_masses_it_is_still_an_arm() -> None:
    found = arm(ARM.split("[joint.link]", maxsplit=1)[0])
    assert found.joint[0].link is None


@pytest.mark.parametrize("what", SPOILED)
def test_a_spoiled_link(what: str) -> None:
    before, after, text = SPOILED[what]
    assert before in ARM
    with pytest.raises(DescriptionError) as caught:
        arm(ARM.replace(before, after, 1))
    assert text in str(caught.value)
    assert "one.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_cylinder_that_stands_in_is_one_in_any_direction() -> None:
    """Moments of a solid cylinder, summed over a cloud of points that fills it."""
    generator = np.random.default_rng(3)
    count, mass, length = 400_000, 0.3, 0.2
    radius = STAND_IN_RADIUS * np.sqrt(generator.random(count))
    angle = generator.uniform(0.0, 2.0 * np.pi, count)
    points = np.column_stack(
        [
            radius * np.cos(angle),
            radius * np.sin(angle),
            generator.uniform(-length / 2, length / 2, count),
        ]
    )
    Q, _ = np.linalg.qr(generator.normal(size=(3, 3)))
    points = points @ Q.T
    squares = (points**2).sum(axis=1)
    cloud = mass * (squares.mean() * np.eye(3) - points.T @ points / count)
    assert stand_in_inertia(mass, length * Q[:, 2]) == pytest.approx(cloud, abs=0.005 * cloud.max())


def test_the_ball_that_stands_in() -> None:
    expected = 0.4 * 0.3 * STAND_IN_RADIUS**2 * np.eye(3)
    assert stand_in_inertia(0.3, [0.0, 0.0, 0.0]) == pytest.approx(expected)
