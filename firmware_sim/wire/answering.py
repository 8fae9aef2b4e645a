"""What servos do alike with either protocol: only frames, errors and widths of addresses differ.

Sources: e-Manual, "DYNAMIXEL Protocol 1.0" and "DYNAMIXEL Protocol 2.0", Instruction Details;
X-series pages, "Secondary(Shadow) ID(12)". Where they are silent: whoever follows a silent servo in
a list stays silent too, for each waits for the one before it (ROBOTIS in DynamixelSDK issue 364). A
servo listed twice answers at its first place only, so that whoever stands behind its second place
waits in vain.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial

from firmware_sim.firmware.codes import StatusError
from firmware_sim.firmware.servo import Servo
from firmware_sim.wire.parser import Packet
from firmware_sim.wire.protocol2_shares import ReadShare
from firmware_sim.wire.replies import Listeners, Reply, Turn

Handler = Callable[[Servo, bytes], Reply | None]
"""What an instruction to one servo does with its parameters, and what is answered."""


@dataclass(frozen=True, slots=True)
class Dialect:
    """How a protocol spells a write and its confirmation.

    Parameters
    ----------
    address_size : int
        Bytes of an address in the parameters.
    too_short : StatusError
        What a write without data is.
    confirmation : callable
        Returns the status packet of a servo that had an ID, with an error number.
    """

    address_size: int
    too_short: StatusError
    confirmation: Callable[[Servo, int, StatusError], bytes]

    def confirm(self, servo: Servo, act: Callable[[], StatusError]) -> Reply | None:
        """Act and say how it went, as the servo was set before: a new ID counts from then on."""
        servo_id, delay = servo.servo_id, servo.return_delay
        silent = servo.status_return_level < 2
        error = act()
        return None if silent else Reply(self.confirmation(servo, servo_id, error), delay)

    def write(self, servo: Servo, params: bytes) -> Reply | None:
        """Write."""
        return self.confirm(servo, lambda: self._spread(servo.write, params))

    def reg_write(self, servo: Servo, params: bytes) -> Reply | None:
        """Keep a write for later."""
        return self.confirm(servo, lambda: self._spread(servo.register_write, params))

    def action(self, servo: Servo, _params: bytes) -> Reply | None:
        """Do what was kept."""
        return self.confirm(servo, servo.act)

    def write_as_shadow(self, servo: Servo, params: bytes) -> None:
        """Write as a secondary ID is told to: to RAM, and without a word."""
        self._spread(partial(servo.write, ram_only=True), params)

    def reg_write_as_shadow(self, servo: Servo, params: bytes) -> None:
        """Keep a write that a secondary ID was told."""
        self._spread(partial(servo.register_write, ram_only=True), params)

    def _spread(self, write: Callable[[int, bytes], StatusError], params: bytes) -> StatusError:
        size = self.address_size
        if len(params) <= size:
            return self.too_short
        return write(int.from_bytes(params[:size], "little"), params[size:])


def ask(
    packet: Packet,
    listeners: Listeners,
    when: float,
    obey: Callable[[Servo, int, bytes], Reply | None],
    shadow_handlers: Mapping[int, Callable[[Servo, bytes], object]],
) -> list[Turn]:
    """Let those whom an instruction names obey it, at a time in s; shadows do it silently."""
    servo_id, instruction, params = packet[:3]
    _feed(listeners, when)
    replies = []
    for servo in listeners.hearing(servo_id):
        reply = obey(servo, instruction, params)
        if reply is not None:
            replies.append(reply)
    for servo in listeners.hearing_shadows(servo_id):
        if instruction in shadow_handlers:
            shadow_handlers[instruction](servo, params)
    return [replies] if replies else []


def awake(listeners: Listeners, when: float) -> list[Servo]:
    """Return all who hear an instruction to all, at a time in s."""
    _feed(listeners, when)
    return [servo for servo in listeners.everyone if servo.hears]


def _feed(listeners: Listeners, when: float) -> None:
    """Feed the bus watchdogs of all who hear an instruction, whomever it names."""
    for servo in listeners.everyone:
        if servo.watches and servo.hears:
            servo.feed(when)


def refuse(servo_id: int, listeners: Listeners, say: Callable[[Servo], Reply | None]) -> list[Turn]:
    """Let those whom a damaged frame names say so; no secondary ID and nobody of all does."""
    replies = [reply for servo in listeners.hearing(servo_id) if (reply := say(servo)) is not None]
    return [replies] if replies else []


def in_turn(
    shares: Iterable[ReadShare],
    listeners: Listeners,
    read: Callable[[Servo, int, int], Reply | None],
) -> list[Turn]:
    """Return the answers to a read of several, in the order asked for, up to a silent one."""
    turns: list[Turn] = []
    answered: set[int] = set()
    for servo_id, address, size in shares:
        replies = []
        for servo in () if servo_id in answered else listeners.by_id.get(servo_id, ()):
            reply = read(servo, address, size) if servo.hears else None
            if reply is not None:
                replies.append(reply)
        if not replies:
            break
        answered.add(servo_id)
        turns.append(replies)
    return turns
