"""One older servo in a world of its own, with registers by name and time that is told to it."""

from firmware_sim.firmware.codes import StatusError
from firmware_sim.firmware.model import ServoModel
from firmware_sim.firmware.world import build_world
from firmware_sim.physics.axis import Axis
from firmware_sim.rig.settings import ServoSettings
from firmware_sim.tables import find_model

DIRECTION = 1024  # bit 10: clockwise


class ClassicBench:
    """A servo at its middle; ``ClassicBench("mx-28", Max_Torque=512)`` sets EEPROM registers."""

    def __init__(
        self,
        name: str,
        start: int | None = None,
        *,
        firmware: int | None = None,
        voltage: float | None = None,
        **registers: int,
    ) -> None:
        self.model: ServoModel = find_model(name, firmware=firmware)
        middle = 2048 if name.startswith("mx") else 512
        names = {name.replace("_", " "): value for name, value in registers.items()}
        settings = ServoSettings(
            self.model, 1, middle if start is None else start, voltage, registers=names
        )
        self.world = build_world([settings])
        (self.servo,) = self.world.servos
        self.now = 0.0

    @property
    def axis(self) -> Axis:
        """What the servo drives."""
        return self.world.plant.axes[0]

    def run(self, duration: float) -> None:
        """Let time pass, s."""
        self.now += duration
        self.world.advance(self.now)

    def write(self, name: str, value: int) -> StatusError:
        """Write one register."""
        register = self.model.table[name]
        raw = value.to_bytes(register.size, "little", signed=value < 0)
        return self.servo.write(register.address, raw)

    def set(self, **values: int) -> None:
        """Write registers that are not refused, one after the other."""
        for name, value in values.items():
            assert self.write(name.replace("_", " "), value) == StatusError.NONE, name

    def read(self, name: str) -> int:
        """Read one register."""
        register = self.model.table[name]
        error, raw = self.servo.read(register.address, register.size)
        assert error == StatusError.NONE
        return int.from_bytes(raw, "little", signed=register.signed)

    def read_signed(self, name: str) -> int:
        """Read ten bits with a direction bit, counter-clockwise positive."""
        count = self.read(name)
        return DIRECTION - count if count & DIRECTION else count
