"""Transactions with DYNAMIXEL servos of both protocols on one serial bus."""

from __future__ import annotations

from armsyn.driver.exchanging import ExchangeBus, heard
from armsyn.driver.plans import Kind, ReadPlan
from armsyn.driver.protocol import BROADCAST_ID
from armsyn.driver.protocol1 import MAXIMUM_ID as LAST_ID_1
from armsyn.driver.registers import Register
from armsyn.driver.requests import (
    codec,
    ping_request,
    read_request,
    reboot_request,
    write_request,
)
from armsyn.errors import BusError

PING_SLOT = 3e-3
"""Seconds that the vendor's SDK gives each ID to answer a broadcast ping in its turn."""

_PING_SIZE = 3
_SCAN_MARGIN = 3e-3
_SCAN_ROUNDS = 2  # one lost or late answer hides no servo
_FIRST_X_NUMBER = 1000


class Bus(ExchangeBus):
    """A bus of servos behind a serial port; arguments, attributes and errors as `ExchangeBus`."""

    def ping(
        self, servo_id: int, attempts: int = 3, protocol: int | None = None
    ) -> tuple[int, int]:
        """Ask whether a servo is there.

        Parameters
        ----------
        servo_id : int
        attempts : int
            How often to ask before giving up.
        protocol : {1, 2}, optional
            By default the servo's own. A servo of protocol 1.0 is asked for its registers, for
            its answer to a ping says nothing.

        Returns
        -------
        model_number, firmware_version : int

        Raises
        ------
        BusTimeoutError
            No answer.
        PortLostError
            The port went away.
        """
        if (protocol or self._protocol(servo_id)) == 2:
            data = self._ask(ping_request(servo_id, _PING_SIZE), attempts).parameters
            return int.from_bytes(data[:2], "little"), data[2]
        data = self._ask(read_request(1, servo_id, 0, _PING_SIZE), attempts).parameters
        number = int.from_bytes(data[:2], "little")
        if number >= _FIRST_X_NUMBER:  # set to speak 1.0, with its own table
            data = self._ask(read_request(1, servo_id, 6, 1), attempts).parameters
        return number, data[-1]

    def broadcast_ping(self, protocol: int = 2) -> dict[int, int]:
        """Ask all servos of a protocol; takes the whole window in which they could answer.

        Servos of protocol 1.0 would answer all at once: every ID is asked by itself, twice if it
        keeps silent.

        Returns
        -------
        dict of int to int
            ID to model number.
        """
        if protocol == 1:
            return self._ping_each()
        request = ping_request(BROADCAST_ID, _PING_SIZE)
        replies = self._run(request, b"", self.margin + len(request.sizes) * PING_SLOT)
        found = sorted(replies.items())
        return {i: int.from_bytes(r.parameters[:2], "little") for i, r in found}

    def _ping_each(self) -> dict[int, int]:
        found: dict[int, int] = {}
        for _ in range(_SCAN_ROUNDS):
            for servo_id in (i for i in range(LAST_ID_1 + 1) if i not in found):
                request = read_request(1, servo_id, 0, 2)
                replies = self._run(request, b"", _SCAN_MARGIN + 2.0 * self.latency)
                if replies and replies[servo_id].parameters:
                    found[servo_id] = int.from_bytes(replies[servo_id].parameters, "little")
        return dict(sorted(found.items()))

    def read(self, servo_id: int, register: Register, attempts: int = 3) -> int:
        """Value of a register, in its own unit.

        Raises
        ------
        BusTimeoutError
            No answer.
        ServoStatusError
            The servo refused.
        PortLostError
            The port went away.
        """
        number = self._protocol(servo_id)
        request = read_request(number, servo_id, register.address, register.size)
        return register.decode(self._ask(request, attempts).parameters)

    def write(self, servo_id: int, register: Register, value: int, attempts: int = 3) -> None:
        """Write a register and wait for the servo's word that it did; errors as `read`."""
        data = register.encode(value)
        request = write_request(self._protocol(servo_id), servo_id, register.address, data)
        self._ask(request, attempts)

    def reboot(self, servo_id: int, attempts: int = 3) -> None:
        """Let a servo start anew; it is deaf for a while then, and its RAM is as at power-on.

        The servo's word is waited for, but need not come: low Status Return Levels forbid it. One
        that says that it heard a damaged request is told again.

        Raises
        ------
        BusError
            The servo speaks protocol 1.0, which has no such instruction, or refuses.
        PortLostError
            The port went away.
        """
        if self._protocol(servo_id) == 1:
            raise BusError(
                f"servo {servo_id} on {self.port_name} speaks protocol 1.0, which cannot reboot:"
                " switch its power off and on"
            )
        for attempt in range(attempts):
            if attempt:
                self._spend([servo_id])
            replies = self._run(reboot_request(servo_id))
            if not replies or heard(replies):
                break
        self._check(replies.values())

    def sync_write(self, register: Register, values: dict[int, int]) -> None:
        """Write one register of several servos; none of them answers.

        Parameters
        ----------
        register : Register
        values : dict of int to int
            ID to value, in the register's own unit.
        """
        data = b""
        for number in (2, 1):
            ids = [i for i in values if self._protocol(i) == number]
            if ids:
                payload = b"".join(register.encode(values[i]) for i in ids)
                data += codec(number).sync_write(register.address, register.size, ids, payload)
        self.send(data)

    def read_all(
        self, register: Register, servo_ids: tuple[int, ...], attempts: int = 3
    ) -> dict[int, int]:
        """One register of several servos, in the order of `servo_ids`; errors as `read`.

        Who did not answer is asked again by itself: a silent servo keeps those waiting that are
        to answer after it. So is who heard a damaged request.
        """
        replies = heard(self.exchange(b"", self._plans(register, servo_ids, "sync")))
        for _ in range(attempts - 1):
            missing = tuple(i for i in servo_ids if i not in replies)
            if not missing:
                break
            self._spend(missing)
            replies |= heard(self.exchange(b"", self._plans(register, missing, "single")))
        if silent := tuple(i for i in servo_ids if i not in replies):
            raise self._silent(silent)
        self._check(replies.values())
        return {i: register.decode(replies[i].parameters) for i in servo_ids}

    def _plans(self, register: Register, servo_ids: tuple[int, ...], kind: Kind) -> list[ReadPlan]:
        both = {n: tuple(i for i in servo_ids if self._protocol(i) == n) for n in (2, 1)}
        address, size = register.address, register.size
        return [
            ReadPlan(kind if number == 2 else "single", number, address, size, ids)
            for number, ids in both.items()
            if ids
        ]
