"""The servos to simulate: what is known of each before it is powered up."""

from __future__ import annotations

from dataclasses import dataclass, replace

from firmware_sim.errors import RigError
from firmware_sim.model import ServoModel
from firmware_sim.packet import MAX_ID
from firmware_sim.servo import Servo
from firmware_sim.tables import find_model


@dataclass(frozen=True, slots=True)
class ServoSettings:
    """One servo to be simulated.

    Parameters
    ----------
    model : ServoModel
        What it is.
    servo_id : int
        0 to 252.
    start_tick : int
        Where it lies at the start, 0 to 4095.
    baud_code : int
        Of Baud Rate(8); the factory's 1 by default, 57600 bit/s.
    return_delay : int
        Of Return Delay Time(9), 2 us; the factory's 250 by default.
    drive_mode : int
        Of Drive Mode(10).
    supply_voltage : float or None
        V; None for the motor's nominal voltage.
    """

    model: ServoModel
    servo_id: int
    start_tick: int = 2048
    baud_code: int = 1
    return_delay: int = 250
    drive_mode: int = 0
    supply_voltage: float | None = None

    def build(self, when: float) -> Servo:
        """Return the servo, powered up at a time in s."""
        registers = {
            "Baud Rate": self.baud_code,
            "Return Delay Time": self.return_delay,
            "Drive Mode": self.drive_mode,
        }
        return Servo(
            self.model,
            self.servo_id,
            self.start_tick,
            self.supply_voltage,
            settings=registers,
            when=when,
        )


def parse_servo(text: str) -> ServoSettings:
    """Return the servo that ``MODEL:ID`` names.

    Raises
    ------
    RigError
        If the text is of another form, or the model or ID is not possible.
    """
    name, colon, number = text.rpartition(":")
    if not colon or not number.isdecimal():
        raise RigError(f"--servo {text!r} is not of the form MODEL:ID, as in xm430-w350:1")
    if int(number) > MAX_ID:
        raise RigError(f"--servo {text!r}: IDs go from 0 to {MAX_ID}")
    return ServoSettings(find_model(name), int(number))


def with_baud_rate(settings: ServoSettings, baud_rate: int) -> ServoSettings:
    """Return the same servo set to another baud rate, bit/s.

    Raises
    ------
    RigError
        If the model has no such rate.
    """
    rates = settings.model.baud_rates
    if baud_rate not in rates:
        known = ", ".join(map(str, rates))
        raise RigError(
            f"baud = {baud_rate} is none of {settings.model.name}'s {known}", field="baud"
        )
    return replace(settings, baud_code=rates.index(baud_rate))


def check_ids(servos: list[ServoSettings]) -> None:
    """Refuse servos that share an ID.

    Raises
    ------
    RigError
        If two do.
    """
    seen: set[int] = set()
    for servo in servos:
        if servo.servo_id in seen:
            raise RigError(f"ID {servo.servo_id} is given twice: IDs must differ", field="id")
        seen.add(servo.servo_id)
