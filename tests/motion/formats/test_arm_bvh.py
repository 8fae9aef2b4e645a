"""Arms as skeletons: the positions are those of forward kinematics."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from armsyn.arm import load_arm
from armsyn.errors import FormatError
from armsyn.kinematics import Joint, SerialChain
from armsyn.motion import Motion
from armsyn.motion.formats import arm_bvh, read_body

ARMS = (
    *("human7", "koch", "openmanipulator_x", "reachy_right", "viperx_300s", "widowx_250s"),
    "hug_mp4",
)


def anywhere(chain: SerialChain, frames: int = 40) -> Motion:
    """A motion through random postures."""
    random = np.random.default_rng(4)
    angles = random.uniform(chain.lower, chain.upper, (frames, chain.dof))
    return Motion(np.arange(frames) / 50, chain.names, angles, source="anywhere")


@pytest.mark.parametrize("name", ARMS)
def test_positions_read_back_are_those_of_the_arm(tmp_path: Path, name: str) -> None:
    chain = load_arm(name, calibrated=False).chain
    motion = anywhere(chain)
    arm_bvh.write(tmp_path / "a.bvh", motion, chain)
    body = read_body(tmp_path / "a.bvh")
    assert body.skeleton.names == ("base", *chain.names, "tip", "tip_end")
    found = body.positions()
    assert motion.angles is not None
    assert np.abs(found[:, 1:-1] - chain.positions(motion.angles)).max() < 1e-6
    assert not found[:, 0].any()
    np.testing.assert_allclose(body.time, motion.time, atol=1e-9)


def test_the_tip_is_turned_as_the_arms(tmp_path: Path) -> None:
    chain = SerialChain(
        (
            Joint("lift", "prismatic", (0.1, 0, 0.2), (0.3, -0.2, 0.5), (0.0, 1.0, 1.0)),
            Joint("turn", "revolute", (0.2, 0.1, 0), (0, 0.4, 0), (1.0, 2.0, -1.0)),
        ),
        (0.1, 0.2, 0.3),
        (0.2, 0.7, -0.4),
    )
    motion = anywhere(chain)
    assert motion.angles is not None
    arm_bvh.write(tmp_path / "a.bvh", motion, chain)
    body = read_body(tmp_path / "a.bvh")
    frames = body.skeleton.frames(body.root, body.rotations, body.translations)
    for row, angles in enumerate(motion.angles):
        expected = chain.forward(angles)
        np.testing.assert_allclose(frames.positions[row, 1:-1], expected.positions, atol=1e-6)
        turned = pin.log3(expected.orientations[-1].T @ frames.orientations[row, -2])
        assert np.linalg.norm(turned) < 1e-6


def test_joints_in_another_order_and_more_of_them(tmp_path: Path) -> None:
    chain = load_arm("koch", calibrated=False).chain
    motion = anywhere(chain)
    assert motion.angles is not None
    mixed = Motion(
        motion.time,
        ("gripper", *chain.names[::-1]),
        np.concatenate([np.ones((40, 1)), motion.angles[:, ::-1]], axis=1),
    )
    arm_bvh.write(tmp_path / "a.bvh", mixed, chain)
    arm_bvh.write(tmp_path / "b.bvh", motion, chain)
    assert (tmp_path / "a.bvh").read_bytes() == (tmp_path / "b.bvh").read_bytes()


def test_what_is_refused(tmp_path: Path) -> None:
    koch, human = (load_arm(name, calibrated=False).chain for name in ("koch", "human7"))
    with pytest.raises(FormatError, match="anywhere: no angles of shoulder_flexion, "):
        arm_bvh.write(tmp_path / "a.bvh", anywhere(koch), human)
    motion = anywhere(koch)
    assert motion.angles is not None
    uneven = Motion(motion.time**2, motion.joint_names, motion.angles)
    with pytest.raises(FormatError, match="resample the motion to an even rate"):
        arm_bvh.write(tmp_path / "a.bvh", uneven, koch)
    assert not list(tmp_path.iterdir())
