"""Goals that bring a loaded arm where it should be: it sags by what its position loops give way.

A position loop without integral part turns an error into torque: P/128 counts of PWM a tick, 885
counts are the whole voltage (e-Manual, "Position PID Gain", "Goal PWM"), and the whole voltage
gives the stall torque when nothing turns. So a joint is a spring,

    k = (P / 128) / 885 / tick * stall torque * voltage / nominal voltage,    N m/rad,

that a load tau bends by tau / k. Two things are done about it: goals lead the wanted posture by the
declared masses' `gravity_torque` over k (feed-forward), and while the arm stands at the end of its
way, goals are slowly moved by what is measured to be left (correction). The first needs masses and
is there during the motion; the second needs none and finds what the first does not know: another
load, friction, a sagging supply. No gain is written to any servo.

Where a servo has an integral gain of its own it needs no feed-forward; where its loop is another
one (Protocol 1.0, XL-320) only the correction works.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription, gravity_torque
from armsyn.driver.joints import JointState
from armsyn.driver.path import minimum_jerk

FloatArray = NDArray[np.float64]

LARGEST_FEEDFORWARD = 0.12
LARGEST_CORRECTION = 0.1
"""rad that goals may lead by, at most. A feed-forward that nothing asks for puts a joint off by
itself, which must be no following error (0.15 rad at rest)."""

FADE = 0.25
"""Seconds in which the feed-forward comes up under an arm that was limp, at least."""

GENTLE_LEAD = 0.1
"""rad/s on average at which it comes up then, at most, however fast the plan is: nobody who asked
for a slow motion expects the hand to jump first."""

CORRECTION_RATE = 4.0
"""1/s: the part of the remaining error that goals move by. A loop with gravity's load follows its
goal with a time constant of 40-70 ms, so this settles without overshoot up to 1 / (4 x 67 ms)."""

FASTEST_CORRECTION = 0.2
"""rad/s that a correction may move a goal by."""

FASTEST_LEAD = 1.0
"""rad/s that goals may move against the wanted posture in all: gravity's torque changes with the
posture, and the lead must follow it through a fast reach."""

HELD_BACK = 0.12
"""rad from its goal from which on a joint is held by something: no correction pushes there."""

STANDING = 0.05
"""rad/s below which a joint stands, so that what is off is no lag."""

DEAD_BAND = 1.1
"""Ticks that a joint may be off: an encoder shows no less, and flickers by one."""

_INTERVAL = 0.02
"""Seconds for which a gravity torque is good."""


@dataclass(frozen=True)
class LeadSettings:
    """What leads are worked out from.

    Parameters
    ----------
    arm : ArmDescription
    stiffness : array, shape (n,)
        Of `armsyn.driver.gravity_facts.read_stiffness`, N m/rad.
    lower, upper : array, shape (n,)
        Range that goals must keep, rad: the joints' and the servos' own limits.
    period : float
        Of the ticks, s.
    active : bool
        False for goals that are the wanted posture, and nothing else.
    """

    arm: ArmDescription
    stiffness: FloatArray
    lower: FloatArray
    upper: FloatArray
    period: float
    active: bool = True

    @property
    def has_masses(self) -> bool:
        """Whether the arm declares the masses that a feed-forward needs."""
        return all(joint.link is not None for joint in self.arm.joint)

    def feedforward(self, posture: FloatArray) -> FloatArray:
        """Lead that holds a posture against gravity, shape (n,), rad; 0 where it is not known."""
        if not (self.active and self.has_masses):
            return np.zeros(posture.size)
        lead = gravity_torque(self.arm, posture) / self.stiffness
        lead[~np.isfinite(lead)] = 0.0
        return np.asarray(np.clip(lead, -LARGEST_FEEDFORWARD, LARGEST_FEEDFORWARD))

    def expected_droop(self) -> str:
        """What to expect of an arm without masses, in one line; nothing of one that has them."""
        if self.has_masses or not self.active:
            return ""
        firm = np.isfinite(self.stiffness) & (self.stiffness > 0.0)
        if not firm.any():
            return "no masses are declared: how far the arm droops is not known"
        joint = int(np.argmin(np.where(firm, self.stiffness, np.inf)))
        return (
            "no masses are declared: the arm droops until it is corrected at the end of its way,"
            f" {self.arm.joint_names[joint]} by {np.degrees(1.0 / self.stiffness[joint]):.1f}"
            " degrees for each N m on it"
        )


class GoalLead:
    """By how much goals lead the wanted posture.

    Parameters
    ----------
    settings : LeadSettings
    wanted : array, shape (n,)
        Where the arm is, rad.
    sent : array, shape (n,)
        Goals that the servos have, rad.
    holds : array of bool, shape (n,)
        Which servos are under torque: their lead is what holds the arm now.

    Attributes
    ----------
    lead : array, shape (n,)
        rad.
    wanted : array, shape (n,)
        The posture that the goals stand for, rad.
    content : bool
        Whether the correction has nothing left to do, or can do nothing more.
    there : bool
        Whether every joint is where it should be.
    limited : array of bool, shape (n,)
        Joints whose goal would have had to leave its range.
    """

    def __init__(
        self,
        settings: LeadSettings,
        wanted: FloatArray,
        sent: FloatArray,
        holds: NDArray[np.bool_],
    ) -> None:
        self.settings = settings
        n = wanted.size
        self._tick = np.abs(np.broadcast_to(settings.arm.calibration.radians_per_tick, (n,)))
        self._feedforward = self._next = settings.feedforward(wanted)
        self.wanted, self.lead = wanted, sent - wanted
        # what holds a joint beyond the feed-forward goes on holding it ...
        beyond = np.where(holds & settings.active, self.lead - self._feedforward, 0.0)
        self._correction = np.clip(beyond, -LARGEST_CORRECTION, LARGEST_CORRECTION)
        # ... and what is missing to it under a limp one comes up softly
        self._fading = self.lead - self._feedforward - self._correction
        self._fade = max(FADE, float(np.abs(self._fading).max()) / GENTLE_LEAD)
        self.content = not settings.active
        self.there = False
        self.limited = np.zeros(n, dtype=np.bool_)
        self._ticks = 0
        self._every = max(1, round(_INTERVAL / settings.period))

    def goals(self, wanted: FloatArray) -> FloatArray:
        """Goals that bring the arm to a posture; both of shape (n,), rad. Call it once a tick."""
        settings = self.settings
        rest = self._ticks % self._every
        if rest == 0:
            self._feedforward, self._next = self._next, settings.feedforward(wanted)
        self._ticks += 1
        part = (rest + 1) / self._every
        target = self._feedforward + part * (self._next - self._feedforward) + self._correction
        left = 1.0 - minimum_jerk(self._ticks * settings.period / self._fade)
        target += self._fading * left
        most = FASTEST_LEAD * settings.period
        lead = self.lead + np.clip(target - self.lead, -most, most)
        # a posture within its limits stays reachable, and so does a goal that stood beyond them
        last = self.wanted + self.lead
        low = np.minimum(np.minimum(settings.lower, wanted), last)
        high = np.maximum(np.maximum(settings.upper, wanted), last)
        goals = np.clip(wanted + lead, low, high)
        np.greater(np.abs(wanted + lead - goals), self._tick, out=self.limited)
        self.lead, self.wanted = goals - wanted, wanted
        return np.asarray(goals)

    def correct(self, wanted: FloatArray, state: JointState) -> None:
        """Take in what is measured while the wanted posture stands still.

        Parameters
        ----------
        wanted : array, shape (n,)
            rad.
        state : JointState
        """
        if not self.settings.active:
            return
        error = wanted - state.position
        size = np.abs(error)
        off = size > DEAD_BAND * self._tick
        most = FASTEST_CORRECTION * self.settings.period
        change = np.clip(CORRECTION_RATE * self.settings.period * error, -most, most)
        standing = (np.abs(state.velocity) < STANDING) & state.fresh
        works = off & standing & (size < HELD_BACK) & ~self.limited
        self._correction[works] += change[works]
        np.clip(self._correction, -LARGEST_CORRECTION, LARGEST_CORRECTION, out=self._correction)
        spent = np.abs(self._correction) >= LARGEST_CORRECTION
        self.there = not off.any()
        self.content = bool((~off | self.limited | spent | (size >= HELD_BACK)).all())
