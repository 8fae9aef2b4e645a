"""The servos' own position limits, which a motion must keep."""

from __future__ import annotations

from armsyn.arm import Calibration
from armsyn.driver.facts import ServoFacts
from armsyn.driver.registers import POSITION_MODE
from armsyn.errors import LimitError
from armsyn.motion import Motion


def check_position_limits(
    motion: Motion, facts: tuple[ServoFacts, ...], calibration: Calibration
) -> None:
    """Refuse a motion with a goal that a servo would refuse: sync write tells nobody about it.

    Parameters
    ----------
    motion : Motion
        Checked; angles of shape (frames, n), rad.
    facts : tuple of ServoFacts, length n
    calibration : Calibration

    Raises
    ------
    LimitError
        It leaves the limits in registers 52 and 48 of a servo in position mode.
    """
    assert motion.angles is not None  # noqa: S101 - check_trajectory made sure
    ticks = calibration.to_ticks(motion.angles)
    for column, servo in enumerate(facts):
        lower, upper = servo.minimum_position, servo.maximum_position
        low, high = int(ticks[:, column].min()), int(ticks[:, column].max())
        if servo.operating_mode == POSITION_MODE and not lower <= low <= high <= upper:
            value, limit = (low, lower) if low < lower else (high, upper)
            raise LimitError(
                f"{servo.title} would be sent to tick {value}, its own limits are {lower} to"
                f" {upper} (registers 52 and 48): plan another motion, or widen them",
                servo.joint,
                value,
                limit,
            )
