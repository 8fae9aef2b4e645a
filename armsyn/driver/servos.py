"""Servos on a bus, addressed by their registers' names, whatever their family and protocol."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

from armsyn.arm import ServoDescription
from armsyn.driver.models import ServoModel, servo_model
from armsyn.driver.registers import Layout, Register
from armsyn.driver.transactions import Bus
from armsyn.errors import HardwareFaultError, TorqueOnError


def title_of(servo: ServoDescription) -> str:
    """Name of a servo for messages, such as ``servo 4 (elbow)``."""
    shadow = "" if servo.shadow_of is None else f", shadow of {servo.shadow_of}"
    return f"servo {servo.id} ({servo.joint}{shadow})"


class ServoGroup:
    """Some servos of an arm on a bus.

    A shadow hears what is written to its leader's RAM, too. Where the two are to hold different
    values, the shadow's is written after its leader's.

    Parameters
    ----------
    bus : Bus
        Told which protocol each of them speaks.
    servos : sequence of ServoDescription
    firmware : dict of int to int, optional
        Firmware versions by ID, as far as they are known (`armsyn.driver.facts.check_models`
        finds them out); a servo of unknown firmware counts as a new one.

    Raises
    ------
    DescriptionError
        A model that the driver does not know.
    """

    def __init__(
        self,
        bus: Bus,
        servos: Sequence[ServoDescription],
        firmware: dict[int, int] | None = None,
    ) -> None:
        self.bus = bus
        self.firmware: dict[int, int] = {} if firmware is None else firmware
        self.servos = tuple(servos)
        self.models: dict[int, ServoModel] = {
            servo.id: servo_model(servo.model, servo.protocol) for servo in servos
        }
        bus.protocols.update({servo.id: servo.protocol for servo in servos})
        self._titles = {servo.id: title_of(servo) for servo in servos}
        self._leaders = {s.id: s.shadow_of for s in servos if s.shadow_of is not None}

    @property
    def ids(self) -> tuple[int, ...]:
        """IDs, in the order given."""
        return tuple(servo.id for servo in self.servos)

    def title(self, servo_id: int) -> str:
        """Name for messages, such as ``servo 4 (elbow)``."""
        return self._titles[servo_id]

    def only(self, servos: Iterable[ServoDescription]) -> ServoGroup:
        """Return a group of some of these servos, with their firmware known."""
        return ServoGroup(self.bus, tuple(servos), self.firmware)

    def reads_fast(self, servo_id: int) -> bool:
        """Whether a servo's model and firmware answer fast reads; False for unknown firmware."""
        first = self.models[servo_id].fast_firmware
        return first is not None and self.firmware.get(servo_id, -1) >= first

    def having(self, name: str, ids: Iterable[int] | None = None) -> tuple[int, ...]:
        """IDs of the servos that have a register, in their model and firmware."""
        among = self.ids if ids is None else ids
        return tuple(i for i in among if self._has(i, name))

    def _has(self, servo_id: int, name: str) -> bool:
        layout = self.models[servo_id].layout
        if name not in layout:
            return False
        firmware = self.firmware.get(servo_id)
        return firmware is None or firmware >= layout[name].since

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
        TorqueOnError
            The register lies in EEPROM and a servo is under torque: nothing is written, for the
            servo would refuse it without a word.
        BusError
            Whether a servo is under torque cannot be read.
        PortLostError
            The port went away.
        """
        self._check_unlocked(name, self.having(name, values))
        own = [i for i in values if values.get(self._leaders.get(i, i)) != values[i]]
        for ids in ([i for i in values if i not in own], own):
            for register, members in self._by_register(name, self.having(name, ids)).items():
                self.bus.sync_write(register, {i: values[i] for i in members})

    def _check_unlocked(self, name: str, ids: Iterable[int]) -> None:
        locked = [i for i in ids if self.models[i].layout.in_eeprom(name)]
        for servo_id, torque in self.read("Torque Enable", locked).items():
            if torque:
                address = self.models[servo_id].layout[name].address
                raise TorqueOnError(
                    f"{self.title(servo_id)} is under torque, and {name} (register {address}) can"
                    " only be written without: support the arm, then armsyn release",
                    servo_id,
                )

    def set(self, name: str, values: Mapping[int, int]) -> None:
        """Write a register of servos and read it back; once more to those that read wrong.

        Nobody says that a sync write came damaged.

        Raises
        ------
        HardwareFaultError
            A servo does not take its value.
        TorqueOnError, BusError, PortLostError
            As `write` and `read`.
        """
        self.write(name, values)
        if wrong := self._wrong(name, values, values):
            # a shadow has heard what its leader is told again
            again = {i: values[i] for i in values if {i, self._leaders.get(i)} & wrong.keys()}
            self.write(name, again)
            self.verify(name, again)

    def verify(
        self,
        name: str,
        values: Mapping[int, int],
        tolerance: Mapping[Layout, int] = MappingProxyType({}),
    ) -> None:
        """Make sure that a register of servos reads as it should.

        Parameters
        ----------
        name : str
        values : mapping of int to int
        tolerance : mapping of Layout to int, optional
            How far off servos of a family may read; by default not at all.

        Raises
        ------
        HardwareFaultError, BusError, PortLostError
            As `set`.
        """
        # asked twice: an answer that came twice may be one to the same question of before
        wrong = self._wrong(name, values, values, tolerance)
        for servo_id, value in self._wrong(name, values, wrong, tolerance).items():
            address = self.models[servo_id].layout[name].address
            raise HardwareFaultError(
                f"{self.title(servo_id)} does not take {values[servo_id]} as its {name}"
                f" (register {address} reads {value}): check its limits",
                servo_id,
            )

    def _wrong(
        self,
        name: str,
        values: Mapping[int, int],
        ids: Iterable[int],
        tolerance: Mapping[Layout, int] = MappingProxyType({}),
    ) -> dict[int, int]:
        """What servos read that do not read as they should."""
        return {
            servo_id: value
            for servo_id, value in self.read(name, ids).items()
            if abs(value - values[servo_id]) > tolerance.get(self.models[servo_id].layout, 0)
        }

    def _by_register(self, name: str, ids: Iterable[int]) -> dict[Register, list[int]]:
        groups: dict[Register, list[int]] = {}
        for servo_id in ids:
            groups.setdefault(self.models[servo_id].layout[name], []).append(servo_id)
        return groups
