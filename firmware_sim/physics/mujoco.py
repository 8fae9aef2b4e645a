"""The whole arm as rigid bodies under gravity: MuJoCo's mechanics behind the servos' loops.

In every step the compiled control loops give each motor's torque, MuJoCo moves the bodies, and the
angles go back to the axes, whose encoders, currents and temperatures follow. So an arm sags by
what its position loops give way, falls when its torque drops, and overloads when it is pushed.

What is not modelled: the play of the gears lies between the joint and the encoder, not between the
motor and the joint; MuJoCo's ends of a joint's range give way by some milliradians.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from firmware_sim.errors import PlantError
from firmware_sim.physics import kernel
from firmware_sim.physics.arm_model import build_model, load_mujoco
from firmware_sim.physics.axis import Axes
from firmware_sim.physics.plant import SUPPLY_RESISTANCE, make_supplies

_STANDING = 1.0e-4
"""Speed below which static friction holds, rad/s: a fifteenth of an encoder count a second."""

_STILL_STEPS = 50
"""For how many steps in a row nothing may move or change for the arm to be settled."""

_JAM = 1.0e4
"""Friction of a jammed joint, N m."""

_DISAGREEMENT = 0.02
"""By how much servos on one joint may disagree about its angle at the start, rad."""


class MujocoPlant:
    """Servos in the joints of an arm.

    Parameters
    ----------
    axes : Axes
        What is moved, configured: the arm starts where they lie.
    mjcf : str
        The arm's bodies, as `arm_model.build_model` takes them.
    joints : sequence of str or None
        The joint that each axis turns; torques of axes on one joint add. None for an axis outside
        the arm, which stays independent.
    directions : sequence of int, optional
        1 where a horn's counter-clockwise is the joint's positive direction, -1 where it is not;
        1 for all by default.
    zeros : sequence of float, optional
        Angle of each horn at its joint's zero, rad; 0 for all by default.
    supply_resistance : float or sequence of float
        Of each supply, ohm; one figure for a single supply.

    Raises
    ------
    PlantError
        If MuJoCo is missing, the MJCF cannot be used, or axes on one joint disagree.
    """

    def __init__(
        self,
        axes: Axes,
        mjcf: str,
        joints: Sequence[str | None],
        directions: Sequence[int] | None = None,
        zeros: Sequence[float] | None = None,
        supply_resistance: float | Sequence[float] = SUPPLY_RESISTANCE,
    ) -> None:
        self.axes = axes
        self._state = state = axes.state
        several = isinstance(supply_resistance, Sequence)
        self._supplies = make_supplies(supply_resistance if several else [supply_resistance])
        arm = build_model(mjcf, joints, state[:, kernel.INERTIA].tolist())
        self._step = load_mujoco().mj_step
        self._model, self._data = arm.model, arm.data
        count = len(axes)
        self._directions = np.array(directions or [1] * count, dtype=np.float64)
        self._zeros = np.array(zeros or [0.0] * count, dtype=np.float64)
        self._positions, self._velocities = arm.positions, arm.velocities
        # Row of a joint, column of a servo: sums over the servos of each joint.
        self._forward = np.zeros((arm.model.nv, count))
        self._forward[arm.velocities, np.arange(count)] = self._directions
        self._summed = np.abs(self._forward)
        self._torques, self._dampings = np.zeros(count), np.zeros(count)
        self._angles, self._speeds = np.zeros(count), np.zeros(count)
        self._friction = np.zeros(arm.model.nv)
        self._still = 0
        self._place()
        self._check_start()

    def advance(self, steps: int) -> None:
        """Go on by a number of steps of `kernel.STEP`.

        Raises
        ------
        PlantError
            If the bodies' speeds grow without bound: MuJoCo gives up then.
        """
        state = self._state
        if not np.array_equal(state[:, kernel.MOTOR_ANGLE], self._angles):
            self._place()  # an axis was put elsewhere, as when a state is restored
        if not state[:, kernel.SETTLED].all():
            self._still = 0
        for step in range(steps):
            if self._still >= _STILL_STEPS:
                state[:, kernel.SETTLED] = 1.0
                kernel.advance(state, self._supplies, steps - step)
                return
            self._advance_once()
        if self._data.warning.number.any():
            raise PlantError(
                "the arm's bodies move without bound: check the masses and inertias in its MJCF"
            )

    def _advance_once(self) -> None:
        state, data = self._state, self._data
        kernel.drive(state, self._supplies, self._torques, self._dampings)
        self._torques -= state[:, kernel.LOAD]
        np.dot(self._forward, self._torques, out=data.qfrc_applied)
        np.dot(self._summed, self._dampings, out=self._model.dof_damping)
        standing = np.abs(data.qvel) < _STANDING
        self._set_friction(standing)
        self._step(self._model, data)
        self._observe()
        steady = (state[:, kernel.EFFORT] == state[:, kernel.LAST_DUTY]).all()
        idle = steady and standing.all() and not state[:, kernel.UNDER_WAY].any()
        self._still = self._still + 1 if idle else 0

    def _set_friction(self, standing: kernel.FloatArray) -> None:
        state = self._state
        friction = state[:, kernel.FRICTION] * state[:, kernel.FRICTION_FACTOR]
        np.dot(self._summed, friction + _JAM * state[:, kernel.JAMMED], out=self._friction)
        self._friction[standing] *= kernel.STATIC_FRICTION
        self._model.dof_frictionloss[:] = self._friction

    def _observe(self) -> None:
        """Tell the axes what their motors did."""
        data = self._data
        self._angles = self._zeros + self._directions * data.qpos[self._positions]
        self._speeds = self._directions * data.qvel[self._velocities]
        kernel.observe(self._state, self._angles, self._speeds)

    def _place(self) -> None:
        """Put the joints where their axes are; of several on one joint the first counts."""
        self._angles = self._state[:, kernel.MOTOR_ANGLE].copy()
        backwards = slice(None, None, -1)  # what is written last stays
        joint_angles = self._directions * (self._angles - self._zeros)
        self._data.qpos[self._positions[backwards]] = joint_angles[backwards]
        speeds = self._directions * self._state[:, kernel.MOTOR_SPEED]
        self._data.qvel[self._velocities[backwards]] = speeds[backwards]

    def _check_start(self) -> None:
        found = self._zeros + self._directions * self._data.qpos[self._positions]
        apart = np.abs(found - self._angles)
        if (apart > _DISAGREEMENT).any():
            worst = int(apart.argmax())
            raise PlantError(
                f"servos on one joint disagree: number {worst + 1} lies {apart[worst]:.3f} rad from"
                " where the first says; check start_tick, zero_tick and direction"
            )
