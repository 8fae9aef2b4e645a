"""The numbers of the protocol and the firmware that have names.

Sources: e-Manual, Protocol 2.0, "Error" and "Clear"; Protocol 1.0, "Error"; X-series pages,
"Hardware Error Status(70)", "Operating Mode(11)", "Drive Mode(10)" and "Startup
Configuration(60)".
"""

from __future__ import annotations

from enum import IntEnum, IntFlag

ALERT = 0x80
"""Bit of a status packet's error field that says: look at Hardware Error Status(70)."""

REVERSE_MODE = 0x01
"""Bit of Drive Mode(10): position, velocity, current and PWM count clockwise."""

SLAVE_MODE = 0x02
"""Bit of Drive Mode(10): led by another servo's PWM through a cable."""

TIME_BASED_PROFILE = 0x04
"""Bit of Drive Mode(10): the profile registers hold milliseconds."""

TORQUE_ON_BY_GOAL = 0x08
"""Bit of Drive Mode(10): a goal switches the torque on."""

STARTUP_TORQUE_ON = 0x01
"""Bit of Startup Configuration(60): the torque is on after a boot."""

STARTUP_RAM_RESTORE = 0x02
"""Bit of Startup Configuration(60): a boot takes RAM registers from the backup."""

CLEAR_MULTI_TURN = bytes((0x01, 0x44, 0x58, 0x4C, 0x22))
"""Parameters of the instruction clear that reset the turns of Present Position."""

WATCHDOG_EXPIRED = 0xFF
"""What Bus Watchdog(98) reads after it expired: -1."""

MAX_ID = 252
"""Highest ID of a servo of protocol 2.0; a higher secondary ID means none."""


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


class ErrorBit(IntFlag):
    """Bits of protocol 1.0's error byte, and of Alarm LED(17) and Shutdown(18) of its servos.

    Input voltage, overheating and overload speak of the servo, the others of the instruction.
    """

    INPUT_VOLTAGE = 0x01
    ANGLE_LIMIT = 0x02
    OVERHEATING = 0x04
    RANGE = 0x08
    CHECKSUM = 0x10
    OVERLOAD = 0x20
    INSTRUCTION = 0x40


class OperatingMode(IntEnum):
    """Values of Operating Mode(11)."""

    CURRENT = 0
    VELOCITY = 1
    POSITION = 3
    EXTENDED_POSITION = 4
    CURRENT_BASED_POSITION = 5
    PWM = 16


POSITION_MODES = frozenset(
    (OperatingMode.POSITION, OperatingMode.EXTENDED_POSITION, OperatingMode.CURRENT_BASED_POSITION)
)
"""Modes that Goal Position(116) leads."""

CURRENT_MODES = frozenset((OperatingMode.CURRENT, OperatingMode.CURRENT_BASED_POSITION))
"""Modes in which the current is controlled, and capped."""
