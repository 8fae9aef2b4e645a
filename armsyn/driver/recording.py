"""What an arm was told and what it did, and the files that keep it.

Files follow ``armsyn-motion-1`` (see `armsyn.motion.formats`), so that reading one as a motion
gives the measured motion; what goes beyond a motion stands beside it.
"""

from __future__ import annotations

import enum
import hashlib
from dataclasses import dataclass, field, fields
from typing import Self

import msgspec
import numpy as np
from numpy.typing import NDArray

import armsyn
from armsyn.arm import ArmDescription
from armsyn.driver.log import Event, StreamLog
from armsyn.errors import FormatError
from armsyn.motion import Motion

FloatArray = NDArray[np.float64]


CLEARING = (
    "watchdogs that are armed expire when this program ends: look at the arm, then armsyn clear"
    " lets it move again"
)
"""What follows from a fault, and how to clear it."""

NEXT = "armsyn park puts it to rest, armsyn release lets go of it"
"""What an operator may want of an arm that holds."""


class Ending(enum.Enum):
    """How a run left the arm, in words for the operator."""

    COMPLETED = f"at the target, torque on, holding; {NEXT}"
    PARKED = "parked, torque off"
    PARK_MISSED = f"stopped short of the rest posture, torque on, holding; {NEXT}"
    STOPPED_HOLDING = f"stopped on request, torque on, holding where it came to rest; {NEXT}"
    STOPPED_PARKED = (
        "stopped on request, moved to the rest posture, torque on, holding; armsyn release lets go"
        " of it"
    )
    ABORTED = f"held at once on the second request to stop, torque on; {CLEARING}"
    FAULT = f"held at once on a fault, torque as the fault left it; {CLEARING}"
    OBSERVED = "only recorded: nothing was written to the servos"


def _not_given() -> FloatArray:
    return np.empty(0)


def fingerprint(arm: ArmDescription) -> str:
    """SHA-256 of a description as it is used, with what a calibration changed in it; hex digits.

    Comments and layout of the files do not count.
    """
    return hashlib.sha256(msgspec.json.encode(arm)).hexdigest()


@dataclass(frozen=True)
class Recording:
    """One run of an arm, one row a tick; arrays are read-only.

    Attributes
    ----------
    arm, port : str
    simulated : bool
        As the caller of the session said.
    joint_names : tuple of str
    rate_hz : float
        Asked for.
    time_s : array, shape (ticks,)
        When each command was sent, s from the stream's start, on the monotonic clock.
    commanded_rad : array, shape (ticks, n)
        The posture wanted; NaN where the arm was only observed.
    measured_rad : array, shape (ticks, n)
        The last known angle where a reply was lost (`stale`).
    velocity_rad_s, current_a : array, shape (ticks, n)
        As the servos report them; current is NaN where a servo has no current sensor.
    stale : array of bool, shape (ticks, n)
        Where no reply came.
    hardware_error : array of uint8, shape (ticks, n)
        Hardware Error Status (register 70), as far as it was read.
    events : tuple of Event
        What happened when, and how grave it is.
    ticks, missed_ticks : int
        Commands sent; ticks skipped because the host was late.
    dropped_rows : int
        Ticks that were sent but are not recorded because the arrays were full.
    command_success_rate : float
        Part of the last 100 commands that went out in time and were answered by all.
    ending : Ending
    sent_rad : array, shape (ticks, n)
        Goals that the servos were sent: they lead `commanded_rad` against gravity. The same as
        that where nothing else is given.
    temperature_c, voltage_v : array, shape (ticks, n)
        As the slow check read them last, degrees Celsius and V; NaN where it has not yet.
    description_sha256 : str
        Of the arm's description with its calibration, as the driver used it (`fingerprint`).
    driver_version : str
    target_m : 3-tuple of float or None
        Where a reach was to bring the hand, base frame, m; what follows it (a way back, a way to
        rest) is recorded, too. None for any other motion.
    """

    arm: str
    port: str
    simulated: bool
    joint_names: tuple[str, ...]
    rate_hz: float
    time_s: FloatArray
    commanded_rad: FloatArray
    measured_rad: FloatArray
    velocity_rad_s: FloatArray
    current_a: FloatArray
    stale: NDArray[np.bool_]
    hardware_error: NDArray[np.uint8]
    events: tuple[Event, ...]
    ticks: int
    missed_ticks: int
    dropped_rows: int
    command_success_rate: float
    ending: Ending
    sent_rad: FloatArray = field(default_factory=_not_given)
    temperature_c: FloatArray = field(default_factory=_not_given)
    voltage_v: FloatArray = field(default_factory=_not_given)
    description_sha256: str = ""
    driver_version: str = armsyn.__version__
    target_m: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        shape = self.commanded_rad.shape
        if self.sent_rad.shape != shape:
            object.__setattr__(self, "sent_rad", self.commanded_rad)
        for name in ("temperature_c", "voltage_v"):
            if getattr(self, name).shape != shape:
                object.__setattr__(self, name, np.full(shape, np.nan))
        for item in fields(self):
            value = getattr(self, item.name)
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    @classmethod
    def of_log(
        cls,
        log: StreamLog,
        arm: ArmDescription,
        *,
        port: str,
        simulated: bool,
        rate_hz: float,
        ticks: int,
        missed_ticks: int,
        command_success_rate: float,
        ending: Ending,
    ) -> Self:
        """Take over what a stream recorded; the log's arrays are copied."""
        kept = slice(0, log.rows)
        return cls(
            arm=arm.name,
            port=port,
            simulated=simulated,
            joint_names=arm.joint_names,
            rate_hz=rate_hz,
            time_s=log.time[kept].copy(),
            commanded_rad=log.commanded[kept].copy(),
            sent_rad=log.sent[kept].copy(),
            measured_rad=log.measured[kept].copy(),
            velocity_rad_s=log.velocity[kept].copy(),
            current_a=log.current[kept].copy(),
            temperature_c=log.temperature[kept].astype(np.float64),
            voltage_v=log.voltage[kept].astype(np.float64),
            stale=log.stale[kept].copy(),
            hardware_error=log.hardware_error[kept].copy(),
            events=tuple(log.events),
            ticks=ticks,
            missed_ticks=missed_ticks,
            dropped_rows=log.dropped,
            command_success_rate=command_success_rate,
            ending=ending,
            description_sha256=fingerprint(arm),
        )

    @property
    def source(self) -> str:
        """Where it comes from, for people."""
        kind = "simulated " if self.simulated else ""
        return f"recording of {kind}{self.arm} on {self.port}"

    def measured_motion(self, arm: ArmDescription) -> Motion:
        """Return the measured motion with landmarks by forward kinematics.

        Where a reply was lost, angles are interpolated between those that came.

        Parameters
        ----------
        arm : ArmDescription
            The arm that was recorded.

        Returns
        -------
        Motion

        Raises
        ------
        FormatError
            Another arm, or fewer than two ticks in which some joint answered.
        """
        if arm.joint_names != self.joint_names:
            raise FormatError(f"{self.source}: not a recording of {arm.name}")
        angles = np.empty_like(self.measured_rad)
        for column in range(angles.shape[1]):
            good = ~self.stale[:, column]
            if np.count_nonzero(good) < 2:
                name = self.joint_names[column]
                raise FormatError(f"{self.source}: joint {name} answered fewer than two ticks")
            known = self.measured_rad[good, column]
            angles[:, column] = np.interp(self.time_s, self.time_s[good], known)
        return Motion(
            time=self.time_s,
            joint_names=self.joint_names,
            angles=angles,
            landmark_names=tuple(arm.landmarks),
            landmarks=arm.chain.positions(angles)[:, list(arm.landmark_frames)],
            source=self.source,
        )

    def tracking_rms(self) -> float:
        """Root mean square of measured minus commanded angles, over ticks and joints, rad."""
        error = (self.measured_rad - self.commanded_rad)[~self.stale]
        error = error[np.isfinite(error)]
        return float(np.sqrt(np.mean(error**2))) if error.size else float("nan")
