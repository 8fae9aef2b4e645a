"""A roll-out of 100 steps of human7 (SVD with synergy) against a Python loop over Pinocchio.

The loop's calls are fixed here: per step one ``pin.computeFrameJacobian``, the tip's translation,
``J J^T`` solved by numpy, gains, sigmoid and clip; nothing is validated or allocated beyond that.
All rows are timed in turn, in rounds, in one run. The least time of each counts, and for what runs
on one core the time of its thread: what else the machine does can only add to either.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np
import pinocchio as pin
import rollout_rivals as rivals

from armsyn.arm import load_arm
from armsyn.ik import optimiser_settings
from armsyn.kernels import rollout
from armsyn.kernels.generator import WIDTH, Plan, generate
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
LEAST_SINGLE, LEAST_LANES = 60.0, 500.0
CHAINS, LINKS = 10, 40


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


def pin_loop(chain: SerialChain, start: np.ndarray) -> Callable[[], np.ndarray]:
    """Return the same controller step by step in Python."""
    model, tip = pin_model(chain)
    data = model.createData()
    lower, upper = chain.lower, chain.upper

    def play() -> np.ndarray:
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

    return play


def peak_of_multiply_add() -> Callable[[], object]:
    """Return a call that does nothing but multiply and add, `CHAINS` independent at a time."""
    loads = [f"a{c} = state[lane + {c * WIDTH}]" for c in range(CHAINS)]
    sums = [f"a{c} = a{c} * factor + 0.5" for c in range(CHAINS)]
    stores = [f"state[lane + {c * WIDTH}] = a{c}" for c in range(CHAINS)]
    body = "\n".join(" " * 12 + line for line in [*loads, *sums * LINKS, *stores])
    module: dict[str, Callable[[np.ndarray, float, int], None]] = {}
    exec(  # noqa: S102
        "def peak(state, factor, rounds):\n    for _ in range(rounds):\n"
        f"        for lane in range({WIDTH}):\n{body}\n",
        module,
    )
    peak = numba.njit(error_model="numpy", fastmath={"contract"})(module["peak"])
    state = np.ones(CHAINS * WIDTH)
    return lambda: peak(state, 0.5, 1_000)


def timed(
    call: Callable[[], object], repeats: int = 1, clock: Callable[[], float] = time.thread_time
) -> float:
    """Seconds that one call takes, over a few in a row."""
    began = clock()
    for _ in range(repeats):
        call()
    return (clock() - began) / repeats


def with_cores(cores: int, call: Callable[[], object]) -> float:
    """Seconds that a call takes on as many cores."""
    everything = numba.get_num_threads()
    numba.set_num_threads(min(cores, everything))
    seconds = timed(call, clock=time.thread_time if cores == 1 else time.perf_counter)
    numba.set_num_threads(everything)
    return seconds


def rival_rows(problem: rivals.Problem, last: np.ndarray) -> list[tuple[str, float | str]]:
    """Return seconds a step and lane of each rival that is installed, or why there are none."""
    few = 5

    def played(
        make: Callable[[rivals.Problem], Callable[[], np.ndarray]],
        clock: Callable[[], float] = time.thread_time,
    ) -> float:
        play = make(problem)
        q = play()
        apart = np.abs(q - last).max()
        if apart > 1e-9:
            raise AssertionError(f"plays another motion: {apart:g} rad apart")
        return min(timed(play, clock=clock) for _ in range(few)) / (STEPS - 1) / q.shape[0]

    def ikpy(problem: rivals.Problem) -> float:
        with tempfile.TemporaryDirectory() as folder:
            whole = rivals.ikpy_whole(problem, Path(folder))
        return min(timed(whole) for _ in range(few))

    rows: list[tuple[str, float | str]] = []
    for name, measure in (
        (f"numpy, {LANES} lanes", lambda: played(rivals.numpy_lanes)),
        (f"JAX, {LANES} lanes, all cores", lambda: played(rivals.jax_lanes, time.perf_counter)),
        ("placo, a step of its solver", lambda: rivals.placo_step(problem)),
        ("roboticstoolbox, Python loop", lambda: played(rivals.toolbox_loop)),
        ("ikpy, one whole IK", lambda: ikpy(problem)),
    ):
        try:
            rows.append((name, measure()))
        except ImportError as error:
            rows.append((name, f"skipped: {error}"))
    return rows


def main() -> int:
    """Print the table; 1 when a goal is missed."""
    arm = load_arm("human7")
    chain, settings = arm.chain, optimiser_settings("svd")
    lanes = synergies("C", chain.dof, np.tile([*GAINS, OFFSET, SLOPE], (LANES, 1)))
    timing = rollout.Timing(LAMBDA, DT, 0.0, np.inf)
    paths = np.empty((LANES, STEPS, chain.dof))
    paths[:, 0] = arm.rest
    targets = np.tile(TARGET, (LANES, 1))
    loop = pin_loop(chain, np.asarray(arm.rest))
    path, positions = paths[0].copy(), np.empty((STEPS, chain.dof + 1, 3))
    task = rollout.Task(TARGET, np.empty((0, 0)))
    lane = [part[0] for part in lanes]
    controller = Controller(chain, "svd", LAMBDA)

    def single() -> np.ndarray:
        rollout.roll_out(chain.arrays, settings, *lane, timing, task, -1.0, path, positions)
        return path

    def public() -> np.ndarray:
        return controller.synthesize(arm.rest, TARGET, lanes, dt=DT, frames=STEPS).angles

    def batch() -> None:
        rollout.roll_out_lanes(chain.arrays, settings, lanes, timing, targets, paths)

    peak = peak_of_multiply_add()
    batch()
    peak()
    apart = max(np.abs(played - loop()).max() for played in (single(), public(), paths[-1]))
    rows: list[tuple[str, Callable[[], float]]] = [
        ("Python loop over pin", lambda: timed(loop)),
        ("one roll-out, the plain kernel", lambda: timed(single, 20)),
        ("the same by Controller.synthesize", lambda: timed(public, 20)),
        (f"{LANES} lanes, one core, a lane", lambda: with_cores(1, batch) / LANES),
        (f"{LANES} lanes, two cores, a lane", lambda: with_cores(2, batch) / LANES),
        ("peak", lambda: with_cores(1, peak)),
    ]
    best = dict.fromkeys((name for name, _ in rows), np.inf)
    for _ in range(ROUNDS):
        for name, measure in rows:
            best[name] = min(best[name], measure())
    peak_rate = 2.0 * CHAINS * LINKS * WIDTH * 1_000 / best.pop("peak")
    by_pin, _, _, one_core, two_cores = best.values()
    print(f"a roll-out of {STEPS} steps, human7, SVD with synergy ({ROUNDS} rounds, the best)")
    print(f"{'':34}{'us':>10}{'us a step':>12}{'times pin':>12}")
    for name, seconds in best.items():
        step = seconds * 1e6 / STEPS
        print(f"{name:34}{seconds * 1e6:10.2f}{step:12.4f}{by_pin / seconds:12.1f}")
    problem = rivals.Problem(chain, np.asarray(arm.rest), TARGET, lanes, LAMBDA * DT, DT, STEPS)
    for name, found in rival_rows(problem, paths[0, -1]):
        if isinstance(found, str):
            print(f"{name:34} {found}")
        else:
            times = by_pin / STEPS / found
            print(f"{name:34}{'':10}{found * 1e6:12.4f}{times:12.2f}")
    counted = generate(Plan(chain.arrays, settings, True, False, "paths", ())).operations
    rate = (counted["*"] + counted["+"]) * STEPS / one_core
    print(
        f"a generated step is {counted['*']} multiplications and {counted['+']} additions:"
        f" {rate / 1e9:.1f} GFlop/s on one core,\n  {rate / peak_rate:.0%} of the measured"
        f" multiply-add peak of {peak_rate / 1e9:.1f} GFlop/s;"
        f" {1 / one_core:,.0f} roll-outs a second on one core, {1 / two_cores:,.0f} on two"
    )
    print(f"largest difference between them: {apart:.1e} rad")
    print(f"goals: one roll-out {LEAST_SINGLE:g} x, a lane of one core {LEAST_LANES:g} x")
    missed = by_pin / best["one roll-out, the plain kernel"] < LEAST_SINGLE
    return int(missed or by_pin / one_core < LEAST_LANES)


if __name__ == "__main__":
    raise SystemExit(main())
