"""The whole driver on simulated servos in this process, on a clock that only moves by waiting.

Faults enter through three seams: what happens at a given time (`SteppedArm.at`), what becomes of
the bytes on their way back (`SteppedArm.damage`), and the servos themselves.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from armsyn.arm import ArmDescription
from armsyn.driver import ArmSession
from armsyn.driver.path import straight_way
from armsyn.driver.transactions import Bus
from armsyn.errors import PortLostError
from armsyn.motion import Motion
from firmware_sim.clock import SteppedClock
from firmware_sim.firmware.servo import Servo
from firmware_sim.firmware.world import build_world
from firmware_sim.rig.settings import ServoSettings
from firmware_sim.tables import find_model
from firmware_sim.testing import SteppedPort
from firmware_sim.wire.bus import Bus as SimulatedBus

BAUD_CODE = 3  # 1 Mbaud
REPLY_HEADER = b"\xff\xff\xfd\x00"


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
        self.arm.port.write(data)

    def read(self, deadline: float) -> bytes:
        port = self.arm.port
        while True:
            self._check()
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


class SteppedBus(Bus):
    """A bus on a stepped serial port."""

    def __init__(self, arm: SteppedArm) -> None:
        self._arm = arm
        super().__init__("stepped", 1_000_000)

    def openPort(self) -> bool:  # noqa: N802 - the SDK's name
        self.serial_port = SteppedSerial(self._arm)  # type: ignore[assignment]
        self.is_open = True
        return True


class SteppedArm:
    """An arm of simulated servos; also the clock that its streams run on."""

    def __init__(self, arm: ArmDescription, return_delay: int = 0) -> None:
        self.description = arm
        self.clock = SteppedClock()
        settings = {"Baud Rate": BAUD_CODE, "Return Delay Time": return_delay}
        world = build_world(
            [
                ServoSettings(
                    find_model(s.model),
                    s.id,
                    s.rest_tick,
                    registers={**settings, "Drive Mode": s.drive_mode},
                )
                for s in arm.servo
            ]
        )
        self.servos = world.servos
        self.port = SteppedPort(SimulatedBus(world), self.clock, 1_000_000)
        self.damage: Callable[[bytes], bytes] = lambda data: data
        self._events: list[tuple[float, Callable[[], None]]] = []
        self.bus = SteppedBus(self)

    def session(self, rate: float = 200.0) -> ArmSession:
        session = ArmSession.attach(self.bus, self.description, rate, clock=self)
        session.gravity = False  # nothing has weight here
        return session

    def at(self, delay: float, action: Callable[[], None]) -> None:
        """Do something once `delay` seconds have passed from now."""
        self._events.append((self.clock.now() + delay, action))

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
        return [servo.memory.value(register) for servo in self.servos]

    def torque(self) -> list[int]:
        return self.value("Torque Enable")

    def positions(self) -> np.ndarray:
        """Where the servos really are, rad."""
        ticks = [
            int.from_bytes(servo.read(132, 4)[1], "little", signed=True) for servo in self.servos
        ]
        return self.description.calibration.to_radians(ticks)


def without(servo_id: int) -> Callable[[bytes], bytes]:
    """Lose every reply of one servo."""

    def damage(data: bytes) -> bytes:
        replies = data.split(REPLY_HEADER)
        kept = [r for r in replies[1:] if not r or r[0] != servo_id]
        return replies[0] + b"".join(REPLY_HEADER + r for r in kept)

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
