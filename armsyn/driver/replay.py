"""Trajectories and recordings from files, made ready to be streamed."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.driver.path import straight_way
from armsyn.driver.recording_load import load_recording, read_commanded
from armsyn.errors import FormatError, InputError
from armsyn.motion import Motion
from armsyn.motion.filtering import low_pass
from armsyn.motion.formats import read_motion
from armsyn.motion.resample import MAXIMUM_SAMPLES
from armsyn.safety import START_TOLERANCE, Closest, closest
from armsyn.safety.collision import MARGIN, TICK_MARGIN

FloatArray = NDArray[np.float64]

SMOOTHING = 4.0
"""Hz of the low-pass for measured angles, whose ticks alone would exceed every acceleration."""

_SAME = 1e-3
"""Part of a time step by which steps of one rate may differ: files round."""

_SAME_RATE = 5e-3
"""Part of a rate by which the ticks' own time stamps, whose median is taken, may be off it."""

_RECORDED = "recording of "
"""How the source of a recording's measured motion begins (`Recording.source`)."""


class Replay(NamedTuple):
    """A motion from a file.

    Attributes
    ----------
    motion : Motion
        At the stream's rate, from time 0; not yet checked.
    what : str
        What it was made of, for people.
    margin : float
        m that it must keep from what it must not touch. What was wanted in a run kept what every
        tick must, and so may come nearer than the samples of the motion that was planned then.
    """

    motion: Motion
    what: str
    margin: float = MARGIN


def load_replay(path: Path, arm: ArmDescription, rate: float) -> Replay:
    """Read a trajectory or a recording.

    A recording of a run is streamed as what was wanted of the arm then; one of an arm that was
    only observed as what was measured, smoothed.

    Parameters
    ----------
    path : Path
        ``.npz`` or ``.csv`` of ``armsyn-motion-1``.
    arm : ArmDescription
        Whose joints it must have.
    rate : float
        Hz.

    Returns
    -------
    Replay

    Raises
    ------
    FormatError
        As `armsyn.motion.formats.read_motion`.
    InputError
        No joint angles, other joints than the arm's, or too long.
    """
    motion = read_motion(path)
    if motion.angles is None:
        raise InputError(f"{path}: has landmark positions only: streaming needs joint angles")
    if set(motion.joint_names) != set(arm.joint_names):
        raise InputError(
            f"{path}: joints are {motion.joint_names}, those of {arm.name} are {arm.joint_names}"
        )
    order = [motion.joint_names.index(name) for name in arm.joint_names]
    recorded = _wanted_of(path, motion)
    if recorded is not None:
        wanted, recorded_rate = recorded
        # tick by tick: the time line did not jump over ticks that were missed
        time = np.arange(len(wanted)) / recorded_rate
        even = _resampled(time, wanted[:, order], arm, rate, str(path))
        return Replay(even, "what was wanted of the arm", TICK_MARGIN)
    angles, time = motion.angles[:, order], motion.time - motion.time[0]
    even = _resampled(time, angles, arm, rate, str(path))
    if not motion.source.startswith(_RECORDED):
        return Replay(even, "the file's angles")
    assert even.angles is not None  # noqa: S101 - of the line above
    smooth = low_pass(even.angles, rate, min(SMOOTHING, 0.4 * rate))
    smooth = np.clip(smooth, arm.chain.lower, arm.chain.upper)
    return Replay(
        Motion(even.time, arm.joint_names, smooth, source=even.source),
        f"measured angles, smoothed at {min(SMOOTHING, 0.4 * rate):g} Hz",
    )


def _wanted_of(path: Path, motion: Motion) -> tuple[FloatArray, float] | None:
    """What a recording says was wanted, and its rate, Hz; None of what is no recording of a run."""
    if path.suffix.lower() == ".csv":
        wanted = read_commanded(path, motion.joint_names)
        rate = 1.0 / float(np.median(np.diff(motion.time)))
        rate = round(rate) if abs(rate - round(rate)) < _SAME_RATE * rate else rate
    else:
        try:
            recording = load_recording(path)
        except FormatError:
            return None
        wanted, rate = recording.commanded_rad, recording.rate_hz
    return (wanted, rate) if wanted is not None and np.isfinite(wanted).all() else None


def _resampled(
    time: FloatArray, angles: FloatArray, arm: ArmDescription, rate: float, source: str
) -> Motion:
    """A motion at the stream's rate, by the interpolation that streams use."""
    duration = float(time[-1])
    if duration * rate > MAXIMUM_SAMPLES:
        raise InputError(f"{source}: {duration:.0f} s at {rate:g} Hz is too long: cut it")
    steps = np.diff(time)
    if np.abs(steps - 1.0 / rate).max() < _SAME * steps.max():  # nothing to interpolate
        return Motion(np.arange(time.size) / rate, arm.joint_names, angles, source=source)
    # the arm rests before and after, so that interpolation must begin and end at rest
    time = np.concatenate([[0.0], time + steps[0], [duration + steps[0] + steps[-1]]])
    angles = np.concatenate([angles[:1], angles, angles[-1:]])
    grid = np.arange(math.ceil(float(time[-1]) * rate - 1e-6) + 1) / rate
    return Motion(grid, arm.joint_names, _spline(time, angles, grid), source=source)


def _spline(time: FloatArray, angles: FloatArray, at: FloatArray) -> FloatArray:
    """Angles between samples by cubic splines, at rest at both ends.

    Their accelerations are continuous, and so not greater than those of the motion that was
    sampled, as the monotone cubics' that streams interpolate with are; they may overshoot a
    little, which is judged like all else.
    """
    from scipy.interpolate import CubicSpline  # noqa: PLC0415 - half a second, for this only

    spline = CubicSpline(time, angles, bc_type="clamped")
    return np.asarray(spline(np.minimum(at, time[-1])), dtype=np.float64)


def slowed(motion: Motion, factor: float, rate: float) -> Motion:
    """The same way in `factor` times the time, at `rate` Hz."""
    if not (math.isfinite(factor) and factor > 0.0):
        raise InputError(f"a motion cannot take {factor:g} times its time: give a positive number")
    if factor == 1.0 or motion.angles is None:
        return motion
    if motion.duration * factor * rate > MAXIMUM_SAMPLES:
        raise InputError(f"{motion.source}: {factor:g} times slower is too long: cut it")
    frames = max(2, math.ceil(motion.duration * factor * rate - 1e-6) + 1)
    grid = np.arange(frames) / rate
    angles = _spline(motion.time - motion.time[0], motion.angles, grid / factor)
    return Motion(grid, motion.joint_names, angles, source=motion.source)


def looped(motion: Motion, times: int, arm: ArmDescription, rate: float) -> Motion:
    """A motion several times; where it ends elsewhere than it starts, with straight ways back."""
    assert motion.angles is not None  # noqa: S101 - of `load_replay`
    first, last = motion.angles[0], motion.angles[-1]
    back = straight_way(last, first, arm, rate).angles
    assert back is not None  # noqa: S101 - a straight way
    if np.abs(last - first).max() < 1e-6:
        back = motion.angles[:1]
    rows = [motion.angles]
    for _ in range(times - 1):
        rows += [back[1:], motion.angles[1:]]
    angles = np.concatenate(rows)
    if len(angles) > MAXIMUM_SAMPLES:
        raise InputError(f"{motion.source}: {times} times is too long: loop it less often")
    time = np.arange(len(angles)) / rate
    return Motion(time, motion.joint_names, angles, source=motion.source)


def approach(
    present: FloatArray, motion: Motion, arm: ArmDescription, rate: float
) -> Motion | None:
    """Straight way from where the arm is to where a motion starts; None where it is there.

    It is not yet checked.
    """
    assert motion.angles is not None  # noqa: S101 - of `load_replay`
    if np.abs(present - motion.angles[0]).max() <= START_TOLERANCE:
        return None
    start = np.clip(present, arm.chain.lower, arm.chain.upper)
    return straight_way(start, motion.angles[0], arm, rate)


class Expected(NamedTuple):
    """What to expect of a motion.

    Attributes
    ----------
    duration : float
        s.
    lowest, highest : array, shape (n,)
        rad.
    speed, acceleration : array, shape (n,)
        Greatest of each joint, rad/s and rad/s2.
    nearest : Closest or None
        The nearest two things that must not touch; None where nothing is judged.
    """

    duration: float
    lowest: FloatArray
    highest: FloatArray
    speed: FloatArray
    acceleration: FloatArray
    nearest: Closest | None


def expect(motion: Motion, arm: ArmDescription) -> Expected:
    """Look at what a motion asks of an arm; `armsyn.safety.check_trajectory` judges it."""
    assert motion.angles is not None  # noqa: S101 - of `load_replay`
    step, angles = 1.0 / motion.rate, motion.angles
    velocity = np.diff(angles, axis=0, prepend=angles[:1], append=angles[-1:]) / step
    acceleration = np.diff(velocity, axis=0) / step
    return Expected(
        duration=motion.duration,
        lowest=angles.min(axis=0),
        highest=angles.max(axis=0),
        speed=np.abs(velocity).max(axis=0),
        acceleration=np.abs(acceleration).max(axis=0),
        nearest=closest(angles, arm),
    )
