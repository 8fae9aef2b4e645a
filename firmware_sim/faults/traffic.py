"""Faults of others on the wire: a second master, and noise without any packet."""

from __future__ import annotations

from random import Random

from firmware_sim.errors import FaultError
from firmware_sim.faults.argument import Argument
from firmware_sim.faults.frames import build_request
from firmware_sim.faults.spec import FaultKind, FaultSpec
from firmware_sim.faults.striking import EventFault
from firmware_sim.firmware.servo import Servo

_INSTRUCTIONS = {"ping": 0x01, "read": 0x02, "write": 0x03, "reboot": 0x08}
_REBOOT = "reboot"


class ForeignTraffic(EventFault):
    """A second master asks a servo; the client hears both.

    It waits until the wire is free, so that its packets do not collide with the client's.
    """

    def __init__(self, spec: FaultSpec, random: Random) -> None:
        super().__init__(spec, random)
        self._servo: Servo | None = None
        self._request = b""

    def check(self) -> None:
        """See that there is such a servo and such an instruction, and begin."""
        super().check()
        servos = self.site.chosen(self.spec.servo_id)
        if not servos:
            raise FaultError("foreign-traffic: there is no servo to ask")
        self._servo = servos[0]
        self._request = self._build(self._servo)

    def _build(self, servo: Servo) -> bytes:
        choice = self.spec.choice("instruction")
        if choice == _REBOOT and servo.protocol == 1:
            raise FaultError(
                "foreign-traffic: protocol 1.0 has no reboot",
            )
        width = 1 if servo.protocol == 1 else 2
        address, size = self.spec.whole("address"), self.spec.whole("size")
        if width == 1 and address > 0xFF:
            raise FaultError("foreign-traffic: protocol 1.0 has no address above 255")
        parameters = address.to_bytes(width, "little")
        if choice == "read":
            parameters += size.to_bytes(width, "little")
        elif choice == "write":
            value = self.spec.whole("value") % (1 << 8 * size)
            parameters += value.to_bytes(size, "little")
        else:
            parameters = b""
        number = _INSTRUCTIONS[choice]
        return build_request(servo.protocol, servo.servo_id, number, parameters)

    def strike(self, when: float) -> None:
        """Send the request."""
        if self._servo is None:
            return
        servo = self._servo
        self.struck(when, servo.servo_id, self.spec.choice("instruction"))
        self.site.talk(self._request, when, servo.baud_rate, to_servos=True, to_client=True)


class IdleNoise(EventFault):
    """Random bytes on a wire where nobody speaks."""

    def strike(self, when: float) -> None:
        """Put them there."""
        noise = self.random.randbytes(self.spec.whole("bytes"))
        to = self.spec.choice("to")
        self.struck(when, None, f"{len(noise)} bytes")
        self.site.talk(
            noise,
            when,
            self.site.servos[0].baud_rate if self.site.servos else 1.0e6,
            to_servos=to in ("servos", "both"),
            to_client=to in ("client", "both"),
        )


KINDS = (
    FaultKind(
        "foreign-traffic",
        (40,),
        "a second master sends a request, which the client hears with its answer",
        ForeignTraffic,
        (
            Argument("instruction", "what it sends", "read", choices=tuple(_INSTRUCTIONS)),
            Argument("address", "of a read or write", 132, high=0xFFFF, whole=True),
            Argument("size", "of a read or write", 4, "bytes", low=1, high=4, whole=True),
            Argument("value", "of a write", 0, low=-(2.0**31), high=2.0**32 - 1, whole=True),
        ),
    ),
    FaultKind(
        "idle-noise",
        (1,),
        "random bytes while nobody speaks",
        IdleNoise,
        (
            Argument("bytes", "how many", 4, "bytes", low=1, high=4096, whole=True),
            Argument("to", "who hears them", "both", choices=("client", "servos", "both")),
        ),
        concerns_servo=False,
    ),
)
