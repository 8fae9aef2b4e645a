"""Source of a roll-out made for one chain: straight-line, eight lanes at a time.

The kernel of ``plain.py`` serves any chain; a compiler cannot vectorise it. Here the chain's
numbers are written into the source, what is zero or one vanishes, and the step of a lane becomes
one run of multiplications and additions that the compiler does for several lanes at once. A lane
that needs more (a singular value near the cut-off, which takes the general SVD) is marked and
left to the plain kernel, which is also what every test compares with.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Literal, NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial
from numpy.typing import NDArray

from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.expressions import Source, Value
from armsyn.kernels.optimisers import (
    DAMPED,
    NORMALISED_TRANSPOSE,
    ROUNDING,
    SVD,
    OptimiserSettings,
)
from armsyn.kernels.types import FloatArray

WIDTH = 8
"""Lanes of a block: two vectors of AVX2 or one of AVX-512."""

LARGEST_POWER = 1e300
"""Of e^(offset - slope t); beyond it a lane is left to the plain kernel."""

_POLYNOMIAL_ERROR = 1e-16
_RIGHT_ANGLE = 1e-15
"""Rotations by right angles leave this much in place of 0 and 1."""

_TWO_PI_LOW = 2.4492935982947064e-16
"""What 2 pi exceeds its nearest double by."""

Values = NDArray[np.object_]


Output = Literal["paths", "distances", "gaps"]


class Plan(NamedTuple):
    """What a roll-out is generated for.

    Attributes
    ----------
    chain : ChainArrays
    optimiser : OptimiserSettings
    shared : bool
        One sigmoid for all joints, not one each.
    damped_limits : bool
        Joints near their limits at a limited rate (`Timing.limit_rate`), not just clamped.
    output : {"paths", "distances", "gaps"}
        Write every frame's posture, sum the distances to captured landmarks (paper 3.4), or
        write every frame's vectors from them.
    rows : tuple of int
        Rows (joint, or n for the tip) that the landmarks are compared with; none for paths.
    """

    chain: ChainArrays
    optimiser: OptimiserSettings
    shared: bool
    damped_limits: bool
    output: Output
    rows: tuple[int, ...]

    @property
    def dof(self) -> int:
        """Number of joints."""
        return self.chain.prismatic.size

    @property
    def sigmoids(self) -> int:
        """Sigmoids of a lane."""
        return 1 if self.shared else self.dof


class Generated(NamedTuple):
    """Source of the module, and the operations of one step of a lane by kind.

    Kinds are ``*``, ``+`` (subtractions, too), ``/`` and the names of functions.
    """

    text: str
    operations: Counter[str]


class Rows(NamedTuple):
    """First row of each part of a block's state, shape (rows, WIDTH)."""

    posture: int
    gains: int
    powers: int
    decays: int
    target: int
    doubt: int
    total: int
    gaps: int
    size: int


def rows_of(plan: Plan) -> Rows:
    """Where the state of a lane lies.

    `powers` are e^(offset - slope t), which `decays` multiply from frame to frame; `doubt` is
    not zero once a lane needs the plain kernel; `total` sums the distances of its landmarks, m,
    and `gaps` are the vectors from them in this frame.
    """
    n, k = plan.dof, plan.sigmoids
    gaps = 3 * len(plan.rows) if plan.output == "gaps" else 0
    return Rows(*itertools.accumulate([0, n, n, k, k, 3, 1, 1, gaps]))


def polynomial_ranges(chain: ChainArrays) -> FloatArray:
    """Greatest angle of each joint up to which its sine is right, shape (n,), rad."""
    reach = np.maximum(np.abs(chain.lower), np.abs(chain.upper))
    return np.where(chain.prismatic | (reach > math.pi), np.inf, reach)


def generate(plan: Plan) -> Generated:
    """Write the roll-out of a plan.

    Parameters
    ----------
    plan : Plan

    Returns
    -------
    Generated
        The module defines ``play(states, frames, motions, first, last, factors, share, marks,
        out)``, which `armsyn.kernels.compiled.Play` describes.
    """
    source, rows = Source(), rows_of(plan)
    results = _step(plan, source)
    lines = source.needed_for(list(results.values()))
    marks = [
        f"mark_{k} = marks[motions[block], frame, {k // 3}, {k % 3}]"
        for k in range(3 * len(plan.rows))
    ]
    write = _WRITE.splitlines()
    text = _MODULE.format(
        marks=_indented(marks, 12),
        before=_indented(write if plan.output == "paths" else [], 12),
        body=_indented([f"{line.name} = {line.expression}" for line in lines], 16),
        store=_indented([f"{place} = {value.text}" for place, value in results.items()], 16),
        after=_indented(write if plan.output == "gaps" else [], 12),
        width=WIDTH,
    ).format(
        width=WIDTH,
        first=WIDTH * (rows.posture if plan.output == "paths" else rows.gaps),
        count=plan.dof if plan.output == "paths" else 3 * len(plan.rows),
    )
    return Generated(text, Counter(line.kind for line in lines))


def _indented(lines: Iterable[str], by: int) -> str:
    return "\n".join(" " * by + line for line in lines)


_MODULE = '''\
"""Generated by armsyn.kernels.generator: change that, not this."""

import math

import numpy as np

from armsyn.kernels.compiling import generated_kernel


@generated_kernel
def play(states, frames, motions, first, last, factors, share, marks, out):
    for block in range(first, last):
        state = states[block]
        for frame in range(frames[block]):
            factor = factors[frame]
{marks}
{before}
            for lane in range({width}):
{body}
{store}
{after}
'''

_WRITE = """\
for lane in range(min({width}, out.shape[0] - block * {width})):
    for i in range({count}):
        out[block * {width} + lane, frame, i] = state[{first} + i * {width} + lane]"""


def _step(plan: Plan, source: Source) -> dict[str, Value]:
    """Write one step of a lane; return what is to be stored where."""
    rows = rows_of(plan)

    def place(row: int) -> str:
        return f"state[lane + {row * WIDTH}]"

    def column(first: int, count: int) -> Values:
        return np.array([source.load(place(first + i)) for i in range(count)])

    posture = column(rows.posture, plan.dof)
    powers = column(rows.powers, plan.sigmoids)
    origins, axes = _forward(plan, source, posture)
    error = column(rows.target, 3) - origins[-1]
    J = _jacobian(plan.chain, origins, axes)
    y, divisor, margin = _optimise(plan.optimiser, source, J, error)
    inverse_phi = powers + source.number(1.0)
    factor = source.value("factor")
    if plan.shared:
        y = y * (factor / (inverse_phi[0] * divisor))
        change = column(rows.gains, plan.dof) * (J.T @ y)
    else:
        y = y * (factor / divisor)
        change = column(rows.gains, plan.dof) * (J.T @ y) / inverse_phi
    moved = [_limited(plan, source, i, posture[i], change[i]) for i in range(plan.dof)]
    grown = powers * column(rows.decays, plan.sigmoids)
    results = {place(rows.posture + i): value for i, value in enumerate(moved)}
    results |= {place(rows.powers + i): value for i, value in enumerate(grown)}
    doubt = source.load(place(rows.doubt))
    results[place(rows.doubt)] = doubt + _doubt(source, margin, powers)
    gaps = [origins[row] - _mark(source, k) for k, row in enumerate(plan.rows)]
    if plan.output == "distances":
        total = source.load(place(rows.total))
        for gap in gaps:
            total = total + source.call("math.sqrt", _square(gap))
        results[place(rows.total)] = total
    elif plan.output == "gaps":
        flat = np.concatenate(gaps)
        results |= {place(rows.gaps + i): value for i, value in enumerate(flat)}
    return results


def _forward(plan: Plan, source: Source, posture: Values) -> tuple[list[Values], list[Values]]:
    """Positions of every joint and the tip, and the joints' axes; as `chain.forward`."""
    numbers = np.vectorize(source.number, otypes=[object])
    nearest = np.rint(plan.chain.rotation)
    exact = np.abs(plan.chain.rotation - nearest) < _RIGHT_ANGLE
    rotations = numbers(np.where(exact, nearest, plan.chain.rotation))
    translations = numbers(plan.chain.translation)
    R, position = numbers(np.eye(3)), numbers(np.zeros(3))
    origins, axes = [], []
    for i in range(plan.dof):
        position = position + R @ translations[i]
        R = R @ rotations[i]
        if plan.chain.prismatic[i]:
            position = position + R[:, 2] * posture[i]
        else:
            reach = max(abs(plan.chain.lower[i]), abs(plan.chain.upper[i]))
            s, c = _sine_and_cosine(source, posture[i], reach)
            x, y = R[:, 0] * c + R[:, 1] * s, R[:, 1] * c - R[:, 0] * s
            R = np.stack([x, y, R[:, 2]], axis=1)
        origins.append(position)
        axes.append(R[:, 2])
    return [*origins, position + R @ translations[-1]], axes


def _sine_and_cosine(source: Source, angle: Value, reach: float) -> tuple[Value, Value]:
    """Polynomials in the square of half the angle, as long as the joint's range asks for.

    Chebyshev interpolation of sin(x) / x and cos(x), which are entire functions of x^2, on
    [0, h^2] with k terms is off by at most 2 (h / 2)^2k / (2k)!.
    """
    if reach > math.pi:
        turns = source.call("np.rint", angle * source.number(0.5 / math.pi))
        angle = angle - turns * source.number(2.0 * math.pi)
        angle = angle - turns * source.number(_TWO_PI_LOW)
        reach = math.pi
    half, reach = angle * source.number(0.5), reach / 2.0
    order = 1
    while 2.0 * (reach / 2.0) ** (2 * order) / math.factorial(2 * order) > _POLYNOMIAL_ERROR:
        order += 1
    square = half * half

    def polynomial(function: Callable[[FloatArray], FloatArray]) -> Value:
        fit = Chebyshev.interpolate(function, order - 1, domain=[0.0, reach**2])
        total = source.number(0.0)
        for coefficient in fit.convert(kind=Polynomial).coef[::-1]:
            total = total * square + source.number(coefficient)
        return total

    sine = half * polynomial(lambda z: np.sinc(np.sqrt(z) / np.pi))
    cosine = polynomial(lambda z: np.cos(np.sqrt(z)))
    double = sine + sine
    return double * cosine, source.number(1.0) - double * sine


def _jacobian(chain: ChainArrays, origins: list[Values], axes: list[Values]) -> Values:
    """Linear part of the geometric Jacobian of the tip, shape (3, n)."""
    columns = []
    for i, axis in enumerate(axes):
        x, y, z = axis
        dx, dy, dz = origins[-1] - origins[i]
        turning = [y * dz - z * dy, z * dx - x * dz, x * dy - y * dx]
        columns.append(list(axis) if chain.prismatic[i] else turning)
    return np.array(columns).T


def _optimise(
    optimiser: OptimiserSettings, source: Source, J: Values, error: Values
) -> tuple[Values, Value, Value]:
    """Return y, a divisor d and a margin: where that is positive O(J, error) is J^T y / d."""
    if optimiser.kind in (SVD, DAMPED):
        return _inverse(optimiser, source, J, error)
    if optimiser.kind == NORMALISED_TRANSPOSE:
        norm = _square(J.T @ error)
        scale = source.call("math.sqrt", _square(error))
        divisor = source.call("math.sqrt", norm) * source.number(optimiser.slowing)
        return error * scale, divisor, norm
    return error, source.number(1.0), source.number(1.0)


def _inverse(
    optimiser: OptimiserSettings, source: Source, J: Values, error: Values
) -> tuple[Values, Value, Value]:
    """Return (J J^T + damping) inverted by cofactors; the margin is that of `_exact3`."""
    damped = optimiser.kind == DAMPED
    square = optimiser.damping**2 if damped else 0.0
    cut_off = 0.0 if damped else optimiser.cut_off
    B = J @ J.T + np.vectorize(source.number, otypes=[object])(square * np.eye(3))
    cofactors = np.array(
        [
            [
                B[(i + 1) % 3, (j + 1) % 3] * B[(i + 2) % 3, (j + 2) % 3]
                - B[(i + 1) % 3, (j + 2) % 3] * B[(i + 2) % 3, (j + 1) % 3]
                for j in range(3)
            ]
            for i in range(3)
        ]
    )
    determinant = B[0] @ cofactors[0]
    trace = B[0, 0] + B[1, 1] + B[2, 2]
    least = trace * trace * trace * source.number(0.25 * max(cut_off * cut_off, ROUNDING))
    return cofactors @ error, determinant, determinant - least


def _square(vector: Values) -> Value:
    total: Value = vector @ vector
    return total


def _limited(plan: Plan, source: Source, i: int, angle: Value, change: Value) -> Value:
    """Posture after a change, within the joint's limits."""
    lower, upper = source.number(plan.chain.lower[i]), source.number(plan.chain.upper[i])
    if not plan.damped_limits:
        return source.call("min", source.call("max", angle + change, lower), upper)
    share = source.value("share")
    room = source.call("max", change, (lower - angle) * share)
    return angle + source.call("min", room, (upper - angle) * share)


def _doubt(source: Source, margin: Value, powers: Values) -> Value:
    """1 where the margin is not positive or e^(offset - slope t) has left its range, else 0."""
    largest = powers.sum()
    expression = f"0.0 if ({margin.text} > 0.0) & ({largest.text} < {LARGEST_POWER!r}) else 1.0"
    return source.assign(expression, (margin.name, largest.name), "if")


def _mark(source: Source, number: int) -> Values:
    return np.array([source.value(f"mark_{3 * number + k}") for k in range(3)])
