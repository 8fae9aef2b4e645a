"""What the driver must know of each servo model (e-Manual, "Control Table" of its page)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from armsyn.arm import ArmDescription
from armsyn.driver.registers import AX, MX1, XL320, Layout, X
from armsyn.errors import DescriptionError

VELOCITY_UNIT = 0.229 * 2.0 * math.pi / 60.0
"""rad/s of one unit of the X series' velocity registers (0.229 rev/min)."""

_MX1_VELOCITY_UNIT = 0.114 * 2.0 * math.pi / 60.0
_AX_VELOCITY_UNIT = 0.111 * 2.0 * math.pi / 60.0

FAST_FIRMWARE_X430 = 45
FAST_FIRMWARE_X330 = 46


@dataclass(frozen=True)
class ServoModel:
    """What the driver must know of a model.

    Parameters
    ----------
    name : str
        The maker's name in lower case.
    number : int
        What Model Number reads.
    protocol : {1, 2}
        That this table is of.
    layout : Layout
        Its control table.
    current_unit : float or None
        Amperes of one unit of Present Current; None where the servo reports load instead.
    velocity_unit : float
        rad/s of one unit of Present Velocity.
    fast_firmware : int or None
        Firmware from which on it answers fast reads; None where none does.
    """

    name: str
    number: int
    protocol: Literal[1, 2]
    layout: Layout
    current_unit: float | None
    velocity_unit: float = VELOCITY_UNIT
    fast_firmware: int | None = FAST_FIRMWARE_X430


def _x(name: str, number: int, current_unit: float | None) -> ServoModel:
    fast = FAST_FIRMWARE_X330 if "330" in name else FAST_FIRMWARE_X430
    twin = name.startswith("2x")
    return ServoModel(name, number, 2, X, current_unit, fast_firmware=None if twin else fast)


_MODELS = (
    _x("xm430-w350", 1020, 2.69e-3),
    _x("xm430-w210", 1030, 2.69e-3),
    _x("xl430-w250", 1060, None),
    _x("xc430-w150", 1070, None),
    _x("xc430-w240", 1080, None),
    _x("2xl430-w250", 1090, None),
    _x("2xc430-w250", 1160, None),
    _x("xh430-w350", 1000, 2.69e-3),
    _x("xh430-w210", 1010, 2.69e-3),
    _x("xh430-v350", 1040, 1.34e-3),
    _x("xh430-v210", 1050, 1.34e-3),
    _x("xh540-w270", 1100, 2.69e-3),
    _x("xh540-w150", 1110, 2.69e-3),
    _x("xh540-v270", 1140, 2.69e-3),
    _x("xh540-v150", 1150, 2.69e-3),
    _x("xd430-t350", 1001, 2.69e-3),
    _x("xd430-t210", 1011, 2.69e-3),
    _x("xd540-t270", 1101, 2.69e-3),
    _x("xd540-t150", 1111, 2.69e-3),
    _x("xw430-t333", 1270, 2.69e-3),
    _x("xw430-t200", 1280, 2.69e-3),
    _x("xw540-t260", 1170, 2.69e-3),
    _x("xw540-t140", 1180, 2.69e-3),
    _x("xm540-w270", 1120, 2.69e-3),
    _x("xm540-w150", 1130, 2.69e-3),
    _x("xl330-m077", 1190, 1e-3),
    _x("xl330-m288", 1200, 1e-3),
    _x("xc330-t181", 1210, 1e-3),
    _x("xc330-t288", 1220, 1e-3),
    _x("xc330-m181", 1230, 1e-3),
    _x("xc330-m288", 1240, 1e-3),
    ServoModel("mx-28", 30, 2, X, None, fast_firmware=None),
    ServoModel("mx-64", 311, 2, X, 3.36e-3, fast_firmware=None),
    ServoModel("mx-106", 321, 2, X, 3.36e-3, fast_firmware=None),
    ServoModel("mx-28", 29, 1, MX1, None, _MX1_VELOCITY_UNIT, None),
    ServoModel("mx-64", 310, 1, MX1, None, _MX1_VELOCITY_UNIT, None),
    ServoModel("mx-106", 320, 1, MX1, None, _MX1_VELOCITY_UNIT, None),
    ServoModel("ax-12a", 12, 1, AX, None, _AX_VELOCITY_UNIT, None),
    ServoModel("ax-18a", 18, 1, AX, None, _AX_VELOCITY_UNIT, None),
    ServoModel("xl-320", 350, 2, XL320, None, _AX_VELOCITY_UNIT, None),
)

MODELS = {(model.name, model.protocol): model for model in _MODELS}
"""Models by name and protocol (numbers: e-Manual, Model Number; units: e-Manual, Present Current,
Present Velocity)."""

_BY_NUMBER = {model.number: model for model in _MODELS}


def servo_model(name: str, protocol: int = 2) -> ServoModel:
    """Facts of a model.

    Parameters
    ----------
    name : str
        Such as ``xm430-w350``.
    protocol : {1, 2}

    Returns
    -------
    ServoModel

    Raises
    ------
    DescriptionError
        A model this driver does not know, or not in that protocol.
    """
    try:
        return MODELS[name, protocol]  # type: ignore[index]
    except KeyError:
        pass
    known = ", ".join(sorted({model for model, _ in MODELS}))
    if any(model == name for model, _ in MODELS):
        raise DescriptionError(f"servo model {name!r} does not speak protocol {protocol}")
    raise DescriptionError(f"servo model {name!r} is not one the driver knows: {known}")


def check_known(arm: ArmDescription) -> None:
    """Refuse an arm without servos, or with models the driver does not know; DescriptionError."""
    if not arm.servo:
        raise DescriptionError(f"{arm.name} has no servos: it is a model only")
    for servo in arm.servo:
        servo_model(servo.model, servo.protocol)


def find_number(number: int) -> ServoModel | None:
    """Facts of the model with a model number; None for one that the driver does not know."""
    return _BY_NUMBER.get(number)


_NUMBERED = "model number"


def model_name(number: int) -> str:
    """Name of a model number, for messages: ``model number 17`` when unknown."""
    model = find_number(number)
    return model.name if model is not None else f"{_NUMBERED} {number}"


def a_model(name: str) -> str:
    """Return a model's name with its article, for messages: ``an xm430-w350``, ``an ax-12a``."""
    if name == "unknown":
        return "an unknown model"
    if name.startswith(_NUMBERED):
        return name
    return f"an {name}" if name.startswith(("a", "m", "x")) else f"a {name}"  # spelled out
