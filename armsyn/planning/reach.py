"""Plan a human-like reach with the synergy of the nearest learned one.

People reach faster than servos turn: a planned reach is slowed as a whole (lambda / kappa,
s / kappa, the same path) until speed and acceleration limits hold; ``time_scale`` says kappa.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import (
    CollisionError,
    InputError,
    LimitError,
    RefusedMotionError,
    UnreachableError,
)
from armsyn.ik import solve_ik
from armsyn.motion import Motion
from armsyn.safety import check_collision
from armsyn.synergy import LearnedReach, SynergyLibrary, SynergySet
from armsyn.synergy.controller import LIMIT_RATE, RAMP_S, Controller, RollOut

FloatArray = NDArray[np.float64]

TOLERANCE_M = 5e-4
"""A reach is planned to end within this distance of its target."""

LONGEST_S = 8.0
"""Longest reach before slowing; what takes longer to arrive does not arrive."""

MARGIN = 1.02
"""The trajectory keeps this factor inside the limits."""

PLANNING_RATE_HZ = 200.0
"""Frames a second of a plan, whatever rate it is streamed at: the explicit step of the controller
needs lambda dt g well below 1, and the driver interpolates."""

_MOST_SCALINGS = 40
_SETTLE_S = 0.1
_AT_LIMIT_RAD = 0.01


@dataclass(frozen=True)
class PlannedReach:
    """A trajectory with where it came from.

    Parameters
    ----------
    trajectory : Motion
        Joint angles and the arm's landmarks at the streaming rate.
    target : array, shape (3,)
        m, base frame.
    learned : LearnedReach
        The captured reach whose synergy it uses.
    synergy : SynergySet
    rank : int
        0 when that is the nearest; more when nearer ones did not arrive.
    time_scale : float
        kappa, how much slower than the learned reach.
    """

    trajectory: Motion
    target: FloatArray
    learned: LearnedReach
    synergy: SynergySet
    rank: int
    time_scale: float


@dataclass(frozen=True)
class ReachPlanner:
    """Plans reaches of one arm.

    Parameters
    ----------
    arm : ArmDescription
    library : SynergyLibrary
        Learned for that arm.
    ik : {"svd", "jt", "njt", "dls"}
    model : {"A", "B", "C", "D"}
        A is the paper's raw controller: one gain, no sigmoid.

    Raises
    ------
    InputError
        A library of another arm.
    """

    arm: ArmDescription
    library: SynergyLibrary
    ik: str = "svd"
    model: str = "C"

    def __post_init__(self) -> None:
        if self.library.arm != self.arm.name or self.library.joint_names != self.arm.joint_names:
            raise InputError(
                f"the synergies are those of {self.library.arm}"
                f" ({', '.join(self.library.joint_names)}), the arm is {self.arm.name}"
                f" ({', '.join(self.arm.joint_names)}): run armsyn learn --arm {self.arm.name}"
            )

    def plan(
        self, posture: ArrayLike, target: ArrayLike, rate_hz: float = PLANNING_RATE_HZ
    ) -> PlannedReach:
        """Plan a reach from a posture to a target.

        Parameters
        ----------
        posture : array_like, shape (n,)
            Where the arm is, rad.
        target : array_like, shape (3,)
            Position of the hand, base frame, m.
        rate_hz : float
            Of the trajectory.

        Returns
        -------
        PlannedReach

        Raises
        ------
        InputError
            Wrong counts, not finite, or a rate that is not positive.
        LimitError
            The posture is outside the joints' ranges; or no synergy that arrives can be slowed
            until the joints' accelerations hold.
        UnreachableError
            No learned synergy brings the hand within `TOLERANCE_M`.
        CollisionError
            Those that do go through the arm itself or what is around it.
        """
        start = self.arm.chain.checked_posture(posture)
        self._check_inside(start)
        start = np.clip(start, self.arm.chain.lower, self.arm.chain.upper)
        goal = np.asarray(target, dtype=np.float64)
        if goal.shape != (3,) or not np.isfinite(goal).all():
            raise InputError(f"a target is 3 finite numbers of metres, got {goal.tolist()}")
        if not 0 < rate_hz < np.inf:
            raise InputError(f"a trajectory needs a positive rate, got {rate_hz:g} Hz")
        hand = self.arm.chain.forward(start).tip
        candidates = self.library.nearest(hand, goal, self.ik, self.model)
        missed: RollOut | None = None
        refused: RefusedMotionError | None = None
        for rank, (learned, synergy) in enumerate(candidates):
            rolled, scale = self._roll(start, goal, synergy, rate_hz, 1.0), 1.0
            if rolled.arrived:
                try:
                    rolled, scale = self._slowed(start, goal, synergy, rate_hz)
                except LimitError as error:
                    refused = refused or error
                    continue
            if rolled.arrived:
                if collision := check_collision(rolled.angles, self.arm, leaving=True):
                    refused = refused or collision
                    continue
                trajectory = self._trajectory(rolled, rate_hz, learned)
                return PlannedReach(trajectory, goal, learned, synergy, rank, scale)
            if missed is None or rolled.distance < missed.distance:
                missed = rolled
        if missed is None or isinstance(refused, CollisionError):
            assert refused is not None  # noqa: S101 - there is a candidate, and none was missed
            raise refused
        raise UnreachableError(self._why_not(start, goal, missed), missed.distance)

    def _check_inside(self, posture: FloatArray) -> None:
        """Encoders round: a posture may lie a tick outside a limit, not more."""
        tick = 2 * np.pi / 4096
        limits = zip(self.arm.joint, posture, strict=True)
        for joint, value in limits:
            nearest = min(max(value, joint.lower), joint.upper)
            if abs(value - nearest) > tick:
                raise LimitError(
                    f"{joint.name} stands at {value:.3f} rad, outside its range"
                    f" {joint.lower:g} to {joint.upper:g}: move it back by hand",
                    joint.name,
                    float(value),
                    nearest,
                )

    def _roll(
        self, start: FloatArray, goal: FloatArray, synergy: SynergySet, rate_hz: float, scale: float
    ) -> RollOut:
        controller = Controller(self.arm.chain, self.ik, self.library.lambdas[self.ik])
        return controller.synthesize(
            start,
            goal,
            self.library.synergy(synergy),
            dt=1.0 / rate_hz,
            frames=int(LONGEST_S * scale * rate_hz) + 2,
            tolerance=TOLERANCE_M,
            time_scale=scale,
            ramp=RAMP_S,
            limit_rate=LIMIT_RATE,
        )

    def _slowed(
        self, start: FloatArray, goal: FloatArray, synergy: SynergySet, rate_hz: float
    ) -> tuple[RollOut, float]:
        """Slow the reach until every joint's speed and acceleration hold."""
        scale = 1.0
        for _ in range(_MOST_SCALINGS):
            rolled = self._roll(start, goal, synergy, rate_hz, scale)
            excess = self._excess(rolled.angles, rate_hz)
            worst = int(excess.argmax())
            if excess[worst] <= 1.0:
                return rolled, scale
            scale *= max(float(excess[worst]), 1.01)
        joint = self.arm.joint_names[worst]
        raise LimitError(
            f"slowed {scale:.0f} times the reach still asks {excess[worst]:.2f} times what"
            f" {joint} may do in speed or acceleration: choose another target or --ik",
            joint,
            float(excess[worst]),
            1.0,
        )

    def _excess(self, angles: FloatArray, rate_hz: float) -> FloatArray:
        """By how much each joint would have to be slowed, shape (n,); at most 1 within limits."""
        at_rest = np.concatenate([angles[:1], angles, angles[-1:]])
        velocity = np.diff(at_rest, axis=0) * rate_hz
        acceleration = np.diff(velocity, axis=0) * rate_hz
        speed = (np.abs(velocity) / self.arm.max_velocity).max(axis=0)
        strain = (np.abs(acceleration) / self.arm.max_acceleration).max(axis=0)
        return np.asarray(MARGIN * np.maximum(speed, np.sqrt(strain)))

    def _trajectory(self, rolled: RollOut, rate_hz: float, learned: LearnedReach) -> Motion:
        """Hold the last posture a moment, so that the recording shows the hand at rest."""
        held = int(np.ceil(_SETTLE_S * rate_hz))
        angles = np.concatenate([rolled.angles, np.repeat(rolled.angles[-1:], held, axis=0)])
        positions = self.arm.chain.positions(angles)
        return Motion(
            time=np.arange(angles.shape[0]) / rate_hz,
            joint_names=self.arm.joint_names,
            angles=angles,
            landmark_names=tuple(self.arm.landmarks),
            landmarks=positions[:, list(self.arm.landmark_frames)],
            source=f"planned for {self.arm.name} like {learned.name}",
        )

    def _advice(self, goal: FloatArray) -> str:
        base = self.arm.chain.forward(self.arm.rest).positions[0]
        distance, reach = float(np.linalg.norm(goal - base)), self.arm.chain.reach
        if distance > 10 * reach:
            return "targets are in metres"
        if distance > reach:
            return (
                f"the arm is {reach:.2f} m long, the target {distance:.2f} m from its first joint"
            )
        facing = np.array([np.cos(self.arm.facing), np.sin(self.arm.facing)]).round(2) + 0.0
        return (
            "it is too near, behind the arm or outside its joints' ranges: the arm faces"
            f" x {facing[0]:g}, y {facing[1]:g}"
        )

    def _why_not(self, start: FloatArray, goal: FloatArray, missed: RollOut) -> str:
        where = "({:.3f}, {:.3f}, {:.3f}) m".format(*goal)
        best = solve_ik(self.arm.chain, goal, start, restarts=20, tolerance=TOLERANCE_M)
        if not best.success:
            return (
                f"target {where} cannot be reached by {self.arm.name}: its hand stays"
                f" {best.position_error:.3f} m away; {self._advice(goal)}"
            )
        chain, last = self.arm.chain, missed.angles[-1]
        near_limit = np.minimum(last - chain.lower, chain.upper - last) < _AT_LIMIT_RAD
        joints = [name for name, near in zip(chain.names, near_limit, strict=True) if near]
        why = f", with {' and '.join(joints)} at the limit" if joints else ""
        return (
            f"target {where} is within reach of {self.arm.name}, but every learned synergy"
            f" ({self.ik}/{self.model}) is still {missed.distance * 100:.1f} cm or more away from"
            f" it after {missed.time[-1]:.0f} s{why}: try another --ik, or go by way of another"
            " target"
        )


def joined(first: Motion, second: Motion) -> Motion:
    """Return two motions of the same joints one after the other.

    Parameters
    ----------
    first, second : Motion
        At one rate; the second starts where the first ends.

    Returns
    -------
    Motion

    Raises
    ------
    InputError
        Other joints, or a second motion that starts elsewhere.
    """
    if first.joint_names != second.joint_names:
        raise InputError(f"{second.source} has other joints than {first.source}")
    if first.angles is None or second.angles is None:
        raise InputError("only motions with joint angles can be joined")
    if not np.allclose(first.angles[-1], second.angles[0], rtol=0.0, atol=1e-3):
        raise InputError(f"{second.source} does not start where {first.source} ends")
    step = 1.0 / first.rate
    rows = [(motion.angles, motion.landmarks) for motion in (first, second)]
    angles, landmarks = (
        None if any(part is None for part in parts) else np.concatenate(parts)
        for parts in zip(*rows, strict=True)
    )
    return Motion(
        time=np.concatenate([first.time, first.time[-1] + step + second.time - second.time[0]]),
        joint_names=first.joint_names,
        angles=angles,
        landmark_names=first.landmark_names,
        landmarks=landmarks,
        source=f"{first.source}, then {second.source}",
    )
