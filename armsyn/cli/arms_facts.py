"""What is known of an arm, as one document for people and programs."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from armsyn.arm import ArmDescription, find_file, load_arm
from armsyn.arm.calibration_file import find_calibration
from armsyn.arm.checks import TIP
from armsyn.arm.droop import WorstLoad, hand_droop, stiffness, worst_loads
from armsyn.arm.motors import FULL_PWM
from armsyn.arm.servos import ServoDescription
from armsyn.errors import DescriptionError

DROOP_FORMULA = (
    "torque of the arm's weight / k of the joint's servos;"
    f" k = P gain / 128 / {FULL_PWM} a tick x stall torque x volts / nominal volts,"
    " AX: full torque at the initial compliance slope (e-Manual: Position PID Gain, Goal PWM,"
    " Compliance Slope, Specifications); initial gains, no feed-forward, no correction, no friction"
)


def arm_facts(name: str, folder: Path | None) -> dict[str, Any]:
    """Gather what is known of an arm.

    Parameters
    ----------
    name : str
    folder : Path or None
        The only one to search, if given.

    Returns
    -------
    dict
        Ready for JSON: lengths in m, angles in rad, masses in kg, torques in N m; None for what is
        not known.

    Raises
    ------
    DescriptionError
        As `load_arm`.
    """
    arm = load_arm(name, folder)
    weighed = all(joint.link is not None for joint in arm.joint)
    loads = worst_loads(arm) if weighed else None
    heaviest = _heaviest(arm, loads)
    solids = arm.solids
    return {
        "name": arm.name,
        "title": arm.title,
        "files": _files(name, folder),
        "landmarks": _landmarks(arm),
        "follows": arm.follows,
        "reach_m": arm.chain.reach,
        "hand_at_rest_m": _list(arm.chain.forward(arm.rest).tip),
        "moving_mass_kg": float(arm.bodies.masses.sum()) if weighed else None,
        "gravity_m_s2": list(arm.gravity),
        "joints": _joints(arm, loads),
        "servos": [_servo(arm, servo) for servo in arm.servo],
        "gripper": _gripper(arm),
        "droop": {
            "hand_m": _known(hand_droop(arm, heaviest.posture)) if heaviest else None,
            "posture": _list(heaviest.posture) if heaviest else None,
            "formula": DROOP_FORMULA,
        },
        "collision": {
            "described": [joint.name for joint in arm.joint if joint.shape is not None],
            "planes": [plane.name for plane in arm.plane],
            "boxes": [box.name for box in arm.box],
            "pairs_judged": len(dict.fromkeys(solids.names)),
            "pairs_not_judged": [list(pair) for pair in (*arm.collision_ignore, *solids.unjudged)],
        },
    }


def _heaviest(arm: ArmDescription, loads: tuple[WorstLoad, ...] | None) -> WorstLoad | None:
    """The load that bends its joint most."""
    if loads is None or not arm.servo:
        return None
    bends = np.array([abs(load.torque) for load in loads]) / stiffness(arm)
    return loads[int(np.nanargmax(bends))] if np.isfinite(bends).any() else None


def _files(name: str, folder: Path | None) -> dict[str, str | None]:
    try:
        synergies = str(find_file(name, ".synergies.json", folder))
    except DescriptionError:
        synergies = None
    calibration = find_calibration(name, None, folder)
    return {
        "description": str(find_file(name, ".toml", folder)),
        "calibration": str(calibration) if calibration is not None else None,
        "synergies": synergies,
    }


def _landmarks(arm: ArmDescription) -> list[dict[str, Any]]:
    positions = arm.chain.forward(np.zeros(arm.chain.dof)).positions
    rows = {frame: row for row, frame in enumerate((*arm.joint_names, TIP))}
    return [
        {"name": name, "frame": frame, "zero_m": _list(positions[rows[frame]])}
        for name, frame in arm.anatomy.items()
    ]


def _joints(arm: ArmDescription, loads: tuple[WorstLoad, ...] | None) -> list[dict[str, Any]]:
    spring = stiffness(arm)
    found = []
    for row, joint in enumerate(arm.joint):
        torque = abs(loads[row].torque) if loads is not None else math.nan
        found.append(
            {
                "name": joint.name,
                "kind": joint.kind,
                "lower": joint.lower,
                "upper": joint.upper,
                "rest": joint.rest,
                "max_velocity": joint.max_velocity,
                "max_acceleration": joint.max_acceleration,
                "mass_kg": joint.link.mass if joint.link is not None else None,
                "worst_torque": _known(torque),
                "droop": _known(torque / float(spring[row])) if spring[row] else None,
            }
        )
    return found


def _servo(arm: ArmDescription, servo: ServoDescription) -> dict[str, Any]:
    role = "joint"
    if servo.shadow_of is not None:
        role = "shadow"
    elif arm.gripper is not None and servo.joint == arm.gripper.name:
        role = "gripper"
    return {
        "id": servo.id,
        "model": servo.model,
        "joint": servo.joint,
        "role": role,
        "shadow_of": servo.shadow_of,
        "protocol": servo.protocol,
        "supply_voltage": servo.supply_voltage,
        "direction": servo.direction,
        "zero_tick": servo.zero_tick,
        "rest_tick": servo.rest_tick,
        "drive_mode": servo.drive_mode,
        "baud": servo.baud,
        "return_delay_us": servo.return_delay_us,
    }


def _gripper(arm: ArmDescription) -> dict[str, Any] | None:
    gripper = arm.gripper
    if gripper is None:
        return None
    return {
        "name": gripper.name,
        "open": gripper.open,
        "closed": gripper.closed,
        "width_open_m": gripper.width_open,
        "width_closed_m": gripper.width_closed,
        "max_velocity": gripper.max_velocity,
        "max_current_a": gripper.max_current,
    }


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _list(values: np.ndarray[Any, np.dtype[np.float64]]) -> list[float]:
    return [round(float(value), 9) for value in values]
