"""The numbers of the protocol and the firmware that have names.

Sources: e-Manual, Protocol 2.0, "Error"; X-series pages, "Hardware Error Status(70)", "Operating
Mode(11)" and "Drive Mode(10)".
"""

from __future__ import annotations

from enum import IntEnum

ALERT = 0x80
"""Bit of a status packet's error field that says: look at Hardware Error Status(70)."""

REVERSE_MODE = 0x01
"""Bit of Drive Mode(10): position, velocity, current and PWM count clockwise."""

TIME_BASED_PROFILE = 0x04
"""Bit of Drive Mode(10): the profile registers hold milliseconds."""

TORQUE_ON_BY_GOAL = 0x08
"""Bit of Drive Mode(10): a goal switches the torque on."""


class StatusError(IntEnum):
    """Error numbers of a status packet."""

    NONE = 0x00
    RESULT_FAIL = 0x01
    INSTRUCTION = 0x02
    CRC = 0x03
    DATA_RANGE = 0x04
    DATA_LENGTH = 0x05
    DATA_LIMIT = 0x06
    ACCESS = 0x07


class HardwareError(IntEnum):
    """Bits of Hardware Error Status(70) and Shutdown(63)."""

    INPUT_VOLTAGE = 0x01
    OVERHEATING = 0x04
    MOTOR_ENCODER = 0x08
    ELECTRICAL_SHOCK = 0x10
    OVERLOAD = 0x20


class OperatingMode(IntEnum):
    """The modelled values of Operating Mode(11)."""

    POSITION = 3
    EXTENDED_POSITION = 4
