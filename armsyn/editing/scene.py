"""Scenes: what an edit asks for, in a TOML file; `TEMPLATE` shows everything it may say."""

from __future__ import annotations

import math
from importlib.resources import files
from pathlib import Path
from typing import Literal, NamedTuple

import msgspec

from armsyn.editing.constraints import Constraint, KeyFrame, KeyTrajectory, Orientation, Pin, Triple
from armsyn.editing.constraints import Key as TrajectoryKey
from armsyn.editing.figure import Effector
from armsyn.editing.solving import SolverOptions
from armsyn.errors import ArmsynError, ConstraintError, FormatError
from armsyn.kinematics.rotation import from_expmap
from armsyn.motion.formats.files import check_size

LARGEST = 2**20
TEMPLATE = files("armsyn.editing").joinpath("scene.toml").read_text(encoding="utf-8")
"""A scene with every part, its units and its defaults, in comments."""
_ORIGIN = (0.0, 0.0, 0.0)


class Scene(NamedTuple):
    """What an edit asks for.

    Attributes
    ----------
    constraints : tuple of Constraint
    options : SolverOptions
    """

    constraints: tuple[Constraint, ...]
    options: SolverOptions


class _Part(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    body: str
    point: Triple = _ORIGIN
    level: int = 1
    axes: str = "xyz"

    @property
    def effector(self) -> Effector:
        return Effector(self.body, self.point)


class _KeyFrame(_Part, frozen=True, kw_only=True):
    frame: int
    to: Triple | None = None
    by: Triple | None = None

    def constraint(self) -> Constraint:
        return KeyFrame(self.effector, self.frame, self.to, self.by, self.level, self.axes)


class _Pin(_Part, frozen=True, kw_only=True):
    frames: tuple[int, ...] | None = None
    turned: bool = False

    def constraint(self) -> Constraint:
        return Pin(self.effector, self.frames, self.level, self.axes, self.turned)


class _Orientation(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    body: str
    frame: int
    to_deg: Triple | None = None
    by_deg: Triple | None = None
    level: int = 1

    def constraint(self) -> Constraint:
        to, by = _radians(self.to_deg), _radians(self.by_deg)
        turned = None if to is None else from_expmap(to)
        return Orientation(Effector(self.body), self.frame, turned, by, self.level)


class _Key(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    frame: int
    at: Triple


class _Trajectory(_Part, frozen=True, kw_only=True):
    keys: tuple[_Key, ...]
    relative: bool = False
    ease_in: int = 0
    ease_out: int = 0
    tension: float = 0.0
    continuity: float = 0.0
    bias: float = 0.0

    def constraint(self) -> Constraint:
        return KeyTrajectory(
            self.effector,
            tuple(TrajectoryKey(key.frame, key.at) for key in self.keys),
            relative=self.relative,
            ease_in=self.ease_in,
            ease_out=self.ease_out,
            tension=self.tension,
            continuity=self.continuity,
            bias=self.bias,
            level=self.level,
            axes=self.axes,
        )


class _Solver(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    iterations: int = 100
    damping: float = 0.01
    damping_unit: Literal["relative", "metre", "centimetre"] = "relative"
    whiten: bool = True
    tolerance: float = 1e-6
    toward: Literal["", "clip", "mean"] = ""
    toward_coefficients: tuple[float, ...] = ()
    pull: float = 1.0
    coefficient_bound: float = 6.0
    allowed_miss: float = 1e-3
    metres_per_radian: float = 0.5


class _File(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    schema: Literal["armsyn-scene-1"]
    solver: _Solver = _Solver()
    key_frame: tuple[_KeyFrame, ...] = ()
    pin: tuple[_Pin, ...] = ()
    orientation: tuple[_Orientation, ...] = ()
    key_trajectory: tuple[_Trajectory, ...] = ()


def load_scene(path: Path | str) -> Scene:
    """Read a scene.

    Parameters
    ----------
    path : Path or str
        A TOML file as `TEMPLATE` shows.

    Returns
    -------
    Scene

    Raises
    ------
    FormatError
        Missing, not TOML, or with something unknown or of another kind in it.
    ConstraintError
        A constraint that cannot be understood, by the file and its place.
    """
    path = Path(path)
    check_size(path, LARGEST)
    try:
        return parse_scene(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise FormatError(f"{path}: cannot read it: {error}") from error
    except ArmsynError as error:
        raise type(error)(f"{path}: {error}") from error


def parse_scene(text: str) -> Scene:
    """Read a scene's text; as `load_scene`."""
    try:
        found = msgspec.toml.decode(text, type=_File)
    except msgspec.DecodeError as error:
        raise FormatError(f"not a scene: {error}") from error
    options = SolverOptions(**msgspec.structs.asdict(found.solver))
    constraints: list[Constraint] = []
    for name in ("key_frame", "pin", "orientation", "key_trajectory"):
        for place, part in enumerate(getattr(found, name)):
            try:
                constraints.append(part.constraint())
            except ConstraintError as error:
                raise ConstraintError(f"[[{name}]] {place + 1}: {error}") from error
    if not constraints:
        raise ConstraintError("the scene asks for nothing: give a key_frame or key_trajectory")
    return Scene(tuple(constraints), options)


def _radians(degrees: Triple | None) -> Triple | None:
    if degrees is None:
        return None
    x, y, z = map(math.radians, degrees)
    return x, y, z
