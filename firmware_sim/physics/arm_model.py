"""An arm's MJCF made ready for servos: MuJoCo's model, and where each servo sits in it.

What MuJoCo is told of a servo: the rotor's inertia, seen from the horn, is the joint's `armature`;
back-EMF and drag of the gears are its `damping`, their friction its `frictionloss`. The last two
are set anew in every step (`mujoco`), as torque off and faults change them.
"""

from __future__ import annotations

import importlib
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware_sim.errors import PlantError
from firmware_sim.physics import kernel

STIFF = [0.9999, 0.9999, 0.001, 0.5, 2.0]
"""MuJoCo's solimp for friction and obstacles: as near to Coulomb's as it goes. With its default a
joint that friction holds would creep by some tenths of a degree a second, with this by a
millionth."""

QUICK = [2.0 * kernel.STEP, 1.0]
"""MuJoCo's solref for the same: the shortest time that it takes, s, and critical damping."""

_LIGHT = 1.0e-9
"""Inertia of the body that turns with a servo outside the arm, kg m^2: its armature counts."""


@dataclass(frozen=True, slots=True)
class ArmModel:
    """MuJoCo's model of an arm and the rows of its servos.

    Parameters
    ----------
    model, data : Any
        MuJoCo's ``MjModel`` and ``MjData``.
    places : ndarray of int, shape (2, servos)
        Where each servo's joint stands in ``qpos``, and in ``qvel``.
    joints : ndarray of int, shape (servos,)
        Which of the model's joints each servo turns.
    """

    model: Any
    data: Any
    places: NDArray[np.intp]
    joints: NDArray[np.intp]


def load_mujoco() -> ModuleType:
    """Return the package, which is not needed by anything else.

    Raises
    ------
    PlantError
        If it is not installed.
    """
    try:
        return importlib.import_module("mujoco")
    except ImportError as error:
        raise PlantError(
            "the arm as rigid bodies needs MuJoCo: pip install 'armsyn[physics]'"
        ) from error


def build_model(
    mjcf: str,
    joints: Sequence[str | None],
    inertias: Sequence[float],
    outside: Collection[str] = (),
) -> ArmModel:
    """Compile MJCF with the servos in its joints.

    Parameters
    ----------
    mjcf : str
        Of the arm. Its time step, integrator and actuators are not used, nor are armature, damping,
        friction and springs of the joints that have a servo.
    joints : sequence of str or None
        The joint that each servo turns; None for one outside the arm, which gets a joint of its own
        that nothing else feels.
    inertias : sequence of float
        Of each motor with its gears, seen from the horn, kg m^2.
    outside : collection of str
        Joints, such as a gripper's, that are made outside the arm if its MJCF has none of the name.

    Returns
    -------
    ArmModel
        With a time step of `kernel.STEP`.

    Raises
    ------
    PlantError
        If MuJoCo is missing, the text is no MJCF, or a joint is unknown or no hinge.
    """
    mujoco = load_mujoco()
    mujoco.set_mju_user_warning(_keep_quiet)
    try:
        spec = mujoco.MjSpec.from_string(mjcf)
        _set_options(mujoco, spec)
        _make_outside(mujoco, spec, set(outside).intersection(joints))
        hinges = [
            _make_hinge(mujoco, spec, f"servo {k} alone")
            if joint is None
            else _find_hinge(mujoco, spec, joint)
            for k, joint in enumerate(joints)
        ]
        for hinge in hinges:
            _clear(hinge)
        for hinge, inertia in zip(hinges, inertias, strict=True):
            hinge.armature += inertia
        model = spec.compile()
    except ValueError as error:
        if isinstance(error, PlantError):
            raise
        raise PlantError(
            f"the arm's MJCF cannot be used: {' '.join(str(error).split())}"
        ) from error
    rows = [hinge.id for hinge in hinges]
    places = np.array([model.jnt_qposadr[rows], model.jnt_dofadr[rows]], dtype=np.intp)
    return ArmModel(model, mujoco.MjData(model), places, np.array(rows, dtype=np.intp))


def _keep_quiet(warning: str) -> None:
    """Take MuJoCo's warnings, which it would write to a file in the working directory.

    The one that matters, bodies moving without bound, the plant finds by itself.
    """


def _set_options(mujoco: ModuleType, spec: Any) -> None:
    spec.option.timestep = kernel.STEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION


def _make_outside(mujoco: ModuleType, spec: Any, names: Collection[str]) -> None:
    """Make joints outside the arm, but for those that it has."""
    for name in sorted(set(names) - {known.name for known in spec.joints}):
        _make_hinge(mujoco, spec, name)


def _make_hinge(mujoco: ModuleType, spec: Any, name: str) -> Any:
    """Return a new joint that nothing else feels."""
    body = spec.worldbody.add_body(name=f"{name} (outside the arm)")
    body.explicitinertial = True
    body.mass = _LIGHT
    body.inertia = [_LIGHT] * 3
    return body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 0.0, 1.0])


def _find_hinge(mujoco: ModuleType, spec: Any, joint: str) -> Any:
    """Return a servo's joint."""
    found = {known.name: known for known in spec.joints}
    if joint not in found:
        known = ", ".join(name for name in found if name) or "none"
        raise PlantError(f"the arm's MJCF has no joint {joint!r}; its joints are {known}")
    if found[joint].type != mujoco.mjtJoint.mjJNT_HINGE:
        raise PlantError(f"the arm's joint {joint!r} is no hinge: no servo can turn it")
    return found[joint]


def _clear(hinge: Any) -> None:
    """Take from a joint what its servos bring along."""
    hinge.armature = 0.0
    hinge.damping = 0.0 * hinge.damping
    hinge.stiffness = 0.0 * hinge.stiffness
    hinge.frictionloss = 0.0
    hinge.solref_friction = QUICK
    hinge.solimp_friction = STIFF
