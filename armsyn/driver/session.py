"""A session with an arm: open and check, run trajectories, and leave the arm in a known state.

How a run leaves the arm:

=====================  ================================  =================================  ========
ending                 torque                            motion                             watchdog
=====================  ================================  =================================  ========
error before motion    as it was found                   none                               as found
completed              on, holding                       at the target, or as near as the   0
                                                         arm came: an event says how near
completed with `park`  off; on, holding, when a joint    parked                             0
                       is over 0.05 rad off rest
first request to stop  on, holding                       decelerated; then to rest if the   0
                                                         way is free and takes 3 s at most
second request, fault  on, holding (what a fault left)   goals stand still at once          armed
host dead              the servos' own                   stopped by their watchdog          expired
=====================  ================================  =================================  ========

A fault after `park` has switched the torque off leaves it off, and its message says so.

The same holds for both servos of a dual joint. Servos without a watchdog (Protocol 1.0, XL-320, X
series before firmware 38) need `accept_no_watchdog`: where the table says armed or expired, they go
on to the last goal they heard and hold it until somebody lets them go. The gripper is no part of a
run: it keeps its goal and its torque, and has no watchdog armed, but its errors end a run.

Profiles are set as `armsyn.driver.profiles` says during a run, put back where the watchdog is 0 at
its end, and left otherwise. What is put back or switched off is read back; where that fails, the
error names the servos. A fault's message says what it left and how to clear it: if only the
profiles could not be put back, the watchdog is off already. A fault is latched: the session runs
nothing more, no port is opened again by itself, and the next session finds what was left. Servos
that have restarted meanwhile have lost what was written to their RAM: all of it, watchdog, profile
and goal, is written and read back before their torque comes on again.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Self

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.driver.checks import check_facts, check_watchdogs, unwatched
from armsyn.driver.clock import Clock, MonotonicClock
from armsyn.driver.collector import collector_frozen
from armsyn.driver.facts import check_models, read_facts
from armsyn.driver.joints import JointGroup
from armsyn.driver.models import check_known
from armsyn.driver.realtime import realtime
from armsyn.driver.recording import Recording
from armsyn.driver.run import ArmRun
from armsyn.driver.servos import ServoGroup
from armsyn.driver.setpoint import SetpointMotion, check_longest
from armsyn.driver.setpoint_thread import Setpoint, SetpointThread
from armsyn.driver.signals import StopRequests
from armsyn.driver.stream import OnTick, Streamer
from armsyn.driver.timing import check_rate
from armsyn.driver.transactions import Bus
from armsyn.errors import ArmFaultError, BusTimeoutError, StopRequestedError
from armsyn.motion import Motion
from armsyn.safety import check_trajectory
from armsyn.safety.collision import MARGIN

FloatArray = NDArray[np.float64]

STREAM_MARGIN = 1.0
"""Periods that a reply may be late while streaming: the next tick then starts a little late, which
is better than a lost state."""

SHORTEST_STREAM_MARGIN = 2e-3
"""Seconds that a reply may be late while streaming, at least."""


class ArmSession:
    """An arm on a port, checked and ready to run; made by `open`.

    Attributes
    ----------
    recording : Recording or None
        Of the last run, also when it raised; None when nothing was streamed.
    fault : Exception or None
        What the last run left an arm with that is not as it should be; the session runs nothing
        more then.
    gravity : bool
        Whether goals lead the wanted posture against gravity (`armsyn.driver.gravity`); True
        unless it is changed.
    realtime : bool
        Whether to ask for real-time scheduling while the arm moves (`armsyn.driver.realtime`);
        False unless it is changed. Where it is not permitted, an event says so.
    unwatched : tuple of int
        IDs of the servos that no bus watchdog stops.
    stops : StopRequests
        ``session.stops.request()`` asks a run to stop, as SIGINT does; before a run, it keeps
        the torque off.
    """

    def __init__(
        self,
        bus: Bus,
        arm: ArmDescription,
        rate_hz: float,
        *,
        simulated: bool,
        clock: Clock,
        firmware: dict[int, int],
    ) -> None:
        self.bus = bus
        self.arm = arm
        self.rate_hz = rate_hz
        self.simulated = simulated
        self.clock = clock
        self.recording: Recording | None = None
        self.fault: BaseException | None = None
        self.unwatched: tuple[int, ...] = ()
        self._busy = threading.Lock()
        self.stops = StopRequests()
        self.gravity = True
        self.realtime = False
        margin = max(SHORTEST_STREAM_MARGIN, STREAM_MARGIN / rate_hz)
        self._joints = JointGroup(bus, arm, margin, firmware)

    @classmethod
    def open(
        cls,
        port: str,
        arm: ArmDescription,
        rate_hz: float,
        *,
        simulated: bool = False,
        accept_no_watchdog: bool = False,
    ) -> Self:
        """Open the port and check that the arm there is the one described, fit to move.

        Nothing is written to the servos. Checked are: every servo's ID and model; operating
        mode, direction, homing offset; hardware errors and watchdogs; and whether wire, adapter
        and watchdog allow the rate.

        Parameters
        ----------
        port : str
            Path of the serial port.
        arm : ArmDescription
        rate_hz : float
            Commands a second.
        simulated : bool
            Only kept in recordings; nothing else depends on it.
        accept_no_watchdog : bool
            Move servos that have no bus watchdog, too: if this host dies, they go on to their last
            goal and hold it (`unwatched` names them).

        Returns
        -------
        ArmSession
            A context manager; leaving it closes the port.

        Raises
        ------
        DescriptionError
            An arm without servos, or with models the driver does not know.
        PortError
            The port cannot be opened.
        ServoMissingError, ServoMismatchError
            Not the arm that is described, or not set up to be streamed to.
        HardwareFaultError
            A latched hardware error or an expired bus watchdog.
        NoWatchdogError
            Servos without a bus watchdog, and nobody has accepted that.
        BusRateError
            The wire or the adapter cannot carry the rate, or it is too slow for the watchdog.
        BusError
            Lost replies.
        """
        check_known(arm)
        bus = Bus(port, arm.servo[0].baud)
        try:
            return cls.attach(
                bus, arm, rate_hz, simulated=simulated, accept_no_watchdog=accept_no_watchdog
            )
        except BaseException:
            bus.close()
            raise

    @classmethod
    def attach(
        cls,
        bus: Bus,
        arm: ArmDescription,
        rate_hz: float,
        *,
        simulated: bool = False,
        accept_no_watchdog: bool = False,
        clock: Clock | None = None,
    ) -> Self:
        """Check the arm on a bus that is open already; as `open`, which see.

        Parameters
        ----------
        bus : Bus
            The session closes it.
        arm, rate_hz, simulated, accept_no_watchdog
            As `open`.
        clock : Clock, optional
            That the stream runs on; the system's monotonic clock by default.
        """
        check_known(arm)
        group = ServoGroup(bus, arm.servo)
        check_models(group, arm.name)
        facts = read_facts(group)
        check_facts(facts, arm)
        moving = [servo for servo in facts if servo.joint in arm.joint_names]
        check_watchdogs(moving, accepted=accept_no_watchdog)
        session = cls(
            bus,
            arm,
            rate_hz,
            simulated=simulated,
            clock=clock or MonotonicClock(),
            firmware=group.firmware,
        )
        session.unwatched = tuple(servo.servo_id for servo in unwatched(moving))
        session.check_rate([servo.return_delay for servo in facts])
        return session

    def check_rate(self, return_delays: Sequence[float]) -> None:
        """Refuse a rate that wire or adapter cannot carry; BusRateError."""
        cycle, latency = self._joints.cycle(), self.bus.latency
        check_rate(self.rate_hz, self.bus.baudrate, return_delays, latency, cycle)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the port; the arm stays as it is. A second call does nothing."""
        self.bus.close()

    def read_posture(self) -> FloatArray:
        """Present angles of the joints, shape (n,), rad.

        Raises
        ------
        BusError, PortLostError
            As the bus.
        """
        return self._joints.read_posture()

    def run(
        self,
        trajectory: Motion,
        park: Motion | None = None,
        on_tick: OnTick | None = None,
        *,
        margin: float = MARGIN,
    ) -> Recording:
        """Check a trajectory, stream it, and leave the arm as the table above says.

        SIGINT and SIGTERM are requests to stop while this runs (in the main thread). A request
        from before, or during the checks, is heeded before torque; one that comes too late to
        stop this run stops the next.

        Parameters
        ----------
        trajectory : Motion
            From where the arm is; angles in rad.
        park : Motion, optional
            Streamed afterwards, from the trajectory's end to the arm's rest posture. Then the
            torque goes off, unless a joint is more than 0.05 rad off rest (`Ending.PARK_MISSED`).
        on_tick : callable, optional
            Called after each tick with path time and duration, s; must return quickly.
        margin : float
            m that the trajectory keeps between what must not touch; every tick keeps 2 mm anyway.

        Returns
        -------
        Recording
            Its `ending` says how the run ended.

        Raises
        ------
        RefusedMotionError, InputError
            A trajectory that must not be run; nothing has changed on the arm.
        StopRequestedError
            A stop was asked for before torque, or servos fell silent after it; nothing has changed
            on the arm.
        ArmFaultError
            A fault before motion (all but indirect addresses, `armsyn.driver.gathering`, is put
            back as it was found, or the message says what is not) or during it (the arm holds, the
            watchdog stays armed, and the session runs nothing more).
        """

        def checked(posture: FloatArray) -> Motion:
            check_trajectory(trajectory, self.arm, posture, margin=margin)
            if park is not None and trajectory.angles is not None:
                check_trajectory(park, self.arm, trajectory.angles[-1])
            return trajectory

        return self._run(checked, park, on_tick)

    def run_setpoint(
        self,
        setpoint: Setpoint,
        longest: float,
        on_tick: OnTick | None = None,
        *,
        recorded: float | None = None,
    ) -> Recording:
        """Stream what a function says, and leave the arm as the table above says.

        Each setpoint is judged before it is sent. An exception of the function is a fault: the arm
        is held, and it is raised here. A function that does not answer within
        `armsyn.driver.setpoint_thread.PATIENCE` is a fault, too.

        Parameters
        ----------
        setpoint : callable
            ``setpoint(t, state) -> posture or None``, called in a thread of its own; see
            `armsyn.driver.setpoint_thread.Setpoint`.
        longest : float
            Seconds after which the arm comes to rest, unless the function is finished earlier.
        on_tick : callable, optional
            As `run`.
        recorded : float, optional
            Seconds for whose record there is to be memory; `longest` where it is not given.

        Returns
        -------
        Recording

        Raises
        ------
        RefusedMotionError, InputError
            Setpoints that do not start where the arm is; nothing has changed on the arm.
        SetpointError
            A function that stalls, or gives no posture.
        Exception
            As `run`, and what the function raises.
        """
        recorded = longest if recorded is None else recorded
        check_longest(longest)
        check_longest(recorded)
        with SetpointThread(setpoint, self.clock) as thread:
            motion = SetpointMotion(thread, longest, recorded)

            def checked(posture: FloatArray) -> SetpointMotion:
                return motion.check(posture, self.arm)

            return self._run(checked, None, on_tick)

    def _run(
        self,
        checked: Callable[[FloatArray], Motion | SetpointMotion],
        park: Motion | None,
        on_tick: OnTick | None,
    ) -> Recording:
        if not self._busy.acquire(blocking=False):
            raise ArmFaultError("another thread moves the arm in this session: wait for its end")
        try:
            return self._run_alone(checked, park, on_tick)
        finally:
            self._busy.release()

    def _run_alone(
        self,
        checked: Callable[[FloatArray], Motion | SetpointMotion],
        park: Motion | None,
        on_tick: OnTick | None,
    ) -> Recording:
        if self.fault is not None:
            raise ArmFaultError(f"this session has ended with a fault: {self.fault}")
        self.recording = None
        with self.stops, collector_frozen(), realtime(wanted=self.realtime) as refusal:
            run = ArmRun(
                self._joints,
                self.arm,
                self.rate_hz,
                stops=self.stops,
                trajectory=checked(self.read_posture()),
                park=park,
                clock=self.clock,
                on_tick=on_tick,
                gravity=self.gravity,
                remarks=(refusal,) if refusal else (),
            )
            try:
                run.execute()
            except BusTimeoutError as error:
                if run.powering or not self.stops.count:
                    raise
                self.stops.met()
                raise StopRequestedError(
                    f"asked to stop before the motion began: nothing has moved ({error})"
                ) from error
            finally:
                self.fault = run.fault
                if run.streamer is not None:
                    self.recording = self._record(run, run.streamer)
        assert self.recording is not None  # noqa: S101 - a run that ends well has streamed
        return self.recording

    def _record(self, run: ArmRun, streamer: Streamer) -> Recording:
        return Recording.of_log(
            streamer.log,
            self.arm,
            port=self.bus.port_name,
            simulated=self.simulated,
            rate_hz=self.rate_hz,
            ticks=streamer.ticks,
            missed_ticks=streamer.missed_ticks,
            command_success_rate=streamer.watch.success_rate,
            ending=run.ending,
        )
