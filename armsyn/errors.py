"""The errors of armsyn, each with the exit status its command ends with.

::

    ArmsynError                         never raised itself
    +-- InputError (ValueError)         exit 2: what the user gave
    |   +-- DescriptionError            an arm's description or synergies file
    |   +-- FormatError                 a motion, capture or recording file
    |   +-- CaptureError                captures that learning cannot use
    |   +-- PatternError                motions that no pattern can be learned from
    |   |   +-- SkeletonMismatchError   motions of different skeletons
    |   +-- ConstraintError             what an edit asks for cannot be understood
    +-- ArmFaultError                   exit 3: the arm, the bus, the port
    |   +-- PortError                   no such port, no permission, taken, lost
    |   |   +-- PortLostError
    |   +-- BusError                    what a transaction can end in
    |   |   +-- BusTimeoutError (TimeoutError)
    |   |   |   +-- BusBudgetError      too many answers had to be asked for again
    |   |   +-- ServoStatusError        a servo answered with an error number
    |   +-- BusRateError                a rate the wire cannot carry, or too slow a one
    |   +-- ServoMissingError           an expected ID does not answer
    |   +-- ServoMismatchError          another model, mode or setting than described
    |   +-- HardwareFaultError          alert, shutdown, torque lost, watchdog expired
    |   +-- FollowingError              the arm does not follow its goals
    |   +-- CommandFaultError           a goal that must not be sent, in mid-motion
    |   +-- ServoLoadError              a servo too hot, overloaded or at a wrong voltage
    |   +-- SetpointError               a setpoint function that stalls or gives no posture
    |   +-- TorqueOnError               what only a limp servo takes, for one under torque
    |   +-- NoWatchdogError             servos that a lost host would leave moving
    +-- RefusedMotionError              exit 4: a motion that must not start
    |   +-- UnreachableError            no posture within tolerance of the target
    |   +-- LimitError                  a joint's range, speed, acceleration or jerk
    |   +-- CollisionError              links that would touch each other, a plane or a box
    |   +-- OutsidePatternError         an edit far outside the examples
    +-- StopRequestedError              exit 130: asked to stop before anything moved

Messages are one line: what, where, what to do. The evidence stands in fields beside it.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import ClassVar


def meant(given: str, known: Iterable[str]) -> str:
    """Return "; did you mean 'NAME'?" for the known name nearest to a misspelt one, else ""."""
    import difflib  # noqa: PLC0415 - for what went wrong only

    found = difflib.get_close_matches(given, list(known), n=1)
    return f"; did you mean {found[0]!r}?" if found else ""


class ArmsynError(Exception):
    """Any error that armsyn raises on purpose."""

    exit_status: ClassVar[int] = 1

    def add(self, text: str) -> None:
        """Say more in the error's line, such as what it leaves behind."""
        self.args = (f"{self}; {text}",)


class InputError(ArmsynError, ValueError):
    """Something the user gave is not usable."""

    exit_status = 2


class DescriptionError(InputError):
    """An arm's description, calibration or synergies file is not usable."""


class FormatError(InputError):
    """A motion file cannot be read as what it claims to be."""


class CaptureError(InputError):
    """Captured motions that learning or scoring cannot use."""


class PatternError(InputError):
    """Motions from which no motion pattern can be learned, or a pattern that does not fit."""


class SkeletonMismatchError(PatternError):
    """Motions whose skeletons are not the same.

    Parameters
    ----------
    message : str
        One line.
    clip : str
        The motion that does not fit.
    joint : str
        Where its skeleton differs; empty when it has other joints.
    """

    def __init__(self, message: str, clip: str, joint: str = "") -> None:
        super().__init__(message)
        self.clip = clip
        self.joint = joint


class ConstraintError(InputError):
    """A constraint of an edit that names no body or frame, or has no usable goal."""


class ArmFaultError(ArmsynError):
    """The arm, its bus or its port failed."""

    exit_status = 3


class PortError(ArmFaultError):
    """A serial port that cannot be opened."""


class PortLostError(PortError):
    """A serial port that went away while in use."""


class BusError(ArmFaultError):
    """A transaction on the bus did not succeed."""


class BusTimeoutError(BusError, TimeoutError):
    """A servo did not answer before the transaction's deadline.

    Parameters
    ----------
    message : str
        One line.
    servo_ids : tuple of int
        Who was silent.
    """

    def __init__(self, message: str, servo_ids: tuple[int, ...] = ()) -> None:
        super().__init__(message)
        self.servo_ids = servo_ids


class BusBudgetError(BusTimeoutError):
    """A servo did not answer, and the bus has lost too many answers to ask once more."""


class ServoStatusError(BusError):
    """A servo answered with an error number in its status packet.

    Parameters
    ----------
    message : str
        One line.
    servo_id : int
        Who answered.
    error_number : int
        Bits 0-6 of the status packet's error field (e-Manual, Protocol 2.0, "Error").
    """

    def __init__(self, message: str, servo_id: int, error_number: int) -> None:
        super().__init__(message)
        self.servo_id = servo_id
        self.error_number = error_number


class BusRateError(ArmFaultError):
    """The wire cannot carry the rate that was asked for, or the servos would stop at it.

    Parameters
    ----------
    message : str
        One line with the arithmetic.
    rate_hz : float
        What was asked for.
    cycle_s : float
        What one cycle takes on the wire, s.
    """

    def __init__(self, message: str, rate_hz: float, cycle_s: float) -> None:
        super().__init__(message)
        self.rate_hz = rate_hz
        self.cycle_s = cycle_s


class ServoMissingError(ArmFaultError):
    """Servos of the description do not answer on the bus.

    Parameters
    ----------
    message : str
        One line.
    servo_ids : tuple of int
        Who is missing.
    """

    def __init__(self, message: str, servo_ids: tuple[int, ...]) -> None:
        super().__init__(message)
        self.servo_ids = servo_ids


class ServoMismatchError(ArmFaultError):
    """A servo is not the model, or not set up as, the description says."""


class HardwareFaultError(ArmFaultError):
    """A servo reports a hardware error, lost its torque or its watchdog expired.

    Parameters
    ----------
    message : str
        One line.
    servo_id : int
        Which servo.
    """

    def __init__(self, message: str, servo_id: int) -> None:
        super().__init__(message)
        self.servo_id = servo_id


class FollowingError(ArmFaultError):
    """The measured posture left the commanded one.

    Parameters
    ----------
    message : str
        One line.
    joint : str
        Which joint.
    error_rad : float
        By how much, rad.
    """

    def __init__(self, message: str, joint: str, error_rad: float) -> None:
        super().__init__(message)
        self.joint = joint
        self.error_rad = error_rad


class CommandFaultError(ArmFaultError):
    """A goal that must not be sent came up while the arm was moving.

    Parameters
    ----------
    message : str
        One line.
    joint : str
        Which joint.
    value, limit : float
        What came and what is allowed, in the joint's SI unit.
    """

    def __init__(self, message: str, joint: str, value: float, limit: float) -> None:
        super().__init__(message)
        self.joint = joint
        self.value = value
        self.limit = limit


class ServoLoadError(ArmFaultError):
    """A servo is hotter, takes more current or has another voltage than it may.

    Parameters
    ----------
    message : str
        One line.
    joint : str
        Which joint.
    value, limit : float
        What was measured and what is allowed, in degrees Celsius, A or V.
    """

    def __init__(self, message: str, joint: str, value: float, limit: float) -> None:
        super().__init__(message)
        self.joint = joint
        self.value = value
        self.limit = limit


class TorqueOnError(ArmFaultError):
    """Something that a servo only takes without torque, for one that is under torque.

    Parameters
    ----------
    message : str
        One line.
    servo_id : int
        Which servo.
    """

    def __init__(self, message: str, servo_id: int) -> None:
        super().__init__(message)
        self.servo_id = servo_id


class NoWatchdogError(ArmFaultError):
    """Servos that have no watchdog to stop them, and nobody has accepted that.

    Parameters
    ----------
    message : str
        One line.
    servo_ids : tuple of int
        Which.
    """

    def __init__(self, message: str, servo_ids: tuple[int, ...]) -> None:
        super().__init__(message)
        self.servo_ids = servo_ids


class SetpointError(ArmFaultError):
    """A setpoint function of the caller's stalled, or gave something that is no posture."""


class RefusedMotionError(ArmsynError):
    """A motion that is refused before anything moves."""

    exit_status = 4


class UnreachableError(RefusedMotionError):
    """A target that the arm cannot reach within tolerance.

    Parameters
    ----------
    message : str
        One line.
    miss_m : float
        How far from the target the best attempt ended, m.
    """

    def __init__(self, message: str, miss_m: float) -> None:
        super().__init__(message)
        self.miss_m = miss_m


class LimitError(RefusedMotionError):
    """A joint would leave its range, or exceed its speed, acceleration or jerk.

    Parameters
    ----------
    message : str
        One line.
    joint : str
        Which joint.
    value, limit : float
        What came and what is allowed, in the joint's SI unit.
    """

    def __init__(self, message: str, joint: str, value: float, limit: float) -> None:
        super().__init__(message)
        self.joint = joint
        self.value = value
        self.limit = limit


class CollisionError(RefusedMotionError):
    """Two parts of the arm, or a part and something around it, would touch.

    Parameters
    ----------
    message : str
        One line.
    first, second : str
        Who: a link by its joint's name, ``base``, or a plane's or box's name.
    frame : int
        Row of the path at or before which they first do.
    depth : float
        How deep into each other they would get, m; negative where they only come too near.
    """

    def __init__(self, message: str, first: str, second: str, frame: int, depth: float) -> None:
        super().__init__(message)
        self.first = first
        self.second = second
        self.frame = frame
        self.depth = depth


class OutsidePatternError(RefusedMotionError):
    """An edit that leaves the examples of its pattern further behind than is allowed.

    Parameters
    ----------
    message : str
        One line.
    coefficient, bound : float
        The largest whitened coefficient and what is allowed, in standard deviations of the
        examples.
    """

    def __init__(self, message: str, coefficient: float, bound: float) -> None:
        super().__init__(message)
        self.coefficient = coefficient
        self.bound = bound


class StopRequestedError(ArmsynError):
    """A stop was asked for before anything moved."""

    exit_status = 130


def by_interrupt(error: BaseException) -> bool:
    """Whether an error is an interrupt, or what compiled code made of one that struck in it.

    Parameters
    ----------
    error : BaseException
        C code that returns although a signal's handler has raised ends in a SystemError of that.

    Returns
    -------
    bool
    """
    cause: BaseException | None = error
    while isinstance(cause, SystemError):
        cause = cause.__cause__
    return isinstance(cause, KeyboardInterrupt)
