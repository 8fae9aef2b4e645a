"""The compiled controller against the paper's equations played step by step over Pinocchio."""

import dataclasses

import numpy as np
import pinocchio as pin
import pytest

from armsyn.arm import ArmDescription
from armsyn.errors import InputError
from armsyn.ik import OPTIMISERS
from armsyn.kinematics import SerialChain
from armsyn.synergy import MODELS, Controller, synergies
from armsyn.synergy.controller import ARM_RATES, RATES
from armsyn.synergy.models import parameter_bounds
from tests.kinematics.oracle import Oracle
from tests.synergy.plain import Plain, Sigmoids

TARGET = np.array([0.35, -0.15, -0.12])
DT = 0.01


def vector(model: str, rng: np.random.Generator) -> np.ndarray:
    """A vector whose sigmoids rise within the second that is played."""
    lower, upper = parameter_bounds(model, 7, stable=False)
    if model in "CD":
        upper[7 : 7 + (lower.size - 7) // 2] = 4.0
    lower[: 1 if model == "A" else 7] = -0.5  # some gains are negative, none runs away
    upper[: 1 if model == "A" else 7] = 2.0
    return rng.uniform(lower, upper)


@pytest.mark.parametrize("pose", [False, True], ids=["position", "pose"])
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("ik", OPTIMISERS)
def test_a_roll_out_is_the_papers_loop(
    human7: ArmDescription, ik: str, model: str, pose: bool
) -> None:
    rng = np.random.default_rng([ord(letter) for letter in ik + model])
    chain, rate = human7.chain, RATES[ik]
    wanted = Oracle(chain).frames(rng.uniform(0.3, 0.7, 7))[1][-1] if pose else None
    for _ in range(3):
        p = vector(model, rng)
        start = human7.rest + rng.uniform(-0.02, 0.3, 7)
        played = Controller(chain, ik).synthesize(
            start, TARGET, synergies(model, 7, p), dt=DT, frames=100, orientation=wanted
        )
        plain = Plain(chain, ik, rate, DT)
        path = plain.play(start, TARGET, Sigmoids(model, 7, p), 100, wanted)
        np.testing.assert_allclose(played.angles, path, rtol=0, atol=1e-8)
        np.testing.assert_array_equal(played.time, np.arange(100) * DT)
        positions = np.array([Oracle(chain).frames(q)[0] for q in path])
        np.testing.assert_allclose(played.positions, positions, rtol=0, atol=1e-8)
        miss = np.linalg.norm(positions[-1, -1] - TARGET)
        assert played.distance == pytest.approx(miss, abs=1e-8)


@pytest.mark.parametrize("ik", OPTIMISERS)
def test_one_step_is_lambda_dt_phi_gain_times_o(human7: ArmDescription, ik: str) -> None:
    p = np.array([1.5, -0.5, 0.8, 1.2, 0.3, 2.0, -1.0, 2.0, 5.0])
    start = np.array([0.3, 0.4, 0.5, 1.0, 0.1, 0.2, 0.1])
    played = Controller(human7.chain, ik, 2.0).synthesize(
        start, TARGET, synergies("C", 7, p), dt=0.005, frames=2
    )
    oracle = Oracle(human7.chain)
    J, dX = oracle.jacobian(start)[:3], TARGET - oracle.frames(start)[0][-1]
    change = {
        "svd": np.linalg.pinv(J) @ dX,
        "jt": J.T @ dX,
        "njt": J.T @ dX / np.linalg.norm(J.T @ dX) * np.linalg.norm(dX) / 0.5,
        "dls": np.linalg.solve(J.T @ J + 0.05**2 * np.eye(7), J.T @ dX),
    }[ik]
    phi = 1 / (1 + np.exp(2.0))  # at t = 0
    wanted = start + phi * p[:7] * 2.0 * 0.005 * change
    np.testing.assert_allclose(played.angles[1], wanted, rtol=0, atol=1e-12)


@pytest.mark.parametrize("limit_rate", [np.inf, 10.0])
@pytest.mark.parametrize("ik", OPTIMISERS)
def test_limits_clamp_or_damp_as_the_plain_loop(
    human7: ArmDescription, ik: str, limit_rate: float
) -> None:
    chain = human7.chain
    rng = np.random.default_rng(7)
    met = 0
    for _ in range(10):
        far = rng.normal(size=3)
        far *= 0.5 / np.linalg.norm(far)  # anywhere, so mostly where limits are in the way
        start = rng.uniform(chain.lower, chain.upper)
        p = np.concatenate([rng.uniform(0.25, 3, 7), [1.0, 9.0]])
        played = Controller(chain, ik).synthesize(
            start, far, synergies("C", 7, p), dt=DT, frames=60, limit_rate=limit_rate
        )
        plain = Plain(chain, ik, RATES[ik], DT, limit_rate=limit_rate)
        path = plain.play(start, far, Sigmoids("C", 7, p), 60)
        np.testing.assert_allclose(played.angles, path, rtol=0, atol=1e-6)
        assert (played.angles >= chain.lower).all()
        assert (played.angles <= chain.upper).all()
        margin = np.minimum(path - chain.lower, chain.upper - path)
        if np.isfinite(limit_rate):  # nears a limit by a tenth a step at most: never meets it
            met += int((margin[-1] < 0.1).sum())
            assert (margin[1:] >= 0.9 * margin[:-1] - 1e-12).all()
            assert (played.angles > chain.lower).all()
            assert (played.angles < chain.upper).all()
        else:
            met += int((margin[-1] == 0.0).sum())
    assert met >= 5


@pytest.mark.parametrize("ik", OPTIMISERS)
def test_halving_dt_changes_a_motion_in_proportion_to_dt(human7: ArmDescription, ik: str) -> None:
    p = np.array([1.4, 0.7, 1.1, 0.9, 0.6, 1.2, 0.8, 3.0, 6.0])

    def end(steps: int) -> np.ndarray:
        rolled = Controller(human7.chain, ik).synthesize(
            human7.rest, TARGET, synergies("C", 7, p), dt=1.0 / steps, frames=steps + 1
        )
        return rolled.angles[-1]

    limit = end(25_600)
    errors = [float(np.linalg.norm(end(steps) - limit)) for steps in (100, 200, 400)]
    assert 1e-4 < errors[0] < 0.1
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.25)
    assert errors[1] / errors[2] == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize("ramp", [0.0, 0.1])
@pytest.mark.parametrize("ik", OPTIMISERS)
def test_time_scale_is_the_same_path_at_stretched_times(
    human7: ArmDescription, ik: str, ramp: float
) -> None:
    def play(kappa: float, dt: float, frames: int) -> np.ndarray:
        p = [1.4, 0.7, 1.1, 0.9, 0.6, 1.2, 0.8, 3.0, 6.0]
        rolled = Controller(human7.chain, ik).synthesize(
            human7.rest,
            TARGET,
            synergies("C", 7, p),
            dt=dt,
            frames=frames,
            time_scale=kappa,
            ramp=ramp,
            limit_rate=10.0,
        )
        return rolled.angles

    original = play(1.0, 0.01, 151)
    # Same number of steps a motion: the same numbers
    np.testing.assert_allclose(play(1.7, 0.017, 151), original, rtol=0, atol=1e-12)
    # Same step in seconds: the same path to the order of dt
    slowed = play(2.0, 0.01, 301)
    assert np.abs(slowed[::2] - original).max() < 0.03
    finer = np.abs(play(2.0, 0.001, 3001)[::20] - play(1.0, 0.001, 1501)[::10]).max()
    assert finer < 0.15 * np.abs(slowed[::2] - original).max()


def test_the_ramp_is_a_minimum_jerk_rise_from_rest(human7: ArmDescription) -> None:
    p = np.array([1.0, 1, 1, 1, 1, 1, 1, 0.0, 2.0])  # phi(0) is one half
    played = Controller(human7.chain, "svd").synthesize(
        human7.rest, TARGET, synergies("C", 7, p), dt=DT, frames=40, ramp=0.1
    )
    plain = Plain(human7.chain, "svd", 6.0, DT, ramp=0.1)
    path = plain.play(human7.rest, TARGET, Sigmoids("C", 7, p), 40)
    np.testing.assert_allclose(played.angles, path, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(played.angles[1], human7.rest)
    step = np.linalg.norm(np.diff(played.angles, axis=0), axis=1)
    assert step[1] < 0.02 * step.max()


def test_it_stops_when_the_hand_is_there_and_says_so(human7: ArmDescription) -> None:
    controller, one = Controller(human7.chain, "svd"), synergies("A", 7, [1.0])
    arrived = controller.synthesize(
        human7.rest, TARGET, one, dt=DT, frames=1000, tolerance=1e-3, limit_rate=10.0
    )
    assert arrived.arrived
    assert arrived.distance <= 1e-3
    assert len(arrived.time) == len(arrived.angles) == len(arrived.positions) < 1000
    miss = np.linalg.norm(arrived.positions[:, -1] - TARGET, axis=1)
    assert (miss[:-1] > 1e-3).all()
    late = controller.synthesize(human7.rest, TARGET, one, dt=DT, frames=20, tolerance=1e-3)
    assert not late.arrived
    assert len(late.time) == 20
    unbounded = controller.synthesize(human7.rest, TARGET, one, dt=DT, frames=1000)
    assert len(unbounded.time) == 1000
    assert not unbounded.arrived


def test_a_pose_has_arrived_only_with_its_orientation(human7: ArmDescription) -> None:
    free = tuple(dataclasses.replace(j, lower=-9.0, upper=9.0) for j in human7.chain.joints)
    chain = SerialChain(free, human7.chain.tip_xyz)
    goal = np.array([0.6, 0.3, 0.4, 1.2, 0.3, 0.2, 0.1])
    position, orientation = (part[-1] for part in Oracle(chain).frames(goal))
    task = {"dt": DT, "frames": 1500, "tolerance": 1e-3}
    start = goal + np.array([0.2, -0.1, 0.1, 0.2, -0.2, 0.1, -0.1])
    one = synergies("A", 7, [1.0])
    there = Controller(chain, "svd").synthesize(
        start, position, one, orientation=orientation, **task
    )
    assert there.arrived
    R = Oracle(chain).frames(there.angles[-1])[1][-1]
    assert np.linalg.norm(pin.log3(orientation @ R.T)) <= 1e-3
    # With fewer joints than the pose needs, the place is met and the orientation is not
    wrist = SerialChain(
        tuple(dataclasses.replace(j, lower=-1e-9, upper=1e-9) for j in free[4:]), (0, 0, -0.1)
    )
    place, turned = wrist.forward([0.0, 0.0, 0.0]).tip, Oracle(chain).frames(goal)[1][-1]
    stuck = Controller(wrist, "svd").synthesize(
        [0, 0, 0], place, synergies("A", 3, [1.0]), orientation=turned, **task
    )
    assert stuck.distance <= 1e-3
    assert not stuck.arrived


def test_rates_belong_to_optimisers(human7: ArmDescription) -> None:
    assert set(RATES) == set(ARM_RATES) == set(OPTIMISERS)
    assert Controller(human7.chain, "jt").lambda_ == 60.0
    assert Controller(human7.chain, "jt", 7.0).lambda_ == 7.0


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"target": [0.1, 0.2]}, "a target is 3 finite numbers"),
        ({"target": [0.1, np.nan, 0.2]}, "a target is 3 finite numbers"),
        ({"start": [0.0] * 6}, "a posture of this chain is 7 finite numbers"),
        ({"start": [np.inf] * 7}, "a posture of this chain is 7 finite numbers"),
        ({"orientation": np.eye(2)}, "a 3 x 3 rotation matrix"),
        ({"orientation": -np.eye(3)}, "a 3 x 3 rotation matrix"),
        ({"orientation": np.full((3, 3), np.nan)}, "a 3 x 3 rotation matrix"),
        ({"frames": 0}, "must be positive"),
        ({"dt": 0.0}, "must be positive"),
        ({"dt": np.nan}, "must be positive"),
        ({"time_scale": 0.0}, "must be positive"),
    ],
)
def test_what_cannot_be_played_is_refused(
    human7: ArmDescription, change: dict[str, object], said: str
) -> None:
    asked = {"start": human7.rest, "target": TARGET, "dt": DT, "frames": 10} | change
    with pytest.raises(InputError, match=said):
        Controller(human7.chain).synthesize(synergy=synergies("A", 7, [1.0]), **asked)


@pytest.mark.parametrize("rate", [0.0, -1.0, np.nan, np.inf])
def test_a_rate_is_positive(human7: ArmDescription, rate: float) -> None:
    with pytest.raises(InputError, match="lambda must be a positive rate"):
        Controller(human7.chain, "svd", rate)


def test_an_unknown_optimiser_is_named(human7: ArmDescription) -> None:
    with pytest.raises(InputError, match="no optimiser 'newton'"):
        Controller(human7.chain, "newton")
