"""The e-Manual's example packets, sent to servos on a stepped clock, answered byte for byte.

docs/en/dxl/protocol2, "Instruction Details", and docs/en/dxl/protocol1, "Status Packet" and
"Instruction Details". The servos are brought into the state that each example says it starts from.
Requests of protocol 1.0 that are not here are in the tests of the older servos' bus.
"""

from firmware_sim.clock import SteppedClock
from firmware_sim.firmware.codes import HardwareError
from firmware_sim.firmware.servo import BOOT_TIME
from firmware_sim.firmware.world import World, build_world
from firmware_sim.physics import kernel
from firmware_sim.rig.settings import ServoSettings
from firmware_sim.stepped import SteppedPort
from firmware_sim.tables import find_model
from firmware_sim.wire.bus import Bus

W210 = "xm430-w210"
T288 = "xc330-t288"
OK_1 = "FF FF FD 00 01 04 00 55 00 A1 0C"
"""The status packet that most examples with ID 1 end with."""


class Line:
    """Servos at their factory's baud rate, and a client that speaks hexadecimal."""

    def __init__(self, *servos: ServoSettings) -> None:
        self.world: World = build_world(servos)
        self.port = SteppedPort(
            Bus(self.world), SteppedClock(), float(self.world.servos[0].baud_rate)
        )

    def ask(self, request: str) -> bytes:
        """Send a frame; return everything that comes back."""
        return self.port.exchange(bytes.fromhex(request))

    def value(self, servo_id: int, name: str) -> int:
        """Return what a register holds, as no instruction has read it."""
        (servo,) = [servo for servo in self.world.servos if servo.servo_id == servo_id]
        return servo.memory.value(name)

    def wait(self, duration: float) -> None:
        """Let time pass, s."""
        self.port.wait_until(self.port.clock.now() + duration)


def servo(
    model: str, servo_id: int, tick: int = 2048, firmware: int | None = None, **registers: int
) -> ServoSettings:
    named = {name.replace("_", " "): value for name, value in registers.items()}
    return ServoSettings(find_model(model, firmware), servo_id, tick, registers=named)


def said(*frames: str) -> bytes:
    return bytes.fromhex("".join(frames))


def test_ping_of_one_and_of_all() -> None:
    line = Line(servo(W210, 1, firmware=38), servo(W210, 2, firmware=38))
    first = "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D"
    second = "FF FF FD 00 02 07 00 55 00 06 04 26 6F 6D"
    assert line.ask("FF FF FD 00 01 03 00 01 19 4E") == said(first)
    assert line.ask("FF FF FD 00 FE 03 00 01 31 42") == said(first, second)


def test_read_and_sync_read_of_positions() -> None:
    line = Line(servo(W210, 1, tick=166), servo(W210, 2, tick=2079))
    first = "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0"
    second = "FF FF FD 00 02 08 00 55 00 1F 08 00 00 BA BE"
    assert line.ask("FF FF FD 00 01 07 00 02 84 00 04 00 1D 15") == said(first)
    both = line.ask("FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA")
    assert both == said(first, second)


def test_write_of_a_goal() -> None:
    line = Line(servo(W210, 1))
    assert line.ask("FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89") == said(OK_1)
    assert line.value(1, "Goal Position") == 512


def test_reg_write_and_action() -> None:
    """The example's 200 is within the Velocity Limit of an XM430-W210, 330."""
    line = Line(servo(W210, 1))
    assert line.ask("FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E") == said(OK_1)
    assert line.value(1, "Registered Instruction") == 1
    assert line.value(1, "Goal Velocity") != 200
    assert line.ask("FF FF FD 00 01 03 00 05 02 CE") == said(OK_1)
    assert line.value(1, "Registered Instruction") == 0
    assert line.value(1, "Goal Velocity") == 200


def test_factory_reset_of_all_but_the_id() -> None:
    line = Line(servo(W210, 1, Temperature_Limit=50))
    assert line.ask("FF FF FD 00 01 04 00 06 01 A1 E6") == said(OK_1)
    line.wait(2 * BOOT_TIME)
    assert line.value(1, "Temperature Limit") == 80


def test_reboot() -> None:
    line = Line(servo(W210, 1))
    line.ask("FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89")
    assert line.ask("FF FF FD 00 01 03 00 08 2F 4E") == said(OK_1)
    assert line.ask("FF FF FD 00 01 03 00 01 19 4E") == b""
    line.wait(2 * BOOT_TIME)
    assert line.value(1, "Goal Position") == 2048


def test_clear_of_turns() -> None:
    line = Line(servo(W210, 1, tick=2 * 4096 + 166, Operating_Mode=4))
    assert line.ask("FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC") == said(OK_1)
    position = "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0"
    assert line.ask("FF FF FD 00 01 07 00 02 84 00 04 00 1D 15") == said(position)


def test_backup_and_restore() -> None:
    line = Line(servo(T288, 1, Temperature_Limit=50))
    assert line.ask("FF FF FD 00 01 08 00 20 01 43 54 52 4C 16 F5") == said(OK_1)
    line.world.servos[0].write(31, b"\x3c")
    # The manual ends this one with 92 F5, which is not its CRC: its servo would have refused it.
    misprint = "FF FF FD 00 01 08 00 20 02 43 54 52 4C 92 F5"
    assert line.ask(misprint)[:9] == said("FF FF FD 00 01 04 00 55 03")
    assert line.ask("FF FF FD 00 01 08 00 20 02 43 54 52 4C 9E F5") == said(OK_1)
    line.wait(2 * BOOT_TIME)
    assert line.value(1, "Temperature Limit") == 50


def test_sync_write_of_goals() -> None:
    line = Line(servo(W210, 1), servo(W210, 2))
    request = "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87"
    assert line.ask(request) == b""
    assert [line.value(i, "Goal Position") for i in (1, 2)] == [150, 170]


def test_fast_sync_read() -> None:
    line = Line(servo(T288, 3, tick=166), servo(T288, 7, tick=2079), servo(T288, 4, tick=1023))
    assert line.ask("FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2") == said(
        "FF FF FD 00 FE 19 00 55 00 03 A6 00 00 00 84 08",
        "00 07 1F 08 00 00 16 CA",
        "00 04 FF 03 00 00 D1 9E",
    )


def test_bulk_read_of_voltage_and_temperature() -> None:
    first = servo(W210, 1)
    line = Line(
        ServoSettings(first.model, 1, supply_voltage=11.9),
        servo(W210, 2),
    )
    line.world.plant.axes.state[1, kernel.TEMPERATURE] = 36.0
    answer = line.ask("FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05")
    assert answer == said(
        "FF FF FD 00 01 06 00 55 00 77 00 C3 69", "FF FF FD 00 02 05 00 55 00 24 8B A9"
    )


def test_bulk_write_of_limits() -> None:
    """The limits of the example are the factory's: others stand there before."""
    line = Line(servo(W210, 1, Max_Voltage_Limit=140), servo(W210, 2, Temperature_Limit=60))
    request = "FF FF FD 00 FE 10 00 93 01 20 00 02 00 A0 00 02 1F 00 01 00 50 B7 68"
    assert line.ask(request) == b""
    assert line.value(1, "Max Voltage Limit") == 160
    assert line.value(2, "Temperature Limit") == 80


def test_fast_bulk_read() -> None:
    line = Line(servo(T288, 3, tick=166), servo(T288, 7, Operating_Mode=16), servo(T288, 4))
    pwm = line.world.servos[1]
    pwm.write(64, b"\x01")
    pwm.write(100, (421).to_bytes(2, "little"))
    line.wait(0.5)
    line.world.plant.axes.state[2, kernel.TEMPERATURE] = 31.0
    request = "FF FF FD 00 FE 12 00 9A 03 84 00 04 00 07 7C 00 02 00 04 92 00 01 00 DA 2D"
    assert line.ask(request) == said(
        "FF FF FD 00 FE 14 00 55 00 03 A6 00 00 00 67 A4", "00 07 A5 01 24 74", "00 04 1F D9 C1"
    )


def ax(servo_id: int) -> ServoSettings:
    return servo("ax-12a", servo_id, 512, Baud_Rate=1)


def test_a_write_of_protocol_1_to_all_gives_the_unknown_servo_its_id() -> None:
    line = Line(ax(17))
    assert line.ask("FF FF FE 04 03 03 01 F6") == b""
    line.wait(0.1)
    assert line.ask("FF FF 01 02 01 FB") == said("FF FF 01 02 00 FC")


def test_a_factory_reset_of_protocol_1() -> None:
    line = Line(ax(0))
    assert line.ask("FF FF 00 02 06 F7") == said("FF FF 00 02 00 FD")
    line.wait(2 * BOOT_TIME)
    assert line.ask("FF FF 01 02 01 FB") == said("FF FF 01 02 00 FC")


def test_the_status_of_an_overloaded_and_overheated_servo_of_protocol_1() -> None:
    line = Line(ax(1))
    line.world.servos[0].raise_hardware_error(HardwareError.OVERLOAD)
    line.world.servos[0].raise_hardware_error(HardwareError.OVERHEATING)
    assert line.ask("FF FF 01 02 01 FB") == said("FF FF 01 02 24 D8")


def test_a_goal_and_its_profile_of_protocol_1() -> None:
    """The example of "Instruction Checksum": three bytes from 12 on; they are voltage limits.

    170 is 17 V, above what an MX-28 can be set to, so that it answers with a range error; an AX,
    whose limits go up to 250, takes 100 and 170 as Min and Max Voltage Limit.
    """
    request = "FF FF 01 05 03 0C 64 AA DC"
    assert Line(servo("mx-28", 1, Baud_Rate=1)).ask(request) == said("FF FF 01 02 08 F4")
    line = Line(ax(1))
    assert line.ask(request) == said("FF FF 01 02 00 FC")
    limits = ("Min Voltage Limit", "Max Voltage Limit")
    assert [line.value(1, name) for name in limits] == [100, 170]
