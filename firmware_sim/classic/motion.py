"""What the registers of an older servo make its axis do.

Joint mode (MX: multi-turn mode too) leads to Goal Position, at most as fast as Moving Speed, 0 for
as fast as it can, with Goal Acceleration where there is one: AX by compliance, MX and XL-320 by PID
control. Wheel mode puts out what Moving Speed says: AX and XL-320 an output in 0.1 %, MX a speed.
MX-64 and MX-106 have a mode that controls the current. Torque Limit caps the output; at 0 the
servo runs free.

Sources: e-Manual, docs/en/dxl/ax/ax-12a, docs/en/dxl/mx/mx-28 and mx-106, docs/en/dxl/x/xl320,
"Moving Speed", "Torque Limit", "Goal Acceleration", "Torque Control Mode Enable"; AX-12 User's
Manual, "Max Torque" (free at 0). Where they are silent: without a Moving Speed there is no control
of acceleration either; the direction bit of Moving Speed means nothing in joint mode; speed control
in MX' wheel mode is a PI controller's (`SPEED_INTEGRAL_TIME`), with full output for an error of the
no-load speed; Punch is without effect on PID control.
"""

from __future__ import annotations

import math

from firmware_sim.classic.compliance import compliance, gains
from firmware_sim.classic.counting import Mode, StepCount, TickCount, mode_of
from firmware_sim.classic.rows import DIRECTION_BIT, FULL_SCALE
from firmware_sim.firmware.memory import Memory
from firmware_sim.firmware.model import ServoModel
from firmware_sim.physics.axis import Axis
from firmware_sim.physics.kernel import STEP
from firmware_sim.physics.profile import Profile, ProfileType, velocity_profile

SPEED_INTEGRAL_TIME = 0.02
"""Proportional over integral gain of speed control, s; chosen: no overshoot without a load."""

Count = StepCount | TickCount


def signed(count: int) -> int:
    """Return what ten bits and a direction bit mean, counter-clockwise positive."""
    size = count % DIRECTION_BIT
    return -size if count & DIRECTION_BIT else size


def with_direction(value: float) -> int:
    """Return a value, counter-clockwise positive, as ten bits and a direction bit."""
    size = min(FULL_SCALE, round(abs(value)))
    return size | DIRECTION_BIT if value < 0.0 and size else size


class Motion:
    """Registers on one side, an axis on the other.

    Parameters
    ----------
    model : ServoModel
        What it is.
    memory : Memory
        Its registers.
    axis : Axis
        What it drives, configured.
    """

    def __init__(self, model: ServoModel, memory: Memory, axis: Axis) -> None:
        self._units = model.units
        self._no_load_speed = model.motor.no_load_speed
        self._memory = memory
        self.axis = axis
        names = memory.table.by_name
        self._has_compliance = "CW Compliance Slope" in names
        self._has_acceleration = "Goal Acceleration" in names
        self._has_torque_control = "Goal Torque" in names
        self._current_unit = model.current_unit or 0.0
        self.count: Count = TickCount(memory) if self._has_acceleration else StepCount()
        self._leads = False

    @property
    def position(self) -> int:
        """What Present Position reads."""
        return self.count.position(self.axis.ticks)

    @property
    def mode(self) -> Mode:
        """What the angle limits or Control Mode choose."""
        return mode_of(self._memory)

    @property
    def is_output_wheel(self) -> bool:
        """Whether it is in the kind of wheel mode that controls the output, not the speed."""
        return self.mode is Mode.WHEEL and not self._has_acceleration

    def angle(self, position: int) -> float:
        """Return the shaft's angle, rad, that a position means."""
        return self.count.steps(position, self.axis.ticks) * self._units.angle

    def install(self) -> None:
        """Tell an axis just configured what no register holds."""
        gain = 60.0 / (2.0 * math.pi * self._no_load_speed)
        self.axis.set_velocity_gains(gain, gain * STEP / SPEED_INTEGRAL_TIME)

    def boot(self) -> None:
        """Begin without torque, in the turn that the shaft is in."""
        self._leads = False
        self.axis.release()
        self.count.fold(self.axis.ticks)
        self.take_settings()

    def switch_mode(self) -> None:
        """Begin anew after the angle limits or Control Mode have changed."""
        self.count.update()
        if self.mode is Mode.MULTI_TURN:
            self.count.fold(self.axis.ticks)
        self._leads = False
        if self.mode is not Mode.WHEEL:
            self._memory.store("Goal Position", self.position)
        self.drive()

    def take_settings(self) -> None:
        """Read limits, gains and counting again."""
        self.count.update()
        self.axis.set_caps(self._memory.value("Torque Limit") / FULL_SCALE)
        if not self._has_compliance:
            per_step = gains(self._memory)
            self.axis.set_position_gains(
                per_step.proportional, per_step.integral * STEP, per_step.derivative / STEP
            )

    def drive(self) -> None:
        """Do what the registers say now, or run free."""
        value = self._memory.value
        self.take_settings()
        if not (value("Torque Enable") and value("Torque Limit")):
            self._leads = False
            self.axis.release()
        elif self._has_torque_control and value("Torque Control Mode Enable"):
            self._leads = False
            self._drive_torque()
        elif self.mode is Mode.WHEEL:
            self._leads = False
            self._drive_wheel()
        else:
            self._lead_to_goal()

    def _drive_torque(self) -> None:
        """Control the current; Goal Torque(71) counts no further than Torque Limit(34)."""
        goal = signed(self._memory.value("Goal Torque"))
        limit = self._memory.value("Torque Limit")
        self.axis.drive_current(max(-limit, min(limit, goal)) * self._current_unit)

    def _drive_wheel(self) -> None:
        speed = signed(self._memory.value("Moving Speed"))
        if self._has_acceleration:
            self.axis.drive_velocity(speed * self._units.velocity, self._acceleration)
        else:
            self.axis.drive_duty(speed / FULL_SCALE)

    def _lead_to_goal(self) -> None:
        if not self._leads:
            self.axis.hold()
            self._leads = True
        if not self._has_compliance:
            self.axis.follow(self._profile())
            return
        curve = compliance(self._memory)
        sides = curve.counter_clockwise, curve.clockwise
        self.axis.drive_compliance(
            self._profile(),
            (sides[0].margin, sides[1].margin),
            (sides[0].slope, sides[1].slope),
            curve.punch,
        )

    def _profile(self) -> Profile:
        axis = self.axis
        speed = self._memory.value("Moving Speed") % DIRECTION_BIT
        start, velocity = axis.reference, axis.reference_velocity
        if axis.kind is ProfileType.STEP and abs(axis.velocity) >= self._units.velocity:
            # On its way as fast as it can, with the trajectory at its end since the beginning.
            start, velocity = axis.angle, axis.velocity
        return velocity_profile(
            start,
            velocity,
            self.angle(self._memory.value("Goal Position")),
            speed * self._units.velocity,
            self._acceleration,
        )

    @property
    def _acceleration(self) -> float:
        """Of the trajectory, rad/s^2; 0 for none."""
        if not self._has_acceleration:
            return 0.0
        return self._memory.value("Goal Acceleration") * self._units.acceleration
