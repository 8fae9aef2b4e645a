"""A roll-out of 100 steps of human7 (SVD with synergy) against a Python loop over Pinocchio.

The loop's calls are fixed here: per step one ``pin.computeFrameJacobian``, the tip's translation,
``J J^T`` solved by numpy, gains, sigmoid and clip; nothing is validated or allocated beyond that.
All rows are timed in turn, in rounds, in one run; medians and their ratios are printed.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numba
import numpy as np
import pinocchio as pin

from armsyn.arm import load_arm
from armsyn.ik import optimiser_settings
from armsyn.kernels import rollout
from armsyn.kinematics import SerialChain
from armsyn.synergy import Controller, synergies

STEPS = 100
LANES = 1_000
ROUNDS = 25
DT = 0.01
LAMBDA = 6.0
TARGET = np.array([0.35, -0.10, -0.15])
GAINS = np.array([1.2, 0.8, 1.5, 1.0, 0.7, 1.1, 0.9])
OFFSET, SLOPE = 4.0, 8.0
LEAST_SINGLE, LEAST_LANES = 60.0, 120.0


def pin_model(chain: SerialChain) -> tuple[pin.Model, int]:
    """Build the chain as a Pinocchio model; return it with the tip's frame."""
    model = pin.Model()
    parent = 0
    for joint in chain.joints:
        placement = pin.SE3(pin.rpy.rpyToMatrix(*joint.rpy), np.array(joint.xyz))
        moving = pin.JointModelRevoluteUnaligned(np.array(joint.axis))
        parent = model.addJoint(parent, moving, placement, joint.name)
    tip = pin.SE3(pin.rpy.rpyToMatrix(*chain.tip_rpy), np.array(chain.tip_xyz))
    return model, model.addFrame(pin.Frame("tip", parent, 0, tip, pin.FrameType.OP_FRAME))


def pin_loop(
    model: pin.Model,
    data: pin.Data,
    tip: int,
    start: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
) -> np.ndarray:
    """Play the same controller step by step in Python."""
    path = np.empty((STEPS, start.size))
    q = start
    for step in range(STEPS):
        path[step] = q
        J = pin.computeFrameJacobian(model, data, q, tip, pin.LOCAL_WORLD_ALIGNED)[:3]
        dX = TARGET - data.oMf[tip].translation
        dq = J.T @ np.linalg.solve(J @ J.T, dX)
        phi = 1.0 / (1.0 + np.exp(OFFSET - SLOPE * step * DT))
        q = np.clip(q + LAMBDA * DT * phi * GAINS * dq, lower, upper)
    return path


def timed(call: Callable[[], object], repeats: int) -> float:
    """Seconds that one call takes, over a few in a row."""
    began = time.perf_counter()
    for _ in range(repeats):
        call()
    return (time.perf_counter() - began) / repeats


def main() -> int:
    """Print the table; 1 when a goal is missed."""
    arm = load_arm("human7")
    chain = arm.chain
    model, tip = pin_model(chain)
    data = model.createData()
    lanes = synergies("C", chain.dof, np.tile([*GAINS, OFFSET, SLOPE], (LANES, 1)))
    controller = Controller(chain, "svd", LAMBDA)
    timing = rollout.Timing(LAMBDA, DT, 0.0, np.inf)
    paths = np.empty((LANES, STEPS, chain.dof))
    paths[:, 0] = arm.rest
    targets = np.tile(TARGET, (LANES, 1))
    settings = optimiser_settings("svd")

    def loop() -> np.ndarray:
        return pin_loop(model, data, tip, arm.rest, chain.lower, chain.upper)

    path, positions = paths[0].copy(), np.empty((STEPS, chain.dof + 1, 3))
    task = rollout.Task(TARGET, np.empty((0, 0)))
    lane = [part[0] for part in lanes]

    def single() -> np.ndarray:
        rollout.roll_out(chain.arrays, settings, *lane, timing, task, -1.0, path, positions)
        return path

    def public() -> np.ndarray:
        return controller.synthesize(arm.rest, TARGET, lanes, dt=DT, frames=STEPS).angles

    def batch() -> None:
        rollout.roll_out_lanes(chain.arrays, settings, lanes, timing, targets, paths)

    cores = numba.get_num_threads()
    batch()
    apart = max(np.abs(played - loop()).max() for played in (single(), public(), paths[-1]))
    times: dict[str, list[float]] = {
        name: [] for name in ("pin", "single", "public", "one core", "all cores")
    }
    for _ in range(ROUNDS):
        times["pin"].append(timed(loop, 1))
        times["single"].append(timed(single, 20))
        times["public"].append(timed(public, 20))
        numba.set_num_threads(1)
        times["one core"].append(timed(batch, 1) / LANES)
        numba.set_num_threads(cores)
        times["all cores"].append(timed(batch, 1) / LANES)
    median = {name: statistics.median(values) for name, values in times.items()}
    ratio = {name: median["pin"] / value for name, value in median.items()}
    print(f"a roll-out of {STEPS} steps, human7, SVD with synergy ({ROUNDS} rounds, medians)")
    print(f"{'':34}{'us':>10}{'us a step':>12}{'times pin':>12}")
    for name, label in (
        ("pin", "Python loop over pin"),
        ("single", "one roll-out, the kernel"),
        ("public", "the same by Controller.synthesize"),
        ("one core", f"{LANES} lanes, one core, a lane"),
        ("all cores", f"{LANES} lanes, {cores} cores, a lane"),
    ):
        value = median[name] * 1e6
        print(f"{label:34}{value:10.2f}{value / STEPS:12.4f}{ratio[name]:12.1f}")
    print(f"largest difference between them: {apart:.1e} rad")
    print(f"goals: one roll-out {LEAST_SINGLE:g} x, a lane of all cores {LEAST_LANES:g} x")
    return int(ratio["single"] < LEAST_SINGLE or ratio["all cores"] < LEAST_LANES)


if __name__ == "__main__":
    raise SystemExit(main())
