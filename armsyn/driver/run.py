"""One run of an arm: torque on, the motion, and the ending it deserves."""

from __future__ import annotations

import contextlib

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.driver import power
from armsyn.driver.checks import check_facts, unwatched
from armsyn.driver.clock import Clock
from armsyn.driver.facts import ServoFacts, read_facts
from armsyn.driver.gravity import GoalLead, LeadSettings
from armsyn.driver.gravity_facts import make_lead, read_lead_settings
from armsyn.driver.joints import JointGroup
from armsyn.driver.limits import check_position_limits, check_streamed, with_servo_limits
from armsyn.driver.log import MOST_ROWS, StreamLog
from armsyn.driver.path import Path, straight_way
from armsyn.driver.profiles import streaming_profiles
from armsyn.driver.recording import Ending
from armsyn.driver.setpoint import SetpointMotion
from armsyn.driver.signals import StopRequests
from armsyn.driver.stream import LONGEST_CORRECTION, OnTick, Outcome, Streamer
from armsyn.driver.timing import WATCHDOG_SECONDS
from armsyn.driver.watch import WatchSettings
from armsyn.errors import (
    ArmFaultError,
    ArmsynError,
    FollowingError,
    RefusedMotionError,
    StopRequestedError,
)
from armsyn.motion import Motion
from armsyn.safety import CommandLimits, check_start, check_trajectory

FloatArray = NDArray[np.float64]

LONGEST_PARKING = 3.0
"""Seconds the way to rest may take after a request to stop."""

PARK_TOLERANCE = 0.05
"""rad that each joint may be off the rest posture for the torque to go off there."""

CURE = (
    "look at the arm, then armsyn clear lets it move again; armsyn release lets go of it (support"
    " it first)"
)
HELD = "left with torque on (but where a servo lost it), holding, watchdog armed"
HELD_UNWATCHED = "left with torque as the fault left it, holding, watchdog off"
"""What a fault leaves, for its message."""

RELEASED = "left without torque, released at rest"
HALF_RELEASED = "left with only servo {} under torque, holding; the others were released at rest"
UNKNOWN_RELEASE = "being released at rest, and whether the servos have torque cannot be read"
"""The same, from when the torque goes off after parking."""

_SPARE = 1.5
"""How much longer than planned a run may become and still be recorded whole."""


class ArmRun:
    """One run: `execute` it once.

    Parameters
    ----------
    joints : JointGroup
    arm : ArmDescription
    rate_hz : float
    stops : StopRequests
    trajectory : Motion or SetpointMotion
        Checked.
    clock : Clock
        That the stream runs on.
    park : Motion or None
        Checked; streamed after the trajectory. Then the torque goes off, if the arm is at rest.
    on_tick : callable or None
    gravity : bool
        Whether goals lead the wanted posture against gravity (`armsyn.driver.gravity`).
    remarks : tuple of str
        Warnings that the recording keeps.

    Attributes
    ----------
    ending : Ending
        How it left the arm.
    fault : Exception or None
        What keeps the arm from moving again.
    powering : bool
        Whether anything was written to the servos.
    streamer : Streamer or None
        What was streamed; None when nothing was.
    """

    def __init__(
        self,
        joints: JointGroup,
        arm: ArmDescription,
        rate_hz: float,
        *,
        stops: StopRequests,
        trajectory: Motion | SetpointMotion,
        clock: Clock,
        park: Motion | None = None,
        on_tick: OnTick | None = None,
        gravity: bool = True,
        remarks: tuple[str, ...] = (),
    ) -> None:
        self.joints = joints
        moving = (servo for servo in joints.group.servos if servo.joint in arm.joint_names)
        self.group = joints.group.only(moving)
        self.arm = arm
        self.rate_hz = rate_hz
        self.stops = stops
        self.trajectory = trajectory
        self.clock = clock
        self.park = park
        self.on_tick = on_tick
        self.gravity = gravity
        self.remarks = remarks
        self.ending = Ending.FAULT
        self.fault: BaseException | None = None
        self.powering = False
        self.streamer: Streamer | None = None
        self._facts: tuple[ServoFacts, ...] = ()
        self._limp: frozenset[int] = frozenset()
        self._profiles: dict[str, dict[int, int]] = {}
        self._armed = False
        self._releasing = False
        self._strangers = joints.bus.foreign_traffic

    def execute(self) -> None:
        """Run it.

        Raises
        ------
        LimitError
            The trajectory leaves the servos' own position limits, would be refused at one of its
            ticks, or starts where the arm no longer is; nothing has changed, or all is put back.
        StopRequestedError
            A stop was asked for before torque; nothing has changed.
        ArmFaultError
            A fault. Before motion all is put back as it was found, but for indirect addresses
            (`armsyn.driver.gathering`); during it the goals stand still and the watchdog stays
            armed. The message says so, and what could not be put back; `fault` is then set.
        """
        everything = read_facts(self.joints.group)
        check_facts(everything, self.arm)
        self._facts = tuple(servo for servo in everything if servo.servo_id in self.group.ids)
        self._profiles = streaming_profiles(self.arm, self._facts, self.group)
        self._limp = frozenset(s.servo_id for s in everything if not s.torque_enabled)
        for motion in (self.trajectory, self.park):
            if isinstance(motion, Motion):
                check_position_limits(motion, self._facts, self.arm)
        log, lead = self._make_log(), self._read_lead_settings()
        self._check_ticks(lead)
        self._heed_stop()
        self.streamer = streamer = self._power_up(log, lead)
        try:
            streamer.begin()
            self.ending = self._move(streamer)
            self._note_strangers(streamer)
            self._finish(streamer)
        except BaseException as error:
            self.ending, self.fault = Ending.FAULT, error
            self._note_strangers(streamer)
            self._hold(streamer, error)
            _say_also(error, self._left())
            raise

    def _check_ticks(self, settings: LeadSettings) -> None:
        """Refuse a motion that would be a fault on its way, before it begins; LimitError."""
        start = self._lead_from(self._facts, settings).wanted
        limits = CommandLimits.of(self.arm, 1.0 / self.rate_hz, start)
        limits = with_servo_limits(limits, self._facts, self.arm, start)
        for motion in (self.trajectory, self.park):
            if isinstance(motion, Motion):
                start = check_streamed(motion, start, limits, self._heed_stop)

    def _left(self) -> str:
        """What a fault leaves, for its message."""
        if self._releasing:
            armed = "watchdog armed" if self._armed else "watchdog off"
            return f"{self._released()}, {armed}: {CURE}"
        if not self._armed:
            return HELD_UNWATCHED
        lacking = ", ".join(str(servo.servo_id) for servo in unwatched(self._facts))
        without = f" (servo {lacking} has none: it holds until it is released)" if lacking else ""
        return f"{HELD}{without}: {CURE}"

    def _released(self) -> str:
        """Who has torque now that it was to go off."""
        try:
            torque = self.group.read("Torque Enable")
        except ArmFaultError:
            return UNKNOWN_RELEASE
        holding = ", ".join(str(servo_id) for servo_id, on in torque.items() if on)
        return HALF_RELEASED.format(holding) if holding else RELEASED

    def _heed_stop(self) -> None:
        """Give no torque to an arm that was asked to stop."""
        if self.stops.count:
            self.stops.met()
            raise StopRequestedError(
                "asked to stop before the motion began: nothing has moved; run it again to move"
            )

    def _power_up(self, log: StreamLog, lead: LeadSettings) -> Streamer:
        self.powering = True
        try:
            facts = power.prepare(self.group, self._facts, self._profiles, self._gather_health)
            streamer = self._make_streamer(facts, log, lead)
            power.power_up(self.group, facts)
        except BaseException as error:
            if failed := power.restore(self.group, self._facts):
                self.fault = error
                _say_also(error, self._not_restored(failed))
            raise
        self._armed = True
        return streamer

    def _gather_health(self) -> None:
        self.joints.gather_health(self.group, self._limp)

    def _not_restored(self, failed: dict[int, str]) -> str:
        titles = {servo.servo_id: servo.title for servo in self._facts}
        named = ", ".join(f"{titles[i]} ({why})" for i, why in failed.items())
        count = f"{len(failed)} of {len(self._facts)}"
        return f"and {count} servos could not be restored: {named}; {CURE}"

    @property
    def _leaders(self) -> tuple[ServoFacts, ...]:
        """Facts of the servos that the joints are commanded by, base to tip."""
        return self._facts[: len(self.arm.leaders)]

    def _make_log(self) -> StreamLog:
        motion = self.trajectory
        planned = motion.recorded if isinstance(motion, SetpointMotion) else motion.duration
        planned += self.park.duration if self.park else 0.0
        longest = _SPARE * (planned + LONGEST_PARKING + 3 * LONGEST_CORRECTION)
        return StreamLog(min(int(longest * self.rate_hz) + 1, MOST_ROWS), len(self._leaders))

    def _read_lead_settings(self) -> LeadSettings:
        period, servos = 1.0 / self.rate_hz, self._leaders
        return read_lead_settings(self.group, self.arm, servos, period, gravity=self.gravity)

    def _lead_from(self, facts: tuple[ServoFacts, ...], settings: LeadSettings) -> GoalLead:
        """Let goals lead from where the servos are; LimitError when the motion starts elsewhere.

        The arm may have moved since the motion was checked, and the way back to its start would
        be gone within `armsyn.driver.path.BLEND`, however far it is.
        """
        servos, standing = facts[: len(self.arm.leaders)], power.standing_goals(facts)
        ticks = [servo.present_position for servo in servos]
        motion = self.trajectory
        first = motion.first if isinstance(motion, SetpointMotion) else motion.angles
        assert first is not None  # noqa: S101 - the session has checked the motion
        check_start(np.atleast_2d(first)[0], self.arm.calibration.to_radians(ticks), self.arm)
        return make_lead(settings, servos, [standing[servo.servo_id] for servo in servos])

    def _make_streamer(
        self, facts: tuple[ServoFacts, ...], log: StreamLog, settings: LeadSettings
    ) -> Streamer:
        """Make a streamer that begins where the arm is right before torque."""
        period, servos = 1.0 / self.rate_hz, facts[: len(self.arm.leaders)]
        lead = self._lead_from(facts, settings)
        self.joints.start_at([servo.present_position for servo in servos])
        commanded = lead.wanted
        limits = CommandLimits.of(self.arm, period, commanded)
        for remark in filter(None, (*self.remarks, settings.expected_droop())):
            log.note(0.0, remark, "warning")
        return Streamer(
            link=self.joints,
            settings=WatchSettings(
                period=period,
                limits=with_servo_limits(limits, self._facts, self.arm, commanded),
                servos=self.joints.group.servos,
                limp=self._limp - set(self.group.ids),
                limited=frozenset(self._profiles["Moving Speed"]),
                polls=self.joints.polls,
            ),
            max_acceleration=self.arm.max_acceleration,
            longest_stall=WATCHDOG_SECONDS,
            commanded=commanded,
            log=log,
            stops=self.stops,
            clock=self.clock,
            on_tick=self.on_tick,
            lead=lead,
        )

    def _move(self, streamer: Streamer) -> Ending:
        start = streamer.commanded
        if isinstance(self.trajectory, SetpointMotion):
            outcome = streamer.run(
                self.trajectory.course(start, self.arm, streamer.settings.limits)
            )
        else:
            outcome = streamer.follow(Path(self.trajectory, start=start))
        ending = Ending.COMPLETED
        if outcome is Outcome.ARRIVED and self.park is not None:
            outcome = streamer.follow(Path(self.park, start=streamer.commanded))
            ending = Ending.PARKED
        if outcome is Outcome.STOPPED:
            way = self._way_to_rest(streamer.commanded) if self.stops.park else None
            if way is None:
                return Ending.STOPPED_HOLDING
            streamer.note("moving to the rest posture")
            outcome = streamer.follow(Path(way), may_stop=False)
            ending = Ending.STOPPED_PARKED
        return Ending.ABORTED if outcome is Outcome.ABORTED else ending

    def _way_to_rest(self, start: FloatArray) -> Motion | None:
        """Way from the last goals to rest; None when it is too long or must not be gone."""
        try:
            way = straight_way(start, self.arm.rest, self.arm, self.rate_hz)
            if way.duration > LONGEST_PARKING:
                return None
            check_trajectory(way, self.arm, start)
            check_position_limits(way, self._facts, self.arm)
        except RefusedMotionError:
            return None
        return way

    def _finish(self, streamer: Streamer) -> None:
        if self.ending in (Ending.PARKED, Ending.STOPPED_PARKED):
            self._check_parked(streamer)
        streamer.note(self.ending.value)
        if self.ending is Ending.ABORTED:
            self.fault = ArmFaultError(self.ending.value)
            self._hold(streamer, self.fault)
            return
        if self.ending is Ending.PARKED:
            self._releasing = True
            power.torque_off(self.group)
        else:
            power.check_holding(self.group)
        power.disarm_watchdog(self.group)
        self._armed = False
        power.restore_profiles(self.group, self._facts)
        if self.ending in (Ending.STOPPED_HOLDING, Ending.STOPPED_PARKED):
            self.stops.met()

    def _note_strangers(self, streamer: Streamer) -> None:
        """Say once that somebody else speaks on the bus."""
        packets = self.joints.bus.foreign_traffic - self._strangers
        self._strangers += packets
        if packets:
            streamer.note(
                f"{packets} packets of another master were heard on {self.joints.bus.port_name}:"
                " end the program or unplug the controller that sends them",
                "warning",
            )

    def _check_parked(self, streamer: Streamer) -> None:
        """Let an arm that is away from rest keep its torque: it would fall."""
        off = np.abs(self.joints.read_posture() - self.arm.rest)
        joint = int(np.argmax(off))
        if off[joint] <= PARK_TOLERANCE:
            return
        streamer.note(
            f"stands {off[joint]:.3f} rad off its rest posture at {self.arm.joint_names[joint]}",
            "warning",
        )
        parking = self.ending is Ending.PARKED
        self.ending = Ending.PARK_MISSED if parking else Ending.STOPPED_HOLDING

    def _hold(self, streamer: Streamer, error: BaseException) -> None:
        """Let the goals stand still; the joint that something holds gives way to it.

        The present posture is no goal for the others: it lies behind a moving joint, which
        would overshoot and come back.
        """
        goals = streamer.sent.copy()
        if isinstance(error, FollowingError):
            joint = self.arm.joint_names.index(error.joint)
            limits = streamer.settings.limits
            there = streamer.measured[joint]
            goals[joint] = np.clip(there, limits.lower[joint], limits.upper[joint])
        if self._releasing:  # who is limp is not to be told where to go
            streamer.note(str(error), "fault")
            return
        streamer.note(f"held: {error}", "fault")
        with contextlib.suppress(ArmFaultError):  # a port that is gone cannot be told
            self.joints.send(goals)


def _say_also(error: BaseException, text: str) -> None:
    """Add to an error's line; to one that is not ours, as a note."""
    if isinstance(error, ArmsynError):
        error.add(text)
    else:
        error.add_note(text)
