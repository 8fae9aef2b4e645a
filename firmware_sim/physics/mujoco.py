"""The whole arm as rigid bodies under gravity: MuJoCo's mechanics behind the servos' loops.

In every step the compiled control loops give each motor's torque, MuJoCo moves the bodies, and the
angles go back to the axes, whose encoders, currents and temperatures follow. So an arm sags by
what its position loops give way, falls when its torque drops, and overloads when it is pushed.

What is not modelled: the play of the gears lies between the joint and the encoder, not between the
motor and the joint; MuJoCo's ends of a joint's range give way by some milliradians.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from firmware_sim.errors import PlantError
from firmware_sim.physics import kernel
from firmware_sim.physics.arm_kernel import COLUMNS, load_joints, read_joints
from firmware_sim.physics.arm_model import build_model, load_mujoco
from firmware_sim.physics.arm_stops import Stops
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
    outside : collection of str
        Joints that the arm need not have: see `arm_model.build_model`.

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
        outside: Collection[str] = (),
    ) -> None:
        self.axes = axes
        self._state = axes.state
        if isinstance(supply_resistance, Sequence):
            self._supplies = make_supplies(supply_resistance)
        else:
            self._supplies = make_supplies([supply_resistance])
        arm = build_model(mjcf, joints, self._state[:, kernel.INERTIA].tolist(), outside)
        self._mj_step = load_mujoco().mj_step
        self._arm = arm
        self._stops = Stops(arm)
        count = len(axes)
        self._mounts = np.array([directions or [1] * count, zeros or [0] * count], dtype=np.float64)
        self._drives = np.zeros((2, count))  # torques and dampings of the motors
        self._motion = np.zeros((2, count))  # angles and speeds of the motors
        self._figures = np.array([_STANDING, kernel.STATIC_FRICTION, _JAM])
        self._still_for = 0
        # MuJoCo's own memory: what is written here is what it steps from
        self._joints = (arm.data.qpos, arm.data.qvel)
        self._sums = (arm.data.qfrc_applied, arm.model.dof_damping, arm.model.dof_frictionloss)
        self._place()
        self._check_start()

    def advance(self, steps: int) -> None:
        """Go on by a number of steps of `kernel.STEP`.

        Parameters
        ----------
        steps : int

        Raises
        ------
        PlantError
            If the bodies' speeds grow without bound: MuJoCo gives up then.
        """
        state = self._state
        if not np.array_equal(state[:, kernel.MOTOR_ANGLE], self._motion[0]):
            self._place()  # an axis was put elsewhere, as when a state is restored
        self._stops.update(state, self._mounts)
        if not state[:, kernel.SETTLED].all():
            self._still_for = 0
        due = self._arm.data.time + 0.5 * kernel.STEP
        for step in range(steps):
            if self._still_for >= _STILL_STEPS:
                state[:, kernel.SETTLED] = 1.0
                kernel.advance(state, self._supplies, steps - step)
                return
            self._advance_once()
            if self._arm.data.time < due:  # MuJoCo begins anew where speeds have no bound
                raise PlantError(
                    "the arm's bodies move without bound: check the masses and inertias in its MJCF"
                )
            due += kernel.STEP

    def _advance_once(self) -> None:
        state, arm, mounts = self._state, self._arm, self._mounts
        drives, motion = self._drives, self._motion
        positions, velocities = self._joints
        kernel.drive(state, self._supplies, drives[0], drives[1])
        load_joints(
            state, COLUMNS, drives, arm.places[1], mounts[0], self._figures, velocities, *self._sums
        )
        self._mj_step(arm.model, arm.data)
        still = read_joints(
            state,
            COLUMNS,
            arm.places,
            mounts,
            _STANDING,
            kernel.SAME_DUTY,
            positions,
            velocities,
            motion,
        )
        kernel.observe(state, motion[0], motion[1])
        self._still_for = self._still_for + 1 if still else 0

    def _place(self) -> None:
        """Put the joints where their axes are; of several on one joint the first counts."""
        state, (directions, zeros) = self._state, self._mounts
        self._motion[0] = state[:, kernel.MOTOR_ANGLE]
        angles = directions * (self._motion[0] - zeros)
        speeds = directions * state[:, kernel.MOTOR_SPEED]
        for i in reversed(range(len(state))):  # what is written last stays
            position, dof = self._arm.places[:, i]
            self._joints[0][position] = angles[i]
            self._joints[1][dof] = speeds[i]

    def _check_start(self) -> None:
        directions, zeros = self._mounts
        found = zeros + directions * self._joints[0][self._arm.places[0]]
        apart = np.abs(found - self._motion[0])
        if (apart > _DISAGREEMENT).any():
            worst = int(apart.argmax())
            raise PlantError(
                f"servos on one joint disagree: number {worst + 1} lies {apart[worst]:.3f} rad from"
                " where the first says; check start_tick, zero_tick and direction"
            )
