"""Captured reaches on an arm: joint angles that follow the landmarks without jumps."""

from pathlib import Path

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.errors import CaptureError
from armsyn.motion.captures import load_captures
from armsyn.motion.retargeting import retarget
from armsyn.planning.continuous import continuous_postures
from armsyn.planning.examples import PHASE, examples_of_people, examples_on_arm
from armsyn.planning.postures import tips


def test_a_motion_of_the_arm_itself_is_found_in_its_landmarks() -> None:
    arm = load_arm("human7", calibrated=False)
    far = arm.rest + np.array([0.6, 0.3, -0.4, 0.7, 0.2, 0.1, 0.1])
    motion = arm.rest + (far - arm.rest) * (3 * PHASE**2 - 2 * PHASE**3)[:, None]
    rows = list(arm.landmark_frames)
    landmarks = arm.chain.positions(motion)[:, rows]
    found = continuous_postures(arm.chain, arm.landmark_frames, landmarks, arm.rest)
    gaps = np.linalg.norm(arm.chain.positions(found)[:, rows] - landmarks, axis=2)
    assert gaps.max() < 3e-3
    assert np.abs(np.diff(found, axis=0)).max() < 0.03
    assert (found >= arm.chain.lower).all()
    assert (found <= arm.chain.upper).all()


def test_joints_do_not_swing_where_an_arm_passes_a_singularity(captures: Path) -> None:
    """Fitted frame by frame, two joints of this reach turn by 0.6 rad in a hundredth of it."""
    assert captures
    arm = load_arm("human7", calibrated=False)
    (capture,) = load_captures("garza:BackHigh")
    done: list[tuple[int, int]] = []
    found = examples_on_arm(arm, [capture], "segment", lambda *count: done.append(count))
    assert np.abs(np.diff(found.angles[0], axis=0)).max() < 0.12
    assert done == [(1, 1)]
    assert (found.subjects, found.places) == (("garza",), ("BackHigh",))
    assert np.allclose(tips(arm.chain, found.angles[:, -1]), found.targets)
    wanted = retarget(capture.motion, arm).landmarks
    assert wanted is not None
    fitted = arm.chain.positions(found.angles[0])[:, list(arm.landmark_frames)]
    assert np.linalg.norm(fitted[[0, -1]] - wanted[[0, -1]], axis=2).max() < 0.015


def test_nothing_captured_is_refused() -> None:
    with pytest.raises(CaptureError, match="no captured"):
        examples_on_arm(load_arm("koch", calibrated=False), [])


def test_examples_of_a_person_end_at_their_targets(captures: Path) -> None:
    assert captures
    examples = examples_of_people("S01")
    assert examples.size == 100
    assert set(examples.subjects) == {"S01"}
    assert len(set(examples.places)) == 7
    assert examples.angles.shape == (100, 101, 4)
    assert np.allclose(tips(examples.chain, examples.angles[:, -1]), examples.targets)
    whole = examples_of_people("S01", cut="segment")
    assert (whole.durations > examples.durations).mean() > 0.9
    some = examples.only(np.array(examples.places) == "R-9")
    assert set(some.places) == {"R-9"}
    assert some.size == examples.places.count("R-9")
