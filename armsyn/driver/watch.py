"""Judging what the arm answers while it is streamed to: silence, losses, faults."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ServoDescription
from armsyn.driver.checks import PAIR_TOLERANCE_TICKS, cure_of_error
from armsyn.driver.joints import Health, JointState
from armsyn.driver.registers import WATCHDOG_EXPIRED, hardware_error_names
from armsyn.driver.servos import title_of
from armsyn.errors import ArmsynError, BusError, BusTimeoutError, HardwareFaultError
from armsyn.safety import CommandLimits

FloatArray = NDArray[np.float64]

SUCCESS_WINDOW = 100
"""Commands over which the success rate is taken, as libfranka's control_command_success_rate."""

LOWEST_SUCCESS = 0.5
"""Success rate of a full window below which the stream gives up."""

LONGEST_SILENCE = 0.2
"""Seconds without a reply after which a servo counts as silent: an error budget, not one strike."""

FEWEST_UNANSWERED = 3
"""Reads in a row, and so periods, that must have brought no reply then: at slow rates, or after a
stall, one lost reply is no silence."""

MISSED_ROUNDS = 3
"""Rounds of slow checks without a reply after which a servo that nothing else is read of, such as
a shadow or a gripper, counts as silent."""

SETTLED_ERROR = 0.005
SETTLED_SPEED = 0.03
"""rad and rad/s within which the arm has arrived."""

APART_TICKS = 5 * PAIR_TOLERANCE_TICKS
"""How far the servos of a dual joint may read apart while it moves (8.8 degrees): they are read
one after the other."""

_STOPPED = "was stopped by its bus watchdog: it heard nothing for too long; check its cable"
_SWITCHED_OFF = (
    "has lost its torque, without a hardware error: it restarted (check its power) or another"
    " program switched it off"
)
_RESTARTED = "restarted (its RAM is as at power-on): check its power; the next run writes all anew"

SPEED_MEMORY = 0.2
"""Seconds in which the goal's speed fades from what following errors are judged by."""


@dataclass(frozen=True)
class WatchSettings:
    """What an arm is judged by.

    Attributes
    ----------
    period : float
        Of the ticks, s.
    limits : CommandLimits
    servos : tuple of ServoDescription
        All that are watched, as `armsyn.driver.joints.watched_servos` has them: one a joint
        first.
    limp : frozenset of int
        IDs of servos that need no torque: a gripper that had none.
    limited : frozenset of int
        IDs of servos of older families whose Moving Speed was set: it reads 0 after a restart.
    polls : int
        Slow checks in a round that asks every servo; 0 to judge no silence by them.
    """

    period: float
    limits: CommandLimits
    servos: tuple[ServoDescription, ...]
    limp: frozenset[int] = frozenset()
    limited: frozenset[int] = frozenset()
    polls: int = 0


class ArmWatch:
    """Remembers what the servos answered and finds the fault in it.

    Parameters
    ----------
    settings : WatchSettings
    now : float
        s.

    Attributes
    ----------
    hardware_error : array of uint8, shape (n,)
        Hardware Error Status of each joint's servo, as far as it was read.
    settled_ticks : int
        Ticks in a row in which the whole arm was at its goals and at rest.
    speed : array, shape (n,)
        Of the goals, of late, rad/s: what their following errors are judged by.
    """

    def __init__(self, settings: WatchSettings, now: float) -> None:
        n = len(settings.limits.names)
        self.settings = settings
        self.hardware_error = np.zeros(n, dtype=np.uint8)
        self.settled_ticks = 0
        self._successes: deque[bool] = deque(maxlen=SUCCESS_WINDOW)
        self.speed = np.zeros(n)
        self._heard = np.full(n, now)
        self._unanswered = np.zeros(n, dtype=np.int64)
        self._unheard = np.zeros(len(settings.servos), dtype=np.int64)

    @property
    def success_rate(self) -> float:
        """Part of the last 100 commands that went out in time and were answered by all servos."""
        return sum(self._successes) / max(1, len(self._successes))

    def missed(self, ticks: int) -> None:
        """Count ticks at which no command was sent."""
        self._successes.extend([False] * min(ticks, SUCCESS_WINDOW))

    def update(
        self, now: float, before: FloatArray, command: FloatArray, state: JointState
    ) -> None:
        """Take in what the servos answered to a command.

        Parameters
        ----------
        now : float
            s.
        before, command : array, shape (n,)
            The command before this one, and this one, rad.
        state : JointState
        """
        period = self.settings.period
        faded = self.speed * (1.0 - period / SPEED_MEMORY)
        self.speed = np.maximum(np.abs(command - before) / period, faded)
        self._heard[state.fresh] = now
        self._unanswered = np.where(state.fresh, 0, self._unanswered + 1)
        self._successes.append(bool(state.fresh.all()))
        there = np.abs(command - state.position).max() < SETTLED_ERROR
        arrived = there and np.abs(state.velocity).max() < SETTLED_SPEED and state.fresh.all()
        self.settled_ticks = self.settled_ticks + 1 if arrived else 0

    def fault(self, now: float) -> ArmsynError | None:
        """Return what is wrong with the answers, if anything; `judge_tick` judges the following.

        Parameters
        ----------
        now : float
            s.

        Returns
        -------
        BusTimeoutError, BusError or None
            A servo silent for too long; too many commands lost.
        """
        lost = self._unanswered >= FEWEST_UNANSWERED
        silence = np.where(lost, now - self._heard, 0.0)
        silent = int(np.argmax(silence))
        if silence[silent] > max(LONGEST_SILENCE, FEWEST_UNANSWERED * self.settings.period):
            servo = self.settings.servos[silent]
            return BusTimeoutError(
                f"{title_of(servo)} has been silent for {silence[silent]:.2f} s: check its cable"
                " and power",
                (servo.id,),
            )
        if len(self._successes) == SUCCESS_WINDOW and self.success_rate < LOWEST_SUCCESS:
            return BusError(
                f"only {self.success_rate:.0%} of the last {SUCCESS_WINDOW} commands went out in"
                " time and were answered: check cables, or use a lower rate"
            )
        return None

    def silence_fault(self, health: Health | None) -> BusTimeoutError | None:
        """Count a slow check, and return who has answered none of them for too long.

        Only servos without a state at every tick are judged: `fault` judges the others.

        Parameters
        ----------
        health : Health or None
            What it brought; None for a lost reply.

        Returns
        -------
        BusTimeoutError or None
        """
        self._unheard += 1
        if health is not None:
            self._unheard[health.row] = 0
        rounds = MISSED_ROUNDS * self.settings.polls
        joints = self._heard.size
        for servo, unheard in zip(
            self.settings.servos[joints:], self._unheard[joints:], strict=True
        ):
            if rounds and unheard > rounds:
                return BusTimeoutError(
                    f"{title_of(servo)} has not answered {MISSED_ROUNDS} rounds of slow checks:"
                    " check its cable and power",
                    (servo.id,),
                )
        return None

    def poll_fault(self, health: Health | None) -> HardwareFaultError | BusTimeoutError | None:
        """Return what a slow check of one servo says; a lost reply says nothing.

        Parameters
        ----------
        health : Health or None

        Returns
        -------
        HardwareFaultError, BusTimeoutError or None
            A hardware error, torque or RAM lost, a bus watchdog that has expired, or a shadow that
            does not follow; servos that are silent, if the watchdog expired while they were.
        """
        if health is None:
            return None
        servo = self.settings.servos[health.row]
        if health.hardware_error is not None and health.row < self.hardware_error.size:
            self.hardware_error[health.row] = health.hardware_error
        problem = self._problem(servo, health)
        if problem is None:
            return None
        if problem is _STOPPED and (self._unanswered >= FEWEST_UNANSWERED - 1).any():
            return self._kept_waiting(servo)
        return HardwareFaultError(f"{title_of(servo)} {problem}", servo.id)

    def _kept_waiting(self, stopped: ServoDescription) -> BusTimeoutError:
        """Name those who are silent: waiting for them kept another from its commands."""
        rows = np.flatnonzero(self._unanswered >= FEWEST_UNANSWERED - 1)
        silent = [self.settings.servos[row] for row in rows]
        return BusTimeoutError(
            f"no answer from {', '.join(map(title_of, silent))}, and {title_of(stopped)} was"
            " stopped by its bus watchdog meanwhile: check cables and power",
            tuple(servo.id for servo in silent),
        )

    def _problem(self, servo: ServoDescription, health: Health) -> str | None:
        watchdog = health.bus_watchdog
        streamed = servo.joint in self.settings.limits.names
        lost = health.torque_enabled is False and servo.id not in self.settings.limp
        problem = None
        if health.hardware_error:
            problem = _error(servo, health.hardware_error)
        elif watchdog == WATCHDOG_EXPIRED:
            problem = _STOPPED
        elif watchdog == 0 and streamed:
            problem = f"has lost its {'torque' if lost else 'bus watchdog'}: it {_RESTARTED}"
        elif health.moving_speed == 0 and servo.id in self.settings.limited:
            problem = _RESTARTED
        elif lost:
            problem = _SWITCHED_OFF
        elif health.apart is not None and abs(health.apart) > APART_TICKS:
            problem = (
                f"reads {abs(health.apart)} ticks off its leader, {APART_TICKS} are allowed: one of"
                " the two does not hear its goals, or the joint has come apart; look at it"
            )
        return problem

    def alert_fault(self, row: int) -> HardwareFaultError:
        """Return the fault of a joint's servo whose alert bit is set."""
        servo = self.settings.servos[row]
        return HardwareFaultError(
            f"{title_of(servo)} {_error(servo, int(self.hardware_error[row]))}", servo.id
        )


def _error(servo: ServoDescription, status: int) -> str:
    cause = hardware_error_names(status) if status else "its cause could not be read"
    return f"reports a hardware error: {cause}; {cure_of_error(servo)}"
