"""Restarting servos that a hardware error has stopped: each once, and looked at afterwards.

A reboot ends a latched error, and with it the torque: the joint falls. RAM is as at power-on then
(torque, watchdog, profiles, goals), and turns beyond the first are forgotten (e-Manual, "Present
Position(132)"). An error whose cause is still there comes back at once; rebooting again and again
would only heat the motor, so a second reboot within `SHORTEST_INTERVAL` is refused; one that
another program may have made is seen by the servo's own clock, and waited out.
"""

from __future__ import annotations

from dataclasses import dataclass

from armsyn.driver import registers as reg
from armsyn.driver.clock import Clock, MonotonicClock
from armsyn.driver.presence import hardware_error
from armsyn.driver.servos import ServoGroup
from armsyn.errors import BusTimeoutError, HardwareFaultError

SHORTEST_INTERVAL = 10.0
"""Seconds between two reboots of one servo: an overloaded motor has cooled a little; chosen."""

LONGEST_BOOT = 3.0
"""Seconds that a servo may take to answer again."""

WATCHED = 1.0
"""Seconds for which an error that comes back is looked for."""

_LOOK = 0.05
_TURN = reg.LAST_TICK + 1


@dataclass(frozen=True)
class Rebooted:
    """A servo that was restarted.

    Attributes
    ----------
    servo_id : int
    before, after : int
        Hardware errors, X series' bits; `after` is not 0 when an error came back.
    turns : int
        Whole turns by which its position reads differently now.
    boot_time : float
        Until it answered again, s.
    """

    servo_id: int
    before: int
    after: int
    turns: int
    boot_time: float


class Rebooter:
    """Restarts servos of a group, none of them twice in a row.

    Parameters
    ----------
    group : ServoGroup
    clock : Clock, optional
    """

    def __init__(self, group: ServoGroup, clock: Clock | None = None) -> None:
        self.group = group
        self.clock = clock or MonotonicClock()
        self._last: dict[int, float] = {}

    def reboot(self, servo_id: int) -> Rebooted:
        """Restart a servo, wait for it, and look whether its error comes back.

        Parameters
        ----------
        servo_id : int
            Its joint falls, if it is not limp already.

        Returns
        -------
        Rebooted

        Raises
        ------
        HardwareFaultError
            It was restarted a moment ago, does not answer again, or has not started anew.
        BusError
            Protocol 1.0 has no reboot: its supply must be switched.
        PortLostError
            The port went away.
        """
        title, started = self.group.title(servo_id), self.clock.now()
        since = started - self._last.get(servo_id, -SHORTEST_INTERVAL)
        if since < SHORTEST_INTERVAL:
            raise HardwareFaultError(
                f"{title} was rebooted {since:.0f} s ago: see to the cause first, and let it cool",
                servo_id,
            )
        if pause := self.pause(servo_id):
            self.clock.sleep_until(started + pause)
            started = self.clock.now()
        before, position = self._error(servo_id), self._position(servo_id)
        self._last[servo_id] = started
        self.group.bus.reboot(servo_id)
        self._wait_for(servo_id, started)
        boot_time = self.clock.now() - started
        if self.group.read("Torque Enable", (servo_id,))[servo_id]:
            raise HardwareFaultError(
                f"{title} did not start anew, its torque is still on: switch its supply off and on",
                servo_id,
            )
        after = self._watch(servo_id)
        turns = round((self._position(servo_id) - position) / _TURN)
        return Rebooted(servo_id, before, after, turns, boot_time)

    def pause(self, servo_id: int) -> float:
        """Seconds for which `reboot` leaves a servo alone first, as it may just have started.

        Its Realtime Tick says so, which begins anew every 33 s without a start, too (e-Manual,
        "Realtime Tick(120)"): nobody can tell, so that it is waited for and not refused.
        """
        if "Realtime Tick" not in self.group.models[servo_id].layout:
            return 0.0
        running = self.group.read("Realtime Tick", (servo_id,))[servo_id] * reg.TICK_UNIT
        return max(0.0, SHORTEST_INTERVAL - running)

    def _wait_for(self, servo_id: int, started: float) -> None:
        while self.clock.now() - started < LONGEST_BOOT:
            self.clock.sleep_until(self.clock.now() + _LOOK)
            try:
                self.group.bus.ping(servo_id, attempts=1)
            except BusTimeoutError:
                continue
            return
        raise HardwareFaultError(
            f"{self.group.title(servo_id)} has not answered {LONGEST_BOOT:g} s after its reboot:"
            " check its cable, switch its supply off and on",
            servo_id,
        )

    def _watch(self, servo_id: int) -> int:
        """Errors that it reports within `WATCHED` seconds."""
        end = self.clock.now() + WATCHED
        while self.clock.now() < end:
            if error := self._error(servo_id):
                return error
            self.clock.sleep_until(self.clock.now() + _LOOK)
        return 0

    def _error(self, servo_id: int) -> int:
        return hardware_error(self.group, servo_id)

    def _position(self, servo_id: int) -> int:
        return self.group.read("Present Position", (servo_id,))[servo_id]
