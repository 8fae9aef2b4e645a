"""The controller written out as the paper has it, step by step, over Pinocchio."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from armsyn.kinematics import SerialChain
from tests.kinematics.oracle import Oracle

Array = NDArray[np.float64]
CUT_OFF, DAMPING, SLOWING, RADIUS = 1e-3, 0.05, 0.5, 0.2  # the documented constants of O


def optimise(name: str, J: Array, dX: Array) -> Array:
    """Return O(J, dX) of section 3.1."""
    if name == "svd":
        return np.linalg.pinv(J, rcond=CUT_OFF) @ dX
    if name == "dls":
        return J.T @ np.linalg.inv(J @ J.T + DAMPING**2 * np.eye(len(J))) @ dX
    step = J.T @ dX
    if name == "njt":
        step *= np.linalg.norm(dX) / SLOWING / np.linalg.norm(step)
    return step


@dataclass(frozen=True)
class Sigmoids:
    """M and phi of a parameter vector, section 4: sig(x) = 1 / (1 + e^x), phi = sig(-s t + o)."""

    model: str
    dof: int
    parameters: Array

    @property
    def gains(self) -> Array:
        p, n = self.parameters, self.dof
        return np.diag(np.full(n, p[0]) if self.model == "A" else p[:n])

    def phi(self, t: float) -> Array:
        p, n = self.parameters, self.dof
        if self.model in "AB":
            return np.ones(n)
        o, s = (p[n], p[n + 1]) if self.model == "C" else (p[n : 2 * n], p[2 * n :])
        return np.full(n, 1.0) / (1.0 + np.exp(-s * t + o))


@dataclass(frozen=True)
class Plain:
    """One controller: a chain, an optimiser, lambda, and what arms add to the paper."""

    chain: SerialChain
    optimiser: str
    rate: float
    dt: float
    ramp: float = 0.0
    limit_rate: float = np.inf

    def play(
        self,
        start: Array,
        target: Array,
        synergy: Sigmoids,
        frames: int,
        orientation: Array | None = None,
    ) -> Array:
        """Return the postures, shape (frames, n)."""
        oracle = Oracle(self.chain)
        path = [np.array(start)]
        for frame in range(frames - 1):
            q = path[-1]
            J, dX = self._task(oracle, q, target, orientation)
            change = self.rate * self.dt * optimise(self.optimiser, J, dX)
            t = frame * self.dt
            change = synergy.phi(t) * (synergy.gains @ change) * self._ramp(t)
            path.append(self._within_limits(q, change))
        return np.array(path)

    def _task(
        self, oracle: Oracle, q: Array, target: Array, orientation: Array | None
    ) -> tuple[Array, Array]:
        positions, orientations = oracle.frames(q)
        J, dX = oracle.jacobian(q), target - positions[-1]
        if orientation is None:
            return J[:3], dX
        turn = pin.log3(orientation @ orientations[-1].T)
        return np.vstack([J[:3], RADIUS * J[3:]]), np.concatenate([dX, RADIUS * turn])

    def _ramp(self, t: float) -> float:
        s = t / self.ramp if t < self.ramp else 1.0
        return 10 * s**3 - 15 * s**4 + 6 * s**5

    def _within_limits(self, q: Array, change: Array) -> Array:
        lower, upper = self.chain.lower, self.chain.upper
        if np.isinf(self.limit_rate):
            return np.clip(q + change, lower, upper)
        share = min(1.0, self.limit_rate * self.dt)
        return q + np.clip(change, share * (lower - q), share * (upper - q))
