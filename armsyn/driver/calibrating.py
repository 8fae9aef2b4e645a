"""Finding zero, direction and range of an arm's joints while a person moves the limp arm.

Nothing here moves a joint, switches a torque, or writes to a servo; only `align`, which is asked
for by itself, sets the homing offset of a dual joint's second servo.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterable
from datetime import UTC, datetime
from typing import Literal

from armsyn.arm import ArmDescription, ServoDescription
from armsyn.arm.calibration import radians_per_tick
from armsyn.arm.calibration_file import ArmCalibration, ServoCalibration
from armsyn.driver import registers as reg
from armsyn.driver.calibrating_follow import Follower, turn_of
from armsyn.driver.checks import LARGEST_HOMING_OFFSET, PAIR_TOLERANCE_TICKS
from armsyn.driver.facts import ServoFacts, check_models, read_facts
from armsyn.driver.servos import ServoGroup, title_of
from armsyn.driver.transactions import Bus
from armsyn.errors import ServoMismatchError, TorqueOnError

LEAST_MOVE = 0.17
"""rad that a joint must be moved by to show its direction, or for its range to count."""

REST_AGAIN = 0.09
"""rad by which the rest posture may differ when the arm is put there a second time."""

_LOOKS = 12
_BETWEEN_LOOKS = 0.02
_STILL_TICKS = 12
"""What a posture is that is held still: that many ticks at most within 0.24 s."""

_PAIR_MOVING_TICKS = 2 * PAIR_TOLERANCE_TICKS
"""How far a dual joint's servos may read apart while it is moved: they are read one by one."""


class ArmCalibrator:
    """An arm that lies limp on a bus, to be moved by hand.

    Parameters
    ----------
    bus : Bus
    arm : ArmDescription
        Without an older calibration.

    Attributes
    ----------
    facts : tuple of ServoFacts
        As found, in the order of the description's servos.
    follower : Follower
        Where the servos are.

    Raises
    ------
    ServoMissingError, ServoMismatchError
        Not the arm that is described, or not set up.
    TorqueOnError
        A servo holds.
    BusError, PortLostError
        As the bus; from all methods.
    """

    def __init__(self, bus: Bus, arm: ArmDescription) -> None:
        self.bus = bus
        self.arm = arm
        self.group = ServoGroup(bus, arm.servo)
        check_models(self.group, arm.name)
        self.facts = read_facts(self.group)
        for facts in self.facts:
            check_fit(facts, arm, bus.port_name)
        self.follower = Follower(self.group)
        self._rest: dict[int, int] = {}
        self._rest_angle = rest_angles(arm)
        self._directions: dict[int, int] = {servo.id: servo.direction for servo in arm.servo}
        self._ranges: dict[int, tuple[int, int]] = {}

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of what is moved, base to tip, the gripper last."""
        return tuple(self._rest_angle)

    def servos_of(self, joint: str) -> tuple[ServoDescription, ...]:
        """The servos of a joint, its leader first."""
        own = [servo for servo in self.arm.servo if servo.joint == joint]
        return tuple(sorted(own, key=lambda servo: servo.shadow_of is not None))

    def direction(self, servo_id: int) -> int:
        """Sign between a servo's ticks and its joint's angle, as far as it is known by now."""
        return self._directions[servo_id]

    def follow_anew(self) -> None:
        """Read the servos' settings again, and follow from where they are now."""
        self.facts = read_facts(self.group)
        self.follower = Follower(self.group)

    def mark_rest(self) -> bool:
        """Take the present posture as rest, and zero from it.

        Returns
        -------
        bool
            False where the arm does not hold still; nothing is taken then.

        Raises
        ------
        ServoMismatchError
            A servo has been turned by whole turns since it was switched on.
        """
        seen = self._still()
        if seen is None:
            return False
        for facts in self.facts:
            turn = turn_of(facts.servo.model)
            actual = seen[facts.servo_id] - facts.homing_offset
            outside = turn is not None and not 0 <= actual < turn
            if outside and facts.operating_mode != reg.POSITION_MODE:
                raise ServoMismatchError(
                    f"{facts.title} reads {seen[facts.servo_id]}, more than a turn: it counts turns"
                    " that it forgets without power; switch it off and on, and calibrate again"
                )
        self._rest = seen
        self.follower.forget_range()
        return True

    def away_from_rest(self) -> dict[str, float] | None:
        """How far each joint is from where it was at rest, rad; None while it is moving."""
        seen = self._still()
        if seen is None:
            return None
        away = {}
        for joint in self.joints:
            leader = self.servos_of(joint)[0]
            ticks = seen[leader.id] - self._rest[leader.id]
            away[joint] = self._directions[leader.id] * ticks * radians_per_tick(leader.model)
        return away

    def mark_direction(self, joint: str, began: dict[int, int]) -> int:
        """Take the way that a joint was moved since a look as its positive direction.

        Parameters
        ----------
        joint : str
        began : dict of int to int
            The follower's ticks before.

        Returns
        -------
        int
            1 or -1, the sign between its leader's ticks and its angle; 0 where it was hardly moved.

        Raises
        ------
        ServoMismatchError
            The servos of a dual joint do not turn alike.
        """
        servos = self.servos_of(joint)
        moved = {servo.id: self.follower.ticks[servo.id] - began[servo.id] for servo in servos}
        self._check_pair(servos, moved)
        leader = servos[0]
        if abs(moved[leader.id]) * radians_per_tick(leader.model) < LEAST_MOVE:
            return 0
        direction = 1 if moved[leader.id] > 0 else -1
        self._directions |= {servo.id: direction for servo in servos}
        return direction

    def mark_range(self, joint: str) -> float:
        """Take the ends that a joint was at since its range was forgotten as its range.

        Returns
        -------
        float
            How far they are apart, rad; below `LEAST_MOVE` nothing is taken.

        Raises
        ------
        ServoMismatchError
            As `mark_direction`.
        """
        servos = self.servos_of(joint)
        lowest, highest = self.follower.lowest, self.follower.highest
        for ends in (lowest, highest):
            self._check_pair(servos, {s.id: ends[s.id] - self._rest[s.id] for s in servos})
        leader = servos[0]
        span = (highest[leader.id] - lowest[leader.id]) * radians_per_tick(leader.model)
        if span >= LEAST_MOVE:
            self._ranges |= {servo.id: (lowest[servo.id], highest[servo.id]) for servo in servos}
        return span

    def result(self, method: Literal["rest", "hand"], name: str | None) -> ArmCalibration:
        """What was found; `mark_rest` must have been met."""
        return ArmCalibration(
            schema="armsyn-calibration-1",
            arm=self.arm.name,
            date=datetime.now(UTC).isoformat(timespec="seconds"),
            method=method,
            port=self.bus.port_name,
            servo=tuple(self._servo(facts) for facts in self.facts),
            name=name,
        )

    def _servo(self, facts: ServoFacts) -> ServoCalibration:
        servo = facts.servo
        turn = turn_of(servo.model)
        rest = self._rest[servo.id]
        # position mode folds to one turn as torque comes on, the turn of the encoder in which rest
        # lies; the homing offset is added to what is left
        actual = rest - facts.homing_offset
        folded = 0 if turn is None else actual % turn - actual
        direction = self._directions[servo.id]
        angle = self._rest_angle[servo.joint]
        found = self._ranges.get(servo.id)
        return ServoCalibration(
            id=servo.id,
            joint=servo.joint,
            model=servo.model,
            model_number=self.group.models[servo.id].number,
            firmware=facts.firmware or 0,
            protocol=servo.protocol,
            zero_tick=round(rest + folded - direction * angle / radians_per_tick(servo.model)),
            direction=1 if direction > 0 else -1,
            homing_offset=facts.homing_offset,
            drive_mode=facts.drive_mode,
            operating_mode=facts.operating_mode,
            range_ticks=None if found is None else (found[0] + folded, found[1] + folded),
        )

    def _still(self) -> dict[int, int] | None:
        """Where the servos are held, the middle of several looks; None while one moves."""
        looks = []
        for _ in range(_LOOKS):
            looks.append(dict(self.follower.look()))
            port = self.bus.serial_port
            port.read(port.now() + _BETWEEN_LOOKS)
        columns = {i: [look[i] for look in looks] for i in self.group.ids}
        if any(max(column) - min(column) > _STILL_TICKS for column in columns.values()):
            return None
        return {i: round(statistics.median(column)) for i, column in columns.items()}

    def _check_pair(self, servos: Iterable[ServoDescription], moved: dict[int, int]) -> None:
        leader, *shadows = servos
        for shadow in shadows:
            here, there = moved[shadow.id], moved[leader.id]
            if abs(here + there) <= _PAIR_MOVING_TICKS < abs(here - there):
                raise ServoMismatchError(
                    f"{title_of(shadow)} counts the other way round than servo {leader.id}, whose"
                    " goals it follows: they would fight; armsyn setup sets its drive mode"
                )
            if abs(here - there) > _PAIR_MOVING_TICKS:
                raise ServoMismatchError(
                    f"{title_of(shadow)} went {here} ticks while servo {leader.id} on the same"
                    f" joint went {there}: a horn is loose, or it is not on this joint"
                )


def rest_angles(arm: ArmDescription) -> dict[str, float]:
    """Rest posture by joint, base to tip, the gripper last; rad."""
    angles = dict(zip(arm.joint_names, arm.rest.tolist(), strict=True))
    if arm.gripper is not None and arm.gripper_servo is not None:
        angles[arm.gripper.name] = arm.gripper.rest_angle
    return angles


def check_fit(facts: ServoFacts, arm: ArmDescription, port: str) -> None:
    """Refuse a servo that holds, or is not set up so that a calibration would last.

    Raises
    ------
    TorqueOnError
        Its torque is on.
    ServoMismatchError
        Another mode, direction or homing offset than an arm is driven with.
    """
    if facts.torque_enabled:
        raise TorqueOnError(
            f"{facts.title} on {port} holds with its torque on, and a calibration is done on a limp"
            " arm: support the arm, then armsyn release",
            facts.servo_id,
        )
    grips = arm.gripper is not None and facts.joint == arm.gripper.name
    modes = (reg.POSITION_MODE, reg.EXTENDED_POSITION_MODE)
    allowed = (*modes, reg.CURRENT_POSITION_MODE) if grips else modes
    wrong = None
    if facts.operating_mode not in allowed:
        wrong = f"is in operating mode {facts.operating_mode}"
    elif (facts.drive_mode ^ facts.servo.drive_mode) & reg.DRIVE_MODE_REVERSE:
        wrong = "counts positions the other way round than described (bit 0 of Drive Mode)"
    elif facts.operating_mode == reg.POSITION_MODE and (
        abs(facts.homing_offset) > LARGEST_HOMING_OFFSET
    ):
        wrong = f"has a homing offset of {facts.homing_offset}, which position mode ignores"
    if wrong:
        raise ServoMismatchError(
            f"{facts.title} on {port} {wrong}: run armsyn setup --all --arm {arm.name} first"
        )
