"""The shape of a speed profile: its peak, its likeness to minimum jerk."""

from __future__ import annotations

import numpy as np

from armsyn.errors import CaptureError, InputError
from armsyn.motion import FloatArray
from armsyn.motion.resample import interpolate


def minimum_jerk_speed(phase: FloatArray) -> FloatArray:
    """Return the speed of the minimum-jerk movement of unit duration and length.

    Parameters
    ----------
    phase : array, shape (samples,)
        Time over duration, 0 to 1.

    Returns
    -------
    array, shape (samples,)
        30 s^2 - 60 s^3 + 30 s^4, dimensionless; 1.875 at its peak.

    References
    ----------
    Flash and Hogan, J Neurosci 5:1688 (1985).
    """
    return 30 * phase**2 * (1 - phase) ** 2


def path_length(speed: FloatArray, rate: float) -> float:
    """Integrate speed over time (trapezoidal rule).

    Parameters
    ----------
    speed : array, shape (samples,)
        m/s.
    rate : float
        Hz.

    Returns
    -------
    float
        m.
    """
    return float((speed[1:] + speed[:-1]).sum()) / (2 * rate)


def time_to_peak(speed: FloatArray) -> float:
    """Return when the speed peaks, as a share of the movement time.

    Parameters
    ----------
    speed : array, shape (samples,)
        m/s, from onset to offset.

    Returns
    -------
    float
        0 to 1; about 0.5 in people's reaches. The first sample counts where several are highest.
    """
    return int(np.argmax(speed)) / (speed.size - 1)


def peak_over_mean(speed: FloatArray, rate: float) -> float:
    """Return the peak speed over the mean speed, v_peak T / path.

    Parameters
    ----------
    speed : array, shape (samples,)
        m/s, from onset to offset.
    rate : float
        Hz.

    Returns
    -------
    float
        1.875 for minimum jerk, 1 for constant speed.
    """
    return float(speed.max()) * (speed.size - 1) / rate / path_length(speed, rate)


def correlation(first: FloatArray, second: FloatArray) -> float:
    """Return Pearson's r of two profiles over normalised time.

    Parameters
    ----------
    first, second : array, shape (samples,) each
        Speeds from onset to offset, evenly sampled; the longer is interpolated to the shorter.

    Returns
    -------
    float
        -1 to 1; NaN when one of them is constant, for then there is none.

    Raises
    ------
    InputError
        When one of them has fewer than two samples.
    """
    if min(first.size, second.size) < 2:
        raise InputError("correlation needs two samples of each profile at least")
    samples = min(first.size, second.size)
    a, b = (_stretched(profile, samples) for profile in (first, second))
    a, b = _centred(a), _centred(b)
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    return float(a @ b) / size if size > 0 else float("nan")


def _centred(profile: FloatArray) -> FloatArray:
    centred = profile - profile.mean()
    # What is left of a constant profile is the rounding of its mean, not a shape.
    is_constant = np.abs(centred).max() <= 1e-12 * np.abs(profile).max()
    return np.zeros_like(profile) if is_constant else centred


def _stretched(profile: FloatArray, samples: int) -> FloatArray:
    if profile.size == samples:
        return profile
    own = np.linspace(0.0, 1.0, profile.size)
    return interpolate(own, profile, np.linspace(0.0, 1.0, samples))


def minimum_jerk_fit(speed: FloatArray, rate: float) -> tuple[float, float]:
    """Compare with the minimum-jerk movement of the same duration and path length.

    Parameters
    ----------
    speed : array, shape (samples,)
        m/s, from onset to offset.
    rate : float
        Hz.

    Returns
    -------
    r : float
        Pearson's correlation; NaN for a constant speed.
    r2 : float
        1 minus the squared differences over the variance of the minimum-jerk curve, which is the
        same for every profile of one duration and path; below 0 where a constant would be closer.

    Raises
    ------
    CaptureError
        When there are fewer than three samples.

    References
    ----------
    Richardson and Flash, J Neurosci 22:8201 (2002).
    """
    if speed.size < 3:
        raise CaptureError("a minimum-jerk fit needs three samples at least")
    duration = (speed.size - 1) / rate
    fit = minimum_jerk_speed(np.linspace(0.0, 1.0, speed.size))
    fit = fit * path_length(speed, rate) / duration
    r2 = 1 - float(((speed - fit) ** 2).sum()) / float(((fit - fit.mean()) ** 2).sum())
    return correlation(speed, fit), r2
