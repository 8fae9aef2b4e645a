"""Movements of a recording: made ones with known ends, and captured ones against their table."""

import csv
import itertools
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.signal import find_peaks

from armsyn.errors import CaptureError
from armsyn.motion import FloatArray, Motion
from armsyn.motion.filtering import hand_speed
from armsyn.motion.formats import read_body, read_motion
from armsyn.motion.formats.hug_mp import read_hug_mp
from armsyn.motion.movements import Movement, ReachRule, find_movements
from armsyn.motion.peaks import count_prominent_peaks

RATE = 100
RULE = ReachRule()


def minimum_jerk(length: float, duration: float) -> FloatArray:
    phase = np.linspace(0, 1, round(duration * RATE) + 1)
    return np.asarray(length * (10 * phase**3 - 15 * phase**4 + 6 * phase**5))


def path(*parts: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Along x, each part going on from where the last one ended."""
    along = [np.zeros(1)]
    for part in parts:
        along.append(part[1:] - part[0] + along[-1][-1])
    x = np.concatenate(along)
    return np.arange(x.size) / RATE, np.stack([x, np.zeros_like(x), np.zeros_like(x)], axis=1)


def rest(seconds: float) -> FloatArray:
    return np.zeros(round(seconds * RATE) + 1)


def test_a_reach_between_rests_is_cut_where_minimum_jerk_says() -> None:
    (found,) = find_movements(*path(rest(0.5), minimum_jerk(0.4, 1.0), rest(0.5)), cutoff=None)
    assert found.duration == pytest.approx(0.88113, abs=0.002)
    assert found.onset == pytest.approx(0.5 + (1 - 0.88113) / 2, abs=0.002)
    assert found.displacement == pytest.approx(0.4 * 0.99617, abs=1e-3)
    assert found.path == pytest.approx(found.displacement, rel=1e-3)
    assert found.time_to_peak == pytest.approx(0.5, abs=0.005)
    assert found.peak_speed == pytest.approx(1.875 * 0.4, rel=1e-3)
    assert (found.peaks, found.prominent_peaks) == (1, 1)
    assert found.first == 55
    assert found.last == 145


def test_out_and_back_without_a_rest_are_two() -> None:
    out = minimum_jerk(0.4, 1.0)
    found = find_movements(*path(rest(0.5), out, out[::-1], rest(0.5)))
    assert [movement.displacement for movement in found] == pytest.approx([0.4, 0.4], abs=0.01)
    assert found[0].offset < 1.5 < found[1].onset


def test_a_pause_on_the_way_parts_no_movement_unless_it_is_a_rest() -> None:
    half = minimum_jerk(0.2, 0.6)
    assert len(find_movements(*path(rest(0.5), half, half, rest(0.5)))) == 1
    assert len(find_movements(*path(rest(0.5), half, rest(0.4), half, rest(0.5)))) == 2


def test_settling_belongs_to_no_movement() -> None:
    time, positions = path(
        rest(0.5), minimum_jerk(0.4, 1.0), minimum_jerk(-0.015, 0.5), minimum_jerk(0.01, 0.5)
    )
    (found,) = find_movements(time, positions)
    assert found.offset < 1.5


def test_what_is_cut_while_moving_says_so() -> None:
    time, positions = path(rest(0.5), minimum_jerk(0.6, 1.0))
    (found,) = find_movements(time[:110], positions[:110])
    assert found.last == 109
    assert "ends while moving" in RULE.fault(found, whole(time[:110], positions[:110]))
    (found,) = find_movements(time[90:], positions[90:])
    assert "begins while moving" in RULE.fault(found, whole(time[90:], positions[90:]))


def whole(time: FloatArray, positions: FloatArray, **parts: FloatArray) -> Motion:
    landmarks = np.stack([*parts.values(), positions], axis=1)
    return Motion(time, landmark_names=(*parts, "hand"), landmarks=landmarks, source="made")


def test_gaps_of_the_hand_cut_and_those_of_others_are_named() -> None:
    time, positions = path(rest(0.5), minimum_jerk(0.6, 1.0), rest(0.5))
    elbow = positions.copy()
    elbow[100] = np.nan
    (found,) = find_movements(time, positions)
    fault = RULE.fault(found, whole(time, positions, elbow=elbow))
    assert fault == "elbow has a gap at frame 100"
    before, after = find_movements(time, elbow)
    assert before.last == 99
    assert after.first == 101
    assert "ends while moving" in RULE.fault(before, whole(time, elbow))
    assert "begins while moving" in RULE.fault(after, whole(time, elbow))


def test_rules_are_told_apart() -> None:
    time, positions = path(rest(0.5), minimum_jerk(0.2, 1.0), rest(0.5))
    (found,) = find_movements(time, positions)
    assert "under 0.25" in RULE.fault(found, whole(time, positions))
    assert ReachRule(displacement=0.1).fault(found, whole(time, positions)) == ""
    third = minimum_jerk(0.15, 0.5)
    time, positions = path(rest(0.5), third, third, third, rest(0.5))
    (found,) = find_movements(time, positions)
    assert "3 speed peaks" in RULE.fault(found, whole(time, positions))


def test_nothing_to_find_is_refused() -> None:
    with pytest.raises(CaptureError, match="no movement"):
        find_movements(*path(rest(1.0)))
    time, positions = path(rest(0.5), minimum_jerk(0.6, 1.0))
    with pytest.raises(CaptureError, match="no movement"):
        find_movements(time, np.full_like(positions, np.nan))


@given(
    st.lists(
        st.tuples(st.floats(0.1, 0.6), st.floats(0.5, 2.0), st.floats(0.4, 1.0)),
        min_size=1,
        max_size=5,
    )
)
def test_every_reach_between_rests_is_found(reaches: list[tuple[float, float, float]]) -> None:
    parts = [rest(0.5)]
    for length, duration, pause in reaches:
        parts += [minimum_jerk(length, duration), rest(pause)]
    time, positions = path(*parts)
    # The slowest must stay over the fraction of the fastest's peak that counts as resting
    found = find_movements(time, positions, fraction=0.02)
    assert len(found) == len(reaches)
    for movement, (length, duration, _) in zip(found, reaches, strict=True):
        assert movement.displacement == pytest.approx(length, rel=0.02)
        assert movement.duration == pytest.approx(duration, rel=0.2)
    assert all(a.offset < b.onset for a, b in itertools.pairwise(found))


@given(
    arrays(np.float64, st.tuples(st.integers(5, 40), st.just(3)), elements=st.floats(-1, 1)),
    st.floats(0, 0.99),
)
def test_any_path_gives_ordered_movements_or_a_refusal(path: FloatArray, fraction: float) -> None:
    time = np.arange(len(path)) / 30
    try:
        found = find_movements(time, path, fraction=fraction)
    except CaptureError:
        assert np.ptp(path, axis=0).max() < 1e-6
        return
    ends = [end for movement in found for end in (movement.onset, movement.offset)]
    assert ends == sorted(ends)
    for movement in found:
        assert 0 <= movement.first < movement.last < len(path)
        assert movement.onset <= movement.peak_time <= movement.offset
        assert movement.displacement <= movement.path + 1e-9
        assert movement.prominent_peaks >= 1


@given(
    # No two alike: to scipy, neither of two equal peaks is the higher one on the other's way
    st.lists(st.integers(0, 2000), min_size=1, max_size=60, unique=True).filter(any),
    st.floats(0.05, 0.9),
)
def test_prominent_peaks_are_those_of_scipy(values: list[int], prominence: float) -> None:
    speed = np.array(values, dtype=np.float64)
    least = np.floor(prominence * float(speed.max())) + 0.5
    oracle = find_peaks(np.concatenate([[0.0], speed, [0.0]]), prominence=least)[0]
    assert count_prominent_peaks(speed, least / float(speed.max())) == len(oracle)


def segments(captures: Path, name: str) -> list[dict[str, str]]:
    with (captures / "segments" / name).open(newline="") as file:
        return list(csv.DictReader(file))


def compared(
    rows: list[dict[str, str]], found: list[Movement]
) -> Iterator[tuple[dict[str, str], Movement, int, int]]:
    """Rows of a table, each with the movement that shares most of its frames, and the errors."""
    for row in rows:
        first, last = int(row["start_frame"]), int(row["end_frame"])
        best = max(found, key=lambda one: min(one.last, last) - max(one.first, first))
        yield row, best, best.first - first, best.last - last


def test_garza_is_cut_as_in_the_table(captures: Path) -> None:
    rows = segments(captures, "garza.csv")
    pairs: list[tuple[dict[str, str], Movement, int, int]] = []
    for name in dict.fromkeys(row["file"].removesuffix(".skm") for row in rows):
        body = read_body(f"{captures}/reach/garza/reach.npz#{name}")
        wrist = body.positions()[:, body.skeleton.index("JtWristRt")]
        own = [row for row in rows if row["file"].startswith(name)]
        pairs += compared(own, find_movements(body.time, wrist))
    assert len(pairs) == 70
    assert max(max(abs(onset), abs(offset)) for _, _, onset, offset in pairs) <= 1
    assert all(one.prominent_peaks == int(row["n_speed_peaks"]) for row, one, _, _ in pairs)
    for row, one, _, _ in pairs:
        assert one.displacement == pytest.approx(float(row["displacement_m"]), abs=0.005)


def test_ulema_is_cut_as_in_the_table(captures: Path) -> None:
    """The table's cut there is 8 %; it joins the last reach of RF2 and its way back, twice."""
    different = []
    for name in ("HTH1", "RF1", "RF2"):
        motion = read_motion(captures / "reach" / "ulema" / f"{name}.c3d")
        assert motion.landmarks is not None
        hand = motion.landmarks[:, motion.landmark_names.index("LMC3")]
        found = find_movements(motion.time, hand, fraction=0.08)
        assert len(found) == 8
        rows = [row for row in segments(captures, "ulema.csv") if row["file"].startswith(name)]
        different += [
            (name, int(row["start_frame"]), int(row["end_frame"]))
            for row, _, onset, offset in compared(rows, found)
            if max(abs(onset), abs(offset)) > 1
        ]
    assert different == [("RF2", 707, 879), ("RF2", 706, 880)]


def test_hug_mp_is_usable_as_in_the_table(captures: Path) -> None:
    """One in 1222 differs: there the hand creeps on after its reach, and the table goes on, too."""
    rows = segments(captures, "hug_mp.csv")
    motions = {
        subject: read_hug_mp(captures / "reach" / "hug_mp" / f"{subject}_trajs.mat")
        for subject in ("S01", "S02", "S03", "S04")
    }
    agree = starts = 0
    for row in rows:
        key = int(row["rep"]), int(row["task"]), int(row["motion"])
        motion = motions[row["subject"]][key]
        found = find_movements(motion.time, motion.hand)
        main = max(found, key=lambda one: one.path)
        agree += (RULE.fault(main, motion) == "") == (row["usable"] == "True")
        starts += main.first <= 10
    assert len(rows) == 1222
    assert agree >= 1221
    assert starts >= 0.95 * len(rows)


def test_golf_swings_turn_at_the_top_as_in_the_table(captures: Path) -> None:
    """The table's low-pass is 20 Hz there; its takeaway is 5 % of the swing's highest speed, where
    a movement's onset is 5 % of its own: the backswing's, 11-15 frames earlier.
    """
    for row in segments(captures, "golf.csv")[:13]:
        body = read_body(f"{captures}/golf/gears.npz#swing{int(row['file']):02d}")
        # Beyond these frames markers are missing (the captures' README)
        shift = 2 if row["file"] == "11" else 0
        body = body.between(2, 320) if shift else body
        hand = body.positions()[:, body.skeleton.index("left_wrist")]
        back, down = find_movements(body.time, hand, cutoff=20.0)
        assert down.first + shift == pytest.approx(int(row["top_frame"]), abs=1)
        assert abs(back.last - down.first) <= 1
        assert round(down.peak_time * 240) + shift == int(row["peak_hand_speed_frame"])
        assert down.peak_speed == pytest.approx(float(row["peak_hand_speed"]), abs=0.006)
        if not shift:
            assert 11 <= int(row["takeaway_frame"]) - back.first <= 15
            speed = hand_speed(body.time, hand, cutoff=20.0, rest=0.0).speed
            first = int(np.argmax(speed >= 0.05 * speed.max()))
            assert first == int(row["takeaway_frame"])
