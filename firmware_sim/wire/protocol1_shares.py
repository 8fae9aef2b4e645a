"""Protocol 1.0: whose share is what, in the parameters of instructions to several servos.

Source: e-Manual, "DYNAMIXEL Protocol 1.0", Sync Write, Bulk Read. Nothing here raises: a share
that is cut off is left out.
"""

from __future__ import annotations

from firmware_sim.wire.protocol2_shares import ReadShare, WriteShare


def bulk_reads_1(params: bytes) -> list[ReadShare]:
    """Return the shares of a bulk read: 0, then length, ID, address of each."""
    starts = range(1, len(params) - 2, 3)
    return [ReadShare(params[at + 1], params[at + 2], params[at]) for at in starts]


def sync_writes_1(params: bytes) -> list[WriteShare]:
    """Return the shares of a sync write: address, length, then ID and data of each."""
    if len(params) < 2 or not params[1]:
        return []
    address, size = params[0], params[1]
    starts = range(2, len(params) - size, size + 1)
    return [WriteShare(params[at], address, params[at + 1 : at + 1 + size]) for at in starts]
