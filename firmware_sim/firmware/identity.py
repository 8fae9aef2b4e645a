"""What the protocol must know of a servo before it can talk to it, copied out of its registers."""

from __future__ import annotations

from firmware_sim.firmware.codes import MAX_ID
from firmware_sim.firmware.memory import Memory
from firmware_sim.firmware.model import ServoModel
from firmware_sim.firmware.timeline import Timeline

_RETURN_DELAY_UNIT = 2.0e-6

IDENTITY_NAMES = frozenset(
    (
        "ID",
        "Secondary(Shadow) ID",
        "Protocol Type",
        "Baud Rate",
        "Return Delay Time",
        "Status Return Level",
    )
)
"""Registers after whose change `Identity.take_identity` is to be called."""


class Identity:
    """Names, protocol and manners of one servo.

    Parameters
    ----------
    model : ServoModel
        What it is.
    memory : Memory
        Its registers, with their EEPROM values in place.
    timeline : Timeline
        Counts changes of identity.

    Attributes
    ----------
    servo_id : int
        What it is called.
    secondary_id : int or None
        A name that it shares with others: it obeys writes to RAM, and never replies.
    protocol : int
        1 or 2: what it speaks now.
    baud_rate : int
        bit/s.
    return_delay : float
        How long it waits before it replies, s.
    status_return_level : int
        0 replies to ping only, 1 also to reads, 2 to everything.
    """

    def __init__(self, model: ServoModel, memory: Memory, timeline: Timeline) -> None:
        self.model = model
        self.memory = memory
        self._timeline = timeline
        self.take_identity()

    def take_identity(self) -> None:
        """Copy what the protocol needs often out of the registers."""
        self._timeline.identities += 1
        value, known = self.memory.value, self.model.table.by_name
        self.servo_id = value("ID")
        self.baud_rate = self.model.baud_rates[value("Baud Rate")]
        self.return_delay = value("Return Delay Time") * _RETURN_DELAY_UNIT
        self.status_return_level = value("Status Return Level")
        self.protocol = value("Protocol Type") if "Protocol Type" in known else self.model.protocol
        secondary = MAX_ID + 1
        if "Secondary(Shadow) ID" in known:
            secondary = value("Secondary(Shadow) ID")
        self.secondary_id = secondary if secondary <= MAX_ID else None
