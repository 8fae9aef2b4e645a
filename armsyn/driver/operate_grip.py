"""Opening and closing an arm's gripper with limited force, and saying whether it holds something.

A servo that measures its current grips in current-based position mode (5), where Goal Current
bounds what it pushes with; the others in a position mode, where Goal PWM (Torque Limit on classic
ones) does (e-Manual, XM430-W350, "Operating Mode(11)", "Goal PWM(100)"). Changing the mode resets
Goal Current and Goal PWM to their limits, so they are written after it, and again read after the
torque is on: a gripper that forgets its limit crushes. The gripper holds what it has until it is
told otherwise: its torque stays on. It has no watchdog armed: whatever becomes of the program, the
servo goes on to its goal with this force.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from armsyn.arm import ArmDescription, GripperDescription, ServoDescription, calibration_of
from armsyn.driver import registers as reg
from armsyn.driver.clock import Clock, MonotonicClock
from armsyn.driver.facts import check_models
from armsyn.driver.operate import read_latched
from armsyn.driver.servos import ServoGroup
from armsyn.driver.transactions import Bus
from armsyn.errors import DescriptionError, HardwareFaultError, InputError, ServoMismatchError

USUAL_FORCE = 0.3
"""Part of its greatest PWM, or of its greatest current, that a gripper grips with unless asked."""

ARRIVED = math.radians(2.0)
"""How near its goal a gripper has arrived."""

PUSHING = 0.5
"""Part of the allowed current or force from which on a gripper that stands short of its goal
holds something."""

_LOOK = 0.02
_STILL = 0.3
"""Seconds without motion after which it has come to rest."""

_STILL_ANGLE = math.radians(0.5)
_SPARE = 3.0
"""Seconds beyond the time of the way after which a gripper that never rests is given up."""

_OUTSIDE = math.radians(30.0)
"""How far outside its range a gripper may be found: fingers that are pressed apart."""

_CLASSIC_FULL = 1023

OnLook = Callable[[float], None]
"""Told the width, m, at each look."""


@dataclass(frozen=True)
class Grip:
    """How a gripper came to rest.

    Attributes
    ----------
    width, goal_width : float
        Between the fingers, m: where it rests, and where it was sent.
    arrived, held : bool
        At its goal; short of it and pushing, so that something is between its fingers (or stops
        them). Neither: it stands short of its goal without pushing.
    current : float or None
        A, size; None where it is not measured.
    effort : float
        What it pushes with by what it may, 0 to about 1.
    """

    width: float
    goal_width: float
    arrived: bool
    held: bool
    current: float | None
    effort: float


class Gripper:
    """An arm's gripper on a bus.

    Parameters
    ----------
    bus : Bus
    arm : ArmDescription
    clock : Clock, optional

    Raises
    ------
    DescriptionError
        The arm has no gripper.
    ServoMissingError, ServoMismatchError
        Its servo does not answer, is another model, or has lost its turns.
    HardwareFaultError
        Its servo reports a hardware error.
    """

    def __init__(self, bus: Bus, arm: ArmDescription, clock: Clock | None = None) -> None:
        servo, gripper = arm.gripper_servo, arm.gripper
        if servo is None or gripper is None:
            raise DescriptionError(f"{arm.name} has no gripper that is described")
        self.servo: ServoDescription = servo
        self.description: GripperDescription = gripper
        self.group = ServoGroup(bus, [servo])
        self.clock = clock or MonotonicClock()
        self.model = self.group.models[servo.id]
        self._calibration = calibration_of((servo,))
        check_models(self.group, arm.name)
        self._check_sound()

    @property
    def measures_current(self) -> bool:
        """Whether it grips to a current; to a part of its force otherwise."""
        return self.model.current_unit is not None

    @property
    def title(self) -> str:
        """Name for messages."""
        return self.group.title(self.servo.id)

    def width(self) -> float:
        """Present distance between the fingers, m."""
        return self._width(self._angle())

    def mode_to_set(self) -> int | None:
        """Operating mode that it must be put into, for which its torque goes off; None if none."""
        mode = self._read("Operating Mode")
        if mode is None or self.model.layout is not reg.X:
            return None
        if self.measures_current:
            return None if mode == reg.CURRENT_POSITION_MODE else reg.CURRENT_POSITION_MODE
        position = (reg.POSITION_MODE, reg.EXTENDED_POSITION_MODE)
        return None if mode in position else reg.POSITION_MODE

    def holds(self) -> bool:
        """Whether its torque is on."""
        return bool(self._read("Torque Enable"))

    def force_of(self, current: float | None, force: float | None) -> float:
        """Check and complete what is asked for: A where it measures current, else a part of 1.

        Raises
        ------
        InputError
            A current for a servo that has none, or the reverse; one beyond what is allowed.
        """
        if self.measures_current:
            if force is not None:
                raise InputError(f"{self.title} measures its current: --current A, not --force")
            return self._current_of(current)
        if current is not None:
            raise InputError(f"{self.title} ({self.servo.model}) measures no current: --force")
        if force is not None and not 0.0 < force <= 1.0:
            raise InputError(f"a force is above 0 and at most 100 percent, got {force * 100:g}")
        return USUAL_FORCE if force is None else force

    def _current_of(self, current: float | None) -> float:
        assert self.model.current_unit is not None  # noqa: S101 - it measures current
        limit = (self._read("Current Limit") or 0) * self.model.current_unit
        most = self.description.max_current
        if current is None:
            return USUAL_FORCE * limit if most is None else min(most, limit)
        if not math.isfinite(current) or current <= 0:
            raise InputError(f"a current is above 0 A, got {current:g}")
        if most is not None and current > most:
            raise InputError(f"{current:g} A: the gripper is described to take {most:g} A at most")
        if current > limit:
            raise InputError(
                f"{current:g} A: {self.title} is limited to {limit:.2f} A (Current Limit)"
            )
        return current

    def check_width(self, width: float) -> None:
        """Refuse a width, m, that the gripper does not have: InputError."""
        self._goal(width)

    def move(self, width: float, force: float, on_look: OnLook | None = None) -> Grip:
        """Open or close to a width, or until something stops the fingers; then hold.

        Parameters
        ----------
        width : float
            m.
        force : float
            As `force_of` gives it.
        on_look : callable, optional

        Returns
        -------
        Grip

        Raises
        ------
        InputError
            A width that it does not have; nothing has changed.
        HardwareFaultError
            The servo does not take a setting, or reports an error on the way.
        BusError, PortLostError
            As the bus.
        """
        goal = self._goal(width)
        self._set_up(goal, force)
        self.group.set("Goal Position", {self.servo.id: self._tick(goal)})
        return self._follow(goal, width, force, on_look)

    def stop(self) -> None:
        """Hold where it is: for a person who asks to stop."""
        present = self.group.read("Present Position")
        self.group.set("Goal Position", present)

    def _goal(self, width: float) -> float:
        d = self.description
        low, high = sorted((d.width_closed, d.width_open))
        if not (math.isfinite(width) and low <= width <= high):
            raise InputError(
                f"the gripper opens from {low * 1e3:.0f} to {high * 1e3:.0f} mm,"
                f" {width * 1e3:g} mm are asked for"
            )
        part = (width - d.width_closed) / (d.width_open - d.width_closed)
        return d.closed + part * (d.open - d.closed)

    def _width(self, angle: float) -> float:
        d = self.description
        part = (angle - d.closed) / (d.open - d.closed)
        return d.width_closed + part * (d.width_open - d.width_closed)

    def _set_up(self, goal: float, force: float) -> None:
        servo_id, mode = self.servo.id, self.mode_to_set()
        if mode is not None:
            self.group.set("Torque Enable", {servo_id: 0})
            self.group.set("Operating Mode", {servo_id: mode})
        limits = self._limits(goal, force)
        for name, value in limits.items():
            self.group.set(name, {servo_id: value})
        if self.holds():
            return
        self.group.set("Goal Position", self.group.read("Present Position"))
        self.group.set("Torque Enable", {servo_id: 1})
        for name, value in limits.items():  # the torque has come on with what was written
            self.group.verify(name, {servo_id: value})

    def _limits(self, goal: float, force: float) -> dict[str, int]:
        """Registers that bound speed and force; only those that the servo has."""
        limits = self._speed(goal)
        if self.measures_current:
            assert self.model.current_unit is not None  # noqa: S101 - it measures current
            limits["Goal Current"] = max(1, round(force / self.model.current_unit))
        elif self.model.layout is reg.X:
            limits["Goal PWM"] = round(force * (self._read("PWM Limit") or 0))
        else:
            limits["Torque Limit"] = round(force * _CLASSIC_FULL)
        return limits

    def _speed(self, goal: float) -> dict[str, int]:
        speed, unit = self.description.max_velocity, self.model.velocity_unit
        if self.model.layout is not reg.X:
            return {"Moving Speed": min(_CLASSIC_FULL, max(1, int(speed / unit)))}
        if (self._read("Drive Mode") or 0) & reg.DRIVE_MODE_TIME_PROFILE:
            way = abs(goal - self._angle())
            return {
                "Profile Velocity": max(1, math.ceil(1e3 * way / speed)),
                "Profile Acceleration": 0,
            }
        most = self._read("Velocity Limit")
        units = max(1, int(speed / unit))
        units = units if most is None else min(units, most)
        return {"Profile Velocity": units, "Profile Acceleration": 0}

    def _follow(self, goal: float, width: float, force: float, on_look: OnLook | None) -> Grip:
        here = self._angle()
        now = moved_at = self.clock.now()
        end = now + abs(goal - here) / self.description.max_velocity + _SPARE
        resting = here
        while now < end and now - moved_at < _STILL:
            self.clock.sleep_until(now + _LOOK)
            now, here = self.clock.now(), self._angle()
            if abs(here - resting) > _STILL_ANGLE:
                resting, moved_at = here, now
            if on_look is not None:
                on_look(self._width(here))
            self._check_going()
        arrived = abs(goal - here) <= ARRIVED
        effort, current = self._effort(force)
        held = not arrived and effort >= PUSHING
        return Grip(self._width(here), width, arrived, held, current, effort)

    def _effort(self, force: float) -> tuple[float, float | None]:
        if self.measures_current:
            assert self.model.current_unit is not None  # noqa: S101 - it measures current
            current = abs(self._read("Present Current") or 0) * self.model.current_unit
            return current / force, current
        if self.model.layout is reg.X:
            return abs(self._read("Present Current") or 0) * 1e-3 / force, None
        return abs(self._read("Present Load") or 0) / _CLASSIC_FULL / force, None

    def _check_sound(self) -> None:
        latched = read_latched(self.group)
        for servo_id, error in latched.errors.items():
            raise HardwareFaultError(
                f"{self.title} reports a hardware error: {reg.hardware_error_names(error)};"
                " see to the cause, then armsyn reboot",
                servo_id,
            )
        if latched.watchdogs:
            raise HardwareFaultError(
                f"{self.title} has its bus watchdog armed or expired: look at the arm, then armsyn"
                " clear",
                self.servo.id,
            )
        self._check_settings()
        low, high = sorted((self.description.open, self.description.closed))
        angle = self._angle()
        if not low - _OUTSIDE <= angle <= high + _OUTSIDE:
            raise ServoMismatchError(
                f"{self.title} is at {math.degrees(angle):.0f} degrees, its range is"
                f" {math.degrees(low):.0f} to {math.degrees(high):.0f}: it has lost its turns"
                " (armsyn reboot folds them), or armsyn calibrate"
            )

    def _check_settings(self) -> None:
        """Make sure that it counts as described, and that no other servo's goals move it."""
        drive_mode, follows = self._read("Drive Mode"), self._read("Secondary ID")
        if ((drive_mode or 0) ^ self.servo.drive_mode) & reg.DRIVE_MODE_REVERSE:
            raise ServoMismatchError(
                f"{self.title} counts positions the other way round than described (bit 0 of"
                " register 10, Drive Mode): armsyn setup sets it"
            )
        if follows is not None and follows < reg.NO_SECONDARY_ID and follows != self.servo.id:
            raise ServoMismatchError(
                f"{self.title} follows the goals of servo {follows} (register 12, Secondary ID):"
                " write 255 there with its torque off (armsyn setup does)"
            )

    def _check_going(self) -> None:
        for servo_id, error in read_latched(self.group).errors.items():
            raise HardwareFaultError(
                f"{self.title} reports a hardware error: {reg.hardware_error_names(error)}; see to"
                " the cause, then armsyn reboot",
                servo_id,
            )
        if not self.holds():
            raise HardwareFaultError(
                f"{self.title} has lost its torque: check its power", self.servo.id
            )

    def _angle(self) -> float:
        ticks = self.group.read("Present Position")
        return float(self._calibration.to_radians([ticks[self.servo.id]])[0])

    def _tick(self, angle: float) -> int:
        return int(self._calibration.to_ticks([angle])[0])

    def _read(self, name: str) -> int | None:
        return self.group.read(name).get(self.servo.id)
