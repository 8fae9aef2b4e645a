"""The four optimisers by name, with their constants.

================ ============================================================================
``svd``          pseudo-inverse by SVD: J^T (J J^T)^-1 while no singular value is below the
                 cut-off, else the truncated inverse; never damped
``jt``           J^T dX
``njt``          the direction of J^T dX; its norm is the task error over `slowing`
``dls``          J^T (J J^T + mu^2 I)^-1 dX (Wampler 1986)
================ ============================================================================

Sources: Aubry, Julliard, Gibet 2009, 3.1 (svd, jt, njt). The paper does not say how the
normalised step ends; a step that shrinks with the error is our choice, for one of constant
length would circle the target.
"""

from __future__ import annotations

import math

from armsyn.errors import InputError
from armsyn.kernels import optimisers as kernels
from armsyn.kernels.optimisers import OptimiserSettings

OPTIMISERS = ("svd", "jt", "njt", "dls")
_KINDS = {
    "svd": kernels.SVD,
    "jt": kernels.TRANSPOSE,
    "njt": kernels.NORMALISED_TRANSPOSE,
    "dls": kernels.DAMPED,
}


def optimiser_settings(
    name: str,
    *,
    cut_off: float = 1e-3,
    damping: float = 0.05,
    slowing: float = 0.5,
    radius: float = 0.2,
) -> OptimiserSettings:
    """Constants of an optimiser.

    Parameters
    ----------
    name : {"svd", "jt", "njt", "dls"}
    cut_off : float
        ``svd``: singular values below this share of the largest count as zero.
    damping : float
        ``dls``: mu, m.
    slowing : float
        ``njt``: task error, m, at which one unit of lambda dt turns one radian.
    radius : float
        m that one radian of orientation error weighs in a pose.

    Returns
    -------
    OptimiserSettings

    Raises
    ------
    InputError
        Unknown name, or a constant out of its range.
    """
    if name not in _KINDS:
        raise InputError(f"no optimiser {name!r}; known: {', '.join(OPTIMISERS)}")
    if not (0.0 <= cut_off < 1.0 and 0.0 < damping < math.inf):
        raise InputError(
            f"cut_off must be in [0, 1) and damping above 0, got {cut_off:g} and {damping:g}"
        )
    if not (0.0 < slowing < math.inf and 0.0 < radius < math.inf):
        raise InputError(f"slowing and radius must be above 0, got {slowing:g} and {radius:g}")
    return OptimiserSettings(_KINDS[name], cut_off, damping, slowing, radius)
