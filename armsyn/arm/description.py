"""What an arm is: joints, limits, landmarks and servos, read from ``<arm>.toml``."""

from __future__ import annotations

import math
import tomllib
from functools import cached_property
from pathlib import Path
from typing import Annotated, Literal, cast

import msgspec
import numpy as np
from numpy.typing import NDArray

from armsyn.arm.calibration import Calibration
from armsyn.arm.link import InertiaDescription, LinkDescription, Positive, Triple, check_inertia
from armsyn.arm.search import find_file
from armsyn.errors import DescriptionError, InputError
from armsyn.kinematics import Joint, SerialChain

FloatArray = NDArray[np.float64]
NotNegative = Annotated[float, msgspec.Meta(ge=0)]
Tick = Annotated[int, msgspec.Meta(ge=-(2**31), lt=2**31)]

MAXIMUM_BYTES = 1_000_000
TIP = "tip"
STANDARD_GRAVITY = 9.80665
"""m/s2."""


class JointDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A ``[[joint]]`` table.

    Attributes
    ----------
    name, kind, xyz, rpy, axis, lower, upper
        As in :class:`armsyn.kinematics.Joint`; m and rad.
    rest : float
        Where the joint stands at rest, rad or m.
    max_velocity : float
        Greatest planned speed, rad/s or m/s: 80 % of the servo's no-load speed.
    max_acceleration : float
        Greatest planned acceleration, rad/s2 or m/s2.
    link : LinkDescription or None
        What the joint moves, as a body: only a simulation of the whole arm needs it.
    """

    name: str
    axis: Triple
    lower: float
    upper: float
    rest: float
    max_velocity: Positive
    max_acceleration: Positive
    kind: Literal["revolute", "prismatic"] = "revolute"
    xyz: Triple = (0.0, 0.0, 0.0)
    rpy: Triple = (0.0, 0.0, 0.0)
    link: LinkDescription | None = None


class TipDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The ``[tip]`` table: the hand in the last joint's frame, m and rad.

    Attributes
    ----------
    xyz, rpy : 3-tuple of float
    mass : float
        Of what sits at the tip, a tool or a payload, taken as a point, kg.
    """

    xyz: Triple
    rpy: Triple = (0.0, 0.0, 0.0)
    mass: NotNegative = 0.0


class ServoDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A ``[[servo]]`` table: one servo, the joint it moves and how it is set up.

    Attributes
    ----------
    joint : str
    id : int
        On the bus, 0-252.
    model : str
        The maker's name in lower case, such as ``xm430-w350``. Whether it is known is found out
        where it matters, as a port is opened or a simulator started.
    direction : {1, -1}
        Sign between ticks and the joint's angle.
    zero_tick : int
        Position register at the joint's zero.
    rest_tick : int
        Position register at the joint's rest value: where a simulated servo lies.
    supply_voltage : float
        V.
    baud : int
        Bits a second.
    return_delay_us : int
        Return delay time, us, even.
    drive_mode : int
        Drive mode register. The driver refuses a servo whose bit 0 (reverse) differs, or whose
        bits 1 (dual-joint slave) or 3 (torque on by a goal) are set; bit 2 (time-based profile)
        may differ, as no profile is used. A simulated servo takes all of it.
    """

    joint: str
    id: Annotated[int, msgspec.Meta(ge=0, le=252)]
    model: str
    zero_tick: Tick
    rest_tick: Tick
    supply_voltage: Positive
    direction: Literal[1, -1] = 1
    baud: Annotated[int, msgspec.Meta(gt=0)] = 1_000_000
    return_delay_us: Annotated[int, msgspec.Meta(ge=0, le=508, multiple_of=2)] = 0
    drive_mode: Annotated[int, msgspec.Meta(ge=0, le=255)] = 0


class ArmDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True, dict=True):
    """An arm, as ``<arm>.toml`` describes it.

    Attributes
    ----------
    schema : str
        ``armsyn-arm-1``.
    name, title : str
        The file's name, and one line for people.
    joint : tuple of JointDescription
        From base to tip.
    tip : TipDescription
    landmarks : dict of str to str
        Landmark (shoulder, elbow, wrist, hand) to the joint at whose frame it lies, or ``tip``;
        the hand last.
    servo : tuple of ServoDescription
        One a joint, in the joints' order; empty for an arm that exists as a model only.
    facing : float
        Direction the arm reaches in, as an angle from x about z, rad.
    gravity : 3-tuple of float
        Acceleration of free fall in the base's frame, m/s2: says how the base is mounted.
    """

    schema: Literal["armsyn-arm-1"]
    name: str
    title: str
    joint: tuple[JointDescription, ...]
    tip: TipDescription
    landmarks: dict[str, str]
    servo: tuple[ServoDescription, ...] = ()
    facing: float = 0.0
    gravity: Triple = (0.0, 0.0, -STANDARD_GRAVITY)

    @cached_property
    def chain(self) -> SerialChain:
        """The arm's kinematics."""
        joints = tuple(
            Joint(j.name, j.kind, j.xyz, j.rpy, j.axis, j.lower, j.upper) for j in self.joint
        )
        return SerialChain(joints, self.tip.xyz, self.tip.rpy)

    @cached_property
    def calibration(self) -> Calibration:
        """Ticks and radians of the servos."""
        return Calibration(
            zero_tick=np.array([servo.zero_tick for servo in self.servo], dtype=np.int64),
            direction=np.array([servo.direction for servo in self.servo], dtype=np.int64),
        )

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, base to tip."""
        return tuple(joint.name for joint in self.joint)

    @property
    def rest(self) -> FloatArray:
        """Rest posture, shape (n,), rad or m."""
        return np.array([joint.rest for joint in self.joint])

    @property
    def max_velocity(self) -> FloatArray:
        """Greatest planned joint speeds, shape (n,), rad/s or m/s."""
        return np.array([joint.max_velocity for joint in self.joint])

    @property
    def max_acceleration(self) -> FloatArray:
        """Greatest planned joint accelerations, shape (n,), rad/s2 or m/s2."""
        return np.array([joint.max_acceleration for joint in self.joint])

    @cached_property
    def landmark_frames(self) -> tuple[int, ...]:
        """For each landmark its row in ``chain.positions``: a joint's, or n for the tip."""
        rows = {name: row for row, name in enumerate((*self.joint_names, TIP))}
        return tuple(rows[frame] for frame in self.landmarks.values())

    def slowed(self, factor: float) -> ArmDescription:
        """Return the same arm with speed limits divided by a factor, accelerations by its square.

        Parameters
        ----------
        factor : float
            At least 1.

        Returns
        -------
        ArmDescription

        Raises
        ------
        InputError
            A factor below 1, or not finite.
        """
        if not 1.0 <= factor < np.inf:
            raise InputError(f"an arm can be slowed by a factor of at least 1, got {factor:g}")
        joints = tuple(
            msgspec.structs.replace(
                joint,
                max_velocity=joint.max_velocity / factor,
                max_acceleration=joint.max_acceleration / factor**2,
            )
            for joint in self.joint
        )
        return msgspec.structs.replace(self, joint=joints)


def load_arm(name: str, directory: Path | None = None) -> ArmDescription:
    """Load an arm's description by its name.

    Parameters
    ----------
    name : str
        Such as ``human7``.
    directory : Path, optional
        Search only here instead of on the usual path (`armsyn.arm.search`).

    Returns
    -------
    ArmDescription

    Raises
    ------
    DescriptionError
        Unknown arm, unreadable file, or a field that is missing, unknown or out of range;
        the message names file and field.
    """
    path = find_file(name, ".toml", directory)
    description = parse_arm(_read(path), str(path))
    if description.name != path.stem:
        raise DescriptionError(f"{path}: name is {description.name!r}, the file says {path.stem!r}")
    return description


def parse_arm(text: str, where: str) -> ArmDescription:
    """Read a description from TOML text.

    Parameters
    ----------
    text : str
    where : str
        The file, for messages.

    Returns
    -------
    ArmDescription

    Raises
    ------
    DescriptionError
        As `load_arm`.
    """
    try:
        document = tomllib.loads(text)
        description = msgspec.convert(document, ArmDescription)
        _check(description)
    except (tomllib.TOMLDecodeError, msgspec.ValidationError, InputError, RecursionError) as error:
        raise DescriptionError(f"{where}: {error}") from error
    return description


def _read(path: Path) -> str:
    try:
        if path.stat().st_size > MAXIMUM_BYTES:
            raise DescriptionError(f"{path}: larger than {MAXIMUM_BYTES} bytes")
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise DescriptionError(f"{path}: {error}") from error


def _check(arm: ArmDescription) -> None:
    """What the types cannot say."""
    _check_finite(arm)
    _ = arm.chain  # names, axes and limits
    for joint in arm.joint:
        if not joint.lower <= joint.rest <= joint.upper:
            raise InputError(f"joint {joint.name}: rest {joint.rest:g} is outside its limits")
        if joint.link is not None and joint.link.inertia is not None:
            _check_link(joint.name, joint.link.inertia)
    frames = {*arm.joint_names, TIP}
    for landmark, frame in arm.landmarks.items():
        if frame not in frames:
            raise InputError(f"landmark {landmark}: {frame!r} is neither a joint nor {TIP!r}")
    if not arm.landmarks or list(arm.landmarks.values())[-1] != TIP:
        raise InputError(f"landmarks: the last one is the hand and must be {TIP!r}")
    if arm.servo:
        _check_servos(arm)


def _check_link(joint: str, inertia: InertiaDescription) -> None:
    try:
        check_inertia(inertia)
    except InputError as error:
        raise InputError(f"joint {joint}: link: {error}") from None


def _check_finite(arm: ArmDescription) -> None:
    """TOML knows nan and inf; no number of an arm may be one."""
    tables: list[tuple[str, msgspec.Struct]] = [("", arm), ("tip: ", arm.tip)]
    for joint in arm.joint:
        tables.append((f"joint {joint.name}: ", joint))
        if joint.link is not None:
            tables.append((f"joint {joint.name}: link: ", joint.link))
        if joint.link is not None and joint.link.inertia is not None:
            tables.append((f"joint {joint.name}: link: inertia: ", joint.link.inertia))
    tables += [(f"servo {servo.id}: ", servo) for servo in arm.servo]
    for where, table in tables:
        for field, value in msgspec.structs.asdict(table).items():
            numbers = value if isinstance(value, tuple) else (value,)
            if any(isinstance(x, float) and not math.isfinite(x) for x in numbers):
                raise InputError(f"{where}{field} must be finite, got {value}")


def _check_servos(arm: ArmDescription) -> None:
    ids = [servo.id for servo in arm.servo]
    twice = sorted({i for i in ids if ids.count(i) > 1})
    if twice:
        raise InputError(f"servo ID {twice[0]} is given twice; every servo needs its own")
    joints = tuple(servo.joint for servo in arm.servo)
    if joints != arm.joint_names:
        raise InputError(f"servos move {joints}, the joints are {arm.joint_names}: one each")
    if len({servo.baud for servo in arm.servo}) > 1:
        raise InputError("servos of one bus must share one baud rate")
    for joint in arm.joint:
        if joint.kind != "revolute":
            raise InputError(f"joint {joint.name}: only revolute joints can have a servo")
    rest_ticks = arm.calibration.to_ticks(arm.rest)
    for servo, tick in zip(arm.servo, cast("list[int]", rest_ticks.tolist()), strict=True):
        if abs(servo.rest_tick - tick) > 1:
            raise InputError(
                f"servo {servo.id}: rest_tick {servo.rest_tick} is not the joint's rest ({tick})"
            )
