"""The atlases that come with armsyn: small, of their arms, and what they predict holds."""

from pathlib import Path

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.errors import RefusedMotionError
from armsyn.motion.filtering import hand_speed
from armsyn.motion.peaks import count_peaks
from armsyn.planning.atlas import Atlas, atlas_of
from armsyn.planning.motion_planner import MotionPlanner
from armsyn.planning.synergy_atlas import SynergyPredictor
from armsyn.synergy.models import STABLE_GAIN

ROOT = Path(__file__).resolve().parents[2]
ARMS = ("human7", "widowx_250s", "viperx_300s", "openmanipulator_x", "koch")
PHASE_STEP = 0.01


@pytest.fixture(params=ARMS)
def atlas(request: pytest.FixtureRequest) -> Atlas:
    return atlas_of(load_arm(request.param, calibrated=False), ROOT / "calibration")


def asked(atlas: Atlas, count: int = 120) -> tuple[np.ndarray, np.ndarray]:
    """Starts at rest and random targets among the captured ones, well away from the hand."""
    arm = load_arm(atlas.facts.arm, calibrated=False)
    hull = atlas.predictor("linear").hull  # type: ignore[attr-defined]
    corners = hull.triangles.reshape(-1, 3)
    targets = np.random.default_rng(1).uniform(corners.min(axis=0), corners.max(axis=0), (4000, 3))
    away = np.linalg.norm(targets - arm.chain.forward(arm.rest).tip, axis=1)
    inside = targets[(hull.outside(targets) == 0) & (away > 0.2 * arm.chain.reach)][:count]
    return np.repeat(arm.rest[None], len(inside), axis=0), inside


def test_a_file_is_small_and_says_where_it_comes_from(atlas: Atlas) -> None:
    file = ROOT / "calibration" / f"{atlas.facts.arm}.atlas.json"
    assert file.stat().st_size < 300_000
    assert atlas.kinds == ("linear", "latent", "synergy")
    assert atlas.facts.captures == "garza:all"
    assert atlas.facts.subjects == ("garza",)
    assert atlas.facts.reaches >= 60
    assert atlas.facts.repeats.startswith("hug_mp:S01")
    assert atlas.variability is not None
    notice = (ROOT / "NOTICE").read_text()
    assert "calibration/*.atlas.json" in notice
    assert "SmartBody" in notice


def test_every_plan_ends_within_a_millimetre(atlas: Atlas) -> None:
    starts, targets = asked(atlas)
    assert len(targets) > 50
    for kind in atlas.kinds:
        found = atlas.predictor(kind).predict(starts, targets)
        assert found.reached.mean() > 0.97, kind
        assert (found.angles[:, 0] == starts).all()
        assert not found.outside.any()
        assert found.durations.min() > 0.5
        assert found.durations.max() < 3.0


def test_synergies_contract_wherever_the_target_lies(atlas: Atlas) -> None:
    """J G J^+ has its eigenvalues between the gains, all positive (performance.md)."""
    predictor = atlas.predictor("synergy")
    assert isinstance(predictor, SynergyPredictor)
    starts, targets = asked(atlas, 30)
    far = np.concatenate([targets, 3.0 * targets])
    gains = predictor.family.synergies(
        predictor.coordinates(np.concatenate([starts, starts]), far)
    ).gains
    assert (gains >= STABLE_GAIN).all()
    step = predictor.family.lambda_ * predictor.family.duration / 200
    assert step * gains.max() < 2.0
    end = predictor.predict(starts, targets).angles[:, -1]
    for posture, own in zip(end, gains, strict=False):
        J = predictor.chain.jacobian(posture)
        if np.linalg.cond(J) < 1e3:
            values = np.linalg.eigvals(J @ np.diag(own) @ np.linalg.pinv(J)).real
            assert own.min() - 1e-6 < values.min()
            assert values.max() < own.max() + 1e-6


def test_synergies_move_the_hand_in_one_bell(atlas: Atlas) -> None:
    predictor = atlas.predictor("synergy")
    found = predictor.predict(*asked(atlas))
    single = 0
    for angles, duration in zip(found.angles, found.durations, strict=True):
        hand = predictor.chain.positions(angles)[:, -1]
        rate = 1.0 / (PHASE_STEP * duration)
        speed = np.linalg.norm(np.diff(hand, axis=0), axis=1) * rate
        single += count_peaks(speed, rate) == 1
    assert single >= 0.8 * len(found.angles)


@pytest.mark.parametrize("kind", ["latent", "linear", "synergy"])
def test_what_is_planned_from_anywhere_goes_in_one_bell(atlas: Atlas, kind: str) -> None:
    """Whatever is predicted: counted over the whole reach, as any motion is measured."""
    arm, rng = load_arm(atlas.facts.arm, calibrated=False), np.random.default_rng(4)
    postures = rng.uniform(arm.chain.lower, arm.chain.upper, (2, 20, arm.chain.dof))
    planner, made = MotionPlanner(arm, atlas.predictor(kind)), 0
    for start, end in postures.swapaxes(0, 1):
        try:
            planned = planner.plan(start, arm.chain.forward(end).tip)
        except RefusedMotionError:
            continue
        hand = arm.chain.positions(planned.angles)[:, -1]
        profile = hand_speed(planned.trajectory.time, hand)
        assert count_peaks(profile.speed, profile.rate) <= 1
        made += 1
    assert made >= 3
