"""Looking for servos at all baud rates, in both protocols. Nothing is written.

Every ID is pinged by itself, in Protocol 2.0 too: a broadcast ping waits no less long (3 ms for
each ID that there could be), and its answers do not say whose garbled reply that was. An answer
counts also when it comes while another ID is being asked, for it names its sender: so the pace is
set by the wire alone, and an adapter that keeps bytes to itself for 16 ms only delays the end.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from armsyn.driver import protocol, protocol1
from armsyn.driver.models import find_number, model_name
from armsyn.driver.scan_probe import Probe
from armsyn.driver.timing import wire_time
from armsyn.driver.transactions import Bus
from armsyn.errors import BusError, PortError, PortLostError

X_BAUD_RATES = (4_500_000, 4_000_000, 3_000_000, 2_000_000, 1_000_000, 115_200, 57_600, 9_600)
"""Of the X series, MX with Protocol 2.0 and XL-320 (e-Manual, "Baud Rate(8)")."""

CLASSIC_BAUD_RATES = (2_500_000, 2_250_000, 500_000, 400_000, 250_000, 200_000, 19_200)
"""More of the AX and MX series with Protocol 1.0 (e-Manual, "Baud Rate(4)")."""

BAUD_RATES = tuple(sorted((*X_BAUD_RATES, *CLASSIC_BAUD_RATES), reverse=True))
"""All of them, the fastest first."""

PROTOCOLS = (2, 1)

_AGAIN = 3
"""How often an ID is asked once more before it is believed to answer, or to answer garbled."""

_MOST_GARBLED = 12
"""More IDs than that are noise at a wrong baud rate, not servos that talk at once."""

_LIVE_BLOCKS = {"X": (120, 28), "XL-320": (37, 10)}
"""Address and size of what differs between two servos that are alike: time, positions, volts."""

_LIVE_BLOCK_1 = (36, 8)

ScanProgress = Callable[[float, int, int, int], None]
"""Called with the part done (0 to 1), the baud rate, the protocol, and the servos found so far."""


@dataclass(frozen=True)
class FoundServo:
    """A servo that answers.

    Attributes
    ----------
    baud, protocol, servo_id : int
        How to reach it.
    model_number, firmware : int or None
        None for one that answers nothing but pings (Status Return Level 0, Protocol 1.0).
    """

    baud: int
    protocol: int
    servo_id: int
    model_number: int | None
    firmware: int | None

    @property
    def model(self) -> str:
        """The model's name, or its number."""
        return "unknown" if self.model_number is None else model_name(self.model_number)


@dataclass(frozen=True)
class SuspectId:
    """An ID at which what comes back is garbled: two servos of one ID, most likely."""

    baud: int
    protocol: int
    servo_id: int


@dataclass(frozen=True)
class ScanResult:
    """What a scan has found.

    Attributes
    ----------
    servos : tuple of FoundServo
        By falling baud rate, then protocol and ID.
    suspects : tuple of SuspectId
        None of a rate at which nothing answers cleanly, where servos answer at another one.
    refused : tuple of int
        Baud rates that the adapter does not take.
    noisy : tuple of int
        Baud rates at which there is nothing but garbage: servos that talk at another one.
    """

    servos: tuple[FoundServo, ...]
    suspects: tuple[SuspectId, ...] = ()
    refused: tuple[int, ...] = ()
    noisy: tuple[int, ...] = ()


def protocols_at(baud: int, protocols: Iterable[int] = PROTOCOLS) -> tuple[int, ...]:
    """Those of some protocols that any servo speaks at a baud rate."""
    only_classic = baud in CLASSIC_BAUD_RATES
    return tuple(number for number in protocols if number == 1 or not only_classic)


def scan(
    bus: Bus,
    bauds: Sequence[int] = BAUD_RATES,
    protocols: Sequence[int] = PROTOCOLS,
    on_progress: ScanProgress | None = None,
) -> ScanResult:
    """Look for servos; about 35 s for all baud rates and both protocols.

    Parameters
    ----------
    bus : Bus
        For the scan alone; its baud rate is put back afterwards.
    bauds : sequence of int
        To try, in this order.
    protocols : sequence of int
        1, 2 or both.
    on_progress : callable, optional
        See `ScanProgress`.

    Returns
    -------
    ScanResult

    Raises
    ------
    PortLostError
        The port went away.
    """
    servos: list[FoundServo] = []
    suspects: list[SuspectId] = []
    refused: list[int] = []
    plan = [(baud, number) for baud in bauds for number in protocols_at(baud, protocols)]
    total = sum(_duration(*step) for step in plan)
    done = 0.0
    with restored_baud(bus):
        for baud, number in plan:
            if on_progress is not None:
                on_progress(done / total, baud, number, len(servos))
            done += _duration(baud, number)
            if baud in refused:
                continue
            try:
                bus.setBaudRate(baud)
            except PortLostError:
                raise
            except PortError:
                refused.append(baud)
                continue
            found, garbled = scan_rate(bus, number)
            servos += found
            suspects += garbled
    clean = {servo.baud for servo in servos}
    noisy = {suspect.baud for suspect in suspects} - clean if clean else set()
    believed = tuple(suspect for suspect in suspects if suspect.baud not in noisy)
    return ScanResult(tuple(servos), believed, tuple(refused), tuple(sorted(noisy, reverse=True)))


@contextlib.contextmanager
def restored_baud(bus: Bus) -> Iterator[None]:
    """Put a bus's baud rate back at the end of a block."""
    before = bus.baudrate
    try:
        yield
    finally:
        with contextlib.suppress(PortError):  # a port that is lost has said so already
            bus.setBaudRate(before)


def _duration(baud: int, number: int) -> float:
    """Seconds that a scan at a rate takes, about."""
    size = 24 if number == 2 else 12
    return 254 * (wire_time(size, baud) + 2.6e-3)


def scan_rate(bus: Bus, number: int) -> tuple[list[FoundServo], list[SuspectId]]:
    """Look for servos of a protocol at the bus's present baud rate; errors as `scan`."""
    probe = Probe(bus, number)
    last = protocol.MAXIMUM_ID if number == 2 else protocol1.MAXIMUM_ID
    answered, garbled = probe.ping_each(range(last + 1))
    doubtful: set[int] = set()
    if len(garbled) <= _MOST_GARBLED:
        # what was garbled may have come late: it is of this ID or of one asked shortly before
        doubtful = {max(0, i - late) for i in garbled for late in range(probe.latest_ids + 1)}
    candidates = sorted(answered | doubtful)
    servos, suspects = [], []
    for servo_id in candidates:
        found = _look_at(bus, probe, servo_id) if servo_id in answered else None
        if found is not None:
            servos.append(found)
        if _is_garbled(probe, servo_id, found):
            suspects.append(SuspectId(bus.baudrate, number, servo_id))
    return servos, suspects


def _look_at(bus: Bus, probe: Probe, servo_id: int) -> FoundServo | None:
    """Ask a servo that answered who it is; None when it does not answer a second time."""
    try:
        number, firmware = bus.ping(servo_id, _AGAIN, probe.protocol)
    except BusError:  # silent, refused, or garbled
        pings = [probe.ping(servo_id) for _ in range(_AGAIN)]
        if not any(answer.packets for answer in pings):
            return None
        return FoundServo(bus.baudrate, probe.protocol, servo_id, None, None)
    return FoundServo(bus.baudrate, probe.protocol, servo_id, number, firmware)


def _is_garbled(probe: Probe, servo_id: int, found: FoundServo | None) -> bool:
    """Whether most answers are bytes that are no packet."""
    if found is None:
        answers = []
        for _ in range(_AGAIN):
            answers.append(probe.ping(servo_id))
            if not answers[-1].garbled:
                return False
    else:
        block = _LIVE_BLOCK_1
        if probe.protocol == 2:
            model = None if found.model_number is None else find_number(found.model_number)
            block = _LIVE_BLOCKS["X" if model is None else model.layout.name]
        answers = [probe.read(servo_id, *block) for _ in range(_AGAIN)]
    return 2 * sum(answer.garbled for answer in answers) > _AGAIN
