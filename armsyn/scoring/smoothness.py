"""Smoothness of a speed profile as a number: SPARC and LDLJ.

Neither may gate human-likeness alone: a raw inverse-kinematics decay scores better on LDLJ than
minimum jerk does (-4.12 against -5.30).
"""

from __future__ import annotations

import math

import numpy as np

from armsyn.errors import CaptureError
from armsyn.motion import FloatArray

SPARC_CUTOFF = 10.0
SPARC_THRESHOLD = 0.05
SPARC_PADDING = 4


def spectral_arc_length(
    speed: FloatArray,
    rate: float,
    cutoff: float = SPARC_CUTOFF,
    threshold: float = SPARC_THRESHOLD,
    padding: int = SPARC_PADDING,
) -> float:
    """Measure SPARC, minus the arc length of the speed's normalised amplitude spectrum.

    Parameters
    ----------
    speed : array, shape (samples,)
        Speed, m/s, from onset to offset.
    rate : float
        Hz.
    cutoff : float
        Hz, the highest frequency looked at.
    threshold : float
        Amplitude, of the largest, below which the spectrum's tail is left out.
    padding : int
        The spectrum has 2^padding times the samples, rounded up to a power of two. Its grid
        scatters SPARC by up to 0.015.

    Returns
    -------
    float
        Dimensionless; about -1.4 for a simple reach, lower for a less smooth one.

    Raises
    ------
    CaptureError
        When nothing moves, or too little of the spectrum is left.

    References
    ----------
    Balasubramanian et al., J NeuroEng Rehabil 12:112 (2015), eq. 4-5.
    """
    _check_moving(speed, 2)
    size = int(2 ** (math.ceil(math.log2(speed.size)) + padding))
    spectrum = np.abs(np.fft.rfft(speed, size))
    frequency = np.fft.rfftfreq(size, 1 / rate)
    amplitude = (spectrum / spectrum.max())[frequency <= cutoff]
    last = int(np.flatnonzero(amplitude >= threshold)[-1])
    if last == 0:
        raise CaptureError("too few samples for a spectral arc length: the motion is too short")
    steps = np.diff(amplitude[: last + 1])
    return -float(np.hypot(1 / last, steps).sum())


def log_dimensionless_jerk(speed: FloatArray, rate: float) -> float:
    """Measure LDLJ, -ln(T^3 / v_peak^2 * integral of the squared second derivative of speed).

    T is the number of samples over the rate (N / fs), as in the authors' own code; with
    T = (N - 1) / fs the value would be larger by 3 ln(N / (N - 1)). The derivative is the second
    difference, so the value moves with the rate: minimum jerk, -5.322 in closed form, gives
    -5.302 at 100 Hz.

    Parameters
    ----------
    speed : array, shape (samples,)
        Speed, m/s, from onset to offset; say its filter with the number.
    rate : float
        Hz.

    Returns
    -------
    float
        Dimensionless; higher is smoother.

    Raises
    ------
    CaptureError
        When nothing moves, there are fewer than three samples, or the speed has no curvature.

    References
    ----------
    Balasubramanian et al., J NeuroEng Rehabil 12:112 (2015), eq. 2; Bayle et al. (2023).
    """
    _check_moving(speed, 3)
    jerk_squared = float((np.diff(speed, 2) ** 2).sum()) * rate**3
    dimensionless = (speed.size / rate) ** 3 / float(speed.max()) ** 2 * jerk_squared
    if dimensionless <= 0:
        raise CaptureError("a speed without curvature has no LDLJ: the motion is not a reach")
    return -math.log(dimensionless)


def _check_moving(speed: FloatArray, samples: int) -> None:
    if speed.size < samples:
        raise CaptureError(f"{speed.size} samples of speed are too few: at least {samples} needed")
    if not np.isfinite(speed).all() or speed.max() <= 0:
        raise CaptureError(
            "the speed has gaps, or nothing moves: there is no smoothness to measure"
        )
