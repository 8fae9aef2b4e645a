"""An arm's joints on a bus: postures in radians out, states in SI units back.

Servos of several families and protocols may share a bus: goals go out by one sync write for each
register, states come back by one read for each family (`armsyn.driver.blocks`).
"""

from __future__ import annotations

import struct
from collections.abc import Collection
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription, ServoDescription
from armsyn.driver.blocks import (
    HEALTH_BLOCKS,
    STATE_BLOCKS,
    WATCHDOG_BLOCK,
    Health,
    HealthBlock,
    StateBlock,
    health_plan,
    state_plans,
)
from armsyn.driver.gathering import gather_health
from armsyn.driver.goals import GoalPackets
from armsyn.driver.parser import StatusPacket
from armsyn.driver.plans import ReadPlan, exchange_duration
from armsyn.driver.registers import X
from armsyn.driver.servos import ServoGroup
from armsyn.driver.timing import Cycle
from armsyn.driver.transactions import Bus

__all__ = ["Health", "JointGroup", "JointState", "watched_servos"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

FAST_LOSSES = 3.0
"""Incomplete cycles of late after which fast and bulk reads, of which a damaged byte takes all that
follow, give way to sync and single reads, of which it takes one servo's."""

_LOSS_MEMORY = 0.99
"""What is left of a count of losses a cycle later."""

_UNKNOWN = np.array(np.nan)
_X_STATE = STATE_BLOCKS[X]


class JointState(NamedTuple):
    """What the joints answered. The arrays are used again by the next exchange.

    Attributes
    ----------
    position : array, shape (n,)
        rad; the last known one where a servo did not answer.
    velocity : array, shape (n,)
        rad/s, as the servo reports it; likewise.
    current : array, shape (n,)
        A, positive towards positive angles; NaN for servos that do not measure it.
    fresh : array of bool, shape (n,)
        Which servos answered this time.
    alert : array of bool, shape (n,)
        Which of them report a hardware error.
    temperature, voltage : array, shape (n,)
        Degrees Celsius and V, as last heard of, of the joint's hotter servo and of the one with
        the lower voltage; NaN before that.
    """

    position: FloatArray
    velocity: FloatArray
    current: FloatArray
    fresh: BoolArray
    alert: BoolArray
    temperature: FloatArray = _UNKNOWN
    voltage: FloatArray = _UNKNOWN


class _Poll(NamedTuple):
    """One of the slow checks, which are made in turns."""

    row: int
    block: HealthBlock
    plan: ReadPlan


def watched_servos(arm: ArmDescription) -> tuple[ServoDescription, ...]:
    """All servos of an arm: one a joint in the joints' order, then shadows and the gripper's."""
    return (*arm.leaders, *(servo for servo in arm.servo if servo not in arm.leaders))


class JointGroup:
    """The joints of an arm on a bus, and what else there is to watch.

    Parameters
    ----------
    bus : Bus
    arm : ArmDescription
    margin : float
        Seconds that the replies of a cycle, slow checks among them, may be late while streaming.
    firmware : dict of int to int, optional
        Firmware versions by ID, as `armsyn.driver.facts.check_models` finds them out. Without
        them no servo is read fast.
    missing : collection of int
        IDs of servos that are not read: behind a silent one in a read of several, others stay
        silent, too.

    Attributes
    ----------
    group : ServoGroup
        All servos, as `watched_servos` has them; rows of a `Health` are its.
    temperature, voltage : array, shape (servos,)
        As last heard of, degrees Celsius and V; NaN before that.
    """

    def __init__(
        self,
        bus: Bus,
        arm: ArmDescription,
        margin: float,
        firmware: dict[int, int] | None = None,
        missing: Collection[int] = (),
    ) -> None:
        self.bus = bus
        self.margin = self._margin_left = margin
        self.calibration = arm.calibration
        self.group = ServoGroup(bus, watched_servos(arm), firmware)
        self._leaders = self.group.only(arm.leaders)
        self.ids = self._leaders.ids
        self.names = arm.joint_names
        models = [self.group.models[i] for i in self.ids]
        direction = self.calibration.direction.astype(np.float64)
        zero = self.calibration.zero_tick.astype(np.float64)
        position_units = np.broadcast_to(self.calibration.radians_per_tick, zero.shape)
        velocity_units = [model.velocity_unit for model in models]
        current_units = [model.current_unit or np.nan for model in models]
        still = np.zeros(len(models))
        self._offset = np.array([still, still, zero])
        self._unit = direction * np.array([current_units, velocity_units, position_units])
        self._rows = {identifier: row for row, identifier in enumerate(self.group.ids)}
        self._pairs = _pairs_of(arm)
        blocks = [STATE_BLOCKS[model.layout] for model in models]
        self._decoding = [(i, b.size, b.decode) for i, b in zip(self.ids, blocks, strict=True)]
        self._present = self._leaders.only(s for s in arm.leaders if s.id not in missing)
        self._plans = state_plans(self._present)
        self._losses = 0.0
        self._goals = GoalPackets(self._leaders, zero, self._unit[2])
        self._whole_state = _whole_state(blocks)
        self._missing = missing
        self._gathered: dict[int, HealthBlock] = {}
        self._polls = self._make_polls()
        self._first_polls = {poll.row: poll for poll in reversed(self._polls)}
        self._make_arrays()

    def _make_arrays(self) -> None:
        n, servos = len(self.ids), len(self.group.ids)
        self.temperature = np.full(servos, np.nan)
        self.voltage = np.full(servos, np.nan)
        # rows: current, velocity, position; columns: joints
        self._raw, self._measured = np.zeros((2, 3, n))
        self._state = JointState(
            position=self._measured[2],
            velocity=self._measured[1],
            current=self._measured[0],
            fresh=np.zeros(n, dtype=np.bool_),
            alert=np.zeros(n, dtype=np.bool_),
            temperature=np.full(n, np.nan),
            voltage=np.full(n, np.nan),
        )

    def gather_health(self, servos: ServoGroup, limp: Collection[int]) -> None:
        """Make the slow checks of servos by one read each, where that can be had.

        As `armsyn.driver.gathering.gather_health`, which writes to limp ones; to be called before
        torque, with the watchdogs armed, which then tell of a restart: it forgets what was written.
        """
        self._gathered = gather_health(servos, limp)
        self._polls = self._make_polls()

    def _make_polls(self) -> tuple[_Poll, ...]:
        """Torque and errors of every servo first, then temperatures and how shadows follow."""
        first, later = [], []
        for row, servo in enumerate(self.group.servos):
            if servo.id in self._missing:
                continue
            layout = self.group.models[servo.id].layout
            gathered = self._gathered.get(servo.id)
            polls = [
                _Poll(row, block, health_plan(self.group, servo.id, block))
                for block in (HEALTH_BLOCKS[layout] if gathered is None else (gathered,))
                if self.group.having(block.name, (servo.id,))
            ]
            first.append(polls[0])
            later += polls[1:]
            if servo.shadow_of is not None:
                block = self._following_block(servo, STATE_BLOCKS[layout])
                later.append(_Poll(row, block, health_plan(self.group, servo.id, block)))
        return (*first, *later)

    def _following_block(self, shadow: ServoDescription, state: StateBlock) -> HealthBlock:
        assert shadow.shadow_of is not None  # noqa: S101 - a shadow
        leader = self._rows[shadow.shadow_of]

        def decode(row: int, reply: StatusPacket) -> Health:
            apart = int(state.decode(reply.parameters)[2] - self._raw[2, leader])
            return Health(row, apart=apart if self._state.fresh[leader] else None)

        return HealthBlock(state.name, state.address, state.size, decode)

    @property
    def polls(self) -> int:
        """How many slow checks there are; `poll` makes them in turns."""
        return len(self._polls)

    def read_posture(self) -> FloatArray:
        """Present angles, shape (n,), rad; errors as `ServoGroup.read`."""
        ticks = self._leaders.read("Present Position")
        return self.calibration.to_radians([ticks[i] for i in self.ids])

    def start_at(self, ticks: list[int]) -> None:
        """Take `ticks` as the last known positions until the servos answer."""
        self._raw[:2], self._raw[2] = 0.0, ticks
        self._convert()

    def goals_packet(self, command: FloatArray) -> bytes:
        """Sync writes of goal positions, shape (n,), rad; shadows hear them, too.

        A goal that its register cannot hold becomes the nearest that it can.
        """
        return self._goals.of(command)

    def send(self, command: FloatArray) -> None:
        """Write goals, shape (n,), rad; PortLostError when the port went away."""
        self.bus.send(self.goals_packet(command))

    def exchange(self, command: FloatArray) -> JointState:
        """Write goals and read the joints' state.

        Parameters
        ----------
        command : array, shape (n,)
            rad.

        Returns
        -------
        JointState
            Its arrays are used again by the next call.

        Raises
        ------
        PortLostError
            The port went away.
        """
        return self._cycle_with(self.goals_packet(command))

    def read_state(self) -> JointState:
        """Read the joints' state and write nothing; as `exchange`."""
        return self._cycle_with(b"")

    def _cycle_with(self, before: bytes) -> JointState:
        replies = self.bus.exchange(before, self._plans, self.margin)
        self._margin_left = self.bus.margin_left(self.margin)
        return self._take(replies)

    def _take(self, replies: dict[int, StatusPacket]) -> JointState:
        if len(replies) == len(self.ids) and self._take_whole(replies):
            return self._state
        state, alert = self._state, [False] * len(self.ids)
        fresh = alert.copy()
        for row, (identifier, size, decode) in enumerate(self._decoding):
            reply = replies.get(identifier)
            if reply is None:
                continue
            alert[row] = reply.alert
            if len(reply.parameters) == size:
                fresh[row] = True
                decoded = decode(reply.parameters)
                self._raw[:, row] = decoded[:3]
                if len(decoded) > 3:  # voltage and temperature, too
                    self._keep(row, *decoded[3:])
        state.fresh[:], state.alert[:] = fresh, alert
        self._convert()
        self._count_losses(complete=sum(fresh) == len(self._present.ids))
        return state

    def _take_whole(self, replies: dict[int, StatusPacket]) -> bool:
        """Decode in one go what nearly every cycle brings; returns whether it was that."""
        packets = [replies[i] for i in self.ids]
        data = [packet.parameters for packet in packets]
        whole = self._whole_state
        if whole is None or any(len(parameters) != _X_STATE.size for parameters in data):
            return False
        values = whole.unpack(b"".join(data))
        self._raw[:] = values[0::3], values[1::3], values[2::3]
        self._state.fresh[:], self._state.alert[:] = True, [packet.alert for packet in packets]
        self._convert()
        self._count_losses(complete=True)
        return True

    def _count_losses(self, *, complete: bool) -> None:
        """Do without fast and bulk reads when too many of them are cut short."""
        self._losses = _LOSS_MEMORY * self._losses + (not complete)
        if self._losses > FAST_LOSSES and any(
            plan.kind in ("fast", "bulk") for plan in self._plans
        ):
            self._plans = state_plans(self._present, fast=False)

    def _convert(self) -> None:
        np.subtract(self._raw, self._offset, out=self._measured)
        np.multiply(self._measured, self._unit, out=self._measured)

    def read_health(self, row: int) -> Health | None:
        """Torque and hardware error of one servo; None when it did not answer."""
        poll = self._first_polls.get(row)
        return None if poll is None else self._ask(poll)

    def poll(self, turn: int) -> Health | None:
        """Make the next of the slow checks, whose turn it is; None when there is no answer.

        Temperatures and voltages are also kept here, and in the states that follow.
        """
        return self._ask(self._polls[turn % len(self._polls)])

    def _ask(self, poll: _Poll) -> Health | None:
        servo_id = self.group.ids[poll.row]
        health = self._look(poll)
        if health is None:
            return None
        if health.torque_enabled is False and poll.block is self._gathered.get(servo_id):
            return self._ask_itself(poll.row)
        if health.voltage == health.voltage:  # not NaN
            self._keep(poll.row, health.voltage, health.temperature)
        if health.torque_enabled is False:  # why: a restart takes the watchdog, too
            return health._replace(bus_watchdog=self._watchdog(poll.row))
        return health

    def _ask_itself(self, row: int) -> Health | None:
        """Ask a servo's registers themselves: after a restart its indirect addresses lead nowhere.

        It may have its torque, by its Startup Configuration; the watchdog tells of a restart. With
        both, somebody else has taken the indirect addresses: they are not asked again.
        """
        health, watchdog = self._look(self._first_polls[row]), self._watchdog(row)
        if health is not None and health.torque_enabled and watchdog:
            del self._gathered[self.group.ids[row]]
            self._polls = self._make_polls()
        if watchdog is None:
            return health
        return (health or Health(row))._replace(bus_watchdog=watchdog)

    def _watchdog(self, row: int) -> int | None:
        """Bus watchdog of one servo; None when it has none, or did not answer."""
        servo_id = self.group.ids[row]
        if not self.group.having("Bus Watchdog", (servo_id,)):
            return None
        plan = health_plan(self.group, servo_id, WATCHDOG_BLOCK)
        health = self._look(_Poll(row, WATCHDOG_BLOCK, plan))
        return None if health is None else health.bus_watchdog

    def _look(self, poll: _Poll) -> Health | None:
        """What one read brings."""
        replies = self.bus.exchange(b"", (poll.plan,), self._margin_left)
        self._margin_left = self.bus.margin_left(self._margin_left)
        reply = replies.get(self.group.ids[poll.row])
        if reply is None or len(reply.parameters) != poll.block.size:
            return None
        return poll.block.decode(poll.row, reply)

    def cycle(self) -> Cycle:
        """What a cycle takes on the wire, return delays as the bus knows them."""
        before = len(self.goals_packet(self._state.position))
        baud, delays = self.bus.baudrate, self.bus.return_delays
        none = dict.fromkeys(self.group.ids, 0.0)
        polls = (exchange_duration(0, (poll.plan,), baud, delays) for poll in self._polls)
        return Cycle(
            exchange=exchange_duration(before, self._plans, baud, delays),
            health=max(polls),
            reads=sum(len(plan.requests) for plan in self._plans),
            without_delay=exchange_duration(before, self._plans, baud, none),
        )

    def _keep(self, row: int, voltage: float, temperature: float) -> None:
        self.voltage[row], self.temperature[row] = voltage, temperature
        joint, pair = self._pairs[row]
        if joint is not None:
            self._state.temperature[joint] = np.fmax.reduce(self.temperature[pair])
            self._state.voltage[joint] = np.fmin.reduce(self.voltage[pair])


def _pairs_of(arm: ArmDescription) -> list[tuple[int | None, list[int]]]:
    """For each watched servo its joint's row, None for the gripper's, and all servos there."""
    servos = watched_servos(arm)
    return [
        (
            arm.joint_names.index(servo.joint) if servo.joint in arm.joint_names else None,
            [row for row, other in enumerate(servos) if other.joint == servo.joint],
        )
        for servo in servos
    ]


def _whole_state(blocks: list[StateBlock]) -> struct.Struct | None:
    """How the states of all joints are decoded at once, where they are all of the X layout."""
    if any(block is not _X_STATE for block in blocks):
        return None
    return struct.Struct("<" + "hii" * len(blocks))
