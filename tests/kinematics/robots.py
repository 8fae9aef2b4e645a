"""URDF text written from lists of joints, and what Pinocchio makes of it."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

Array = NDArray[np.float64]
Triple = tuple[float, float, float]


@dataclass(frozen=True)
class UrdfPart:
    """A joint and its child link, named after it."""

    name: str
    kind: str = "revolute"
    xyz: Triple | None = None
    rpy: Triple | None = None
    axis: Triple | None = None
    limit: tuple[float, float] | None = (-3.0, 3.0)
    parent: str | None = None
    """Link; by default the previous part's."""
    inside: str = ""


def urdf(*parts: UrdfPart, base: str = "base", extra: str = "") -> str:
    """Write a robot whose parts hang one below the other unless they name another parent."""
    lines = ['<?xml version="1.0"?>', '<robot name="test">', f'<link name="{base}"/>']
    above = base
    for part in parts:
        lines += _lines(part, part.parent or above)
        above = f"{part.name}_link"
    return "\n".join([*lines, extra, "</robot>"])


def _lines(part: UrdfPart, parent: str) -> list[str]:
    origin = "".join(
        f' {name}="{" ".join(map(repr, value))}"'
        for name, value in (("xyz", part.xyz), ("rpy", part.rpy))
        if value is not None
    )
    lines = [
        f'<link name="{part.name}_link"/>',
        f'<joint name="{part.name}" type="{part.kind}">',
        f'<parent link="{parent}"/><child link="{part.name}_link"/>',
        f"<origin{origin}/>" if origin else "",
        f'<axis xyz="{" ".join(map(repr, part.axis))}"/>' if part.axis else "",
    ]
    if part.limit and part.kind in ("revolute", "prismatic"):
        low, high = part.limit
        lines.append(f'<limit lower="{low!r}" upper="{high!r}" effort="1" velocity="1"/>')
    return [*lines, part.inside, "</joint>"]


class UrdfOracle:
    """Pinocchio's reading of a URDF."""

    def __init__(self, text: str) -> None:
        self.model = pin.buildModelFromXML(text)
        self.data = self.model.createData()

    def frames(self, values: dict[str, float], links: list[str]) -> list[tuple[Array, Array]]:
        """Position and orientation of `links` in the root link's frame."""
        pin.framesForwardKinematics(self.model, self.data, self._configuration(values))
        frames = [self.data.oMf[self.model.getFrameId(link)] for link in links]
        return [(frame.translation.copy(), frame.rotation.copy()) for frame in frames]

    def jacobian(self, values: dict[str, float], tip: str) -> Array:
        """Return the tip's Jacobian in the root link's axes: a column for each of `values`."""
        frame = self.model.getFrameId(tip)
        q = self._configuration(values)
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        J = np.array(pin.computeFrameJacobian(self.model, self.data, q, frame, axes))
        columns = [self.model.joints[self.model.getJointId(name)].idx_v for name in values]
        return J.reshape(6, -1)[:, columns]

    def _configuration(self, values: dict[str, float]) -> Array:
        q = pin.neutral(self.model)
        for name, value in values.items():
            joint = self.model.joints[self.model.getJointId(name)]
            # a continuous joint is cosine and sine there
            q[joint.idx_q : joint.idx_q + joint.nq] = (
                [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
            )
        return q
