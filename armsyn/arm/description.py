"""What an arm is: joints, limits, landmarks and servos, read from ``<arm>.toml``."""

from __future__ import annotations

import tomllib
from functools import cached_property
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from armsyn.arm.allowed_fields import allowed_instead
from armsyn.arm.calibration import Calibration
from armsyn.arm.calibration_file import find_calibration, read_calibration, with_calibration
from armsyn.arm.checks import TIP, check_description
from armsyn.arm.gravity import Bodies, bodies_of
from armsyn.arm.joints import ACCELERATION_TIME, JointDescription, TipDescription
from armsyn.arm.link import Triple
from armsyn.arm.search import find_file
from armsyn.arm.servos import (
    GripperDescription,
    ServoDescription,
    calibration_of,
)
from armsyn.arm.shapes import BoxDescription, CapsuleDescription, PlaneDescription
from armsyn.arm.solids import Solids
from armsyn.arm.urdf import with_urdf
from armsyn.errors import DescriptionError, InputError
from armsyn.kinematics import Joint, SerialChain

FloatArray = NDArray[np.float64]

MAXIMUM_BYTES = 1_000_000
MOST_JOINTS = 64
MOST_SERVOS = 253
"""IDs of a bus."""
LARGEST_SLOWING = 1e6
"""Factor; its cube, by which jerks are divided, must be a number that a limit can be divided by."""

_SHAPES = msgspec.Meta(max_length=100)
STANDARD_GRAVITY = 9.80665
"""m/s2."""


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
    anatomy : dict of str to str
        The table ``[landmarks]``: landmark (shoulder, elbow, wrist, hand) to the joint at whose
        frame it lies, or ``tip``; the hand last.
    follows : {"landmarks", "hand"}
        What of a captured person the arm follows: all those landmarks, if it is built like a
        person's; or, like an arm on a table, which cannot hang, the hand's path only.
    servo : tuple of ServoDescription
        One a joint, in the joints' order, its shadows and the gripper's anywhere between; empty
        for an arm that exists as a model only.
    gripper : GripperDescription or None
    facing : float
        Direction the arm reaches in, as an angle from x about z, rad.
    gravity : 3-tuple of float
        Acceleration of free fall in the base's frame, m/s2: says how the base is mounted.
    base_shape, plane, box, collision_ignore
        What the base fills, what stands around the arm, and which pairs of names are not judged:
        see `armsyn.arm.shapes`.
    """

    schema: Literal["armsyn-arm-1"]
    name: str
    title: str
    joint: Annotated[tuple[JointDescription, ...], msgspec.Meta(max_length=MOST_JOINTS)]
    tip: TipDescription
    anatomy: dict[str, str] = msgspec.field(name="landmarks")
    servo: Annotated[tuple[ServoDescription, ...], msgspec.Meta(max_length=MOST_SERVOS)] = ()
    gripper: GripperDescription | None = None
    follows: Literal["landmarks", "hand"] = "landmarks"
    facing: float = 0.0
    gravity: Triple = (0.0, 0.0, -STANDARD_GRAVITY)
    base_shape: Annotated[tuple[CapsuleDescription, ...], _SHAPES] = ()
    plane: Annotated[tuple[PlaneDescription, ...], _SHAPES] = ()
    box: Annotated[tuple[BoxDescription, ...], _SHAPES] = ()
    collision_ignore: tuple[tuple[str, str], ...] = ()

    @cached_property
    def chain(self) -> SerialChain:
        """The arm's kinematics."""
        joints = tuple(
            Joint(j.name, j.kind, j.xyz, j.rpy, j.axis, j.lower, j.upper) for j in self.joint
        )
        return SerialChain(joints, self.tip.xyz, self.tip.rpy)

    @cached_property
    def bodies(self) -> Bodies:
        """Masses, as `armsyn.arm.gravity` needs them; InputError for a joint that has none."""
        return bodies_of(self)

    @cached_property
    def leaders(self) -> tuple[ServoDescription, ...]:
        """The servo that each joint is commanded and read by, base to tip."""
        gripper = self.gripper.name if self.gripper is not None else None
        return tuple(s for s in self.servo if s.shadow_of is None and s.joint != gripper)

    @cached_property
    def shadows(self) -> tuple[ServoDescription, ...]:
        """Servos that follow another one's goals."""
        return tuple(servo for servo in self.servo if servo.shadow_of is not None)

    @property
    def gripper_servo(self) -> ServoDescription | None:
        """The gripper's servo."""
        if self.gripper is None or not self.servo:
            return None
        name = self.gripper.name
        return next(s for s in self.servo if s.joint == name and s.shadow_of is None)

    @cached_property
    def calibration(self) -> Calibration:
        """Ticks and radians of the joints' servos."""
        return calibration_of(self.leaders)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, base to tip."""
        return tuple(joint.name for joint in self.joint)

    @property
    def rest(self) -> FloatArray:
        """Rest posture, shape (n,), rad or m."""
        return np.array([joint.rest for joint in self.joint])

    @cached_property
    def max_velocity(self) -> FloatArray:
        """Greatest planned joint speeds, shape (n,), rad/s or m/s."""
        return np.array([joint.max_velocity for joint in self.joint])

    @cached_property
    def max_acceleration(self) -> FloatArray:
        """Greatest planned joint accelerations, shape (n,), rad/s2 or m/s2."""
        return np.array([joint.max_acceleration for joint in self.joint])

    @cached_property
    def max_jerk(self) -> FloatArray:
        """Greatest planned jerks, shape (n,), rad/s3 or m/s3."""
        return np.array(
            [
                joint.max_acceleration / ACCELERATION_TIME
                if joint.max_jerk is None
                else joint.max_jerk
                for joint in self.joint
            ]
        )

    @cached_property
    def solids(self) -> Solids:
        """What the arm and its surroundings fill; InputError when they touch at rest."""
        return Solids(self)

    @property
    def landmarks(self) -> dict[str, str]:
        """The landmarks that follow a person's, and the joints at whose frames they lie."""
        return self.anatomy if self.follows == "landmarks" else dict([*self.anatomy.items()][-1:])

    @cached_property
    def landmark_frames(self) -> tuple[int, ...]:
        """For each landmark its row in ``chain.positions``: a joint's, or n for the tip."""
        rows = {name: row for row, name in enumerate((*self.joint_names, TIP))}
        return tuple(rows[frame] for frame in self.landmarks.values())

    def slowed(self, factor: float) -> ArmDescription:
        """Return the same arm with speed limits divided by a factor, accelerations by its square,
        jerks that are given by its cube.

        Parameters
        ----------
        factor : float
            From 1 to `LARGEST_SLOWING`.

        Returns
        -------
        ArmDescription

        Raises
        ------
        InputError
            Another factor.
        """
        if not 1.0 <= factor <= LARGEST_SLOWING:
            raise InputError(
                f"an arm can be slowed by a factor of at least 1, at most {LARGEST_SLOWING:.0f},"
                f" got {factor:g}"
            )
        joints = tuple(
            msgspec.structs.replace(
                joint,
                max_velocity=joint.max_velocity / factor,
                max_acceleration=joint.max_acceleration / factor**2,
                max_jerk=None if joint.max_jerk is None else joint.max_jerk / factor**3,
            )
            for joint in self.joint
        )
        return msgspec.structs.replace(self, joint=joints)


def load_arm(
    name: str,
    directory: Path | None = None,
    *,
    unit: str | None = None,
    calibrated: bool = True,
) -> ArmDescription:
    """Load an arm's description by its name, with its calibration laid over it.

    Parameters
    ----------
    name : str
        Such as ``human7``.
    directory : Path, optional
        Search only here instead of on the usual path (`armsyn.arm.search`).
    unit : str, optional
        Which of several arms of that kind: its calibration must be there then.
    calibrated : bool
        Whether to lay ``<name>.calibration.json`` over it, where there is one. A simulated arm
        has the description's zeros: False for that.

    Returns
    -------
    ArmDescription

    Raises
    ------
    DescriptionError
        Unknown arm, unreadable file, or a field that is missing, unknown or out of range;
        the message names file and field. A calibration that is another arm's.
    """
    path = find_file(name, ".toml", directory)
    description = parse_arm(_read(path), str(path), path.parent)
    if description.name != path.stem:
        raise DescriptionError(f"{path}: name is {description.name!r}, the file says {path.stem!r}")
    overlay = find_calibration(name, unit, directory) if calibrated else None
    if overlay is None:
        return description
    try:
        description = with_calibration(description, read_calibration(overlay))
        check_description(description)
    except DescriptionError:
        raise
    except InputError as error:
        raise DescriptionError(f"{overlay}: {error}") from error
    return description


def parse_arm(text: str, where: str, folder: Path | None = None) -> ArmDescription:
    """Read a description from TOML text.

    Parameters
    ----------
    text : str
    where : str
        The file, for messages.
    folder : Path, optional
        That holds the URDF, if the text names one.

    Returns
    -------
    ArmDescription

    Raises
    ------
    DescriptionError
        As `load_arm`.
    """
    try:
        document = with_urdf(tomllib.loads(text), folder)
        description = msgspec.convert(document, ArmDescription)
        check_description(description)
    except (ValueError, OverflowError, RecursionError, InputError) as error:
        # Also of numbers with more digits than Python reads
        allowed = allowed_instead(str(error), ArmDescription)
        raise DescriptionError(f"{where}: {' '.join(str(error).split())}{allowed}") from error
    return description


def _read(path: Path) -> str:
    try:
        if path.stat().st_size > MAXIMUM_BYTES:
            raise DescriptionError(f"{path}: larger than {MAXIMUM_BYTES} bytes")
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise DescriptionError(f"{path}: {error}") from error
