"""Judging what the arm answers while it is streamed to: silence, losses, faults, following."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.driver.joints import Health, JointState
from armsyn.driver.registers import hardware_error_names
from armsyn.errors import ArmsynError, BusError, BusTimeoutError, HardwareFaultError
from armsyn.safety import CommandLimits, check_following

FloatArray = NDArray[np.float64]

SUCCESS_WINDOW = 100
"""Commands over which the success rate is taken, as libfranka's control_command_success_rate."""

LOWEST_SUCCESS = 0.5
"""Success rate of a full window below which the stream gives up."""

LONGEST_SILENCE = 0.2
"""Seconds without a reply after which a servo counts as silent: an error budget, not one strike."""

SETTLED_ERROR = 0.005
SETTLED_SPEED = 0.03
"""rad and rad/s within which the arm has arrived."""

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
    servo_ids : tuple of int
    servo_names : tuple of str
        For messages.
    """

    period: float
    limits: CommandLimits
    servo_ids: tuple[int, ...]
    servo_names: tuple[str, ...]


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
        Hardware Error Status of each servo, as far as it was read.
    settled_ticks : int
        Ticks in a row in which the whole arm was at its goals and at rest.
    """

    def __init__(self, settings: WatchSettings, now: float) -> None:
        n = len(settings.servo_ids)
        self.settings = settings
        self.hardware_error = np.zeros(n, dtype=np.uint8)
        self.settled_ticks = 0
        self._successes: deque[bool] = deque(maxlen=SUCCESS_WINDOW)
        self._speed = np.zeros(n)
        self._heard = np.full(n, now)

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
        faded = self._speed * (1.0 - period / SPEED_MEMORY)
        self._speed = np.maximum(np.abs(command - before) / period, faded)
        self._heard[state.fresh] = now
        self._successes.append(bool(state.fresh.all()))
        there = np.abs(command - state.position).max() < SETTLED_ERROR
        arrived = there and np.abs(state.velocity).max() < SETTLED_SPEED and state.fresh.all()
        self.settled_ticks = self.settled_ticks + 1 if arrived else 0

    def fault(self, now: float, command: FloatArray, state: JointState) -> ArmsynError | None:
        """Return what is wrong with the arm, if anything.

        Parameters
        ----------
        now : float
            s.
        command : array, shape (n,)
            rad.
        state : JointState

        Returns
        -------
        BusTimeoutError, BusError, FollowingError or None
            A servo silent for too long; too many commands lost; an arm off its goals.
        """
        silence = now - self._heard
        silent = int(np.argmax(silence))
        if silence[silent] > LONGEST_SILENCE:
            return BusTimeoutError(
                f"{self.settings.servo_names[silent]} has been silent for {silence[silent]:.2f} s:"
                " check its cable and power",
                (self.settings.servo_ids[silent],),
            )
        if len(self._successes) == SUCCESS_WINDOW and self.success_rate < LOWEST_SUCCESS:
            return BusError(
                f"only {self.success_rate:.0%} of the last {SUCCESS_WINDOW} commands went out in"
                " time and were answered: check cables, or use a lower rate"
            )
        return check_following(
            command, state.position, self._speed, state.fresh, self.settings.limits
        )

    def health_fault(self, row: int, health: Health | None) -> HardwareFaultError | None:
        """Return what the slow check of one servo says; a lost reply says nothing."""
        if health is None:
            return None
        self.hardware_error[row] = health.hardware_error
        if health.hardware_error:
            return self.alert_fault(row)
        if not health.torque_enabled:
            return HardwareFaultError(
                f"{self.settings.servo_names[row]} has lost its torque, without a hardware error:"
                " it restarted (check its power) or another program switched it off",
                self.settings.servo_ids[row],
            )
        return None

    def alert_fault(self, row: int) -> HardwareFaultError:
        """Return the fault of a servo whose alert bit is set."""
        status = int(self.hardware_error[row])
        cause = hardware_error_names(status) if status else "its cause could not be read"
        return HardwareFaultError(
            f"{self.settings.servo_names[row]} reports a hardware error: {cause}; support the arm,"
            " see to the cause, then reboot the servo (its torque drops)",
            self.settings.servo_ids[row],
        )
