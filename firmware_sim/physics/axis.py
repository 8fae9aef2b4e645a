"""One driven shaft as the firmware sees it: sensors to read, commands to give.

All axes of a simulation lie in one array of numbers (`kernel` names its columns), which compiled
code advances; an `Axis` reads and writes one row of it through a memoryview, which hands out plain
floats several times faster than numpy does. SI units at the horn, counter-clockwise positive.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from firmware_sim.physics import kernel as k
from firmware_sim.physics.fitting import fit_motor
from firmware_sim.physics.handling import Handling
from firmware_sim.physics.motor_data import MotorData
from firmware_sim.physics.profile import Profile, ProfileType

_STEP = float(ProfileType.STEP)


class Axes:
    """All axes of a simulation.

    Parameters
    ----------
    count : int
        How many.

    Attributes
    ----------
    state : ndarray of float, shape (count, kernel.COLUMNS)
        What is known of each.
    """

    def __init__(self, count: int) -> None:
        self.state = np.zeros((count, k.COLUMNS))
        self._axes = [Axis(memoryview(row)) for row in self.state]  # type: ignore[arg-type]

    def __len__(self) -> int:
        return len(self._axes)

    def __getitem__(self, index: int) -> Axis:
        return self._axes[index]

    def __iter__(self) -> Iterator[Axis]:
        return iter(self._axes)

    @property
    def settled(self) -> bool:
        """Whether every axis has settled; quicker than asking each."""
        return k.is_quiet(self.state)

    @property
    def sound(self) -> bool:
        """Whether every axis is watched, and within what its firmware looks into."""
        return k.is_sound(self.state)

    def couple(self, base: int, other: int, gear: int = 1) -> None:
        """Let two shafts turn as one, as servos that share a joint do.

        They are coupled before the play of their gears. The angles that they have keep apart.

        Parameters
        ----------
        base : int
            Which axis; one that several are coupled with is the base of all.
        other : int
            The other one, which is the base of none.
        gear : int
            1 if they turn the same way, -1 if opposite ways.
        """
        joined = self.state[other]
        self.state[base, k.LINK] = k.LEADS
        joined[k.LINK], joined[k.BASE], joined[k.GEAR] = k.FOLLOWS, base, gear

    def column(self, column: int) -> k.FloatArray:
        """Return one of the columns that `kernel` names, of all axes: a view, shape (count,)."""
        return self.state[:, column]


class Axis(Handling):
    """One axis, sensed, handled and commanded; `configure` comes first.

    Parameters
    ----------
    row : memoryview of float
        Its row of the state.
    """

    __slots__ = ()

    def configure(
        self,
        motor: MotorData,
        encoder_step: float,
        supply_voltage: float,
        start_angle: float = 0.0,
        supply: int = 0,
        senses_input: bool = False,
    ) -> None:
        """Make it a new axis: at rest, torque off, at the temperature of the air.

        Parameters
        ----------
        motor : MotorData
            Its data sheet.
        encoder_step : float
            Angle of one count of the encoder, rad.
        supply_voltage : float
            Without current, V.
        start_angle : float
            Of the horn, rad.
        supply : int
            Which of the plant's supplies it hangs on.
        senses_input : bool
            Whether currents are measured and controlled where they come from the supply, not in the
            winding.
        """
        row = self._row
        for column in range(k.COLUMNS):
            row[column] = 0.0
        fit_motor(row, motor)
        row[k.ENCODER_STEP] = encoder_step
        row[k.SOURCE] = row[k.VOLTAGE] = supply_voltage
        row[k.SUPPLY] = float(supply)
        row[k.ANGLE] = row[k.MOTOR_ANGLE] = start_angle
        row[k.REFERENCE] = row[k.LAST_REFERENCE] = row[k.GOAL] = start_angle
        row[k.TICKS] = float(math.floor(start_angle / encoder_step + 0.5))
        row[k.TEMPERATURE] = k.AMBIENT_TEMPERATURE
        row[k.DUTY_CAP] = row[k.FRICTION_FACTOR] = 1.0
        row[k.CURRENT_CAP] = row[k.SLOPE] = math.inf
        row[k.SENSES_INPUT] = float(senses_input)
        row[k.GEAR] = 1.0
        row[k.STOP_LOW], row[k.STOP_HIGH] = -math.inf, math.inf

    def release(self) -> None:
        """Switch the torque off: the gears run down, and a load can turn them."""
        self._enter(k.OFF)
        row = self._row
        row[k.EFFORT] = row[k.AMPERES] = row[k.REFERENCE_SPEED] = 0.0
        row[k.GOAL] = row[k.REFERENCE] = row[k.LAST_REFERENCE] = self.measured_angle

    def hold(self) -> None:
        """Switch the torque on, or stop: position control where the encoder sees the horn."""
        row = self._row
        self._enter(k.POSITION)
        row[k.GOAL] = row[k.REFERENCE] = row[k.LAST_REFERENCE] = self.measured_angle
        row[k.REFERENCE_SPEED] = row[k.INTEGRAL] = 0.0
        row[k.KIND] = float(ProfileType.STEP)

    def follow(self, profile: Profile) -> None:
        """Start on a profile under position control, from this moment on."""
        if self._row[k.MODE] != k.POSITION:
            self.hold()
        self._lead(profile)

    def step_to(self, angle: float) -> None:
        """Have an angle, rad, for the trajectory at once: a profile without a way."""
        row = self._row
        if row[k.MODE] != k.POSITION:
            self.hold()
        row[k.GOAL] = row[k.REFERENCE] = angle
        row[k.KIND] = _STEP
        row[k.UNDER_WAY] = row[k.SETTLED] = 0.0
        row[k.REFERENCE_SPEED] = row[k.REFERENCE_ACCELERATION] = 0.0

    def drive_compliance(
        self,
        profile: Profile,
        margins: tuple[float, float],
        slopes: tuple[float, float],
        punch: float,
    ) -> None:
        """Start on a profile, pushed towards it the way of the AX series.

        Within the margin nothing pushes; outside it the duty begins with the punch and grows with
        the slope (e-Manual, "Compliance Margin", "Compliance Slope", "Punch").

        Parameters
        ----------
        profile : Profile
            The trajectory.
        margins : (float, float)
            Where it pushes counter-clockwise, and clockwise, rad.
        slopes : (float, float)
            The same, duty per rad.
        punch : float
            Duty at the edge of the margin.
        """
        row = self._row
        if row[k.MODE] != k.COMPLIANCE:
            self.hold()
            row[k.MODE] = k.COMPLIANCE
        row[k.MARGIN_UP], row[k.MARGIN_DOWN] = margins
        row[k.SLOPE_UP], row[k.SLOPE_DOWN] = slopes
        row[k.PUNCH] = punch
        self._lead(profile)

    def drive_velocity(self, speed: float, acceleration: float = 0.0) -> None:
        """Turn with a speed, rad/s, reached with an acceleration, rad/s^2 (0: at once)."""
        row = self._row
        if row[k.MODE] != k.VELOCITY:
            self._enter(k.VELOCITY)
            row[k.INTEGRAL] = 0.0
            row[k.REFERENCE_SPEED] = row[k.SPEED]
        row[k.TARGET] = speed
        row[k.RAMP] = acceleration
        at_once = acceleration <= 0.0
        row[k.KIND] = float(ProfileType.STEP if at_once else ProfileType.TRAPEZOIDAL)
        row[k.UNDER_WAY] = float(not at_once and row[k.REFERENCE_SPEED] != speed)
        row[k.SETTLED] = 0.0

    def drive_current(self, amperes: float) -> None:
        """Let it take a current, as it senses that, as far as the voltage allows, A."""
        self._drive(k.CURRENT, amperes)

    def drive_duty(self, duty: float) -> None:
        """Put out a duty of the PWM, -1 to 1."""
        self._drive(k.DUTY, duty)

    def set_position_gains(
        self, p: float, i: float = 0.0, d: float = 0.0, ff1: float = 0.0, ff2: float = 0.0
    ) -> None:
        """Set the gains of position control.

        Parameters
        ----------
        p : float
            Duty per rad of error.
        i : float
            Duty per rad of error and control period.
        d : float
            Duty per rad by which the error changes within a control period.
        ff1, ff2 : float
            Duty per rad/s and per rad/s^2 of the trajectory.
        """
        row = self._row
        row[k.POSITION_P], row[k.POSITION_I], row[k.POSITION_D] = p, i, d
        row[k.FEEDFORWARD_1], row[k.FEEDFORWARD_2] = ff1, ff2
        row[k.SETTLED] = 0.0

    def set_velocity_gains(self, p: float, i: float) -> None:
        """Set the gains of velocity control: duty per rad/s, and per rad/s and control period."""
        self._row[k.VELOCITY_P], self._row[k.VELOCITY_I] = p, i
        self._row[k.SETTLED] = 0.0

    def set_caps(self, duty: float = 1.0, current: float = math.inf) -> None:
        """Cap the duty (0 to 1) and the current (A; none in modes without current control)."""
        self._row[k.DUTY_CAP], self._row[k.CURRENT_CAP] = duty, current
        self._row[k.SETTLED] = 0.0

    def watch(self, hottest: float, lowest: float, highest: float, slack: float) -> None:
        """Let `Axes.sound` tell when there is something to look into.

        Parameters
        ----------
        hottest : float
            Temperature to be reached at most, degrees Celsius.
        lowest, highest : float
            Voltages to lie between, V.
        slack : float
            How far the encoder may be off, rad.
        """
        row = self._row
        row[k.HOTTEST], row[k.ENCODER_SLACK] = hottest, slack
        row[k.LOWEST_VOLTAGE], row[k.HIGHEST_VOLTAGE] = lowest, highest

    def set_slope(self, volts: float) -> None:
        """Let the voltage of the PWM change by so many V in a step; infinity for at once."""
        self._set(k.SLOPE, volts)

    def _enter(self, mode: int) -> None:
        row = self._row
        row[k.MODE] = mode
        row[k.UNDER_WAY] = row[k.SATURATED_FOR] = row[k.SETTLED] = 0.0
        row[k.REFERENCE_ACCELERATION] = 0.0

    def _drive(self, mode: int, target: float) -> None:
        if self._row[k.MODE] != mode:
            self._enter(mode)
        self._set(k.TARGET, target)

    def _lead(self, profile: Profile) -> None:
        row = self._row
        row[k.GOAL] = profile.goal
        row[k.KIND] = float(profile.kind)
        row[k.ELAPSED] = row[k.SETTLED] = 0.0
        row[k.DURATION] = profile.duration
        row[k.PIECES] = float(len(profile.pieces))
        row[k.UNDER_WAY] = float(profile.duration > 0.0)
        column = k.PIECE_1
        for piece in profile.pieces:
            for value in piece:
                row[column] = value
                column += 1
        if profile.duration <= 0.0:
            row[k.REFERENCE] = profile.goal
            row[k.REFERENCE_SPEED] = row[k.REFERENCE_ACCELERATION] = 0.0
