"""Skeleton formats: the same capture as AMC and as BVH, round trips, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

from armsyn.errors import FormatError
from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion.body import BodyMotion
from armsyn.motion.formats import ReadOptions, read_body, read_file, read_motion, write_body

CMU_UNIT = repr(0.0254 / 0.45)
AMC_OF_BVH = {
    **{"Hips": "root", "LowerBack": "lowerback", "Spine": "upperback", "Spine1": "thorax"},
    **{"Neck": "lowerneck", "Neck1": "upperneck", "Head": "head", "Head_end": "head_end"},
    **{"LHipJoint": "lhipjoint", "LeftUpLeg": "lfemur", "LeftLeg": "ltibia"},
    **{"LeftFoot": "lfoot", "LeftToeBase": "ltoes", "LeftToeBase_end": "ltoes_end"},
    **{"RHipJoint": "rhipjoint", "RightUpLeg": "rfemur", "RightLeg": "rtibia"},
    **{"RightFoot": "rfoot", "RightToeBase": "rtoes", "RightToeBase_end": "rtoes_end"},
    **{"LeftShoulder": "lclavicle", "LeftArm": "lhumerus", "LeftForeArm": "lradius"},
    **{"LeftHand": "lwrist", "LeftFingerBase": "lhand", "LFingers": "lfingers"},
    **{"LFingers_end": "lfingers_end", "LThumb": "lthumb", "LThumb_end": "lthumb_end"},
    **{"RFingers_end": "rfingers_end", "RThumb": "rthumb", "RThumb_end": "rthumb_end"},
    **{"RightShoulder": "rclavicle", "RightArm": "rhumerus", "RightForeArm": "rradius"},
    **{"RightHand": "rwrist", "RightFingerBase": "rhand", "RFingers": "rfingers"},
}
BVH = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Arm
  {
    OFFSET 10 0 0
    CHANNELS 3 Zrotation Yrotation Xrotation
    End Site
    {
      OFFSET 20 0 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.01
0 100 0 0 0 0 0 0 0
0 100 5 0 0 90 90 0 0
"""


LOST_BY_THE_EXPORTER = {
    *("Neck", "LeftShoulder", "RightShoulder"),  # all hang from thorax
    *("LeftFingerBase", "LThumb", "RightFingerBase", "RThumb"),  # from lwrist and rwrist
}


def completed(bvh: BodyMotion, amc: BodyMotion) -> BodyMotion:
    """The BVH of 01_01 with the bones that its exporter left out.

    Where a bone carries several others, it wrote OFFSET 0 0 0 for each of them, so that they hang
    from its near end. No reader can know that: neck, shoulders and all beyond are 11.7 cm off.
    """
    offsets, lost = bvh.skeleton.offsets.copy(), set()
    for joint, name in enumerate(bvh.skeleton.names):
        true = amc.skeleton.offsets[amc.skeleton.index(AMC_OF_BVH[name])]
        if not offsets[joint].any() and true.any():
            offsets[joint] = true
            lost.add(name)
    assert lost == LOST_BY_THE_EXPORTER
    skeleton = Skeleton(bvh.skeleton.names, bvh.skeleton.parents, offsets)
    return BodyMotion(bvh.time, skeleton, bvh.rotations, bvh.root)


def test_01_01_has_the_same_joint_positions_as_amc_and_as_bvh(captures: Path) -> None:
    folder = captures / "jump" / "cmu"
    amc = read_body(folder / "01_01.amc")
    bvh = read_body(folder / "01_01.bvh", ReadOptions(unit=CMU_UNIT))
    assert bvh.skeleton.joints == amc.skeleton.joints == len(AMC_OF_BVH)
    bvh = completed(bvh.between(1, bvh.frames - 1), amc)  # its first frame is a T-pose
    assert amc.frames == bvh.frames == 2751
    first = amc.as_motion(list(AMC_OF_BVH.values())).landmarks
    second = bvh.as_motion(list(AMC_OF_BVH)).landmarks
    assert first is not None
    assert second is not None
    # The BVH has four decimals: half of 1e-4 units is 2.8 um an axis for the root, and half of
    # 1e-4 degrees 0.9 um a metre for each joint above
    assert np.linalg.norm(first - second, axis=2).max() < 10e-6


def test_bvh_positions_are_those_of_its_angles(tmp_path: Path) -> None:
    path = tmp_path / "a.bvh"
    path.write_text(BVH)
    reading = read_file(path)
    motion = reading.motion
    assert motion.landmark_names == ("Hips", "Arm", "Arm_end")
    assert motion.landmarks is not None
    # x left, y up, z forward in the file; x forward, y left, z up here
    np.testing.assert_allclose(motion.landmarks[0], [[0, 0, 1], [0, 0.1, 1], [0, 0.3, 1]])
    # about y by 90 degrees, x turns to -z; then about the arm's z, x turns to y
    turned = [[0.05, 0, 1], [-0.05, 0, 1], [-0.05, 0, 1.2]]
    np.testing.assert_allclose(motion.landmarks[1], turned, atol=1e-12)
    assert motion.time.tolist() == [0, 0.01]
    assert reading.facts == {"unit": "cm (assumed)", "up": "y (assumed)"}


def test_bvh_of_other_exporters(tmp_path: Path) -> None:
    text = BVH.replace("Frames: ", "Frames:\t").replace("Time: ", "Time:")
    text = text.replace("OFFSET 20 0 0\n    }", "OFFSET 20 0 0\n}\nEnd Site {OFFSET 0 5 0}", 1)
    (tmp_path / "a.bvh").write_bytes(text.replace("\n", "\r\n").encode("utf-8-sig"))
    motion = read_motion(tmp_path / "a.bvh")
    assert motion.landmark_names == ("Hips", "Arm", "Arm_end", "Arm_end2")
    np.testing.assert_allclose(motion.hand[0], [0, 0.1, 1.05])


def test_unit_up_and_rate_can_be_told(tmp_path: Path) -> None:
    path = tmp_path / "a.bvh"
    path.write_text(BVH)
    reading = read_file(path, ReadOptions(unit="mm", up="z", rate=50))
    assert reading.motion.landmarks is not None
    np.testing.assert_allclose(reading.motion.landmarks[0, 2], [0.03, 0.1, 0])
    assert reading.motion.time.tolist() == [0, 0.02]
    assert reading.facts == {"unit": "mm", "up": "z"}


@pytest.mark.parametrize("name", ["jump/cmu/02_04.amc", "bvh/freebvh.bvh", "bvh/mocapbank.bvh"])
def test_captures_survive_being_written_as_bvh(captures: Path, tmp_path: Path, name: str) -> None:
    body = read_body(captures / name)
    write_body(tmp_path / "a.bvh", body)
    again = read_body(tmp_path / "a.bvh")
    first, second = body.as_motion(), again.as_motion(body.skeleton.names)
    assert first.landmarks is not None
    assert second.landmarks is not None
    assert np.abs(first.landmarks - second.landmarks).max() < 1e-9
    np.testing.assert_allclose(first.time, second.time, atol=1e-9)
    write_body(tmp_path / "b.bvh", again)
    assert read_motion(tmp_path / "b.bvh").landmark_names == again.skeleton.names


def test_moving_joints_and_prerotations_are_written_as_channels(tmp_path: Path) -> None:
    random = np.random.default_rng(1)
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    skeleton = Skeleton(
        ("hips", "left arm", "hand"), (-1, 0, 1), random.normal(size=(3, 3)), np.stack([turn] * 3)
    )
    values = random.normal(size=(2, 4, 3, 3))
    body = BodyMotion(np.arange(4) / 50, skeleton, values[0], values[0, :, 0], values[1])
    write_body(tmp_path / "a.bvh", body)
    again = read_body(tmp_path / "a.bvh")
    assert again.skeleton.names == skeleton.names
    np.testing.assert_allclose(again.positions(), body.positions(), atol=1e-9)


def test_a_chain_of_500_joints_is_written_and_read(tmp_path: Path) -> None:
    count = 500
    skeleton = Skeleton(
        tuple(f"joint{index}" for index in range(count)),
        tuple(range(-1, count - 1)),
        np.ones((count, 3)),
    )
    rotations = np.random.default_rng(2).normal(size=(2, count, 3))
    body = BodyMotion(np.arange(2.0), skeleton, rotations, np.zeros((2, 3)))
    write_body(tmp_path / "a.bvh", body)
    np.testing.assert_allclose(
        read_body(tmp_path / "a.bvh").positions(), body.positions(), atol=1e-6
    )


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("HIERARCHY", "HIERARCHIE", "line 1: .*HIERARCHY"),
        ("ROOT Hips", "ROOT Arm", "unique names"),
        ("ROOT Hips\n{", "ROOT Hips\nOFFSET", "line 3: '{' expected"),
        ("OFFSET 10 0 0", "OFFSET 10 0", "line 8: .*three numbers"),
        ("OFFSET 10 0 0", "OFFSET 10 0 nan", "line 8: 'nan' is not a finite number"),
        ("    CHANNELS 3 Z", "    CHANNELS 4 Z", "line 9: .*a count"),
        ("Zrotation Y", "Wrotation Y", "line 9: unknown channel 'Wrotation'"),
        ("Zrotation Yrotation", "Zrotation Zrotation", "line 9: .*twice"),
        ("JOINT Arm", "ROOT Arm", "line 6: .*one ROOT"),
        ("Frames: 2", "Frames: 3", "line 21: the file was cut: 2 of 3 frames"),
        ("Frames: 2", "Frames: 1", "line 20: more than the 1 frames"),
        ("Frames: 2", "Frames: 99999999999999999999", "line 17: .*whole number"),
        ("Frame Time: 0.01", "Frame Time: 0", "line 18: a frame time"),
        ("90 90 0 0\n", "90 90 0\n", "line 20: 8 numbers, expected 9"),
        ("90 90 0 0\n", "90 1_0 0 0\n", "line 20: '1_0'"),
        ("MOTION", "}", "line 16: '}' is not expected"),
    ],
)
def test_faults_of_bvh_files_are_named(tmp_path: Path, old: str, new: str, match: str) -> None:
    path = tmp_path / "a.bvh"
    assert old in BVH
    path.write_text(BVH.replace(old, new, 1))
    with pytest.raises(FormatError, match=match) as caught:
        read_motion(path)
    assert str(caught.value).startswith(f"{path}: ")
