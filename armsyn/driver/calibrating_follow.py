"""Following joints that a person moves: positions without gaps, across the end of a turn."""

from __future__ import annotations

from armsyn.arm.calibration import RADIANS_PER_TICK, radians_per_tick
from armsyn.arm.calibration_file import last_tick
from armsyn.driver.servos import ServoGroup
from armsyn.errors import ArmFaultError, BusTimeoutError

LONGEST_GAP = 0.5
"""Seconds between two looks within which no hand turns a joint by half a turn (6 rad/s)."""

LONGEST_SILENCE = 2.0
"""Seconds without a whole answer after which the servos count as lost."""

_ROUNDING = 1e-9


class Follower:
    """Positions of servos, counted on where the register starts anew.

    A servo that shows 4095 and then 0 has not turned back: a step of more than half a turn from
    one look to the next is the end of a turn. Many servos count on by themselves while they are
    limp and fold back only when torque comes on; then there is no such step.

    Parameters
    ----------
    group : ServoGroup

    Attributes
    ----------
    ticks : dict of int to int
        By servo; where it is, as counted from the first look.
    lowest, highest : dict of int to int
        Where it was since the last `forget_range`.

    Raises
    ------
    BusError, PortLostError
        As the bus.
    """

    def __init__(self, group: ServoGroup) -> None:
        self._group = group
        self._turns = {servo.id: turn_of(servo.model) for servo in group.servos}
        self._read = group.read("Present Position")
        self._when = group.bus.serial_port.now()
        self.ticks = dict(self._read)
        self.lowest, self.highest = dict(self.ticks), dict(self.ticks)

    def look(self) -> dict[int, int]:
        """Read all positions once more.

        A look that an answer is missing from is left out; who looks again soon loses nothing.

        Returns
        -------
        dict of int to int
            `ticks`.

        Raises
        ------
        ArmFaultError
            Nothing was read for longer than `LONGEST_GAP`, and a servo is far from where it was.
        BusTimeoutError
            Nothing is read for longer than `LONGEST_SILENCE`.
        """
        gap = self._group.bus.serial_port.now() - self._when
        try:
            read = self._group.read("Present Position")
        except BusTimeoutError:
            if gap > LONGEST_SILENCE:
                raise
            return self.ticks
        if gap > LONGEST_GAP:
            self._check_near(read, gap)
        self._when = self._group.bus.serial_port.now()
        for servo_id, tick in read.items():
            self.ticks[servo_id] += self._step(servo_id, tick)
            self.lowest[servo_id] = min(self.lowest[servo_id], self.ticks[servo_id])
            self.highest[servo_id] = max(self.highest[servo_id], self.ticks[servo_id])
        self._read = read
        return self.ticks

    def forget_range(self) -> None:
        """Begin a new range where the servos are."""
        self.lowest, self.highest = dict(self.ticks), dict(self.ticks)

    def _step(self, servo_id: int, tick: int) -> int:
        step, turn = tick - self._read[servo_id], self._turns[servo_id]
        if turn is not None and abs(step) > turn // 2:
            step -= turn if step > 0 else -turn
        return step

    def _check_near(self, read: dict[int, int], gap: float) -> None:
        """After a gap, a servo that is far from where it was may have gone either way."""
        for servo_id, tick in read.items():
            turn, step = self._turns[servo_id], self._step(servo_id, tick)
            if turn is not None and abs(step) > turn // 4:
                raise ArmFaultError(
                    f"{self._group.title(servo_id)} was not read for {gap:.1f} s and has been"
                    " turned far meanwhile, nobody knows which way: calibrate again, with nothing"
                    " else on the bus"
                )


def turn_of(model: str) -> int | None:
    """Ticks of a whole turn; None for a servo that cannot turn round."""
    whole = abs(radians_per_tick(model) - RADIANS_PER_TICK) < _ROUNDING
    return last_tick(model) + 1 if whole else None
