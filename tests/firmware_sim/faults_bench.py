"""Servos with faults on a stepped clock, and a client that speaks raw frames to them."""

from dynamixel_sdk import Protocol2PacketHandler

from firmware_sim.clock import SteppedClock
from firmware_sim.faults.parsing import parse_fault
from firmware_sim.firmware.world import build_world
from firmware_sim.rig.settings import ServoSettings
from firmware_sim.simulation import Simulation
from firmware_sim.tables import find_model
from firmware_sim.testing import SteppedPort
from firmware_sim.wire.bus import Bus

BAUD_RATE = 1_000_000
BYTE = 10 / BAUD_RATE
"""How long a byte takes on the wire, s."""

PING, READ, WRITE, STATUS = 0x01, 0x02, 0x03, 0x55
ALL = 254


def crc_of(frame: bytes) -> int:
    """The CRC of a frame, as the vendor's SDK computes it."""
    handler = Protocol2PacketHandler()
    return int(handler.updateCRC(0, frame[:-2], len(frame) - 2))


def crc_fits(frame: bytes) -> bool:
    """Whether a frame's CRC is right."""
    return crc_of(frame) == int.from_bytes(frame[-2:], "little")


def request(servo_id: int, instruction: int, parameters: bytes = b"") -> bytes:
    """An instruction packet whose parameters need no stuffing."""
    length = (len(parameters) + 3).to_bytes(2, "little")
    frame = b"\xff\xff\xfd\x00" + bytes((servo_id,)) + length + bytes((instruction,)) + parameters
    return frame + crc_of(frame + b"\0\0").to_bytes(2, "little")


def read_request(address: int, size: int, servo_id: int = 1) -> bytes:
    """A read."""
    return request(servo_id, READ, address.to_bytes(2, "little") + size.to_bytes(2, "little"))


def sync_read_request(address: int, size: int, *servo_ids: int) -> bytes:
    """A sync read."""
    head = address.to_bytes(2, "little") + size.to_bytes(2, "little")
    return request(ALL, 0x82, head + bytes(servo_ids))


def frames_of(stream: bytes) -> list[bytes]:
    """Cut a stream of whole frames at their headers."""
    return [b"\xff\xff\xfd\x00" + part for part in stream.split(b"\xff\xff\xfd\x00")[1:]]


class FaultBench:
    """``FaultBench("crc-error:id=1")`` has one XM430 with ID 1; ``servos=`` asks for others.

    At 1 Mbaud, without return delay.
    """

    def __init__(
        self, *faults: str, servos: tuple[str, ...] = ("xm430-w350:1",), seed: int = 0
    ) -> None:
        settings = []
        for name in servos:
            model, number = name.split(":")
            table = find_model(model)
            code = next(c for c, rate in table.baud_rates.items() if rate == BAUD_RATE)
            registers = {"Baud Rate": code, "Return Delay Time": 0}
            settings.append(ServoSettings(table, int(number), 2048, registers=registers))
        self.clock = SteppedClock()
        self.world = build_world(settings)
        self.servos = self.world.servos
        self.told: list[str] = []
        self.simulation = Simulation(
            Bus(self.world),
            faults=[parse_fault(text) for text in faults],
            seed=seed,
            report=lambda strike: self.told.append(str(strike)),
        )
        self.port = SteppedPort(self.simulation, self.clock, BAUD_RATE)

    def exchange(self, data: bytes, patience: float = 0.05) -> bytes:
        """Send bytes and return all that arrives within a time, s."""
        self.port.write(data)
        self.port.wait_until(self.clock.now() + patience)
        return self.port.read(self.port.in_waiting(), 0.0)

    def ping(self, servo_id: int = 1) -> bytes:
        """Return all that comes back for a ping."""
        return self.exchange(request(servo_id, PING))

    def register(self, address: int, size: int = 1, servo_id: int = 1) -> int:
        """Read a register over the bus; it must work."""
        answer = self.exchange(read_request(address, size, servo_id))
        assert crc_fits(answer)
        assert len(answer) == 11 + size
        return int.from_bytes(answer[9:-2], "little", signed=True)

    def write(self, address: int, value: int, size: int = 1, servo_id: int = 1) -> int:
        """Write a register over the bus and return the error field."""
        data = address.to_bytes(2, "little") + value.to_bytes(size, "little", signed=value < 0)
        answer = self.exchange(request(servo_id, WRITE, data))
        assert crc_fits(answer)
        return answer[8]

    def wait_until(self, when: float) -> None:
        """Let time pass until a time in s."""
        self.port.wait_until(when)
        self.simulation.advance(self.clock.now())

    def wait(self, duration: float) -> None:
        """Let time pass, s."""
        self.wait_until(self.clock.now() + duration)
