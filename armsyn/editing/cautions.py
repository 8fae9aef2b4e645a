"""What is to be said of an edit that came out, and may not be what was wanted."""

from __future__ import annotations

from armsyn.editing.result import EditResult

LIFTED_M = 0.02
"""Feet that stood and are higher or lower than this after an edit are seen to float or sink, m."""


def edit_cautions(result: EditResult, coefficient_bound: float) -> list[str]:
    """Return a line for each thing that a user should look at, none for an edit without.

    Parameters
    ----------
    result : EditResult
    coefficient_bound : float
        Standard deviations beyond which an edit is refused unless forced.

    Returns
    -------
    list of str
    """
    found = []
    if not result.success:
        found.append("not every constraint is met: see what each level misses")
    largest = result.largest_coefficient
    if largest is not None and largest > coefficient_bound:
        found.append(
            f"the largest coefficient, {largest:.2f} sigma, is beyond the {coefficient_bound:g}"
            " allowed: far from all examples"
        )
    lifted = {name: foot.lift for name, foot in result.feet.items() if foot.lift > LIFTED_M}
    if lifted:
        name = max(lifted, key=lambda foot: lifted[foot])
        found.append(
            f"feet that stood are lifted or sunk, {name} by {100 * lifted[name]:.1f} cm: pin them"
            ' (in a scene, axes = "z" and a few frames leave the most freedom)'
        )
    return found
