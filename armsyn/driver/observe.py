"""Recording an arm without writing anything to it, at a fixed rate."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.driver.clock import Clock, MonotonicClock
from armsyn.driver.log import Event
from armsyn.driver.monitor import ArmMonitor
from armsyn.driver.recording import Ending, Recording, fingerprint
from armsyn.driver.signals import StopRequests
from armsyn.driver.spool import Spool
from armsyn.errors import InputError

OnLook = Callable[[float], None]
"""Called after each look with the time, s; must return quickly."""

SLOW_CHECKS = 0.25
"""Seconds in which every servo's temperature, voltage and errors are read once."""

_WINDOW = 100


class Observer:
    """Looks at an arm again and again.

    Parameters
    ----------
    monitor : ArmMonitor
    rate_hz : float
    folder : Path
        Where rows wait while it goes on.
    simulated : bool
        Only kept in the recording.
    clock : Clock, optional
    stops : StopRequests, optional
        Any request ends the recording; signals count meanwhile.

    Raises
    ------
    InputError
        A rate that is none.
    """

    def __init__(
        self,
        monitor: ArmMonitor,
        rate_hz: float,
        folder: Path,
        *,
        simulated: bool = False,
        clock: Clock | None = None,
        stops: StopRequests | None = None,
    ) -> None:
        if not (math.isfinite(rate_hz) and rate_hz > 0.0):
            raise InputError(f"a rate of {rate_hz:g} Hz is not a positive number")
        self.monitor = monitor
        self.rate_hz = rate_hz
        self.folder = folder
        self.simulated = simulated
        self.clock = clock or MonotonicClock()
        self.stops = stops or StopRequests()
        self._errors = np.zeros(len(monitor.arm.leaders), dtype=np.uint8)
        self._events: list[Event] = []
        self._missed = 0
        self._complete: list[bool] = []

    def record(self, seconds: float | None = None, on_look: OnLook | None = None) -> Recording:
        """Record until the time is over, or a stop is asked for.

        Parameters
        ----------
        seconds : float, optional
            Until a stop when it is not given.
        on_look : callable, optional

        Returns
        -------
        Recording
            Nothing is commanded in it; its ending is `Ending.OBSERVED`.

        Raises
        ------
        PortLostError
            The port went away.
        InputError
            Nothing can be written to the folder.
        """
        if seconds is not None and not (math.isfinite(seconds) and seconds > 0.0):
            raise InputError(f"{seconds:g} s is no time to record")
        arm = self.monitor.arm
        for identifier in self.monitor.missing:
            title = self.monitor.group.title(identifier)
            self._events.append(Event(0.0, f"{title} does not answer", "warning"))
        with Spool(self.folder, len(arm.leaders)) as spool, self.stops:
            self._look(spool, seconds, on_look)
            rows = spool.read()
            self._note_losses(spool)
            self.stops.met()
            return self._recording(rows, spool)

    def _look(self, spool: Spool, seconds: float | None, on_look: OnLook | None) -> None:
        period, start = 1.0 / self.rate_hz, self.clock.now()
        every = max(1, round(SLOW_CHECKS / period / max(1, self.monitor.polls)))
        due, ticks = start, 0
        while not self.stops.count:
            self.clock.sleep_until(due)
            now = self.clock.now()
            missed = int((now - due) / period)
            due += (missed + 1) * period
            self._missed += missed
            if seconds is not None and now - start >= seconds:
                return
            state = self.monitor.read_state()
            turn, rest = divmod(ticks, every)
            if rest == 0:
                self._poll(turn, now - start)
            spool.append(now - start, state, self._errors)
            self._complete = [*self._complete[1 - _WINDOW :], bool(state.fresh.all())]
            ticks += 1
            if on_look is not None:
                on_look(now - start)

    def _poll(self, turn: int, now: float) -> None:
        health = self.monitor.poll(turn)
        if health is None or health.hardware_error is None or health.row >= self._errors.size:
            return
        if health.hardware_error and not self._errors[health.row]:
            servo = self.monitor.group.servos[health.row]
            title = self.monitor.group.title(servo.id)
            self._events.append(Event(now, f"{title} reports a hardware error", "warning"))
        self._errors[health.row] = health.hardware_error

    def _note_losses(self, spool: Spool) -> None:
        if not spool.dropped:
            return
        why = "the disk is too slow" if spool.error is None else str(spool.error.strerror)
        self._events.append(Event(0.0, f"{spool.dropped} rows could not be kept: {why}", "warning"))

    def _recording(self, rows: NDArray[Any], spool: Spool) -> Recording:
        arm: ArmDescription = self.monitor.arm
        nothing = np.full(rows["position"].shape, np.nan)
        return Recording(
            arm=arm.name,
            port=self.monitor.bus.port_name,
            simulated=self.simulated,
            joint_names=arm.joint_names,
            rate_hz=self.rate_hz,
            time_s=rows["time"].copy(),
            commanded_rad=nothing,
            sent_rad=nothing.copy(),
            measured_rad=rows["position"].copy(),
            velocity_rad_s=rows["velocity"].copy(),
            current_a=rows["current"].copy(),
            temperature_c=rows["temperature"].astype(np.float64),
            voltage_v=rows["voltage"].astype(np.float64),
            stale=~rows["fresh"],
            hardware_error=rows["hardware_error"].copy(),
            events=tuple(sorted(self._events)),
            ticks=len(rows) + spool.dropped,
            missed_ticks=self._missed,
            dropped_rows=spool.dropped,
            command_success_rate=sum(self._complete) / max(1, len(self._complete)),
            ending=Ending.OBSERVED,
            description_sha256=fingerprint(arm),
        )
