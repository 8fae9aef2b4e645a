"""Which of an arm's servos are there, whatever their state: for what a damaged arm needs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import msgspec

from armsyn.arm import ServoDescription
from armsyn.driver.models import ServoModel, find_number
from armsyn.driver.plans import ReadPlan
from armsyn.driver.servos import ServoGroup
from armsyn.driver.transactions import Bus
from armsyn.errors import BusTimeoutError, ServoMissingError, ServoStatusError

_ATTEMPTS = 3


@dataclass(frozen=True)
class Presence:
    """The servos of an arm that answer.

    Attributes
    ----------
    group : ServoGroup
        Those whose model the driver knows, as the models that they are: a servo that is not the
        described one is spoken to by its own registers.
    found : mapping of int to (int, int)
        ID to model number and firmware, of all that answer.
    missing : tuple of ServoDescription
        Those that do not.
    """

    group: ServoGroup
    found: Mapping[int, tuple[int, int]]
    missing: tuple[ServoDescription, ...]

    @property
    def missing_titles(self) -> str:
        """The missing ones for a message, such as ``3 (elbow), 4 (wrist)``; may be empty."""
        return ", ".join(f"{servo.id} ({servo.joint})" for servo in self.missing)


def find_present(bus: Bus, servos: Sequence[ServoDescription]) -> Presence:
    """Ping servos, each in its protocol.

    Parameters
    ----------
    bus : Bus
    servos : sequence of ServoDescription

    Returns
    -------
    Presence
        Servos that are missing are no error here.

    Raises
    ------
    PortLostError
        The port went away.
    """
    found: dict[int, tuple[int, int]] = {}
    for servo in servos:
        try:
            found[servo.id] = bus.ping(servo.id, attempts=2, protocol=servo.protocol)
        except (BusTimeoutError, ServoStatusError):  # that it is missing is what is told of it
            continue
    known = [_as_found(s, found[s.id][0]) for s in servos if s.id in found]
    group = ServoGroup(
        bus,
        [servo for servo in known if servo is not None],
        {servo_id: firmware for servo_id, (_, firmware) in found.items()},
    )
    return Presence(group, found, tuple(servo for servo in servos if servo.id not in found))


def require_somebody(presence: Presence, arm: str) -> None:
    """Refuse to go on when no servo answers: ServoMissingError."""
    if presence.found:
        return
    bus = presence.group.bus
    raise ServoMissingError(
        f"no reply at {bus.baudrate} baud from any servo of {arm} on {bus.port_name}: check the"
        " servos' supply and cable; armsyn scan finds other baud rates and IDs",
        tuple(servo.id for servo in presence.missing),
    )


def hardware_error(group: ServoGroup, servo_id: int) -> int:
    """Hardware error of a servo in the X series' bits; in protocol 1.0 of its answer's flags.

    Raises
    ------
    BusError, PortLostError
        As `ServoGroup.read`.
    """
    layout = group.models[servo_id].layout
    if "Hardware Error Status" in layout:
        return layout.hardware_error(group.read("Hardware Error Status", (servo_id,))[servo_id])
    torque = layout["Torque Enable"]
    plan = ReadPlan("single", 1, torque.address, torque.size, (servo_id,))
    for _ in range(_ATTEMPTS):
        if reply := group.bus.exchange(b"", (plan,), group.bus.margin).get(servo_id):
            return layout.hardware_error(reply.hardware_error or 0)
    raise BusTimeoutError(
        f"no answer from {group.title(servo_id)} on {group.bus.port_name}", (servo_id,)
    )


def model_found(servo: ServoDescription, number: int) -> ServoModel | None:
    """Return the model that answers; None for one unknown, or known in the other protocol only."""
    model = find_number(number)
    return model if model is not None and model.protocol == servo.protocol else None


def _as_found(servo: ServoDescription, number: int) -> ServoDescription | None:
    model = model_found(servo, number)
    return None if model is None else msgspec.structs.replace(servo, model=model.name)
