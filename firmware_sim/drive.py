"""The position loop of a servo: profile, PID controller, motor.

Source: e-Manual, "Position PID Gain(80, 82, 84)": the profile makes a trajectory out of the goal,
the controller makes a PWM out of the trajectory's error, Goal PWM(100) caps it. Gains as the
controller uses them: P/128, I/65536, D/16, in PWM counts for an error in ticks, with I and D per
control period, which is taken to be 1 ms. Everything here is in ticks of the shaft; `servo` knows
about registers.
"""

from __future__ import annotations

from firmware_sim.model import PWM_FULL
from firmware_sim.motor import STEP, Motor
from firmware_sim.profile import Profile, ProfileType

_SLOW = 0.5
"""Speed below which a shaft counts as standing, ticks/s: 0.007 rev/min."""


class PositionDrive:
    """A motor led along profiles.

    Parameters
    ----------
    motor : Motor
        What is driven.
    """

    def __init__(self, motor: Motor) -> None:
        self.motor = motor
        self.torque_on = False
        self.pwm_cap = float(PWM_FULL)
        self.pwm = 0.0
        self.goal = motor.angle
        self.trajectory = motor.angle
        self.trajectory_velocity = 0.0
        self.kind = ProfileType.STEP
        self._gains = (0.0, 0.0, 0.0)
        self._profile: Profile | None = None
        self._elapsed = 0.0
        self._integral = 0.0
        self._last_error = 0.0
        self._settled = True

    @property
    def under_way(self) -> bool:
        """Whether a profile is in progress."""
        return self._profile is not None

    @property
    def settled(self) -> bool:
        """Whether nothing will move until the next command."""
        return self._settled

    def set_gains(self, proportional: int, integral: int, derivative: int) -> None:
        """Take the gains as the registers 84, 82 and 80 hold them."""
        self._gains = (proportional / 128.0, integral / 65_536.0, derivative / 16.0)
        self._settled = False

    def engage(self) -> None:
        """Switch the torque on, holding where the shaft is."""
        self.torque_on = True
        self.stop()

    def release(self) -> None:
        """Switch the torque off."""
        self.torque_on = False
        self.stop()

    def stop(self) -> None:
        """Give up the profile and make the present angle the goal."""
        self._profile = None
        self._integral = 0.0
        self._last_error = 0.0
        self.kind = ProfileType.STEP
        self.goal = self.trajectory = self.motor.angle
        self.trajectory_velocity = 0.0
        self.pwm = 0.0
        self._settled = False

    def follow(self, profile: Profile) -> None:
        """Start on a new profile, from this moment on."""
        self.goal = profile.goal
        self.kind = profile.kind
        self._elapsed = 0.0
        self._profile = profile
        if profile.duration <= 0.0:
            self._arrive()
        self._settled = False

    def disturb(self) -> None:
        """Look at the motor again: its load or supply has changed."""
        self._settled = False

    def advance(self, steps: int) -> None:
        """Go on by a number of steps of physics."""
        while steps > 0 and not self._settled:
            if self.torque_on:
                self._control()
            else:
                self._coast()
            steps -= 1
        if steps > 0:
            self.motor.rest(steps * STEP)

    def _arrive(self) -> None:
        self._profile = None
        self.trajectory = self.goal
        self.trajectory_velocity = 0.0

    def _control(self) -> None:
        """One period of the position loop."""
        profile = self._profile
        if profile is not None:
            self._elapsed += STEP
            self.trajectory, self.trajectory_velocity = profile.at(self._elapsed)
            if self._elapsed >= profile.duration:
                self._arrive()
        motor = self.motor
        proportional, integral, derivative = self._gains
        error = self.trajectory - motor.angle
        pwm = proportional * error
        if derivative:
            pwm += derivative * (error - self._last_error)
            self._last_error = error
        if integral:
            pwm += self._integrate(integral * error, pwm)
        cap = self.pwm_cap
        self.pwm = pwm = cap if pwm > cap else -cap if pwm < -cap else pwm
        motor.drive(pwm / PWM_FULL)
        self._settled = (
            self._profile is None
            and -_SLOW < motor.velocity < _SLOW
            and -_SLOW < motor.pull < _SLOW
            and not (integral and error)
        )

    def _integrate(self, increment: float, rest: float) -> float:
        """Sum the error unless that pushes a full PWM further (the manual's anti-windup)."""
        total = self._integral + increment
        if abs(rest + total) < self.pwm_cap or abs(rest + total) < abs(rest + self._integral):
            self._integral = total
        return self._integral

    def _coast(self) -> None:
        motor = self.motor
        motor.coast()
        if -_SLOW < motor.velocity < _SLOW:
            motor.velocity = 0.0
            self._settled = True
        self.goal = self.trajectory = motor.angle
        self.trajectory_velocity = motor.velocity
