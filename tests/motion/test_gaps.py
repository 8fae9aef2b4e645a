"""Gaps are found, filled only when short enough, and marked, whatever becomes of the motion."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from armsyn.errors import FormatError, InputError
from armsyn.motion import Motion
from armsyn.motion.formats import read_motion, write_motion
from armsyn.motion.gaps import fill_gaps, find_gaps
from armsyn.motion.resample import resample

TIME = np.arange(40) / 100
CUBIC = np.stack([TIME**3, 1 - TIME**2, 2 * TIME], axis=1)


def with_gaps(*gaps: tuple[int, int]) -> Motion:
    """Motion of a cubic with gaps of a landmark, both ends included; another landmark has none."""
    hand = CUBIC.copy()
    for first, last in gaps:
        hand[first : last + 1, 1] = np.nan  # one coordinate is enough
    return Motion(TIME, landmark_names=("hip", "hand"), landmarks=np.stack([CUBIC, hand], axis=1))


def test_gaps_are_found_with_their_lengths() -> None:
    found = find_gaps(with_gaps((0, 2), (10, 10), (20, 24), (38, 39)))
    assert [gap[:3] for gap in found] == [
        *(("hand", 0, 2), ("hand", 10, 10), ("hand", 20, 24), ("hand", 38, 39))
    ]
    assert [gap.seconds for gap in found] == pytest.approx([np.inf, 0.02, 0.06, np.inf])


@given(arrays(np.bool_, 40))
def test_gaps_are_every_frame_that_was_not_seen(unseen: np.ndarray) -> None:
    motion = with_gaps(*((frame, frame) for frame in np.flatnonzero(unseen)))
    covered = np.zeros(40, dtype=bool)
    for gap in find_gaps(motion):
        assert not covered[gap.first : gap.last + 1].any()
        covered[gap.first : gap.last + 1] = True
    np.testing.assert_array_equal(covered, unseen)


def test_short_gaps_are_filled_by_the_cubic_and_marked() -> None:
    gappy = with_gaps((0, 2), (10, 12), (20, 29), (39, 39))
    filled = fill_gaps(gappy, 0.05)
    assert filled.landmarks is not None
    assert filled.filled is not None
    assert np.argwhere(filled.filled).tolist() == [[10, 1], [11, 1], [12, 1]]
    np.testing.assert_allclose(filled.landmarks[10:13, 1], CUBIC[10:13], atol=1e-12)
    assert [gap.first for gap in find_gaps(filled)] == [0, 20, 39]
    further = fill_gaps(filled, 0.5)  # what was filled stays marked
    assert further.filled is not None
    assert np.flatnonzero(further.filled[:, 1]).tolist() == [10, 11, 12, *range(20, 30)]
    assert np.isnan(further.hand[[0, 39]]).any(axis=1).all()


def test_a_gap_of_just_the_longest_is_filled_at_any_time() -> None:
    for first in range(1, 33):
        gappy = with_gaps((first, first + 3))  # 0.05 s, give or take the rounding of the stamps
        assert fill_gaps(gappy, 0.05).filled is not None


def test_nothing_to_fill_is_the_same_motion() -> None:
    whole, ends = with_gaps(), with_gaps((0, 5))
    assert fill_gaps(whole, 1) is whole
    assert fill_gaps(ends, 1) is ends
    lonely = with_gaps((1, 38))  # two frames make no cubic
    assert fill_gaps(lonely, 1).filled is None


@pytest.mark.parametrize("longest", [0, -1, np.nan, np.inf])
def test_a_longest_gap_is_a_positive_time(longest: float) -> None:
    with pytest.raises(InputError, match="positive"):
        fill_gaps(with_gaps(), longest)


@pytest.mark.parametrize("suffix", [".csv", ".npz"])
def test_marks_survive_files_cuts_and_resampling(tmp_path: Path, suffix: str) -> None:
    filled = fill_gaps(with_gaps((10, 12)), 1)
    write_motion(tmp_path / f"a{suffix}", filled)
    again = read_motion(tmp_path / f"a{suffix}")
    assert again.filled is not None
    np.testing.assert_array_equal(again.filled, filled.filled)
    cut = again.between(12, 39)
    assert cut.filled is not None
    assert np.argwhere(cut.filled).tolist() == [[0, 1]]
    assert again.between(13, 39).filled is None
    faster = resample(again, 200)
    assert faster.filled is not None
    assert np.flatnonzero(faster.filled[:, 1]).tolist() == [*range(19, 26)]


@given(st.sampled_from([(40,), (39, 2), (40, 3)]))
def test_marks_of_another_shape_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(FormatError, match="marks of what was filled"):
        Motion(
            TIME,
            landmark_names=("hip", "hand"),
            landmarks=np.stack([CUBIC] * 2, axis=1),
            filled=np.zeros(shape, dtype=bool),
        )
