"""Setpoints from a function of the caller's instead of from a trajectory: the course they make."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.arm import ArmDescription
from armsyn.driver.course import Coast
from armsyn.driver.joints import JointState
from armsyn.driver.path import BLEND, PathTime, minimum_jerk
from armsyn.driver.setpoint_thread import SetpointThread
from armsyn.errors import InputError, LimitError, SetpointError
from armsyn.safety import START_TOLERANCE, CommandLimits

FloatArray = NDArray[np.float64]


class SetpointCourse:
    """A course along what a setpoint function says.

    It begins, and goes on after a stall, from where the goals stand: the setpoints take over
    within 0.25 s.

    Parameters
    ----------
    thread : SetpointThread
    start : array, shape (n,)
        Where the goals stand, rad.
    arm : ArmDescription
    limits : CommandLimits
        That it comes to rest within; of the stream, as its period is.
    longest : float
        Seconds after which it comes to rest.
    """

    stopping = False

    def __init__(
        self,
        thread: SetpointThread,
        start: FloatArray,
        arm: ArmDescription,
        limits: CommandLimits,
        longest: float,
    ) -> None:
        self.duration = longest
        self._thread = thread
        self._arm = arm
        self._limits = limits
        self._period = limits.period
        self._time = PathTime()
        self._before = self._last = start
        self._held, self._since = start, 0.0
        self._coast: Coast | None = None
        self._coasted = 0.0

    @property
    def now(self) -> float:
        """Path time, s."""
        return self._time.now

    @property
    def finished(self) -> bool:
        """Whether it has come to rest."""
        return self._coast is not None and self._coasted >= self._coast.duration

    def advance(self, state: JointState | None) -> FloatArray:
        """Posture of the next tick, shape (n,), rad."""
        wanted = None
        if self._coast is None:
            wanted = self._next(state)
        if wanted is None:
            wanted = self._next_at_rest()
        self._before, self._last = self._last, wanted
        return wanted

    def _next(self, state: JointState | None) -> FloatArray | None:
        t = self._time.advance(self._period)
        if t > self.duration:
            return None
        seen = self.at_rest(self._last) if state is None else own_copy(state)
        answer = self._thread.ask(t, seen)
        if answer is None:
            return None
        wanted = checked_setpoint(answer, t, self._arm)
        self._since += self._period
        if self._since >= BLEND:
            return wanted
        return np.asarray(self._held + minimum_jerk(self._since / BLEND) * (wanted - self._held))

    def _next_at_rest(self) -> FloatArray:
        if self._coast is None:
            limits, velocity = self._limits, (self._last - self._before) / self._period
            self._coast = Coast(
                self._last, velocity, self._arm.max_acceleration, limits.lower, limits.upper
            )
        self._coasted += self._period
        return self._coast.at(self._coasted)

    def stop(self) -> None:
        """Ask no more, and come to rest."""
        self.stopping = True
        if self._coast is None:
            self.duration = self._time.now

    def resume_from_rest(self) -> None:
        """Go on from where the goals stand."""
        self._before = self._held = self._last
        self._since = 0.0
        if self._coast is None:
            self._time.resume_from_rest(BLEND)
        else:
            self._coast = None
            self._next_at_rest()

    def halt(self) -> None:
        """Stay where the goals stand."""
        self.stop()
        self._before, self._coast = self._last, None
        self._next_at_rest()

    @staticmethod
    def at_rest(posture: FloatArray) -> JointState:
        """State of an arm that stands in a posture, as far as it is known."""
        n = posture.size
        return JointState(
            position=posture.copy(),
            velocity=np.zeros(n),
            current=np.full(n, np.nan),
            fresh=np.ones(n, dtype=np.bool_),
            alert=np.zeros(n, dtype=np.bool_),
        )


def own_copy(state: JointState) -> JointState:
    """A state whose arrays nobody uses again."""
    return JointState(**{name: part.copy() for name, part in state._asdict().items()})


def checked_setpoint(answer: ArrayLike, t: float, arm: ArmDescription) -> FloatArray:
    """A setpoint as an array; what it says is judged as any command is.

    Raises
    ------
    SetpointError
        Not n numbers.
    """
    try:
        wanted = np.array(answer, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise SetpointError(f"the setpoint at {t:.3f} s is no posture: {error}") from error
    if wanted.shape != arm.rest.shape:
        raise SetpointError(
            f"the setpoint at {t:.3f} s has the shape {wanted.shape}; {arm.name} has"
            f" {arm.rest.size} joints: give one angle each, rad"
        )
    return wanted


def check_longest(longest: float) -> None:
    """Refuse a duration that is none; InputError."""
    if not (np.isfinite(longest) and longest > 0.0):
        raise InputError(f"the longest duration must be a positive number of seconds: {longest}")


@dataclass(frozen=True)
class SetpointMotion:
    """A motion that a setpoint function makes as it goes.

    Parameters
    ----------
    thread : SetpointThread
        Running.
    duration : float
        Seconds after which it comes to rest, unless it is finished earlier.
    recorded : float
        Seconds that are to be recorded.
    first : array, shape (n,), optional
        The setpoint that it starts from, rad; `check` asks for it.
    """

    thread: SetpointThread
    duration: float
    recorded: float
    first: FloatArray | None = None

    def course(
        self, start: FloatArray, arm: ArmDescription, limits: CommandLimits
    ) -> SetpointCourse:
        """Course from where the goals stand, shape (n,), rad."""
        return SetpointCourse(self.thread, start, arm, limits, self.duration)

    def check(self, present: FloatArray, arm: ArmDescription) -> SetpointMotion:
        """Refuse a function whose first setpoint is not where the arm is.

        Parameters
        ----------
        present : array, shape (n,)
            rad.
        arm : ArmDescription

        Returns
        -------
        SetpointMotion
            The same, with its first setpoint.

        Raises
        ------
        LimitError, InputError
            More than `armsyn.safety.START_TOLERANCE` away; no numbers, or finished already.
        SetpointError
            No posture, or none in time.
        """
        answer = self.thread.ask(0.0, SetpointCourse.at_rest(present))
        if answer is None:
            raise InputError("the setpoint function is finished before it begins")
        first = checked_setpoint(answer, 0.0, arm)
        away = np.abs(first - present)
        if not np.isfinite(first).all():
            raise InputError(f"the first setpoint is not finite: {first}")
        joint = int(np.argmax(away))
        if away[joint] > START_TOLERANCE:
            name = arm.joint_names[joint]
            raise LimitError(
                f"joint {name} is at {present[joint]:.3f} rad but the setpoints start at"
                f" {first[joint]:.3f} rad, more than {START_TOLERANCE:g} rad away: start where"
                " the arm is",
                name,
                float(away[joint]),
                START_TOLERANCE,
            )
        return replace(self, first=first)
