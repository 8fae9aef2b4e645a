"""Arms with shapes, made for tests, and what independent code says of them."""

import coal
import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.arm.description import parse_arm
from armsyn.arm.shapes import CapsuleDescription
from tests.kinematics.oracle import Oracle

Array = NDArray[np.float64]


def joint(name: str, axis: str, xyz: str = "[0.0, 0.0, 0.0]", *more: str) -> str:
    """Return a ``[[joint]]`` table; `more` are further lines of it."""
    lines = [f'name = "{name}"', f"axis = {axis}", f"xyz = {xyz}", "rest = 0.0"]
    if not any("lower" in line for line in more):
        lines += ["lower = -3.0", "upper = 3.0"]
    lines += ["max_velocity = 3.0", "max_acceleration = 20.0", *more]
    return "[[joint]]\n" + "\n".join(lines) + "\n"


def capsule(start: str, end: str, radius: float, table: str = "joint.shape") -> str:
    return f"[[{table}]]\nfrom = {start}\nto = {end}\nradius = {radius}\n"


def arm_of(*tables: str, top: str = "", tip: str = "[0.2, 0.0, 0.0]") -> ArmDescription:
    """Parse an arm of some tables."""
    head = f'schema = "armsyn-arm-1"\nname = "made"\ntitle = "made"\n{top}\n'
    head += f'[landmarks]\nhand = "tip"\n[tip]\nxyz = {tip}\n'
    return parse_arm(head + "\n".join(tables), "made.toml")


def two_links(top: str = "", *tables: str) -> ArmDescription:
    """Return an arm of two links of 0.3 and 0.2 m in the x-y plane, 2 cm thick each way."""
    return arm_of(
        *tables,
        joint("upper", "[0.0, 0.0, 1.0]", "[0.0, 0.0, 0.0]"),
        capsule("[0.0, 0.0, 0.0]", "[0.3, 0.0, 0.0]", 0.02),
        joint("lower_arm", "[0.0, 0.0, 1.0]", "[0.3, 0.0, 0.0]"),
        capsule("[0.0, 0.0, 0.0]", "[0.2, 0.0, 0.0]", 0.02),
        top=top,
    )


def everything() -> ArmDescription:
    """Return an arm with turned joints, a slide, several shapes a link, planes and boxes."""
    return arm_of(
        '[[plane]]\nname = "wall"\npoint = [0.0, 0.9, 0.1]\nnormal = [0.2, -2.0, 0.1]\n',
        '[[box]]\nname = "block"\ncentre = [0.1, -0.5, 0.4]\nsize = [0.1, 0.3, 0.2]\n'
        "rpy = [0.3, -0.5, 0.9]\n",
        capsule("[0.0, 0.0, -0.1]", "[0.1, 0.0, -0.1]", 0.03, "base_shape"),
        joint("a", "[0.0, 0.3, 1.0]", "[0.1, 0.0, 0.2]", "rpy = [0.4, 0.1, -0.3]"),
        capsule("[0.0, 0.05, 0.0]", "[0.2, 0.0, 0.05]", 0.02),
        joint("b", "[1.0, 0.2, 0.0]", "[0.25, 0.0, 0.1]", "rpy = [0.0, 0.7, 0.2]"),
        capsule("[0.0, 0.0, 0.0]", "[0.1, 0.1, 0.0]", 0.02),
        capsule("[0.1, 0.1, 0.0]", "[0.1, 0.1, 0.2]", 0.01),
        joint(
            "slide",
            "[0.0, 1.0, 1.0]",
            "[0.1, 0.1, 0.2]",
            'kind = "prismatic"\nlower = -0.2\nupper = 0.3',
        ),
        capsule("[0.0, 0.0, 0.0]", "[0.05, 0.0, 0.1]", 0.015),
        joint("c", "[0.0, -1.0, 0.0]", "[0.05, 0.0, 0.15]"),
        capsule("[0.0, 0.0, 0.0]", "[0.2, 0.05, 0.0]", 0.02),
    )


def oracle_clearances(arm: ArmDescription, q: Array) -> dict[tuple[str, str], float]:
    """Clearances of all pairs of names by Pinocchio's frames and Coal's distances, m.

    Coal's depths are those of the least way out, so only what is above zero can be compared.
    """
    positions, rotations = Oracle(arm.chain).frames(q)
    bodies: dict[str, list[tuple[coal.CollisionGeometry, coal.Transform3s]]] = {
        "base": [_body(shape, np.eye(3), np.zeros(3)) for shape in arm.base_shape]
    }
    for row, described in enumerate(arm.joint):
        bodies[described.name] = [
            _body(shape, rotations[row], positions[row]) for shape in described.shape or ()
        ]
    for plane in arm.plane:
        normal = np.array(plane.normal) / np.linalg.norm(plane.normal)
        half = coal.Halfspace(normal, float(normal @ np.array(plane.point)))
        bodies[plane.name] = [(half, coal.Transform3s.Identity())]
    for box in arm.box:
        from pinocchio.rpy import rpyToMatrix

        pose = coal.Transform3s(rpyToMatrix(*box.rpy), np.array(box.centre))
        bodies[box.name] = [(coal.Box(*box.size), pose)]
    return {
        (first, second): min(_distance(*one, *other) for one in bodies[first] for other in others)
        for first in bodies
        for second, others in bodies.items()
        if first != second and bodies[first] and others
    }


def _body(
    shape: CapsuleDescription, rotation: Array, position: Array
) -> tuple[coal.CollisionGeometry, coal.Transform3s]:
    start, end = (position + rotation @ np.array(p) for p in (shape.start, shape.end))
    length = float(np.linalg.norm(end - start))
    z = (end - start) / length
    x = np.cross(z, [1.0, 0.0, 0.0] if abs(z[0]) < 0.9 else [0.0, 1.0, 0.0])
    x /= np.linalg.norm(x)
    turn = np.column_stack([x, np.cross(z, x), z])
    return coal.Capsule(shape.radius, length), coal.Transform3s(turn, 0.5 * (start + end))


def _distance(
    one: coal.CollisionGeometry,
    one_pose: coal.Transform3s,
    other: coal.CollisionGeometry,
    other_pose: coal.Transform3s,
) -> float:
    return float(
        coal.distance(
            one, one_pose, other, other_pose, coal.DistanceRequest(), coal.DistanceResult()
        )
    )
