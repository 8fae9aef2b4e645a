"""Servos of any kind on one wire at 1 Mbaud, and a client that sends frames of both protocols."""

from collections.abc import Mapping

from firmware_sim.firmware.codes import StatusError
from firmware_sim.firmware.servo import Servo
from firmware_sim.firmware.world import build_world
from firmware_sim.rig.settings import ServoSettings
from firmware_sim.tables import find_model
from firmware_sim.wire.bus import Bus, Transmission
from firmware_sim.wire.packet import build_packet
from firmware_sim.wire.packet1 import build_packet_1
from firmware_sim.wire.parser import DamagedPacket, Packet, PacketParser
from firmware_sim.wire.parser1 import PacketParser1

RATE = 1_000_000
Answer = tuple[int, ...]


def servo(
    name: str,
    firmware: int | None = None,
    protocol: int | None = None,
    registers: Mapping[str, int] | None = None,
) -> ServoSettings:
    """``servo("xm430-w350:1")``: no return delay, 1 Mbaud, and what `registers` say."""
    model_name, servo_id = name.split(":")
    model = find_model(model_name, firmware=firmware, protocol=protocol)
    code = next(code for code, rate in model.baud_rates.items() if rate == RATE)
    kept = {"Baud Rate": code, "Return Delay Time": 0} | dict(registers or {})
    middle = model.units.ticks_per_turn // 2
    return ServoSettings(model, int(servo_id), min(middle, 2048), registers=kept)


class Wire:
    """``Wire("xm430-w350:1", servo("ax-12a:2", registers={...}))``."""

    def __init__(self, *servos: str | ServoSettings, gap_rule: bool = True) -> None:
        self.world = build_world([servo(s) if isinstance(s, str) else s for s in servos])
        self.servos: tuple[Servo, ...] = self.world.servos
        self.bus = Bus(self.world, gap_rule=gap_rule)
        self.now = 0.0
        self.rate = RATE

    def send(self, frame: bytes) -> list[Transmission]:
        """Send bytes, and wait for what comes back."""
        sent = self.bus.receive(frame, self.now, self.rate)
        self.now = max(self.now, self.bus.wire_free)
        return sent

    def exchange(self, frame: bytes) -> bytes:
        return b"".join(answer.data for answer in self.send(frame))

    def ask(self, servo_id: int, instruction: int, params: bytes = b"") -> list[Answer]:
        """Protocol 2.0: (ID, error, parameters...) of each status packet."""
        found = PacketParser().feed(self.exchange(build_packet(servo_id, instruction, params)))
        return [(p.servo_id, *p.params) for p in intact(found) if p.instruction == 0x55]

    def ask_1(self, servo_id: int, instruction: int, *params: int) -> list[Answer]:
        """Protocol 1.0: (ID, error, parameters...) of each status packet."""
        frame = build_packet_1(servo_id, instruction, bytes(params))
        return [(p.servo_id, p.instruction, *p.params) for p in self.answers_1(frame)]

    def answers_1(self, frame: bytes) -> list[Packet]:
        return intact(PacketParser1().feed(self.exchange(frame)))

    def wait(self, duration: float) -> None:
        self.now += duration
        self.bus.advance(self.now)

    def peek(self, address: int, size: int = 1, index: int = 0) -> int:
        """Look into a servo past the wire."""
        error, data = self.servos[index].read(address, size)
        assert error == StatusError.NONE
        return int.from_bytes(data, "little")


def intact(found: list[Packet | DamagedPacket]) -> list[Packet]:
    assert all(isinstance(packet, Packet) for packet in found)
    return [packet for packet in found if isinstance(packet, Packet)]


def le(*values: int, size: int = 2) -> bytes:
    return b"".join(value.to_bytes(size, "little") for value in values)
