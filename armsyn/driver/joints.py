"""An arm's joints on a bus: postures in radians out, states in SI units back."""

from __future__ import annotations

import struct
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.driver import protocol
from armsyn.driver import registers as reg
from armsyn.driver.models import VELOCITY_UNIT, servo_model
from armsyn.driver.transactions import Bus

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_STATE = struct.Struct("<hii")
"""Present current, velocity and position, side by side from address 126."""


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
    """

    position: FloatArray
    velocity: FloatArray
    current: FloatArray
    fresh: BoolArray
    alert: BoolArray


class Health(NamedTuple):
    """What the slow check of one servo found.

    Attributes
    ----------
    torque_enabled : bool
    hardware_error : int
        Hardware Error Status.
    """

    torque_enabled: bool
    hardware_error: int


class JointGroup:
    """The joints of an arm on a bus.

    Parameters
    ----------
    bus : Bus
    arm : ArmDescription
    margin : float
        Seconds that a reply may be late while streaming.
    """

    def __init__(self, bus: Bus, arm: ArmDescription, margin: float) -> None:
        self.bus = bus
        self.calibration = arm.calibration
        self.ids = tuple(servo.id for servo in arm.leaders)
        self.names = arm.joint_names
        self.margin = margin
        n = len(self.ids)
        self._goal_format = struct.Struct(f"<{n}i")
        direction = self.calibration.direction.astype(np.float64)
        self._velocity_unit = direction * VELOCITY_UNIT
        units = [servo_model(servo.model, servo.protocol).current_unit for servo in arm.leaders]
        self._current_unit = direction * np.array([np.nan if u is None else u for u in units])
        self._raw = np.zeros((n, 3), dtype=np.int64)
        self._state = JointState(
            position=np.zeros(n),
            velocity=np.zeros(n),
            current=np.zeros(n),
            fresh=np.zeros(n, dtype=np.bool_),
            alert=np.zeros(n, dtype=np.bool_),
        )

    def read_posture(self) -> FloatArray:
        """Present angles, shape (n,), rad; errors as `Bus.read_all`."""
        ticks = self.bus.read_all(reg.PRESENT_POSITION, self.ids)
        return self.calibration.to_radians([ticks[i] for i in self.ids])

    def start_at(self, ticks: list[int]) -> None:
        """Take `ticks` as the last known positions until the servos answer."""
        self._raw[:] = 0
        self._raw[:, 2] = ticks
        self._convert()

    def goals_packet(self, command: FloatArray) -> bytes:
        """Sync write of goal positions, shape (n,), rad."""
        data = self._goal_format.pack(*self.calibration.to_ticks(command).tolist())
        goal = reg.GOAL_POSITION
        return protocol.sync_write(goal.address, goal.size, self.ids, data)

    def send(self, command: FloatArray) -> None:
        """Write goals, shape (n,), rad; PortLostError when the port went away."""
        self.bus.serial_port.write(self.goals_packet(command))

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
        replies = self.bus.sync_read(
            reg.STATE_ADDRESS,
            reg.STATE_SIZE,
            self.ids,
            before=self.goals_packet(command),
            margin=self.margin,
        )
        state = self._state
        for row, identifier in enumerate(self.ids):
            reply = replies.get(identifier)
            state.alert[row] = reply is not None and reply.alert
            if reply is not None and len(reply.parameters) == reg.STATE_SIZE:
                self._raw[row] = _STATE.unpack(reply.parameters)
                state.fresh[row] = True
            else:
                state.fresh[row] = False
        self._convert()
        return state

    def _convert(self) -> None:
        state, raw = self._state, self._raw
        state.position[:] = self.calibration.to_radians(raw[:, 2])
        state.velocity[:] = self._velocity_unit * raw[:, 1]
        state.current[:] = self._current_unit * raw[:, 0]

    def read_health(self, row: int) -> Health | None:
        """Torque and hardware error of one joint's servo; None when it did not answer."""
        identifier = self.ids[row]
        replies = self.bus.sync_read(
            reg.HEALTH_ADDRESS, reg.HEALTH_SIZE, (identifier,), margin=self.margin
        )
        reply = replies.get(identifier)
        if reply is None or len(reply.parameters) != reg.HEALTH_SIZE:
            return None
        error = reg.HARDWARE_ERROR_STATUS.address - reg.HEALTH_ADDRESS
        return Health(bool(reply.parameters[0]), reply.parameters[error])
