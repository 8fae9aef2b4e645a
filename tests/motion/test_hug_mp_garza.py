"""The two reaching sets against their README's formulas, written out independently."""

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import loadmat, savemat
from scipy.spatial.transform import Rotation

from armsyn.errors import FormatError
from armsyn.motion import Motion
from armsyn.motion.captures import load_captures
from armsyn.motion.formats.garza import read_garza
from armsyn.motion.formats.hug_mp import read_hug_mp

HUG_MP, GARZA = Path("reach/hug_mp/S01_trajs.mat"), Path("reach/garza/reach.npz")


@pytest.fixture(scope="module")
def seated(captures: Path) -> dict[tuple[int, int, int], Motion]:
    return read_hug_mp(captures / HUG_MP)


@pytest.fixture(scope="module")
def free(captures: Path) -> dict[str, Motion]:
    return read_garza(captures / GARZA)


def test_hug_mp_is_the_formula_of_its_readme(
    captures: Path, seated: dict[tuple[int, int, int], Motion]
) -> None:
    """G = Rx(q1) Ry(q2) R(-z, q3); elbow = G (0, 0, -L1); hand = elbow + G Ry(-q4) (0, 0, -L2)."""
    raw = loadmat(captures / HUG_MP)
    (cells,) = [value for name, value in raw.items() if not name.startswith("__")]
    seen = 0
    for (repetition, task), cell in np.ndenumerate(cells):
        for index, degrees in enumerate(cell.ravel()):
            key = repetition + 1, task + 1, index + 1
            if not degrees.size:
                assert key not in seated
                continue
            seen += 1
            q1, q2, q3, q4 = degrees
            G = (
                Rotation.from_euler("x", q1[:, None], degrees=True)
                * Rotation.from_euler("y", q2[:, None], degrees=True)
                * Rotation.from_rotvec(np.deg2rad(q3)[:, None] * [0, 0, -1])
            )
            elbow = G.apply([0, 0, -0.30])
            bent = Rotation.from_euler("y", -q4[:, None], degrees=True)
            hand = elbow + (G * bent).apply([0, 0, -0.38])
            motion = seated[key]
            expected = np.stack([np.zeros_like(elbow), elbow, hand], axis=1)
            assert motion.landmarks is not None
            np.testing.assert_allclose(motion.landmarks, expected, atol=1e-12)
            np.testing.assert_allclose(motion.angles, np.deg2rad(degrees.T), atol=1e-15)
            np.testing.assert_allclose(motion.time, np.arange(degrees.shape[1]) / 100)
    assert seen == len(seated) > 100
    assert motion.landmark_names == ("shoulder", "elbow", "hand")


@pytest.mark.usefixtures("captures")
def test_hug_mp_ends_lie_on_a_board_of_targets() -> None:
    """Reaches to one target end together, in front of the person, and others elsewhere."""
    ends: dict[str, list[np.ndarray]] = {}
    for capture in load_captures("hug_mp:S01:all"):
        ends.setdefault(capture.name.rsplit("-", 1)[1], []).append(capture.motion.hand[-1])
    assert len(ends) == 7
    means = {target: np.mean(places, axis=0) for target, places in ends.items()}
    for target, places in ends.items():
        assert np.linalg.norm(places - means[target], axis=1).mean() < 0.03
        assert means[target][0] > 0.25  # forward of the shoulder
    apart = [np.linalg.norm(a - b) for i, a in means.items() for j, b in means.items() if i < j]
    assert min(apart) > 0.05


def chest_frame_landmarks(content: dict[str, Any], name: str) -> np.ndarray:
    """Return the arm in the chest's frame by quaternions, every joint of the skeleton visited.

    local = prerot * exp(channel), global by the recursion with offsets; the chest's frame is the
    one it has in the zero pose, turned from x left, y up, z forward to x forward, y left, z up.
    """
    joints = content["joint"].tolist()
    expmap = content[f"{name}|expmap"].astype(float)
    frames = len(expmap)
    position, turn, upright = {}, {}, {}
    for joint, parent in enumerate(content["parent"].tolist()):
        before = Rotation.from_quat(content["prerot_xyzw"][joint])
        local = before * Rotation.from_rotvec(expmap[:, joint])
        offset = content["offset"][joint].astype(float)
        if parent < 0:
            position[joint] = content[f"{name}|root"] + offset
            turn[joint], upright[joint] = local, before
        else:
            position[joint] = position[parent] + turn[parent].apply(offset)
            turn[joint], upright[joint] = turn[parent] * local, upright[parent] * before
    chest = joints.index("JtSpineC")
    arm = ["JtShoulderRt", "JtElbowRt", "JtWristRt", "JtMiddleARt"]
    result = np.empty((frames, 4, 3))
    for row, joint in enumerate(arm):
        away = position[joints.index(joint)] - position[joints.index(arm[0])]
        left, up, forward = upright[chest].apply(turn[chest].inv().apply(away)).T
        result[:, row] = np.stack([forward, left, up], axis=1)
    return result


def test_garza_is_the_recursion_of_its_readme(captures: Path, free: dict[str, Motion]) -> None:
    with np.load(captures / GARZA) as file:
        content = {key: file[key] for key in file.files}
    assert list(free) == content["motions"].tolist()
    for name in list(free)[::5]:
        motion = free[name]
        assert motion.landmarks is not None
        expected = chest_frame_landmarks(content, name)
        np.testing.assert_allclose(motion.landmarks, expected, atol=1e-6)
        np.testing.assert_allclose(motion.time, content[f"{name}|t"])
        assert motion.landmark_names == ("shoulder", "elbow", "wrist", "hand")


def test_garza_segments_are_rigid_and_an_arms(free: dict[str, Motion]) -> None:
    lengths = []
    for motion in free.values():
        assert motion.landmarks is not None
        segments = np.linalg.norm(np.diff(motion.landmarks, axis=1), axis=2)
        assert np.ptp(segments, axis=0).max() < 1e-6
        lengths.append(segments[0])
    assert np.ptp(lengths, axis=0).max() < 1e-6
    upper, fore, hand = lengths[0]
    assert 0.25 < upper < 0.36
    assert 0.2 < fore < 0.32
    assert 0.05 < hand < 0.2


@pytest.mark.usefixtures("captures")
def test_garza_reaches_end_where_their_names_say() -> None:
    ends = {c.name.removeprefix("garza:"): c.motion.hand[-1] for c in load_captures("garza")}
    starts = [capture.motion.hand[0] for capture in load_captures("garza")]
    assert (np.array(starts)[:, 2] < -0.35).all()  # all from beside the body, the arm hanging
    # As the chest sees them: it bends towards the floor and what is far
    for side in ("Forward", "Right30", "Right120", "Left30", "Left60", "Back"):
        assert ends[f"{side}High"][2] > ends[f"{side}Low"][2] + 0.2, side
    for side in ("Right30", "Right120", "Left30", "Left60", "Back"):
        near, mid = (np.linalg.norm(ends[f"{side}Medium{far}"]) for far in ("Near", "Mid"))
        assert near < mid - 0.1, side
    assert ends["ForwardMediumMid"][0] > 0.3
    assert ends["Left60MediumMid"][1] > ends["ForwardMediumMid"][1] > ends["Right120MediumMid"][1]


def _damaged(data: bytes) -> dict[str, bytes]:
    """Ways in which files arrive: nothing, cut short at any place, with bytes changed."""
    numbers = random.Random(1)  # noqa: S311 - to damage files, not to hide anything
    found = {"empty": b"", "text": b"subject,rep\n1,2\n", "zeros": bytes(200)}
    for index in range(12):
        found[f"cut {index}"] = data[: numbers.randrange(len(data))]
        changed = bytearray(data)
        for _ in range(3):
            changed[numbers.randrange(len(data))] ^= 1 + numbers.randrange(255)
        found[f"changed {index}"] = bytes(changed)
        head = bytearray(data)
        head[numbers.randrange(600)] ^= 1 + numbers.randrange(255)
        found[f"head {index}"] = bytes(head)
    return found


@pytest.mark.parametrize(("read", "source"), [(read_hug_mp, HUG_MP), (read_garza, GARZA)])
def test_damaged_files_are_refused_by_name(
    captures: Path, tmp_path: Path, read: Callable[[Path], Any], source: Path
) -> None:
    path = tmp_path / source.name
    kept = 0
    for what, content in _damaged((captures / source).read_bytes()).items():
        path.write_bytes(content)
        try:
            read(path)
        except FormatError as error:
            said = str(error)
        else:
            kept += 1
            said = str(path) if what.startswith(("head", "changed")) else ""  # a byte nobody reads
        assert said.startswith(str(path)), what
    assert kept < 8
    with pytest.raises(FileNotFoundError):
        read(tmp_path / "absent")


@pytest.mark.parametrize(
    "content", [{"a": np.zeros(3), "b": np.zeros(3)}, {"a": np.zeros((3, 3))}, {"a": "text"}]
)
def test_another_mat_file_is_refused(tmp_path: Path, content: dict[str, Any]) -> None:
    path = tmp_path / "other.mat"
    savemat(path, content)
    with pytest.raises(FormatError, match="not a capture of the HuG-MP set"):
        read_hug_mp(path)


def test_other_npz_files_are_refused(tmp_path: Path, captures: Path) -> None:
    path = tmp_path / "other.npz"
    np.savez(path, motions=["a"])
    with pytest.raises(FormatError, match="no key 'joint'"):
        read_garza(path)
    with np.load(captures / GARZA) as file:
        content = {key: file[key] for key in file.files if "|" not in key}
        name = content["motions"][0]
        content |= {key: file[key] for key in file.files if key.startswith(f"{name}|")}
    content["motions"] = np.array([name])
    np.savez(path, **{**content, "parent": np.roll(content["parent"], -1) * 0 + 1})
    with pytest.raises(FormatError, match="-1 for its first"):
        read_garza(path)
    np.savez(path, **{**content, "joint": np.char.add("other", content["joint"])})
    with pytest.raises(FormatError, match=r"not a capture of the garza set: .*no joint"):
        read_garza(path)
