"""What the plant of rigid bodies refuses, in one line."""

import sys
from pathlib import Path

import pytest

from firmware_sim.errors import PlantError, SimulatorError
from firmware_sim.physics.mujoco import MujocoPlant
from tests.firmware_sim.mujoco_arms import PENDULUM, make_axes, pendulum

ARM = PENDULUM.format(gravity=-9.8)
BAD = {
    "no XML": ("hello", "MJCF cannot be used: XML parse error"),
    "another XML": (ARM.replace("<inertial", "<weight"), "MJCF cannot be used: .*weight"),
    "no mass": (ARM.replace('mass="0.5"', 'mass="0"'), "MJCF cannot be used: .*mass"),
    "no such joint": (ARM.replace('"hinge"', '"knee"'), "no joint 'hinge'; its joints are knee"),
    "no joints": ("<mujoco/>", "no joint 'hinge'; its joints are none"),
    "a slide": (ARM.replace('name="hinge"', 'name="hinge" type="slide"'), "is no hinge"),
}


@pytest.mark.parametrize("what", BAD)
def test_mjcf_that_cannot_be_used(what: str) -> None:
    mjcf, said = BAD[what]
    with pytest.raises(PlantError, match=said) as caught:
        MujocoPlant(make_axes([0.0]), mjcf, ["hinge"])
    assert "\n" not in str(caught.value)
    assert caught.value.exit_status == 2


def test_without_mujoco(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(SimulatorError, match=r"pip install 'armsyn\[physics\]'"):
        MujocoPlant(make_axes([0.0]), ARM, ["hinge"])


def test_the_simulator_does_not_import_it_before_it_is_needed() -> None:
    import subprocess

    program = "import sys, firmware_sim.physics.mujoco\nsys.exit('mujoco' in sys.modules)"
    subprocess.run([sys.executable, "-c", program], check=True)


def test_servos_that_disagree_about_their_joint() -> None:
    with pytest.raises(PlantError, match=r"number 2 lies 0\.500 rad from where the first says"):
        MujocoPlant(make_axes([0.0, 0.5]), ARM, ["hinge", "hinge"])


def test_bodies_that_move_without_bound(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    axis, plant = pendulum(0.0)
    axis.apply_load(1e300)
    with pytest.raises(PlantError, match="move without bound"):
        plant.advance(10)
    assert not list(tmp_path.iterdir())  # MuJoCo's log
