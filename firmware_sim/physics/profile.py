"""The velocity profile that leads a servo from one position to the next.

Source: e-Manual, "What is the Profile", "Profile Velocity(112)" and "Profile Acceleration(108)":
a profile velocity of 0 is a step; without an acceleration the profile is rectangular; otherwise
trapezoidal, or triangular where the way is too short to reach the profile velocity. A goal that
comes while a profile runs starts from the velocity of that moment.
"""

from __future__ import annotations

import math
from enum import IntEnum


class ProfileType(IntEnum):
    """Bits 4 and 5 of Moving Status(123)."""

    STEP = 0x00
    RECTANGULAR = 0x10
    TRIANGULAR = 0x20
    TRAPEZOIDAL = 0x30


class Profile:
    """A way made of pieces of constant acceleration.

    Parameters
    ----------
    start, velocity : float
        Where it begins, rad, and how fast, rad/s.
    goal : float
        Where it ends, at rest, rad.
    pieces : list of (float, float, float)
        Duration (s), velocity at its begin (rad/s), acceleration (rad/s^2) of each piece.
    kind : ProfileType
        Its shape.

    Attributes
    ----------
    pieces : list of (float, float, float, float)
        Begin (s since the start), position (rad) and velocity (rad/s) there, acceleration (rad/s^2)
        of each piece; at most three come from the functions below.
    """

    __slots__ = ("duration", "goal", "kind", "pieces")

    def __init__(
        self, start: float, goal: float, pieces: list[tuple[float, float, float]], kind: ProfileType
    ) -> None:
        self.goal = goal
        self.kind = kind
        self.duration = 0.0
        self.pieces: list[tuple[float, float, float, float]] = []
        position = start
        for duration, velocity, acceleration in pieces:
            self.pieces.append((self.duration, position, velocity, acceleration))
            position += (velocity + 0.5 * acceleration * duration) * duration
            self.duration += duration


def velocity_profile(
    start: float, velocity: float, goal: float, speed: float, acceleration: float
) -> Profile:
    """Return a velocity-based profile.

    Parameters
    ----------
    start, velocity : float
        Present trajectory: position (rad) and velocity (rad/s).
    goal : float
        rad.
    speed : float
        Profile velocity, rad/s; 0 for a step.
    acceleration : float
        Profile acceleration, rad/s^2; 0 for a rectangular profile.

    Returns
    -------
    Profile
        From `start` to rest at `goal`.
    """
    way = goal - start
    if speed <= 0.0:
        return Profile(goal, goal, [], ProfileType.STEP)
    if acceleration <= 0.0:
        pieces = [(abs(way) / speed, math.copysign(speed, way), 0.0)] if way else []
        return Profile(start, goal, pieces, ProfileType.RECTANGULAR)
    braking_way = velocity * abs(velocity) / (2.0 * acceleration)
    sign = math.copysign(1.0, way - braking_way)
    peak = math.sqrt(max(0.0, sign * way * acceleration + 0.5 * velocity * velocity))
    kind = ProfileType.TRIANGULAR if peak < speed else ProfileType.TRAPEZOIDAL
    cruise = sign * min(peak, speed)
    ramp = math.copysign(acceleration, cruise - velocity)
    ramp_time = abs(cruise - velocity) / acceleration
    brake_time = abs(cruise) / acceleration
    covered = 0.5 * (velocity + cruise) * ramp_time + 0.5 * cruise * brake_time
    cruise_time = max(0.0, (way - covered) / cruise) if cruise else 0.0
    pieces = [
        (ramp_time, velocity, ramp),
        (cruise_time, cruise, 0.0),
        (brake_time, cruise, -sign * acceleration),
    ]
    return Profile(start, goal, pieces, kind)


def time_profile(
    start: float, velocity: float, goal: float, duration: float, ramp_time: float
) -> Profile:
    """Return a time-based profile (drive mode bit 2).

    Parameters
    ----------
    start, velocity : float
        Present trajectory: position (rad) and velocity (rad/s).
    goal : float
        rad.
    duration : float
        Of the whole way, s; 0 for a step.
    ramp_time : float
        Of speeding up, and of slowing down, s; at most half of `duration` is used.

    Returns
    -------
    Profile
        From `start` to rest at `goal`.
    """
    if duration <= 0.0:
        return Profile(goal, goal, [], ProfileType.STEP)
    ramp_time = min(ramp_time, 0.5 * duration)
    way = goal - start
    if ramp_time <= 0.0:
        return Profile(start, goal, [(duration, way / duration, 0.0)], ProfileType.RECTANGULAR)
    cruise = (way - 0.5 * velocity * ramp_time) / (duration - ramp_time)
    cruise_time = duration - 2.0 * ramp_time
    pieces = [
        (ramp_time, velocity, (cruise - velocity) / ramp_time),
        (cruise_time, cruise, 0.0),
        (ramp_time, cruise, -cruise / ramp_time),
    ]
    kind = ProfileType.TRAPEZOIDAL if cruise_time > 0.0 else ProfileType.TRIANGULAR
    return Profile(start, goal, pieces, kind)
