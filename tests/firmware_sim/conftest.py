"""A simulated bus on a stepped clock, and a client that speaks raw frames to it."""

from collections.abc import Callable

import pytest

from firmware_sim.clock import SteppedClock
from firmware_sim.firmware.world import build_world
from firmware_sim.rig.settings import ServoSettings
from firmware_sim.tables import find_model
from firmware_sim.testing import SteppedPort
from firmware_sim.wire.bus import Bus
from firmware_sim.wire.packet import build_packet
from firmware_sim.wire.parser import Packet, PacketParser

BAUD_RATE = 1_000_000
FACTORY = {
    "Baud Rate": 3,
    "Return Delay Time": 0,
}  # 1 Mbaud, no delay: as an arm's set-up leaves it


class Bench:
    """Servos, their clock, and a port to them."""

    def __init__(self, servos: list[ServoSettings], gap_rule: bool = False) -> None:
        self.clock = SteppedClock()
        self.world = build_world(servos)
        self.servos = self.world.servos
        self.bus = Bus(self.world, gap_rule=gap_rule)
        self.port = SteppedPort(self.bus, self.clock, BAUD_RATE)

    def ask(self, servo_id: int, instruction: int, params: bytes = b"") -> list[tuple[int, ...]]:
        """Send an instruction; return (ID, error, parameters...) of each status packet."""
        answers = PacketParser().feed(
            self.port.exchange(build_packet(servo_id, instruction, params))
        )
        assert all(isinstance(a, Packet) and a.instruction == 0x55 for a in answers)
        return [(a.servo_id, *a.params) for a in answers if isinstance(a, Packet)]

    def write(self, address: int, value: int, size: int = 1, servo_id: int = 1) -> int:
        """Write a register; return the error field."""
        raw = address.to_bytes(2, "little") + value.to_bytes(size, "little", signed=value < 0)
        ((_, error),) = self.ask(servo_id, 0x03, raw)
        return error

    def read(self, address: int, size: int = 1, servo_id: int = 1, *, signed: bool = True) -> int:
        """Read a register of more than a byte with its sign, of a byte without."""
        raw = address.to_bytes(2, "little") + size.to_bytes(2, "little")
        ((_, error, *data),) = self.ask(servo_id, 0x02, raw)
        assert error & 0x7F == 0
        return int.from_bytes(bytes(data), "little", signed=signed and size > 1)

    def wait(self, duration: float) -> None:
        """Let time pass, s."""
        self.clock.advance(duration)
        self.world.advance(self.clock.now())


@pytest.fixture
def bench() -> Callable[..., Bench]:
    """Make a bench: ``bench()`` for one XM430 with ID 1, or ``bench("xm540-w270:3", ...)``."""

    def make(*names: str, gap_rule: bool = False, start_tick: int = 2048, **settings: int) -> Bench:
        registers = FACTORY | {name.replace("_", " "): value for name, value in settings.items()}
        servos = []
        for name in names or ("xm430-w350:1",):
            model, number = name.split(":")
            servos.append(
                ServoSettings(find_model(model), int(number), start_tick, registers=registers)
            )
        return Bench(servos, gap_rule)

    return make
