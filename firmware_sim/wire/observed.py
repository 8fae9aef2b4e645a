"""What whoever observes a bus is told: frames heard and said. `trace_text` makes words of them."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_sim.wire.parser import DamagedPacket, Packet


@dataclass(frozen=True, slots=True)
class Heard:
    """A frame of the client, as the servos of one protocol took it.

    Parameters
    ----------
    when : float
        The end of its last byte on the wire, s.
    protocol : int
        1 or 2.
    packet : Packet or DamagedPacket
        It; its ``frame`` has the bytes.
    """

    when: float
    protocol: int
    packet: Packet | DamagedPacket

    @property
    def data(self) -> bytes:
        """The bytes on the wire."""
        return self.packet.frame


@dataclass(frozen=True, slots=True)
class Said:
    """An answer of the servos, one packet of one or of several.

    Parameters
    ----------
    when : float
        When its last byte has left the wire, s.
    protocol : int
        1 or 2.
    data : bytes
        The bytes on the wire.
    """

    when: float
    protocol: int
    data: bytes
