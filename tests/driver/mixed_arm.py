"""An arm with all there is on one bus: dual joints, both protocols, servos without a watchdog."""

from __future__ import annotations

from msgspec.structs import replace

from armsyn.arm import ArmDescription, load_arm

MX, AX = 7, 8
"""IDs of its servos of protocol 1.0: they have no bus watchdog."""


def mixed_arm() -> ArmDescription:
    """ViperX-300s with an MX-28 and an AX-12A of protocol 1.0 for a wrist.

    Its shoulder and elbow have two motors each, its gripper one.
    """
    arm = load_arm("viperx_300s")
    classic = {
        MX: {"model": "mx-28", "protocol": 1, "drive_mode": 0},
        AX: {"model": "ax-12a", "protocol": 1, "zero_tick": 512, "rest_tick": 512},
    }
    servos = (replace(servo, **classic.get(servo.id, {})) for servo in arm.servo)
    joints = (
        replace(joint, lower=-2.5, upper=2.5) if joint.name == "wrist_rotate" else joint
        for joint in arm.joint
    )
    return replace(arm, name="mixed", joint=tuple(joints), servo=tuple(servos))
