"""How an arm is: every servo's state and settings, read without writing anything.

An arm that is damaged is what this is for: servos that are missing, of another model, mute or
faulty are told of (`armsyn.driver.status_findings`), never refused.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.arm.servos import ServoDescription, calibration_of
from armsyn.driver import registers as reg
from armsyn.driver.models import ServoModel
from armsyn.driver.presence import find_present, hardware_error, model_found
from armsyn.driver.servos import ServoGroup
from armsyn.driver.timing import fitting_rate
from armsyn.driver.transactions import Bus
from armsyn.errors import BusTimeoutError, ServoStatusError

FloatArray = NDArray[np.float64]

LOAD_UNIT = 0.1
"""Percent of one unit of Present Load, X series (classic ones: 100/1023, e-Manual)."""

STATE = (
    "Torque Enable",
    "Hardware Error Status",
    "Bus Watchdog",
    "Goal Position",
    "Present Current",
    "Present Load",
    "Present Position",
    "Present Input Voltage",
    "Present Temperature",
)
SETTINGS = (
    "Return Delay Time",
    "Status Return Level",
    "Drive Mode",
    "Operating Mode",
    "Secondary ID",
    "Homing Offset",
    "Temperature Limit",
    "Max Voltage Limit",
    "Min Voltage Limit",
    "Torque Limit",
)
"""Registers that are read; of each servo those that it has."""


@dataclass(frozen=True)
class ServoStatus:
    """One servo as it was found.

    Attributes
    ----------
    described : ServoDescription
    model : ServoModel or None
        What it is; None when it does not answer, or the driver does not know its model.
    number : int or None
        Model number that it answers with; None when it does not answer.
    firmware : int or None
    stranger : bool
        It answers in the other protocol only.
    values : mapping of str to int
        What its registers read, in their own units; those that it did not answer for are missing.
    """

    described: ServoDescription
    model: ServoModel | None = None
    number: int | None = None
    firmware: int | None = None
    stranger: bool = False
    values: Mapping[str, int] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """Name for messages."""
        return f"servo {self.described.id} ({self.described.joint})"

    @property
    def answers(self) -> bool:
        """Whether it answers a ping."""
        return self.number is not None

    @property
    def voltage(self) -> float | None:
        """V."""
        return self._scaled("Present Input Voltage", reg.VOLTAGE_UNIT)

    @property
    def temperature(self) -> float | None:
        """Degrees Celsius."""
        return self._scaled("Present Temperature", 1.0)

    @property
    def current(self) -> float | None:
        """A, in the servo's own direction; None where it measures none."""
        unit = self.model.current_unit if self.model is not None else None
        return None if unit is None else self._scaled("Present Current", unit)

    @property
    def load(self) -> float | None:
        """Percent of its greatest torque, in its own direction; None where it measures current."""
        if self.model is None or self.model.current_unit is not None:
            return None
        if self.model.layout is reg.X:
            return self._scaled("Present Current", LOAD_UNIT)
        return self._scaled("Present Load", 100.0 / 1023.0)

    @property
    def hardware_error(self) -> int:
        """In the X series' bits; 0 where it is not known."""
        status = self.values.get("Hardware Error Status", 0)
        if self.model is None or "Hardware Error Status" not in self.model.layout:
            return status
        return self.model.layout.hardware_error(status)

    @property
    def torque(self) -> bool | None:
        """Whether its torque is on."""
        value = self.values.get("Torque Enable")
        return None if value is None else bool(value)

    @property
    def return_delay(self) -> float | None:
        """Seconds."""
        return self._scaled("Return Delay Time", reg.RETURN_DELAY_UNIT)

    @property
    def angle(self) -> float | None:
        """Of its joint, rad."""
        return self._angle("Present Position")

    @property
    def goal(self) -> float | None:
        """Of its joint, rad."""
        return self._angle("Goal Position")

    def _angle(self, name: str) -> float | None:
        tick = self.values.get(name)
        if tick is None:
            return None
        return float(calibration_of((self.described,)).to_radians([tick])[0])

    def _scaled(self, name: str, unit: float) -> float | None:
        value = self.values.get(name)
        return None if value is None else value * unit


@dataclass(frozen=True)
class ArmStatus:
    """An arm as it was found.

    Attributes
    ----------
    arm : ArmDescription
    port : str
    baud : int
        Bits a second.
    latency : float
        For which the adapter may keep bytes to itself, s.
    servos : tuple of ServoStatus
        In the description's order.
    unexpected : dict of int to int
        Other servos on the bus: ID to model number; empty also when nobody asked.
    foreign_packets, lost_replies : int
        Of another program, and those that did not come.
    """

    arm: ArmDescription
    port: str
    baud: int
    latency: float
    servos: tuple[ServoStatus, ...]
    unexpected: Mapping[int, int]
    foreign_packets: int = 0
    lost_replies: int = 0

    @property
    def fits(self) -> bool:
        """Whether every servo answers and is of the model described."""
        return all(
            servo.model is not None and servo.model.name == servo.described.model
            for servo in self.servos
        )

    @property
    def posture(self) -> FloatArray:
        """Angles of the joints, shape (n,), rad; NaN where the servo does not answer."""
        angles = {s.described.id: s.angle for s in self.servos}
        found = [angles[leader.id] for leader in self.arm.leaders]
        return np.array([math.nan if angle is None else angle for angle in found])

    @property
    def hand(self) -> FloatArray | None:
        """Where the tip is, shape (3,), m, base frame; None when a joint's angle is unknown."""
        posture = self.posture
        if not np.isfinite(posture).all():
            return None
        return np.asarray(self.arm.chain.forward(posture).tip)

    @property
    def to_limits(self) -> FloatArray:
        """Distance of each joint to its nearer limit, shape (n,), rad; negative beyond it."""
        posture, chain = self.posture, self.arm.chain
        return np.asarray(np.minimum(posture - chain.lower, chain.upper - posture))

    @property
    def fitting_rate(self) -> float | None:
        """Greatest rate of commands that wire and adapter carry, Hz; None when unknown."""
        delays = [s.return_delay for s in self.servos]
        known = [delay for delay in delays if delay is not None]
        if not known or len(known) < len(delays):
            return None
        return fitting_rate(self.baud, known, self.latency)


def read_status(bus: Bus, arm: ArmDescription, *, look_around: bool = True) -> ArmStatus:
    """Read how an arm is. Nothing is written.

    Parameters
    ----------
    bus : Bus
    arm : ArmDescription
        With servos.
    look_around : bool
        Also ask for servos that the description does not have; takes about a second.

    Returns
    -------
    ArmStatus

    Raises
    ------
    PortLostError
        The port went away.
    BusBudgetError
        A bus that loses most answers.
    """
    presence = find_present(bus, arm.servo)
    values = _read_values(presence.group)
    servos = []
    for servo in arm.servo:
        number, firmware = presence.found.get(servo.id, (None, None))
        model = None if number is None else model_found(servo, number)
        stranger = number is None and _speaks(bus, servo, 3 - servo.protocol)
        own = values.get(servo.id, {})
        servos.append(ServoStatus(servo, model, number, firmware, stranger, own))
    ids = {servo.id for servo in arm.servo}
    around = bus.broadcast_ping() if look_around else {}
    return ArmStatus(
        arm=arm,
        port=bus.port_name,
        baud=bus.baudrate,
        latency=bus.latency,
        servos=tuple(servos),
        unexpected={i: number for i, number in around.items() if i not in ids},
        foreign_packets=bus.foreign_traffic,
        lost_replies=bus.counters.timeouts,
    )


def _speaks(bus: Bus, servo: ServoDescription, protocol: int) -> bool:
    try:
        bus.ping(servo.id, attempts=1, protocol=protocol)
    except (BusTimeoutError, ServoStatusError):
        return False
    return True


def _read_values(group: ServoGroup) -> dict[int, dict[str, int]]:
    """Read all registers of all servos; a servo that falls silent is asked no more."""
    values: dict[int, dict[str, int]] = {servo.id: {} for servo in group.servos}
    alive = list(group.ids)
    for name in (*SETTINGS, *STATE):
        _read_one(group, name, alive, values)
    for servo_id in alive:
        if "Hardware Error Status" not in group.models[servo_id].layout:
            with contextlib.suppress(BusTimeoutError):
                values[servo_id]["Hardware Error Status"] = hardware_error(group, servo_id)
    return values


def _read_one(
    group: ServoGroup, name: str, alive: list[int], values: dict[int, dict[str, int]]
) -> None:
    asked = list(alive)
    while asked:
        try:
            for servo_id, value in group.read(name, asked).items():
                values[servo_id][name] = value
        except BusTimeoutError as error:
            for servo_id in tuple(error.servo_ids or asked):
                alive.remove(servo_id)
                asked.remove(servo_id)
        except ServoStatusError as error:  # has no such register, or refuses: left out
            asked.remove(error.servo_id)
        else:
            return
