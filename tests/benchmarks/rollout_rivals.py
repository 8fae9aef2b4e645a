"""The same controller, or the nearest thing, by other libraries; each may be missing.

numpy and JAX play the very same roll-outs, all lanes in step. roboticstoolbox gives kinematics for
one step of a Python loop. placo takes one step of its own solver (C++ inside). ikpy knows only
whole inverse kinematics, which is what is timed.
"""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from armsyn.kernels.rollout import Synergies
from armsyn.kinematics import SerialChain


@dataclass(frozen=True)
class Problem:
    """Roll-outs to play: lambda dt is `pace`, per frame of `dt` seconds."""

    chain: SerialChain
    start: np.ndarray
    target: np.ndarray
    synergies: Synergies
    pace: float
    dt: float
    frames: int


def by_arrays(xp: object, problem: Problem) -> Callable[[np.ndarray, float], np.ndarray]:
    """Return one step of all lanes, from postures (lanes, n) at a time, by numpy or JAX's numpy."""
    arrays, synergies = problem.chain.arrays, problem.synergies
    n = problem.chain.dof

    def step(q: np.ndarray, t: float) -> np.ndarray:
        s, c = xp.sin(q), xp.cos(q)
        zero, one = xp.zeros_like(s[:, 0]), xp.ones_like(s[:, 0])
        R = xp.broadcast_to(xp.eye(3), (q.shape[0], 3, 3))
        position, origins, axes = xp.zeros((q.shape[0], 3)), [], []
        for i in range(n):
            position = position + R @ arrays.translation[i]
            turn = xp.stack([c[:, i], -s[:, i], zero, s[:, i], c[:, i], zero, zero, zero, one], 1)
            R = R @ arrays.rotation[i] @ turn.reshape(-1, 3, 3)
            origins.append(position)
            axes.append(R[:, :, 2])
        tip = position + R @ arrays.translation[n]
        J = xp.stack([xp.cross(a, tip - o) for a, o in zip(axes, origins, strict=True)], 2)
        y = xp.linalg.solve(J @ J.transpose(0, 2, 1), (problem.target - tip)[:, :, None])
        dq = (J.transpose(0, 2, 1) @ y)[:, :, 0]
        phi = 1.0 / (1.0 + xp.exp(synergies.offsets - synergies.slopes * t))
        return xp.clip(q + problem.pace * phi * synergies.gains * dq, arrays.lower, arrays.upper)

    return step


def numpy_lanes(problem: Problem) -> Callable[[], np.ndarray]:
    """All lanes in step by numpy."""
    step = by_arrays(np, problem)

    def play() -> np.ndarray:
        q = np.tile(problem.start, (problem.synergies.gains.shape[0], 1))
        for frame in range(problem.frames - 1):
            q = step(q, frame * problem.dt)
        return q

    return play


def jax_lanes(problem: Problem) -> Callable[[], np.ndarray]:
    """All lanes in step by JAX, compiled, in double precision on the processor."""
    import jax

    jax.config.update("jax_enable_x64", True)
    jax.config.update("jax_platforms", "cpu")
    step = by_arrays(jax.numpy, problem)
    start = np.tile(problem.start, (problem.synergies.gains.shape[0], 1))
    times = np.arange(problem.frames - 1) * problem.dt

    @jax.jit
    def whole(q: object) -> object:
        return jax.lax.scan(lambda q, t: (step(q, t), None), q, times)[0]

    return lambda: np.asarray(whole(start))


def toolbox_loop(problem: Problem) -> Callable[[], np.ndarray]:
    """Return a Python loop over roboticstoolbox's kinematics."""
    from roboticstoolbox import ET, ETS
    from spatialmath import SE3

    terms = []
    for joint in problem.chain.joints:
        axis = np.array(joint.axis)
        if sorted(np.abs(axis)) != [0.0, 0.0, 1.0]:
            raise ImportError("its elementary transforms know no oblique axes")
        turn = (ET.Rx, ET.Ry, ET.Rz)[int(np.argmax(np.abs(axis)))]
        terms.append(ET.SE3(SE3(*joint.xyz) * SE3.RPY(joint.rpy, order="zyx")))
        terms.append(turn(flip=bool(axis.sum() < 0)))
    tip = SE3(*problem.chain.tip_xyz) * SE3.RPY(problem.chain.tip_rpy, order="zyx")
    ets = ETS([*terms, ET.SE3(tip)])
    gains, slopes, offsets = (part[0] for part in problem.synergies)
    lower, upper = problem.chain.lower, problem.chain.upper

    def play() -> np.ndarray:
        q = problem.start
        for frame in range(problem.frames - 1):
            J = ets.jacob0(q)[:3]
            error = problem.target - ets.eval(q)[:3, 3]
            phi = 1.0 / (1.0 + np.exp(offsets - slopes * frame * problem.dt))
            dq = J.T @ np.linalg.solve(J @ J.T, error)
            q = np.clip(q + problem.pace * phi * gains * dq, lower, upper)
        return q[None]

    return play


def ikpy_whole(problem: Problem, folder: Path) -> Callable[[], object]:
    """Return one whole inverse kinematics of ikpy."""
    from ikpy.chain import Chain

    file = folder / "arm.urdf"
    file.write_text(urdf(problem.chain))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        chain = Chain.from_urdf_file(str(file), base_elements=["base"])
        chain.active_links_mask = np.array([link.joint_type != "fixed" for link in chain.links])
    start = np.array([0.0, *problem.start, 0.0])
    return lambda: chain.inverse_kinematics(problem.target, initial_position=start)


def placo_step(problem: Problem) -> float:
    """Seconds of one step of placo's solver.

    Its wheels bind Pinocchio 3, ours is 4, so it may live in an environment of its own, whose
    Python the variable PLACO_PYTHON names.
    """
    command = [os.environ.get("PLACO_PYTHON", sys.executable), "-c", _PLACO]
    numbers = [*problem.start, *problem.target, problem.dt]
    given = "\n".join([" ".join(map(repr, map(float, numbers))), urdf(problem.chain)])
    done = subprocess.run(command, input=given, capture_output=True, text=True, check=False)
    if done.returncode:
        raise ImportError(done.stderr.strip().splitlines()[-1])
    return float(done.stdout.split()[-1])


_PLACO = """
import os, sys, tempfile, time
import numpy as np
import placo
*numbers, dt = map(float, sys.stdin.readline().split())
with tempfile.TemporaryDirectory() as folder:
    file = os.path.join(folder, "robot.urdf")
    open(file, "w").write(sys.stdin.read())
    robot = placo.RobotWrapper(file, placo.Flags.ignore_collisions)
solver = placo.KinematicsSolver(robot)
solver.mask_fbase(True)
names = list(robot.joint_names())
for name, angle in zip(names, numbers):
    robot.set_joint(name, angle)
robot.update_kinematics()
solver.add_position_task("tip", np.array(numbers[len(names):])).configure("tip", "soft", 1.0)
solver.dt = dt
best = float("inf")
for _ in range(20):
    began = time.thread_time()
    for _ in range(200):
        solver.solve(True)
        robot.update_kinematics()
    best = min(best, (time.thread_time() - began) / 200)
print(best)
"""


def urdf(chain: SerialChain) -> str:
    """Return the chain as a URDF without masses to speak of."""
    inertial = (
        '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        "</inertial>"
    )
    lines = ['<robot name="arm"><link name="base"/>']
    parent = "base"
    for joint in chain.joints:
        child = f"{joint.name}_link"
        lines.append(
            f'<link name="{child}">{inertial}</link><joint name="{joint.name}" type="revolute">'
            f'<parent link="{parent}"/><child link="{child}"/>{_origin(joint.xyz, joint.rpy)}'
            f'<axis xyz="{_text(joint.axis)}"/><limit effort="10" velocity="10"'
            f' lower="{joint.lower!r}" upper="{joint.upper!r}"/></joint>'
        )
        parent = child
    lines.append(
        f'<link name="tip">{inertial}</link><joint name="to_tip" type="fixed">'
        f'<parent link="{parent}"/><child link="tip"/>{_origin(chain.tip_xyz, chain.tip_rpy)}'
        "</joint></robot>"
    )
    return "\n".join(lines)


def _origin(xyz: tuple[float, ...], rpy: tuple[float, ...]) -> str:
    return f'<origin xyz="{_text(xyz)}" rpy="{_text(rpy)}"/>'


def _text(numbers: tuple[float, ...]) -> str:
    return " ".join(map(repr, numbers))
