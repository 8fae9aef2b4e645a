"""Servos without a bus: registers by name, on a clock that moves only by waiting."""

from collections.abc import Callable

from firmware_sim.firmware.codes import StatusError
from firmware_sim.firmware.world import build_world
from firmware_sim.physics.axis import Axes
from firmware_sim.physics.plant import JointsPlant, Plant
from firmware_sim.rig.settings import ServoSettings
from firmware_sim.tables import find_model


def stiff_supply(axes: Axes) -> Plant:
    """Independent joints on a supply that does not sag."""
    return JointsPlant(axes, 0.0)


class Solo:
    """One servo: ``Solo("xl330-m288", Operating_Mode=1)`` sets EEPROM registers before power-up."""

    def __init__(
        self,
        name: str = "xm430-w350",
        start_tick: int = 2048,
        voltage: float | None = None,
        *,
        firmware: int | None = None,
        protocol: int | None = None,
        plant: Callable[[Axes], Plant] | None = stiff_supply,
        **registers: int,
    ) -> None:
        model = find_model(name, firmware, protocol)
        named = {key.replace("_", " "): value for key, value in registers.items()}
        settings = ServoSettings(model, 1, start_tick, voltage, registers=named)
        self.world = build_world([settings], plant=plant)
        (self.servo,) = self.world.servos
        self.axis = self.servo.axis
        self.table = model.table

    def read(self, name: str) -> int:
        """What a register reads."""
        register = self.table[name]
        error, data = self.servo.read(register.address, register.size)
        assert error == StatusError.NONE
        return int.from_bytes(data, "little", signed=register.signed)

    def write(self, name: str, value: int) -> StatusError:
        """Write a register; return the error."""
        register = self.table[name]
        return self.servo.write(register.address, raw(value, register.size))

    def set(self, **values: int) -> None:
        """Write registers, none of which may be refused."""
        for name, value in values.items():
            assert self.write(name.replace("_", " "), value) == StatusError.NONE, name

    def wait(self, duration: float) -> None:
        """Let time pass, s, without a request."""
        self.world.advance(self.world.now + duration)


def raw(value: int, size: int) -> bytes:
    """Return a value as registers hold it."""
    return value.to_bytes(size, "little", signed=value < 0)
