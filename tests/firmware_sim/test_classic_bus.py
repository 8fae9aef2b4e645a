"""AX, MX and XL-320 on one bus, byte for byte: the manual's packets, and errors in the answers.

e-Manual, docs/en/dxl/protocol1, "Instruction Details": its examples are with an RX-64, whose
registers lie as those of an AX do.
"""

from firmware_sim.classic.alarms import OVERLOAD_TIME
from firmware_sim.firmware.world import World, build_world
from firmware_sim.rig.settings import ServoSettings
from firmware_sim.tables import find_model
from firmware_sim.wire.bus import Bus
from firmware_sim.wire.packet import build_packet

RATE = 1_000_000


class Wire:
    """Servos at 1 Mbit/s on one wire; ``Wire("ax-12a:1", ...)``."""

    def __init__(self, *names: str, **registers: int) -> None:
        settings = []
        for name in names:
            model_name, servo_id = name.split(":")
            model = find_model(model_name)
            code = next(c for c, rate in model.baud_rates.items() if rate == RATE)
            kept = {"Baud Rate": code} | {n.replace("_", " "): v for n, v in registers.items()}
            middle = 2048 if model_name.startswith("mx") else 512
            settings.append(ServoSettings(model, int(servo_id), middle, registers=kept))
        self.world: World = build_world(settings)
        self.bus = Bus(self.world)
        self.now = 0.0

    def ask(self, frame: bytes) -> bytes:
        """Send bytes; return all that comes back, when it has come."""
        sent = self.bus.receive(frame, self.now, RATE)
        self.now = max([self.now + 1e-3, *(answer.due for answer in sent)])
        return b"".join(answer.data for answer in sent)

    def ask_1(self, servo_id: int, instruction: int, *params: int) -> bytes:
        """Send an instruction of protocol 1.0."""
        body = bytes((servo_id, len(params) + 2, instruction, *params))
        return self.ask(b"\xff\xff" + body + bytes((~sum(body) & 0xFF,)))

    def run(self, duration: float) -> None:
        """Let time pass, s."""
        self.now += duration
        self.bus.advance(self.now)


def said(servo_id: int, error: int, *params: int) -> bytes:
    """Return a status packet of protocol 1.0."""
    body = bytes((servo_id, len(params) + 2, error, *params))
    return b"\xff\xff" + body + bytes((~sum(body) & 0xFF,))


def test_ping_and_read_as_in_the_manual() -> None:
    wire = Wire("ax-12a:1")
    assert wire.ask(bytes.fromhex("FFFF010201FB")) == bytes.fromhex("FFFF010200FC")
    # Present Temperature; the manual's servo has 32 degrees, this one 25.
    assert wire.ask(bytes.fromhex("FFFF0104022B01CC")) == said(1, 0, 25)


def test_reg_write_and_action_as_in_the_manual() -> None:
    wire = Wire("ax-12a:1")
    assert wire.ask(bytes.fromhex("FFFF0105041EF401E2")) == bytes.fromhex("FFFF010200FC")
    assert wire.ask_1(1, 2, 44, 1) == said(1, 0, 1)
    assert wire.ask(bytes.fromhex("FFFFFE0205FA")) == b""
    assert wire.ask_1(1, 2, 30, 2) == said(1, 0, 0xF4, 0x01)
    assert wire.ask_1(1, 2, 44, 1) == said(1, 0, 0)


def test_sync_write_as_in_the_manual() -> None:
    wire = Wire("ax-12a:0", "ax-12a:1")
    assert wire.ask(bytes.fromhex("FFFFFE0E831E040010005001012002600367")) == b""
    assert wire.ask_1(0, 2, 30, 4) == said(0, 0, 0x10, 0x00, 0x50, 0x01)
    assert wire.ask_1(1, 2, 30, 4) == said(1, 0, 0x20, 0x02, 0x60, 0x03)


def test_bulk_read_as_in_the_manual_is_for_mx() -> None:
    frame = bytes.fromhex("FFFFFE09920002011E0202241D")
    wire = Wire("mx-28:1", "mx-64:2")
    # Goal Position of 1 and Present Position of 2, both in the middle.
    assert wire.ask(frame) == said(1, 0, 0x00, 0x08) + said(2, 0, 0x00, 0x08)
    assert Wire("ax-12a:1", "ax-12a:2").ask(frame) == b""


def test_a_factory_reset_makes_it_id_1_again() -> None:
    wire = Wire("ax-12a:9")
    assert wire.ask_1(9, 6) == said(9, 0)
    wire.run(0.5)
    assert wire.ask_1(1, 1) == said(1, 0)


def test_errors_of_an_instruction_are_in_its_answer_only() -> None:
    wire = Wire("ax-12a:1", CCW_Angle_Limit=600)
    assert wire.ask_1(1, 3, 30, 0xBC, 0x02) == said(1, 0x02)  # goal 700: angle limit
    assert wire.ask_1(1, 3, 32, 0x00, 0x08) == said(1, 0x08)  # speed 2048: range
    assert wire.ask_1(1, 3, 36, 0, 0) == said(1, 0x08)  # read-only
    assert wire.ask_1(1, 5) == said(1, 0x40)  # action without a registered write
    assert wire.ask_1(1, 0x77) == said(1, 0x40)
    assert wire.ask(bytes.fromhex("FFFF010201FA")) == said(1, 0x10)  # checksum
    assert wire.ask_1(1, 1) == said(1, 0)


def test_an_overload_is_in_every_answer_until_torque_limit_is_written() -> None:
    wire = Wire("ax-12a:1")
    wire.world.plant.axes[0].jam(True)
    assert wire.ask_1(1, 3, 30, 0xFF, 0x03) == said(1, 0)
    wire.run(OVERLOAD_TIME + 0.1)
    assert wire.ask_1(1, 1) == said(1, 0x20)
    assert wire.ask_1(1, 2, 34, 2) == said(1, 0x20, 0, 0)
    assert wire.ask_1(1, 3, 32, 0x00, 0x08) == said(1, 0x28)
    wire.world.plant.axes[0].jam(False)
    assert wire.ask_1(1, 3, 34, 0xFF, 0x03) == said(1, 0)
    wire.run(2.0)
    assert wire.ask_1(1, 2, 36, 2) in {said(1, 0, low, 0x03) for low in range(0xFB, 0x100)}


def test_both_protocols_share_the_wire() -> None:
    wire = Wire("ax-12a:1", "xl-320:2")
    assert wire.ask(build_packet(2, 1)) == build_packet(2, 0x55, bytes((0, 94, 1, 30)))  # 350
    assert wire.ask_1(1, 1) == said(1, 0)
    assert wire.ask_1(2, 1) == b""
    assert wire.ask(build_packet(1, 1)) == b""


def test_an_xl_320_answers_with_the_errors_of_protocol_2() -> None:
    wire = Wire("xl-320:1")

    def write(address: int, *data: int) -> bytes:
        return wire.ask(build_packet(1, 3, bytes((address, 0, *data))))

    def status(error: int) -> bytes:
        return build_packet(1, 0x55, bytes((error,)))

    assert write(24, 1) == status(0)
    assert write(30, 0xF4, 0x01) == status(0)
    assert write(12, 60) == status(7)  # EEPROM with the torque on
    assert write(25, 8) == status(4)  # range
    assert write(30, 1) == status(5)  # part of a register
    assert write(37, 0, 0) == status(7)  # read-only
    wire.world.plant.axes[0].jam(True)
    assert write(30, 0xFF, 0x03) == status(0)
    wire.run(OVERLOAD_TIME + 0.1)
    assert write(25, 2) == status(0x80)  # the alert


def test_an_xl_320_knows_neither_clear_nor_backup() -> None:
    wire = Wire("xl-320:1")
    for instruction, params in ((0x10, "0144584C22"), (0x20, "014354524C")):
        frame = build_packet(1, instruction, bytes.fromhex(params))
        assert wire.ask(frame) == build_packet(1, 0x55, b"\x02")
