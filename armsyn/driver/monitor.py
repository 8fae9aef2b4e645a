"""Looking at an arm without writing anything to it: posture, state, health and settings.

For an arm that is limp, that holds, or that a fault has left: none of that is judged here, and
nothing drops. Two things a look cannot help: the port is ours alone meanwhile, so that an arm that
another program moves cannot be looked at; and any packet feeds the servos' bus watchdogs, so that
those which a fault left armed do not expire while somebody looks.
"""

from __future__ import annotations

import contextlib
from typing import Self

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.driver import registers as reg
from armsyn.driver.facts import ServoFacts, check_model, read_facts
from armsyn.driver.joints import Health, JointGroup, JointState, watched_servos
from armsyn.driver.models import check_known
from armsyn.driver.servos import ServoGroup
from armsyn.driver.transactions import Bus
from armsyn.errors import BusError, BusTimeoutError, ServoMissingError

FloatArray = NDArray[np.float64]

MARGIN = 0.01
"""Seconds that a reply may be late, beyond the adapter's latency."""


class ArmMonitor:
    """An arm that is looked at; made by `open`.

    Attributes
    ----------
    group : ServoGroup
        All servos: one a joint first, then shadows and the gripper's.
    missing : tuple of int
        IDs of servos that did not answer at the beginning.
    """

    def __init__(self, bus: Bus, arm: ArmDescription, firmware: dict[int, int]) -> None:
        self.bus = bus
        self.arm = arm
        self.missing = tuple(s.id for s in watched_servos(arm) if s.id not in firmware)
        margin = MARGIN + 2.0 * bus.latency
        self._joints = JointGroup(bus, arm, margin, firmware, self.missing)
        self.group: ServoGroup = self._joints.group
        self._seen = np.zeros(len(arm.leaders), dtype=np.bool_)
        self._joints.start_at([0] * len(arm.leaders))

    @classmethod
    def open(cls, port: str, arm: ArmDescription) -> Self:
        """Open the port and find out which of the arm's servos are there.

        Parameters
        ----------
        port : str
            Path of the serial port.
        arm : ArmDescription

        Returns
        -------
        ArmMonitor
            A context manager; leaving it closes the port.

        Raises
        ------
        DescriptionError
            An arm without servos, or with models the driver does not know.
        PortError
            The port cannot be opened.
        ServoMissingError
            None of the servos answers.
        ServoMismatchError
            One is another model: its registers would mean something else.
        """
        check_known(arm)
        bus = Bus(port, arm.servo[0].baud)
        try:
            return cls.attach(bus, arm)
        except BaseException:
            bus.close()
            raise

    @classmethod
    def attach(cls, bus: Bus, arm: ArmDescription) -> Self:
        """Look at an arm on a bus that is open already, which this closes; as `open`."""
        group = ServoGroup(bus, arm.servo)
        for servo in group.servos:
            with contextlib.suppress(BusTimeoutError):
                number, firmware = bus.ping(servo.id)
                check_model(group, servo, number, arm.name)
                group.firmware[servo.id] = firmware
        if not group.firmware:
            raise ServoMissingError(
                f"no servo of {arm.name} answers on {bus.port_name} at {bus.baudrate} baud: check"
                " power, cable and baud rate (armsyn scan looks at all of them)",
                group.ids,
            )
        with contextlib.suppress(BusError):  # it only makes waiting shorter
            delays = group.read("Return Delay Time", group.firmware)
            bus.return_delays |= {i: delay * reg.RETURN_DELAY_UNIT for i, delay in delays.items()}
        return cls(bus, arm, group.firmware)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the port; the arm stays as it is. A second call does nothing."""
        self.bus.close()

    def read_posture(self) -> FloatArray:
        """Present angles, shape (n,), rad; NaN for a joint whose servo has never answered."""
        return self.read_state().position.copy()

    def read_state(self) -> JointState:
        """Read the state of the joints.

        Returns
        -------
        JointState
            Its arrays are used again by the next call; positions are NaN for a joint whose servo
            has never answered.

        Raises
        ------
        PortLostError
            The port went away.
        """
        state = self._joints.read_state()
        self._seen |= state.fresh
        state.position[~self._seen] = np.nan
        return state

    @property
    def polls(self) -> int:
        """How many slow checks there are; `poll` makes them in turns."""
        return self._joints.polls

    def poll(self, turn: int) -> Health | None:
        """Make the slow check whose turn it is; None when there is no answer.

        What it finds of temperatures and voltages is in the states that follow, too.
        """
        return self._joints.poll(turn)

    def read_facts(self) -> tuple[ServoFacts, ...]:
        """Read how the servos that are there are set up, in the order of `group`.

        Raises
        ------
        ServoMismatchError, BusError, PortLostError
            As `armsyn.driver.facts.read_facts`.
        """
        there = (servo for servo in self.group.servos if servo.id not in self.missing)
        return read_facts(self.group.only(there))
