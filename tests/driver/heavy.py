"""The whole driver on an arm that has weight: rigid bodies under gravity, on the stepped clock."""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace

from armsyn.arm import ArmDescription, calibration_of
from armsyn.arm.rig import build_rig
from armsyn.driver import ArmSession
from firmware_sim.assembly import build_simulation
from firmware_sim.rig.file import parse_rig
from firmware_sim.stepped import SteppedPort
from tests.driver.stepped import SteppedArm


class HeavyArm(SteppedArm):
    """An arm of simulated servos and bodies, limp in a posture.

    Parameters
    ----------
    arm : ArmDescription
        As the driver knows it.
    posture : array, shape (n,), optional
        rad; rest when it is not given.
    real : ArmDescription, optional
        As it is: with other masses, say. Else the same.
    """

    def __init__(
        self,
        arm: ArmDescription,
        posture: np.ndarray | None = None,
        real: ArmDescription | None = None,
    ) -> None:
        super().__init__(arm)
        placed = lying(real or arm, arm.rest if posture is None else posture)
        simulation = build_simulation(parse_rig(build_rig(placed)), mujoco=True)
        self.servos = simulation.bus.servos
        self.by_id = {servo.servo_id: servo for servo in self.servos}
        self.port = SteppedPort(simulation, self.clock, self.baud)

    def session(self, rate: float = 200.0, *, accept_no_watchdog: bool = False) -> ArmSession:
        session = super().session(rate, accept_no_watchdog=accept_no_watchdog)
        session.gravity = True
        return session


def lying(arm: ArmDescription, posture: np.ndarray) -> ArmDescription:
    """The arm with a posture for its rest."""
    where = dict(zip(arm.joint_names, posture.tolist(), strict=True))
    if arm.gripper is not None:
        where[arm.gripper.name] = arm.gripper.rest_angle
    ticks = calibration_of(arm.servo).to_ticks([where[servo.joint] for servo in arm.servo])
    return replace(
        arm,
        joint=tuple(replace(joint, rest=where[joint.name]) for joint in arm.joint),
        servo=tuple(
            replace(servo, rest_tick=tick)
            for servo, tick in zip(arm.servo, ticks.tolist(), strict=True)
        ),
    )
