"""The MJCF's shapes: as far apart as ours, and a limp arm lies upon them."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from armsyn.arm import arm_names, load_arm
from armsyn.arm.mjcf import build_mjcf

CALIBRATION = Path(__file__).resolve().parents[2] / "calibration"
ARMS = [name for name in arm_names(CALIBRATION) if load_arm(name, CALIBRATION).servo]
FAR = 0.3


def owner(model: mujoco.MjModel, geom: int) -> str:
    """A shape is called after its link and a number, a plane or box by its own name."""
    name = model.geom(geom).name
    return name if model.geom(geom).type[0] in (0, 6) else name.rpartition(" ")[0]


@pytest.mark.parametrize("name", ARMS)
def test_shapes_are_as_far_apart_as_ours(name: str) -> None:
    arm = load_arm(name, CALIBRATION)
    model = mujoco.MjModel.from_xml_string(build_mjcf(arm))
    data = mujoco.MjData(model)
    pairs = list(zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True))
    assert {frozenset((owner(model, a), owner(model, b))) for a, b in pairs} == {
        frozenset(pair) for pair in arm.solids.names
    }
    generator = np.random.default_rng(8)
    seen = 0
    for _ in range(20):
        q = generator.uniform(arm.chain.lower, arm.chain.upper)
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        found: dict[frozenset[str], float] = {}
        for one, other in pairs:
            key = frozenset((owner(model, one), owner(model, other)))
            apart = mujoco.mj_geomDistance(model, data, one, other, FAR, None)
            found[key] = min(found.get(key, FAR), apart)
        ours: dict[frozenset[str], float] = {}
        for pair, apart in zip(arm.solids.names, arm.solids.clearances(q[None])[0], strict=True):
            ours[frozenset(pair)] = min(ours.get(frozenset(pair), FAR), apart)
        for key, apart in ours.items():
            if apart > 0.0:
                seen += 1
                assert found[key] == pytest.approx(apart, abs=2e-4), key
            else:
                assert found[key] < 2e-4, key
    assert seen > 20


@pytest.mark.parametrize("name", ["koch", "openmanipulator_x", "widowx_250s", "viperx_300s"])
def test_a_limp_arm_comes_to_lie_upon_itself_or_the_table(name: str) -> None:
    """Falling freely from its rest posture it ends in touch with something, never inside it."""
    arm = load_arm(name, CALIBRATION)
    model = mujoco.MjModel.from_xml_string(build_mjcf(arm))
    model.dof_damping[:] = 0.3
    model.opt.timestep = 1e-3
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data = mujoco.MjData(model)
    data.qpos[:] = arm.rest
    mujoco.mj_step(model, data, 8000)
    assert data.ncon
    assert arm.solids.clearances(data.qpos[None].copy()).min() > -1e-3
