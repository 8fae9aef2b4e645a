"""What the raw controller (S_A of the first paper) needs, for an arm that has learned nothing."""

from __future__ import annotations

from armsyn.arm import ArmDescription
from armsyn.planning.checking import PLANNING_RATE_HZ
from armsyn.synergy import LearnedReach, SynergyLibrary, SynergySet
from armsyn.synergy.controller import ARM_RATES
from armsyn.synergy.library import PROFILE_SAMPLES

RAW_PACE = 0.16
"""Gain of S_A for an arm that has learned nothing: the median of what the others learned."""


def raw_library(arm: ArmDescription, ik: str) -> SynergyLibrary:
    """Return what the raw controller (S_A) needs, for an arm that has learned nothing.

    Parameters
    ----------
    arm : ArmDescription
    ik : {"svd", "jt", "njt", "dls"}

    Returns
    -------
    SynergyLibrary
        One set, of `RAW_PACE`, that comes from no capture.
    """
    still = LearnedReach(
        name="",
        kind="reach",
        source="",
        start_m=(0.0, 0.0, 0.0),
        target_m=(0.0, 0.0, 0.0),
        duration_s=0.0,
        start_residual_m=0.0,
        speed_profile=(0.0,) * PROFILE_SAMPLES,
        sets=(SynergySet(ik, "A", (RAW_PACE,), 0.0, 0.0),),
    )
    return SynergyLibrary(
        schema="armsyn-synergies-1",
        arm=arm.name,
        joint_names=arm.joint_names,
        captures="",
        inputs_sha256="",
        seed=0,
        rate_hz=PLANNING_RATE_HZ,
        lambdas=ARM_RATES,
        stable_gains=True,
        complete=True,
        reaches=(still,),
    )
