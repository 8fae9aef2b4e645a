"""Checked reaches a second, from targets to arrays; memory over their number; workers of a cluster.

Reaches are those of human7 from its rest posture to random targets, by the linear map and by the
pattern of whole motions (``latent``) of its atlas where that is there, and by minimum jerk, which
needs none. Each is predicted, led to its end, eased and slowed until the limits hold, sampled at
200 Hz, and checked for ranges, speeds, accelerations, jerks, contacts, its end and one bell of the
hand's speed; where it does not pass it is tried otherwise, as `armsyn reach --plan` does.

    python tests/benchmarks/bench_generate.py [REACHES of the memory's row, 100,000 by default]
"""

from __future__ import annotations

import concurrent.futures
import dataclasses
import json
import multiprocessing
import os
import resource
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numba
import numpy as np
from threadpoolctl import threadpool_limits

from armsyn.arm import ArmDescription, load_arm
from armsyn.errors import ArmsynError
from armsyn.ik import optimiser_settings
from armsyn.kernels import rollout
from armsyn.planning.allowed import tried
from armsyn.planning.generation.batch import Recipe, make_batch
from armsyn.planning.generation.cluster import connected, each_on_cluster
from armsyn.planning.generation.memory import keep_memory
from armsyn.planning.generation.order import Order, sent_order
from armsyn.planning.generation.running import digest_of, generate
from armsyn.planning.generation.targets import ListedTargets, RandomTargets, random_within
from armsyn.planning.minimum_jerk import MinimumJerkPredictor
from armsyn.planning.planner import ATLAS
from armsyn.planning.prediction import Predictor
from armsyn.synergy import synergies

GOAL = 20_000.0
"""Checked reaches a second on two cores."""

BATCH, ROUNDS = 1000, 6
ANYWHERE = 300
STEPS, LANES = 100, 1000
BOX = ([0.2, -0.3, -0.3], [0.4, 0.1, 0.05])
"""m; all of it within reach: what cannot be reached is looked for long before it is refused."""

INPUTS = {"what": "a benchmark"}
CORES = 2


def recipes(arm: ArmDescription) -> Iterator[tuple[str, Recipe]]:
    """Give what is timed."""

    def by(predictor: Predictor) -> Recipe:
        hull = getattr(predictor, "hull", None)
        size = 10_000_000
        targets = RandomTargets(size, 0, *BOX) if hull is None else random_within(size, 0, hull)
        return Recipe(arm, predictor, targets, arm.rest, 200.0)

    yield "minjerk", by(MinimumJerkPredictor(arm.chain))
    try:
        from armsyn.arm import find_file
        from armsyn.planning.atlas_file import load_atlas

        atlas = load_atlas(find_file(arm.name, ATLAS, None), arm)
    except ArmsynError as error:
        print(f"no linear and latent rows: {error}")
        return
    for kind in ("linear", "latent"):
        yield kind, by(atlas.predictor(kind))


def timed(call: Callable[[], object], rounds: int = ROUNDS) -> float:
    """Seconds of this thread that a call takes: the least of a few."""
    best = np.inf
    for _ in range(rounds):
        began = time.thread_time()
        call()
        best = min(best, time.thread_time() - began)
    return best


def parts(recipe: Recipe) -> dict[str, float]:
    """Seconds a reach of each part of the work, on one core, and of all of it.

    Parts are timed by themselves, of reaches as they are predicted: what is left of all is joining,
    and the trying otherwise of reaches that do not pass.
    """
    targets, *_ = recipe.targets.some(0, BATCH)
    starts = np.tile(recipe.start, (BATCH, 1))
    predicted = recipe.predictor.predict(starts, targets)
    motions = (recipe.arm, predicted.angles, predicted.durations, recipe.rate_hz)
    calls = {
        "targets": lambda: recipe.targets.some(0, BATCH),
        "prediction": lambda: recipe.predictor.predict(starts, targets),
        "pacing and judging": lambda: tried(*motions),
        "all": lambda: make_batch(recipe, 0, BATCH),
    }
    spent = {name: timed(call) / BATCH for name, call in calls.items()}
    return spent | {"what is left": 2.0 * spent["all"] - sum(spent.values())}


def from_anywhere(recipe: Recipe) -> str:
    """Say how reaches from random postures fare, most of which people do not start from."""
    chain, rng = recipe.arm.chain, np.random.default_rng(0)
    targets = np.array(recipe.targets.some(0, ANYWHERE)[0])
    starts = rng.uniform(chain.lower, chain.upper, (ANYWHERE, chain.dof))
    listed = dataclasses.replace(recipe, targets=ListedTargets(targets, starts))
    batch = make_batch(listed, 0, ANYWHERE)
    rate = CORES * ANYWHERE / timed(lambda: make_batch(listed, 0, ANYWHERE), 2)
    return (
        f"from random postures {rate:,.0f} a second by the cores' own time,"
        f" {len(batch.index) / ANYWHERE:.1%} made, {len(batch.changed) / ANYWHERE:.1%} changed"
    )


def play(recipe: Recipe, first: int, batches: int) -> float:
    """Make batches in this process, after one to warm up; return the seconds of the wall."""
    keep_memory()
    with threadpool_limits(1):
        make_batch(recipe, 0, BATCH)
        began = time.perf_counter()
        for number in range(batches):
            make_batch(recipe, first + number * BATCH, first + (number + 1) * BATCH)
        return time.perf_counter() - began


def rate_on_two_cores(recipe: Recipe, batches: int = 20) -> float:
    """Reaches a second of two processes at once."""
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(CORES, mp_context=context) as pool:
        best = 0.0
        for _ in range(3):
            spans = [pool.submit(play, recipe, k * 10**6, batches) for k in range(CORES)]
            best = max(best, sum(batches * BATCH / span.result() for span in spans))
    return best


def roll_out_rate(arm: ArmDescription) -> float:
    """Roll-outs of 100 steps a second of the bare kernel on two cores."""
    gains = [1.2, 0.8, 1.5, 1.0, 0.7, 1.1, 0.9]
    lanes = synergies("C", arm.chain.dof, np.tile([*gains, 4.0, 8.0], (LANES, 1)))
    paths = np.empty((LANES, STEPS, arm.chain.dof))
    paths[:, 0] = arm.rest
    targets = np.tile([0.35, -0.10, -0.15], (LANES, 1))
    timing = rollout.Timing(6.0, 0.01, 0.0, np.inf)
    settings = optimiser_settings("svd")
    best = np.inf
    numba.set_num_threads(min(CORES, numba.get_num_threads()))
    for _ in range(ROUNDS):
        began = time.perf_counter()
        rollout.roll_out_lanes(arm.chain.arrays, settings, lanes, timing, targets, paths)
        best = min(best, time.perf_counter() - began)
    return LANES / best


def memory_of(reaches: int) -> tuple[float, float, float]:
    """Greatest memory of a generation of so many reaches in this process, MB; seconds; GB."""
    arm = load_arm("human7", calibrated=False)
    targets = RandomTargets(reaches, 0, *BOX)
    recipe = Recipe(arm, MinimumJerkPredictor(arm.chain), targets, arm.rest, 50.0)
    with tempfile.TemporaryDirectory() as folder:
        order = Order(recipe, f"{folder}/out", "npz", 2000, digest_of(INPUTS))
        began = time.perf_counter()
        report = generate(order, INPUTS, workers=1)
        took = time.perf_counter() - began
        assert report.complete, report.error
        written = sum(file.stat().st_size for file in Path(folder).rglob("*") if file.is_file())
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0, took, written / 1e9


def memory_rows(most: int) -> None:
    """Print the memory of generations of growing size, each in a process of its own."""
    context = multiprocessing.get_context("spawn")
    room = shutil.disk_usage(tempfile.gettempdir()).free
    for reaches in (2000, most // 10, most):
        if reaches * 3500 > room:
            print(f"{reaches:>10,} reaches: left out, as the disk has no room for them")
            continue
        with concurrent.futures.ProcessPoolExecutor(1, mp_context=context) as pool:
            peak, took, size = pool.submit(memory_of, reaches).result()
        print(
            f"{reaches:>10,} reaches at 50 Hz written: {peak:6.0f} MB at most, {took:6.1f} s"
            f" ({reaches / took:,.0f} a second, one process), {size:.2f} GB"
        )


@contextmanager
def cluster(workers: int) -> Iterator[str]:
    """Give the address of a scheduler with so many workers, processes of their own."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    address, local = f"tcp://127.0.0.1:{port}", ["--host", "127.0.0.1", "--no-dashboard"]
    started = []
    with tempfile.TemporaryDirectory() as scratch:
        worker = ["--no-nanny", "--nthreads", "1", "--local-directory", scratch]
        for arguments in (
            ["dask_scheduler", *local, "--port", str(port)],
            *([["dask_worker", address, *local, *worker]] * workers),
        ):
            program = [sys.executable, "-m", f"distributed.cli.{arguments[0]}", *arguments[1:]]
            quiet = subprocess.DEVNULL
            started.append(subprocess.Popen(program, stdout=quiet, stderr=quiet, cwd=scratch))
        try:
            yield address
        finally:
            for process in reversed(started):  # killed, for they wait long for one another else
                process.kill()
                process.wait()


def cluster_rows(recipe: Recipe, chunks: int = 24) -> dict[str, float]:
    """Print chunks a second with one worker and two; return the costs of a task and a chunk."""
    costs: dict[str, float] = {}
    for workers in (1, 2):
        with cluster(workers) as address, connected(address) as client:
            client.wait_for_workers(workers)
            with tempfile.TemporaryDirectory() as folder:
                order = Order(recipe, folder, "npz", BATCH, digest_of(INPUTS))
                token = Path(folder) / ".notes" / "generation.json"
                token.parent.mkdir()
                token.write_text(json.dumps({"digest": order.digest}))
                sent = sent_order(order)
                list(each_on_cluster(client, sent, range(1000, 1000 + 2 * workers)))
                began = time.perf_counter()
                notes = list(each_on_cluster(client, sent, range(chunks)))
                took = time.perf_counter() - began
                bytes_a_chunk = order.file(0).stat().st_size
            began = time.perf_counter()
            tasks = client.map(int, range(2000), pure=False)
            client.gather(tasks)
            costs["task"] = (time.perf_counter() - began) / 2000
        rate = chunks * BATCH / took
        costs |= {f"rate{workers}": rate, "note": float(len(json.dumps(notes[0])))}
        costs |= {"order": float(len(sent)), "chunk": float(bytes_a_chunk)}
        print(f"{workers} workers: {rate:10,.0f} reaches a second, written as npz")
    return costs


def on_paper(costs: dict[str, float], workers: int = 1000) -> None:
    """Print what the measured costs come to with a thousand workers."""
    a_worker = costs["rate1"]
    chunk = costs["chunk"] / BATCH
    for size in (BATCH, 20_000):
        tasks = workers * a_worker / size
        print(
            f"on paper, {workers} workers, {size:,} reaches a chunk: {tasks:,.0f} tasks a second"
            f" of {1.0 / costs['task']:,.0f} that the scheduler was measured to hand out;"
            f" {tasks * costs['note'] / 1e6:.1f} MB/s of notes through it,"
            f" {workers * a_worker * chunk / 1e9:,.0f} GB/s of reaches to the shared disk,"
            f" {workers * costs['order'] / 1e6:,.0f} MB of order once"
        )


def main() -> int:
    """Print the tables; 1 when the goal is missed."""
    most = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    arm = load_arm("human7", calibrated=False)
    keep_memory()
    rollouts = roll_out_rate(arm)
    best, chosen = 0.0, None
    print(f"checked reaches of human7 at 200 Hz, from targets to arrays ({os.cpu_count()} cores)")
    for name, recipe in recipes(arm):
        batch = make_batch(recipe, 0, BATCH)
        with threadpool_limits(1):
            spent = parts(recipe)
        rate = rate_on_two_cores(recipe)
        said = ", ".join(f"{part} {seconds * 1e6:.1f}" for part, seconds in spent.items())
        print(
            f"{name:8}{rate:10,.0f} a second on two cores ({rate / rollouts:.1%} of the roll-out"
            f" kernel's {rollouts:,.0f} of {STEPS} steps);"
            f" {CORES / spent['all']:,.0f} by the cores' own time;"
            f" {len(batch.index) / BATCH:.1%} made, {len(batch.changed) / BATCH:.1%} changed,"
            f" {batch.paced.lengths.mean():.0f} frames each,"
            f" slowed {batch.paced.scales.mean():.2f} times\n{'':8}us a reach on one core: {said}\n"
            f"{'':8}{from_anywhere(recipe)}"
        )
        best, chosen = max(best, rate), recipe
    memory_rows(most)
    assert chosen is not None
    on_paper(cluster_rows(chosen))
    print(f"goal: {GOAL:,.0f} checked reaches a second on two cores")
    return int(best < GOAL)


if __name__ == "__main__":
    raise SystemExit(main())
