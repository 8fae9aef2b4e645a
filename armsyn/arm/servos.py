"""The servos of an arm's description: what moves its joints, shares their load, and grips."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, cast

import msgspec
import numpy as np

from armsyn.arm.calibration import Calibration, radians_per_tick
from armsyn.arm.link import Positive
from armsyn.errors import InputError

if TYPE_CHECKING:
    from armsyn.arm.description import ArmDescription

Tick = Annotated[int, msgspec.Meta(ge=-(2**31), lt=2**31)]
ServoId = Annotated[int, msgspec.Meta(ge=0, le=252)]

_PROTOCOL_1_ONLY = ("ax-",)
"""How the models begin that speak Protocol 1.0 only."""


class ServoDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A ``[[servo]]`` table: one servo, the joint it moves and how it is set up.

    Attributes
    ----------
    joint : str
        Or the gripper's name.
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
    shadow_of : int or None
        ID of the servo on the same joint whose goals this one follows: its Secondary ID
        (register 12). It is read by its own ID.
    protocol : {1, 2}
        That it speaks.
    baud : int
        Bits a second.
    return_delay_us : int
        Return delay time, us, even.
    drive_mode : int
        Drive mode register. The driver refuses a servo whose bit 0 (reverse) differs, or whose
        bits 1 (dual-joint slave) or 3 (torque on by a goal) are set; bit 2 (time-based profile)
        may differ, as it only says what the profile registers mean. A simulated servo takes all
        of it.
    """

    joint: str
    id: ServoId
    model: str
    zero_tick: Tick
    rest_tick: Tick
    supply_voltage: Positive
    direction: Literal[1, -1] = 1
    shadow_of: ServoId | None = None
    protocol: Literal[1, 2] = 2
    baud: Annotated[int, msgspec.Meta(gt=0)] = 1_000_000
    return_delay_us: Annotated[int, msgspec.Meta(ge=0, le=508, multiple_of=2)] = 0
    drive_mode: Annotated[int, msgspec.Meta(ge=0, le=255)] = 0


class GripperDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The ``[gripper]`` table: what the servo whose ``joint`` is its name opens and closes.

    Attributes
    ----------
    open, closed : float
        Angles of its servo, rad: ticks become angles as of any joint.
    width_open, width_closed : float
        Between the fingers there, m; in between taken as linear in the angle.
    name : str
    rest : float or None
        Angle at rest; None for `open`.
    max_velocity : float
        rad/s.
    max_current : float or None
        That it may grip with, A; None where its servo does not control its current.
    """

    open: float
    closed: float
    width_open: Annotated[float, msgspec.Meta(ge=0)]
    width_closed: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    name: str = "gripper"
    rest: float | None = None
    max_velocity: Positive = 2.0
    max_current: Positive | None = None

    @property
    def rest_angle(self) -> float:
        """Angle at rest, rad."""
        return self.open if self.rest is None else self.rest


def calibration_of(servos: tuple[ServoDescription, ...]) -> Calibration:
    """Ticks and radians of some servos, in their order."""
    return Calibration(
        zero_tick=np.array([servo.zero_tick for servo in servos], dtype=np.int64),
        direction=np.array([servo.direction for servo in servos], dtype=np.int64),
        radians_per_tick=np.array([radians_per_tick(servo.model) for servo in servos]),
    )


def check_servos(arm: ArmDescription) -> None:
    """Refuse servos that do not make up the arm.

    Raises
    ------
    InputError
        An ID given twice, a joint without its servo, or a servo without its joint; several
        baud rates on one bus; a shadow of nobody; a resting place that is not the joint's.
    """
    ids = [servo.id for servo in arm.servo]
    twice = sorted({i for i in ids if ids.count(i) > 1})
    if twice:
        raise InputError(f"servo ID {twice[0]} is given twice; every servo needs its own")
    joints = tuple(servo.joint for servo in arm.leaders)
    if joints != arm.joint_names:
        raise InputError(f"servos move {joints}, the joints are {arm.joint_names}: one each")
    if len({servo.baud for servo in arm.servo}) > 1:
        raise InputError("servos of one bus must share one baud rate")
    for joint in arm.joint:
        if joint.kind != "revolute":
            raise InputError(f"joint {joint.name}: only revolute joints can have a servo")
    _check_gripper(arm)
    leading = {servo.id: servo for servo in arm.servo if servo.shadow_of is None}
    for servo in arm.servo:
        _check_protocol(servo)
        if servo.shadow_of is not None:
            _check_shadow(servo, leading.get(servo.shadow_of))
    _check_rest(arm)


def _check_gripper(arm: ArmDescription) -> None:
    gripper = arm.gripper
    if gripper is None:
        return
    if gripper.name in arm.joint_names:
        raise InputError(f"gripper: {gripper.name!r} is a joint's name already")
    if gripper.open == gripper.closed:
        raise InputError("gripper: open and closed are the same angle")
    low, high = sorted((gripper.open, gripper.closed))
    if not low <= gripper.rest_angle <= high:
        raise InputError(
            f"gripper: rest {gripper.rest_angle:g} is neither open, closed nor between"
        )
    if sum(s.joint == gripper.name and s.shadow_of is None for s in arm.servo) != 1:
        raise InputError(f"gripper: needs one servo whose joint is {gripper.name!r}")


def _check_protocol(servo: ServoDescription) -> None:
    if servo.model.startswith(_PROTOCOL_1_ONLY) and servo.protocol != 1:
        raise InputError(f"servo {servo.id}: {servo.model} speaks protocol 1 only: protocol = 1")


def _check_shadow(servo: ServoDescription, leader: ServoDescription | None) -> None:
    if leader is None:
        raise InputError(
            f"servo {servo.id}: shadow_of {servo.shadow_of} is no servo, or a shadow itself"
        )
    if leader.joint != servo.joint:
        raise InputError(
            f"servo {servo.id} moves {servo.joint}, and servo {leader.id}, whose shadow it is,"
            f" {leader.joint}"
        )
    if (leader.model, leader.protocol) != (servo.model, servo.protocol) or servo.protocol != 2:
        raise InputError(
            f"servo {servo.id}: it and servo {leader.id}, whose shadow it is, must be the same"
            " model and speak protocol 2"
        )


def _check_rest(arm: ArmDescription) -> None:
    rest = dict(zip(arm.joint_names, arm.rest.tolist(), strict=True))
    if arm.gripper is not None:
        rest[arm.gripper.name] = arm.gripper.rest_angle
    angles = [rest[servo.joint] for servo in arm.servo]
    ticks = cast("list[int]", calibration_of(arm.servo).to_ticks(angles).tolist())
    for servo, tick in zip(arm.servo, ticks, strict=True):
        if abs(servo.rest_tick - tick) > 1:
            raise InputError(
                f"servo {servo.id}: rest_tick {servo.rest_tick} is not the joint's rest ({tick})"
            )
