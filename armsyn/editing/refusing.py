"""Edits that are not given unless forced: far from the examples, or without what was asked for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from armsyn.editing.constraints import Constraint, Pin, Task
from armsyn.editing.pattern.model import NEGLIGIBLE, MotionModel
from armsyn.editing.result import EditResult, Residual
from armsyn.errors import OutsidePatternError, UnreachableError

FloatArray = NDArray[np.float64]
_ROUNDING = 1e-9
_NOTHING_M = 1e-4
"""An edit that moves no body farther has changed nothing, m."""


def refuse_far(model: MotionModel, reached: FloatArray, own: FloatArray, bound: float) -> None:
    """Refuse what is farther from the mean than allowed, and farther than the clip itself.

    Parameters
    ----------
    model : MotionModel
    reached : array, shape (frames, m)
        Whitened coefficients of the edit.
    own : array, shape (m,)
        The clip's.
    bound : float
        Standard deviations.

    Raises
    ------
    OutsidePatternError
    """
    largest = float(np.abs(reached).max())
    if largest <= max(bound, float(np.abs(own).max()) + _ROUNDING):
        return
    component = int(np.abs(reached).max(axis=0).argmax())
    size, little = float(np.abs(model.directions[component]).max()), ""
    if size < NEGLIGIBLE:
        little = (
            f" (of component {component + 1}, by which they differ next to nothing: one moves no"
            f" joint by more than {1000 * size:.2g} mrad or mm)"
        )
    raise OutsidePatternError(
        f"the edit needs a coefficient of {largest:.6g} standard deviations of the"
        f" examples{little}, beyond the {bound:.6g} allowed: ask for less, learn from examples"
        " nearer to it, or force it",
        largest,
        bound,
    )


def refuse_missed(
    result: EditResult, tasks: Sequence[Task], constraints: Sequence[Constraint], allowed: float
) -> None:
    """Refuse what does not bring the first level to its goals, or changes nothing for the next.

    Parameters
    ----------
    result : EditResult
    tasks : sequence of Task
        Of the constraints.
    constraints : sequence of Constraint
    allowed : float
        What may be missed, m or rad.

    Raises
    ------
    UnreachableError
        What is missed, and which pins ask for more numbers than there are components.
    """
    missed = [residual for residual in result.residuals if residual.worst > allowed]
    if not missed:
        return
    before, after = result.positions
    later = missed[0].level > result.residuals[0].level
    if later and np.linalg.norm(after - before, axis=-1).max() > _NOTHING_M:
        return
    level = missed[0].level
    worst = max((r for r in missed if r.level == level), key=lambda residual: residual.worst)
    pins = [
        residual
        for residual in result.residuals
        if isinstance(constraints[residual.constraint], Pin) and residual.level <= level
    ]
    assert result.own_coefficients is not None  # noqa: S101 - of the latent space
    count = result.own_coefficients.size
    nothing = "nothing changed, as the levels before use all the freedom: " if later else ""
    raise UnreachableError(
        f"{nothing}{worst.label} is missed by {worst.amount}: the pattern's {count}"
        f" component{'s' * (count > 1)} within the joints' limits do not lead there"
        f"{_held_by(pins, tasks, count)}: ask for less, or on a further level; learn from more"
        " examples or more of their variance; or force it",
        worst.worst,
    )


def _held_by(pins: Sequence[Residual], tasks: Sequence[Task], count: int) -> str:
    """Name the pins with what they ask for, and how they are eased."""
    if not pins:
        return ""
    numbers = {residual.constraint for residual in pins}
    asked = sum(
        3 if task.turning else len(task.rows) for task in tasks if task.constraint in numbers
    )
    names = " and ".join(dict.fromkeys(residual.label for residual in pins))
    return (
        f" beside {names}, which ask{'s' * (len(numbers) == 1)} for {asked} numbers of {count}"
        " components (in a scene, pin fewer frames, one axis, such as the height, or on a later"
        " level)"
    )
