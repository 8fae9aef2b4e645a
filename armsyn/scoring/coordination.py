"""How few directions the joints of an arm move along together."""

from __future__ import annotations

import numpy as np

from armsyn.errors import CaptureError
from armsyn.motion import FloatArray


def explained_variance(angles: FloatArray, components: int = 3) -> FloatArray:
    """Return the share of the joint angles' variance that the first principal components explain.

    Parameters
    ----------
    angles : array, shape (samples, joints)
        rad, from onset to offset, evenly spaced in time; not standardised, so that a joint counts
        by how far it moves.
    components : int
        How many.

    Returns
    -------
    array, shape (components,)
        Cumulative: by 1, by the first 2, ...; all 1 from the number of joints on; NaN when no
        joint moves.

    Raises
    ------
    CaptureError
        When angles have gaps.

    References
    ----------
    Bockemuehl, Troje and Duerr, Hum Mov Sci 29:73 (2010): two explain over 90 % within one
    movement.
    """
    if not np.isfinite(angles).all():
        raise CaptureError("joint angles have gaps: there is no coordination to measure")
    spread = np.linalg.svd(angles - angles.mean(axis=0), compute_uv=False) ** 2
    # What is left of joints at rest is the rounding of their mean.
    if spread.sum() <= angles.size * (1e-12 * np.abs(angles).max(initial=1.0)) ** 2:
        return np.full(components, np.nan)
    share = np.minimum(np.cumsum(spread) / spread.sum(), 1.0)
    return np.asarray(np.concatenate([share, np.ones(components)])[:components])
