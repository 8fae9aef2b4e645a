"""The whole driver on simulated servos in this process, on a clock that only moves by waiting.

Faults enter through three seams: what happens at a given time (`SteppedArm.at`), what becomes of
the bytes on their way back (`SteppedArm.damage`), and the servos themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

import msgspec
import numpy as np

from armsyn.arm import ArmDescription
from armsyn.driver import ArmSession
from armsyn.driver.path import straight_way
from armsyn.driver.transactions import Bus
from armsyn.errors import PortLostError
from armsyn.motion import Motion
from firmware_sim.assembly import build_simulation
from firmware_sim.clock import SteppedClock
from firmware_sim.firmware.servo import Servo
from firmware_sim.rig.settings import Rig, ServoSettings
from firmware_sim.rig.shadows import join_shadows
from firmware_sim.rig.table import read_table
from firmware_sim.testing import SteppedPort

REPLY_HEADER = b"\xff\xff\xfd\x00"
TOGETHER = 0xFE
SHARE = 14
"""Bytes of one servo's state in a packet of all together: error, ID, 10 bytes, CRC."""


class SteppedSerial:
    """What `armsyn.driver.serial_port.SerialPort` offers, on the stepped clock."""

    def __init__(self, arm: SteppedArm) -> None:
        self.arm = arm
        self.serial = None
        self.lost = False
        self.written: list[bytes] = []

    def now(self) -> float:
        return self.arm.clock.now()

    def write(self, data: bytes) -> None:
        self._check()
        self.written.append(data)
        with self._losing():
            self.arm.port.write(data)

    def read(self, deadline: float) -> bytes:
        port = self.arm.port
        while True:
            self._check()
            with self._losing():
                size = port.in_waiting()
                data = port.read(size or 1, max(0.0, deadline - self.now()))
                data = self.arm.damage(data + port.read(port.in_waiting(), 0.0))
            if data or self.now() >= deadline:
                return data

    def read_now(self) -> bytes:
        return self.read(self.now())

    def gather(
        self, count: int, expected: float, look: Callable[[bytes], None] | None = None
    ) -> bytes:
        data = self.read_now()
        while len(data) < count and (chunk := self.read(expected)):
            data += chunk
            if look is not None:
                look(data)
        return data

    def close(self) -> None:
        self.lost = True

    def _check(self) -> None:
        if self.lost:
            raise PortLostError("port stepped was lost")

    @contextmanager
    def _losing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:  # unplugged
            self.close()
            raise PortLostError(f"port stepped was lost while in use ({error})") from error


class SteppedBus(Bus):
    """A bus on a stepped serial port."""

    def __init__(self, arm: SteppedArm) -> None:
        self._arm = arm
        super().__init__("stepped", arm.baud)

    def openPort(self) -> bool:  # noqa: N802 - the SDK's name
        self.serial_port = SteppedSerial(self._arm)  # type: ignore[assignment]
        self.is_open = True
        return True


class SteppedArm:
    """An arm of simulated servos; also the clock that its streams run on."""

    def __init__(
        self,
        arm: ArmDescription,
        return_delay: int = 0,
        firmware: Mapping[int, int] | None = None,
        baud: int = 1_000_000,
    ) -> None:
        self.description = arm
        self.clock = SteppedClock()
        settings = _settings_of(arm, return_delay, firmware or {}, baud)
        simulation = build_simulation(Rig(settings))
        self.servos = simulation.bus.servos
        self.by_id = {servo.servo_id: servo for servo in self.servos}
        self.port = SteppedPort(simulation, self.clock, baud)
        self.baud = baud
        self.damage: Callable[[bytes], bytes] = lambda data: data
        self._events: list[tuple[float, Callable[[], None]]] = []
        self.bus = SteppedBus(self)

    def session(self, rate: float = 200.0, *, accept_no_watchdog: bool = False) -> ArmSession:
        session = ArmSession.attach(
            self.bus,
            self.description,
            rate,
            clock=self,
            accept_no_watchdog=accept_no_watchdog,
        )
        session.gravity = False  # nothing has weight here
        return session

    def at(self, delay: float, action: Callable[[], None]) -> None:
        """Do something once `delay` seconds have passed from now."""
        self._events.append((self.clock.now() + delay, action))

    def forget_events(self) -> None:
        """Do nothing of what is still to be done."""
        self._events.clear()

    def now(self) -> float:
        return self.clock.now()

    def sleep_until(self, moment: float) -> None:
        due = [event for event in self._events if event[0] <= moment]
        for event in due:
            self._events.remove(event)
            event[1]()
        self.clock.advance_to(moment)

    def way(self, *change: float) -> Motion:
        """Minimum-jerk motion from rest by `change` rad of the first joints."""
        goal = self.description.rest.copy()
        goal[: len(change)] += change
        return straight_way(self.description.rest, goal, self.description, 200.0)

    def value(self, register: str) -> list[int]:
        self.port.bus.advance(self.clock.now())
        having = (servo for servo in self.servos if register in servo.model.table.by_name)
        return [servo.memory.value(register) for servo in having]

    def torque(self) -> list[int]:
        return self.value("Torque Enable")

    def positions(self) -> np.ndarray:
        """Where the joints' servos really are, rad."""
        self.port.bus.advance(self.clock.now())
        leaders = [self.by_id[servo.id] for servo in self.description.leaders]
        return self.description.calibration.to_radians([present_tick(s) for s in leaders])


def _settings_of(
    arm: ArmDescription, return_delay: int, firmware: Mapping[int, int], baud: int
) -> list[ServoSettings]:
    tables = []
    for servo in arm.servo:
        table = {k: v for k, v in msgspec.to_builtins(servo).items() if v is not None}
        table |= {"baud": baud, "return_delay_us": 2 * return_delay}
        if servo.id in firmware:
            table["firmware"] = firmware[servo.id]
        tables.append(table)
    settings = [read_table(table, {}, arm.name, n) for n, table in enumerate(tables, 1)]
    return join_shadows(settings, [True] * len(settings), arm.name)


def present_tick(servo: Servo) -> int:
    """Present Position of a simulated servo of any family."""
    row = servo.model.table["Present Position"]
    return int.from_bytes(servo.read(row.address, row.size)[1], "little", signed=row.signed)


def without(servo_id: int) -> Callable[[bytes], bytes]:
    """Lose every reply of one servo; in a packet of all together, of those after it, too."""
    cut = False

    def keep(reply: bytes) -> bytes:
        nonlocal cut
        cut = reply[:1] == bytes([servo_id])
        if reply[:1] != bytes([TOGETHER]):
            return b"" if cut else REPLY_HEADER + reply
        head, shares = reply[:4], reply[4:]  # ID, length, instruction
        return REPLY_HEADER + head + together(shares)

    def together(shares: bytes) -> bytes:
        nonlocal cut
        starts = range(0, len(shares), SHARE)
        missing = (at for at in starts if shares[at + 1 : at + 2] == bytes([servo_id]))
        end = 0 if cut else next(missing, None)
        cut = end is not None
        return shares[:end]

    def damage(data: bytes) -> bytes:
        replies = data.split(REPLY_HEADER)
        return together(replies[0]) + b"".join(map(keep, replies[1:]))

    return damage


def deafen(servo: Servo, address: int, value: int, times: int = 10**6) -> None:
    """Let a servo overlook the next writes of a value."""
    original, left = servo.write, iter(range(times))

    def write(at: int, data: bytes) -> object:
        if (
            at == address
            and int.from_bytes(data, "little") == value
            and next(left, None) is not None
        ):
            return 0
        return original(at, data)

    servo.write = write  # type: ignore[assignment, method-assign]
