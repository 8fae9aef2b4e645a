"""What a cycle reads: plans, and the requests that carry them out.

A plan is made once and used at every cycle: its requests, the layout of the bytes that answer
them and their time on the wire are worked out at the first use.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

from armsyn.driver import protocol
from armsyn.driver.requests import Request, codec, read_request
from armsyn.driver.timing import BITS_PER_BYTE

Kind = Literal["sync", "fast", "bulk", "single"]
Block = tuple[int, int]
"""Address and size, bytes."""


@dataclass(frozen=True)
class ReadPlan:
    """How to read bytes of several servos.

    Parameters
    ----------
    kind : {"sync", "fast", "bulk", "single"}
        One request that all answer (sync), with one packet together (fast; the servo's firmware
        must know it), with bytes of their own each (bulk; of protocol 1.0 only MX know it), or
        one request a servo (single).
    protocol : {1, 2}
        1 has no sync and fast reads.
    address, size : int
        Where to read, and how many bytes.
    ids : tuple of int
        Of whom; no ID twice.
    blocks : tuple of (address, size), optional
        One a servo, instead of `address` and `size`; for bulk and single reads.

    Raises
    ------
    ValueError
        No such read.
    """

    kind: Kind
    protocol: int
    address: int
    size: int
    ids: tuple[int, ...]
    blocks: tuple[Block, ...] = field(default=())

    def __post_init__(self) -> None:
        if self.protocol not in (1, 2) or (self.protocol == 1 and self.kind in ("sync", "fast")):
            raise ValueError(f"protocol {self.protocol} has no {self.kind} read")
        if len(set(self.ids)) != len(self.ids):
            raise ValueError(f"IDs {self.ids} of a read hold one twice")
        if self.blocks and (len(self.blocks) != len(self.ids) or self.kind in ("sync", "fast")):
            raise ValueError(f"{len(self.blocks)} blocks are none for each of {len(self.ids)} IDs")

    @cached_property
    def requests(self) -> tuple[Request, ...]:
        """What to send, one after the other's answers."""
        if not self.ids:
            return ()
        sizes = {i: size for i, (_, size) in self._blocks.items()}
        if self.kind == "single":
            return tuple(
                read_request(self.protocol, i, address, size)
                for i, (address, size) in self._blocks.items()
            )
        if self.kind == "bulk":
            return (Request(codec(self.protocol).bulk_read(self._blocks), sizes, self.protocol),)
        build = protocol.fast_sync_read if self.kind == "fast" else protocol.sync_read
        data = build(self.address, self.size, self.ids)
        return (Request(data, sizes, fast=self.kind == "fast"),)

    @property
    def _blocks(self) -> dict[int, Block]:
        blocks = self.blocks or ((self.address, self.size),) * len(self.ids)
        return dict(zip(self.ids, blocks, strict=True))


def bulk_plan(blocks: Mapping[int, Block], protocol_number: int = 2) -> ReadPlan:
    """Bulk read of a block of its own from each servo: ID to (address, size)."""
    return ReadPlan("bulk", protocol_number, 0, 0, tuple(blocks), tuple(blocks.values()))


def exchange_duration(
    before: int, reads: Iterable[ReadPlan], baud: int, return_delays: Mapping[int, float]
) -> float:
    """Seconds of one exchange on the wire, as `Request.duration`."""
    requests = [request for plan in reads for request in plan.requests]
    busy = sum(request.duration(0, baud, return_delays) for request in requests)
    return before * BITS_PER_BYTE / baud + busy
