"""How long packets take on the wire, and whether a rate fits on it and into the watchdog.

Ten bits a byte (start, eight, stop). Bytes of a packet: ping and bare instruction 10, status
11 + data, sync read 14 + servos, sync write 14 + servos x (1 + data) (e-Manual, Protocol 2.0).
Each servo waits its Return Delay Time before it answers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from armsyn.driver.registers import GOAL_POSITION, HEALTH_SIZE, STATE_SIZE, WATCHDOG_UNIT
from armsyn.errors import BusRateError

BITS_PER_BYTE = 10
STATUS_OVERHEAD = 11
SYNC_OVERHEAD = 14

WATCHDOG_UNITS = 15
"""Bus Watchdog while moving: 15 x 20 ms. Longer than the stalls of a busy host (30-180 ms
measured), and short: a servo whose host died only finishes its way to the last goal anyway."""

WATCHDOG_SECONDS = WATCHDOG_UNITS * WATCHDOG_UNIT

SLOWEST_RATE = 2.0 / WATCHDOG_SECONDS
"""Hz at which the watchdog lasts for two periods."""

SHORTEST_LATENCY = 1e-3
"""Seconds to which the latency timer of an adapter can be set."""

ROUNDING = 1e-9
"""Part of a rate that is rounding, for rates that just fit."""

HOST_SHARE = 0.1
"""Part of a period that is the host's: waking up, decoding, checking, recording."""

HOST_MINIMUM = 0.2e-3
"""Seconds of a period that are the host's at least."""


class Cycle(NamedTuple):
    """What a cycle of an arm takes, whatever its servos and protocols.

    Attributes
    ----------
    exchange : float
        Seconds on the wire of goals and states, return delays among them.
    health : float
        Seconds on the wire of the longest status check.
    reads : int
        Reads of states, each of which waits for the adapter.
    without_delay : float
        `exchange` with return delays of 0, s.
    """

    exchange: float
    health: float
    reads: int
    without_delay: float


def wire_time(byte_count: int, baud: int) -> float:
    """Seconds that `byte_count` bytes take at `baud` bits a second."""
    return byte_count * BITS_PER_BYTE / baud


def sync_read_wire_time(servos: int, baud: int, return_delays: Sequence[float], size: int) -> float:
    """Seconds of a sync read of `size` bytes from `servos` servos, with its answers.

    Parameters
    ----------
    servos : int
    baud : int
        Bits a second.
    return_delays : sequence of float, length `servos`
        Return delay time of each, s.
    size : int
        Bytes read of each.

    Returns
    -------
    float
        s.
    """
    count = SYNC_OVERHEAD + servos + servos * (STATUS_OVERHEAD + size)
    return wire_time(count, baud) + float(sum(return_delays))


def cycle_wire_time(
    servos: int, baud: int, return_delays: Sequence[float], size: int = STATE_SIZE
) -> float:
    """Seconds of one cycle on the wire: goals by sync write, states by sync read.

    Parameters
    ----------
    servos : int
    baud : int
        Bits a second.
    return_delays : sequence of float, length `servos`
        Return delay time of each, s.
    size : int
        Bytes read of each; 10 for current, velocity and position.

    Returns
    -------
    float
        s.
    """
    write = SYNC_OVERHEAD + servos * (1 + GOAL_POSITION.size)
    return wire_time(write, baud) + sync_read_wire_time(servos, baud, return_delays, size)


def health_wire_time(baud: int, return_delays: Sequence[float]) -> float:
    """Seconds of the status check of one servo (the slowest to answer) between two cycles."""
    return sync_read_wire_time(1, baud, [max(return_delays)], HEALTH_SIZE)


def host_share(rate_hz: float) -> float:
    """Seconds of each period that are kept for the host."""
    return max(HOST_SHARE / rate_hz, HOST_MINIMUM)


def plain_cycle(baud: int, return_delays: Sequence[float]) -> Cycle:
    """Cycle of servos that are all read by one sync read; arguments as of `check_rate`."""
    servos = len(return_delays)
    return Cycle(
        exchange=cycle_wire_time(servos, baud, return_delays),
        health=health_wire_time(baud, return_delays),
        reads=1,
        without_delay=cycle_wire_time(servos, baud, [0.0] * servos),
    )


def check_rate(
    rate_hz: float,
    baud: int,
    return_delays: Sequence[float],
    latency: float = 0.0,
    cycle: Cycle | None = None,
) -> None:
    """Refuse a rate that the wire cannot carry, or at which the servos' watchdog would expire.

    A period must hold the cycle, the status check of one servo, the adapter's latency after each
    read, and the host's share; and the watchdog must last for two periods, so that one late
    command does not stop the arm.

    Parameters
    ----------
    rate_hz : float
    baud : int
        Bits a second.
    return_delays : sequence of float, one a servo
        As read from the servos, s.
    latency : float
        For which the adapter may keep a reply to itself, s.
    cycle : Cycle, optional
        Of an arm whose servos are not all read by one sync read.

    Raises
    ------
    BusRateError
        It does not fit, or is no positive number; the message holds the arithmetic.
    """
    taken = plain_cycle(baud, return_delays) if cycle is None else cycle
    busy = taken.exchange
    if not 0 < rate_hz < float("inf"):
        raise BusRateError(f"a rate of {rate_hz} Hz is not a positive number", rate_hz, busy)
    if rate_hz < SLOWEST_RATE * (1.0 - ROUNDING):
        raise BusRateError(_too_slow(rate_hz), rate_hz, busy)
    if rate_hz <= rate_of(taken, latency):
        return
    delay, reads = busy - taken.without_delay, _replies_in_words(taken)
    waiting = f", the adapter keeps {reads} for up to {latency * 1e3:g} ms" if latency else ""
    raise BusRateError(
        f"{rate_hz:g} Hz leaves {1e3 / rate_hz:.2f} ms, but one cycle of {len(return_delays)}"
        f" servos at {baud} baud takes {busy * 1e3:.2f} ms ({taken.without_delay * 1e3:.2f} ms of"
        f" bytes, {delay * 1e3:.2f} ms of return delay), a status check {taken.health * 1e3:.2f} ms"
        f"{waiting} and the host {host_share(rate_hz) * 1e3:.2f} ms:"
        f" {_cure(rate_hz, taken, latency)}",
        rate_hz,
        busy,
    )


def _replies_in_words(cycle: Cycle) -> str:
    return "both replies" if cycle.reads == 1 else f"each of {cycle.reads + 1} replies"


def _too_slow(rate_hz: float) -> str:
    return (
        f"{rate_hz:g} Hz sends a goal every {1e3 / rate_hz:.0f} ms, but the servos stop by"
        f" themselves after {WATCHDOG_SECONDS * 1e3:.0f} ms of silence, which must hold two"
        f" periods: use {SLOWEST_RATE:.2f} Hz or more"
    )


def _cure(rate_hz: float, cycle: Cycle, latency: float) -> str:
    fitting = rate_of(cycle, latency)
    slower = f", or use {int(fitting)} Hz or less" if int(fitting) >= SLOWEST_RATE else ""
    short = min(latency, SHORTEST_LATENCY)
    if latency > short and rate_of(cycle, short) >= rate_hz:
        return (
            "set the adapter's latency timer to 1 ms (latency_timer in the port's folder under"
            f" /sys/bus/usb-serial/devices){slower}"
        )
    if rate_of(cycle._replace(exchange=cycle.without_delay), latency) >= rate_hz:
        return f"set Return Delay Time (register 9) to 0{slower}"
    return f"raise the baud rate{slower}"


def fitting_rate(baud: int, return_delays: Sequence[float], latency: float = 0.0) -> float:
    """Greatest rate that the wire can carry, Hz; arguments as of `check_rate`."""
    return rate_of(plain_cycle(baud, return_delays), latency)


def rate_of(cycle: Cycle, latency: float = 0.0) -> float:
    """Greatest rate of a cycle behind an adapter that keeps replies for `latency` s, Hz."""
    busy = cycle.exchange + cycle.health + (cycle.reads + 1) * latency
    return (1.0 + ROUNDING) * min((1.0 - HOST_SHARE) / busy, 1.0 / (busy + HOST_MINIMUM))
