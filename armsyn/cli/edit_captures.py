"""Captured reaches of people as an arm's motions, for `armsyn edit`."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.motion import Motion

RATE = 200.0
"""Hz of arms' motions, as `armsyn stream` takes them."""
MOST_SLOWED = 10.0
"""A reach that an arm takes only slower than this has postures that jump: the arm cannot follow
the person's elbow there."""


def captured_on(text: str, arm: ArmDescription) -> list[Motion]:
    """Put captured reaches on an arm, slowed until its speeds and accelerations hold.

    Parameters
    ----------
    text : str
        Selection of `armsyn.motion.captures.load_captures`, such as ``garza``.
    arm : ArmDescription

    Returns
    -------
    list of Motion
        From rest to rest, of those that the arm can follow; which others were left out is said on
        standard error.

    Raises
    ------
    CaptureError
        Nothing of that name, or nothing that the arm can follow.
    """
    import click

    from armsyn.cli.long_work import StageBars
    from armsyn.errors import CaptureError
    from armsyn.motion.captures import load_captures
    from armsyn.planning.examples import examples_on_arm

    captures = load_captures(text)
    with StageBars() as bars:

        def show(done: int, total: int) -> None:
            if total > 1:  # one takes no time to speak of
                bars.update(f"reaches on {arm.name}", done, total, "")

        examples = examples_on_arm(arm, captures, on_progress=show)
    found, left_out = [], []
    for name, angles, duration in zip(
        examples.names, examples.angles, examples.durations, strict=True
    ):
        motion = _in_time(name, angles, float(duration), arm)
        if motion is None:
            left_out.append(name)
        else:
            found.append(motion)
    if not found:
        raise CaptureError(f"{text}: postures of {arm.name} jump in it: choose another reach")
    if left_out:
        click.echo(f"left out, as postures of {arm.name} jump: {', '.join(left_out)}", err=True)
    return found


def _in_time(name: str, angles: object, duration: float, arm: ArmDescription) -> Motion | None:
    import numpy as np

    from armsyn.errors import LimitError
    from armsyn.motion import Motion
    from armsyn.planning.timing import in_time

    try:
        timed = in_time(np.asarray(angles), duration, arm, RATE)
    except LimitError:
        return None
    if timed.time_scale > MOST_SLOWED:
        return None
    time = np.arange(len(timed.angles)) / RATE
    return Motion(time, arm.joint_names, timed.angles, source=name)
