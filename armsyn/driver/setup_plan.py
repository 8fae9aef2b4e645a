"""What a servo's settings should be for an arm, and how they differ from what was found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from armsyn.arm import ArmDescription, ServoDescription
from armsyn.driver import registers as reg
from armsyn.driver.checks import LARGEST_HOMING_OFFSET
from armsyn.driver.eeprom import PLACE, STATUS_RETURN_LEVEL, EepromImage, row_of
from armsyn.driver.models import ServoModel, a_model
from armsyn.errors import DescriptionError

X_BAUD_CODES = {
    9_600: 0,
    57_600: 1,
    115_200: 2,
    1_000_000: 3,
    2_000_000: 4,
    3_000_000: 5,
    4_000_000: 6,
    4_500_000: 7,
}
"""e-Manual, "Baud Rate(8)"; XL-320 knows the first four."""

_MX1_BAUD_CODES = {2_250_000: 250, 2_500_000: 251, 3_000_000: 252}
_CLASSIC_CLOCK = 2_000_000
_BAUD_TOLERANCE = 0.03

_NOBODY = 255
_TORQUE_AT_START = 0b1
_FORBIDDEN_MODES = reg.DRIVE_MODE_SLAVE | reg.DRIVE_MODE_TORQUE_BY_GOAL


@dataclass(frozen=True)
class Change:
    """A register that is to be written.

    Attributes
    ----------
    register : reg.Register
    found, wanted : int
        In its own unit.
    """

    register: reg.Register
    found: int
    wanted: int

    @property
    def name(self) -> str:
        """The register's name."""
        return self.register.name


def baud_code(model: ServoModel, baud: int) -> int:
    """Value of a model's Baud Rate register.

    Parameters
    ----------
    model : ServoModel
    baud : int
        Bits a second.

    Raises
    ------
    DescriptionError
        A rate that the model does not have.
    """
    if model.layout in (reg.X, reg.XL320):
        code = X_BAUD_CODES.get(baud)
        if code is not None and (model.layout is reg.X or code <= X_BAUD_CODES[1_000_000]):
            return code
    else:
        if model.layout is reg.MX1 and baud in _MX1_BAUD_CODES:
            return _MX1_BAUD_CODES[baud]
        code = round(_CLASSIC_CLOCK / baud) - 1  # e-Manual, AX-12A, "Baud Rate(4)"
        if 1 <= code <= 207 and abs(_CLASSIC_CLOCK / (code + 1) - baud) <= _BAUD_TOLERANCE * baud:
            return code
    raise DescriptionError(f"{a_model(model.name)} has no baud rate of {baud} bit/s")


def wanted_settings(
    arm: ArmDescription, servo: ServoDescription, image: EepromImage
) -> dict[str, int]:
    """Registers as they should be, settings first, then what says how the servo is reached.

    Return Delay Time as described; Status Return Level 2; Torque On by Goal Update and the cable
    slave off; torque at start off; counting direction as described (bit 2 of Drive Mode, the
    time-based profile, stays as it is: the driver writes profiles for either); position mode,
    for a gripper that grips with a current the current-based one; a shadow's Secondary ID is its
    leader's, nobody else has one; a Homing Offset that position mode would ignore is 0; joint mode
    of servos that know it by their angle limits. All else stays as it is.

    Parameters
    ----------
    arm : ArmDescription
    servo : ServoDescription
        Of that arm.
    image : EepromImage
        As found; of the model described.

    Returns
    -------
    dict of str to int
        By register.

    Raises
    ------
    DescriptionError
        A baud rate that the model does not have.
    """
    model, found = image.model, image.registers
    wanted = {
        "Return Delay Time": servo.return_delay_us // 2,
        STATUS_RETURN_LEVEL: 2,
    }
    if model.layout is reg.X:
        wanted |= _x_settings(arm, servo, image)
    elif model.layout is reg.XL320:
        wanted["Operating Mode"] = reg.XL320_JOINT_MODE
    else:
        wanted |= _joint_mode(model, found)
    wanted["ID"] = servo.id
    if model.layout is reg.X:
        wanted["Protocol Type"] = servo.protocol
    wanted["Baud Rate"] = baud_code(model, servo.baud)
    return wanted


def _x_settings(arm: ArmDescription, servo: ServoDescription, image: EepromImage) -> dict[str, int]:
    found = image.registers
    mode = _mode(arm, servo, image.model)
    wanted = {"Operating Mode": mode}
    if found["Firmware Version"] >= row_of(reg.X, "Drive Mode").since:
        kept = found["Drive Mode"] & ~_FORBIDDEN_MODES & ~reg.DRIVE_MODE_REVERSE
        wanted["Drive Mode"] = kept | (servo.drive_mode & reg.DRIVE_MODE_REVERSE)
    wanted["Secondary ID"] = _NOBODY if servo.shadow_of is None else servo.shadow_of
    if servo.shadow_of is None and found["Secondary ID"] >= reg.NO_SECONDARY_ID:
        wanted["Secondary ID"] = found["Secondary ID"]
    if mode == reg.POSITION_MODE and abs(found["Homing Offset"]) > LARGEST_HOMING_OFFSET:
        wanted["Homing Offset"] = 0
    wanted["Startup Configuration"] = found["Startup Configuration"] & ~_TORQUE_AT_START
    return wanted


def _mode(arm: ArmDescription, servo: ServoDescription, model: ServoModel) -> int:
    gripper = arm.gripper
    grips = gripper is not None and servo.joint == gripper.name
    if grips and gripper is not None and gripper.max_current and model.current_unit is not None:
        return reg.CURRENT_POSITION_MODE
    return reg.POSITION_MODE


def _joint_mode(model: ServoModel, found: Mapping[str, int]) -> dict[str, int]:
    """Angle limits for servos that take them as wheel mode (both 0) or several turns (equal)."""
    low, high = found["Min Position Limit"], found["Max Position Limit"]
    if low != high:
        return {}
    last = 1023 if model.layout is reg.AX else 4095
    return {"Min Position Limit": 0, "Max Position Limit": last}


def changes_of(image: EepromImage, wanted: Mapping[str, int]) -> tuple[Change, ...]:
    """Registers that differ, in the order of `wanted`."""
    layout, found = image.model.layout, image.registers
    return tuple(
        Change(row_of(layout, name), found[name], value)
        for name, value in wanted.items()
        if found[name] != value
    )


def place_last(changes: tuple[Change, ...]) -> tuple[Change, ...]:
    """Return the changes with those that say how the servo is reached at the end."""
    settings = tuple(change for change in changes if change.name not in PLACE)
    places = {change.name: change for change in changes if change.name in PLACE}
    return (*settings, *(places[name] for name in PLACE if name in places))
