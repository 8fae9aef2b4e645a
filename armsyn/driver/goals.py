"""Goal positions as packets: radians in, one sync write for each protocol and register out."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from armsyn.driver.registers import Register
from armsyn.driver.requests import codec
from armsyn.driver.servos import ServoGroup

FloatArray = NDArray[np.float64]

_PACKING = {(2, False): "H", (2, True): "h", (4, False): "I", (4, True): "i"}


class GoalPackets:
    """Packs the goals of a group, at every tick the same way.

    Parameters
    ----------
    leaders : ServoGroup
        One servo a joint.
    zero : array, shape (n,)
        Ticks of the joints' zeros.
    unit : array, shape (n,)
        rad a tick, negative where ticks count backwards.
    """

    def __init__(self, leaders: ServoGroup, zero: FloatArray, unit: FloatArray) -> None:
        self._zero, self._unit = zero, unit
        self._lowest, self._highest = _range(leaders)
        self._shares = _shares(leaders)

    def of(self, command: FloatArray) -> bytes:
        """Sync writes of goals, shape (n,), rad.

        A goal that its register cannot hold becomes the nearest that it can.
        """
        wanted = np.rint(self._zero + command / self._unit)
        ticks = np.minimum(np.maximum(wanted, self._lowest), self._highest).astype(int).tolist()
        return b"".join([share.packet(ticks) for share in self._shares])


@dataclass(frozen=True)
class _Share:
    """The servos of one protocol and register."""

    protocol: int
    register: Register
    rows: tuple[int, ...]
    ids: tuple[int, ...]
    packing: struct.Struct

    def packet(self, ticks: list[int]) -> bytes:
        pairs = zip(self.ids, (ticks[row] for row in self.rows), strict=True)
        data = self.packing.pack(*chain.from_iterable(pairs))
        at, size = self.register.address, self.register.size
        packet: bytes = codec(self.protocol).sync_write_shares(at, size, data)
        return packet


def _shares(leaders: ServoGroup) -> tuple[_Share, ...]:
    groups: dict[tuple[int, Register], list[int]] = {}
    for row, servo in enumerate(leaders.servos):
        register = leaders.models[servo.id].layout["Goal Position"]
        groups.setdefault((servo.protocol, register), []).append(row)
    found = []
    for (protocol, register), rows in groups.items():
        one = "B" + _PACKING[register.size, register.coding == "signed"]
        ids = tuple(leaders.ids[row] for row in rows)
        found.append(
            _Share(protocol, register, tuple(rows), ids, struct.Struct("<" + one * len(rows)))
        )
    return tuple(found)


def _range(leaders: ServoGroup) -> tuple[FloatArray, FloatArray]:
    """Least and greatest goals that the registers can hold, ticks."""
    registers = [leaders.models[i].layout["Goal Position"] for i in leaders.ids]
    values = np.array([float(1 << 8 * register.size) for register in registers])
    signed = np.array([register.coding == "signed" for register in registers])
    lowest = np.where(signed, -values / 2, 0.0)
    return lowest, lowest + values - 1.0
