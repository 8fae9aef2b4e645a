"""Servos on a bus, addressed by their registers' names, whatever their family and protocol."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from armsyn.arm import ServoDescription
from armsyn.driver.models import ServoModel, servo_model
from armsyn.driver.registers import Register
from armsyn.driver.transactions import Bus
from armsyn.errors import HardwareFaultError


class ServoGroup:
    """Some servos of an arm on a bus.

    Parameters
    ----------
    bus : Bus
        Told which protocol each of them speaks.
    servos : sequence of ServoDescription

    Raises
    ------
    DescriptionError
        A model that the driver does not know.
    """

    def __init__(self, bus: Bus, servos: Sequence[ServoDescription]) -> None:
        self.bus = bus
        self.servos = tuple(servos)
        self.models: dict[int, ServoModel] = {
            servo.id: servo_model(servo.model, servo.protocol) for servo in servos
        }
        bus.protocols.update({servo.id: servo.protocol for servo in servos})
        self._titles = {servo.id: f"servo {servo.id} ({servo.joint})" for servo in servos}

    @property
    def ids(self) -> tuple[int, ...]:
        """IDs, in the order given."""
        return tuple(servo.id for servo in self.servos)

    def title(self, servo_id: int) -> str:
        """Name for messages, such as ``servo 4 (elbow)``."""
        return self._titles[servo_id]

    def having(self, name: str, ids: Iterable[int] | None = None) -> tuple[int, ...]:
        """IDs of the servos that have a register."""
        among = self.ids if ids is None else ids
        return tuple(i for i in among if name in self.models[i].layout)

    def read(self, name: str, ids: Iterable[int] | None = None) -> dict[int, int]:
        """Read a register of servos.

        Parameters
        ----------
        name : str
            As in `armsyn.driver.registers`.
        ids : iterable of int, optional
            Of whom; those that have no such register are left out. By default all.

        Returns
        -------
        dict of int to int
            ID to value, in the register's own unit.

        Raises
        ------
        BusError, PortLostError
            As `Bus.read_all`.
        """
        values: dict[int, int] = {}
        for register, members in self._by_register(name, self.having(name, ids)).items():
            values |= self.bus.read_all(register, tuple(members))
        return {i: values[i] for i in self.having(name, ids)}

    def write(self, name: str, values: Mapping[int, int]) -> None:
        """Write a register of servos without asking what became of it: nobody answers.

        Parameters
        ----------
        name : str
        values : mapping of int to int
            ID to value; servos that have no such register are left out.

        Raises
        ------
        PortLostError
            The port went away.
        """
        for register, members in self._by_register(name, self.having(name, values)).items():
            self.bus.sync_write(register, {i: values[i] for i in members})

    def set(self, name: str, values: Mapping[int, int]) -> None:
        """Write a register of servos and read it back.

        Raises
        ------
        HardwareFaultError
            A servo does not take its value.
        BusError, PortLostError
            As `read`.
        """
        self.write(name, values)
        self.verify(name, values)

    def verify(self, name: str, values: Mapping[int, int]) -> None:
        """Make sure that a register of servos reads as it should; errors as `set`."""
        for servo_id, value in self.read(name, values).items():
            if value != values[servo_id]:
                address = self.models[servo_id].layout[name].address
                raise HardwareFaultError(
                    f"{self.title(servo_id)} does not take {values[servo_id]} as its {name}"
                    f" (register {address} reads {value}): check its limits",
                    servo_id,
                )

    def _by_register(self, name: str, ids: Iterable[int]) -> dict[Register, list[int]]:
        groups: dict[Register, list[int]] = {}
        for servo_id in ids:
            groups.setdefault(self.models[servo_id].layout[name], []).append(servo_id)
        return groups
