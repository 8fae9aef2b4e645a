"""Who watches a driver from the other side: what goes over the wire, and what servos make of it.

It knows the arm's limits and the rules of a safe driver, and nothing of how the driver keeps them.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

import numpy as np

from firmware_sim.firmware.servo import Servo
from tests.driver.stepped import SteppedArm
from tests.driver.troubles import DISTURBING

GOALS_2 = b"\xff\xff\xfd\x00\xfe"
GOALS_1 = b"\xff\xff\xfe"
STANDING = 12
"""Ticks that a servo may be off its goal as its torque comes on: what a limp joint swings."""

WATCHDOG = 15
"""Units of 20 ms that bus watchdogs are armed with."""

FASTEST_LEAD = 1.0
"""rad/s that goals may move beyond what the posture does, to hold it against gravity."""

MOVING = 64
"""The same for one that somebody moves meanwhile."""


def goals_in(data: bytes) -> tuple[dict[int, int], bytes]:
    """Goals at the beginning of what was sent (sync writes of both protocols), and the rest."""
    goals: dict[int, int] = {}
    while True:
        if data[:5] == GOALS_2 and data[7:12] == b"\x83\x74\x00\x04\x00":
            end, form = 7 + int.from_bytes(data[5:7], "little"), struct.Struct("<Bi")
            body = data[12 : end - 2]
        elif data[:3] == GOALS_1 and data[4:7] == b"\x83\x1e\x02":
            end, form = 4 + data[3], struct.Struct("<BH")
            body = data[7 : end - 1]
        else:
            return goals, data
        goals |= dict(form.iter_unpack(body))
        data = data[end:]


class Witness:
    """Watches an arm from its making on.

    Attributes
    ----------
    phase : str
        What the driver is asked for: ``run``, ``clear``, ``release`` or nothing.
    streamed : list of dict
        Goals of each tick of the present run, ID to tick.
    before, after : list of dict
        Goals that were sent outside of ticks, before the first tick and after it.
    let_go : set of int
        Servos whose torque the driver switched off, while it was on.
    off_rest : float
        How far off rest an arm was that was let go after it had moved, rad.
    broken : list of str
        Rules that were not kept.
    """

    def __init__(self, stepped: SteppedArm, rate: float) -> None:
        self.stepped = stepped
        self.phase = ""
        self.broken: list[str] = []
        self.last_disturbed = -np.inf
        arm = stepped.description
        low, high = (arm.calibration.to_ticks(x) for x in (arm.chain.lower, arm.chain.upper))
        per_tick = np.abs(np.broadcast_to(arm.calibration.radians_per_tick, low.shape))
        steps = (1.05 * arm.max_velocity + FASTEST_LEAD) / rate / per_tick + 1.0
        rows = [servo.id for servo in arm.leaders]
        self.range = {
            i: (min(pair) - 1, max(pair) + 1)
            for i, *pair in zip(rows, low.tolist(), high.tolist(), strict=True)
        }
        moving = (*arm.leaders, *arm.shadows)
        self.watched = {servo.id for servo in moving if servo.protocol == 2}
        self.step = dict(zip(rows, steps.tolist(), strict=True))
        self.begin("")
        self._listen()

    def _listen(self) -> None:
        port, write = self.stepped.port, self.stepped.port.write

        def heard(data: bytes) -> None:
            self.on_wire(data)
            write(data)

        port.write = heard  # type: ignore[method-assign]
        for servo in self.stepped.servos:
            self._listen_to(servo, servo.write)

    def _listen_to(self, servo: Servo, write: Callable[..., Any]) -> None:
        def heard(address: int, data: bytes, **how: Any) -> Any:
            torque = servo.model.table["Torque Enable"].address
            if address == torque and len(data) == 1:
                self.on_torque(servo, bool(data[0]))
            return write(address, data, **how)

        servo.write = heard  # type: ignore[method-assign]

    def begin(self, phase: str) -> None:
        """Take note of what the driver is asked for now."""
        self.phase = phase
        self.streamed: list[dict[int, int]] = []
        self.before: list[dict[int, int]] = []
        self.after: list[dict[int, int]] = []
        self.let_go: set[int] = set()
        self.off_rest = 0.0
        self._last: dict[int, int] = {}

    def on_wire(self, data: bytes) -> None:
        """Judge goals before they reach anybody."""
        goals, rest = goals_in(data)
        if not goals:
            return
        if not self.phase:
            self.say(f"goals that nobody asked for: {goals}")
        if not rest:
            (self.after if self.streamed else self.before).append(goals)
            return
        if not self.streamed:  # the first continue what the servos hold
            self._last = {i: register(self.stepped.by_id[i], "Goal Position") for i in goals}
        self.streamed.append(goals)
        for servo_id, goal in goals.items():
            low, high = self.range[servo_id]
            last = self._last[servo_id]  # an arm that was found outside comes back, but no farther
            if not min(low, last) <= goal <= max(high, last):
                self.say(f"goal {goal} of servo {servo_id} is outside {low} to {high}")
            if abs(goal - last) > self.step[servo_id]:
                self.say(f"goal of servo {servo_id} jumps from {last} to {goal}")
        self._last |= goals

    def on_torque(self, servo: Servo, on: bool) -> None:
        """Judge a servo that gets or loses its torque by a write."""
        was_on = bool(register(servo, "Torque Enable"))
        if was_on and not on:
            self.let_go.add(servo.servo_id)
            off = np.abs(self.stepped.positions() - self.stepped.description.rest).max()
            self.off_rest = max(self.off_rest, float(off))
        if on and not was_on:
            off = abs(register(servo, "Goal Position") - register(servo, "Present Position"))
            if off > (MOVING if self.disturbed else STANDING):
                self.say(f"servo {servo.servo_id} gets torque {off} ticks off its goal")
            watched = servo.servo_id in self.watched
            if watched and register(servo, "Bus Watchdog") != WATCHDOG:
                self.say(f"servo {servo.servo_id} gets torque with its watchdog not armed")
            if self.phase != "run":
                self.say(f"servo {servo.servo_id} gets torque that nobody asked for")

    @property
    def disturbed(self) -> bool:
        """Whether something else than its servos moved or held the arm within the last second."""
        if any(f.spec.kind.name in DISTURBING for f in self.stepped.port.simulation.faults):
            self.last_disturbed = self.stepped.now()
        return self.stepped.now() - self.last_disturbed < 1.0

    def say(self, text: str) -> None:
        """Keep a rule that was broken."""
        self.broken.append(f"{self.stepped.now():.4f} s, {self.phase or 'nothing'}: {text}")


def register(servo: Servo, name: str) -> int:
    """Value of a register of a simulated servo of any family."""
    row = servo.model.table[name]
    return int.from_bytes(servo.read(row.address, row.size)[1], "little", signed=row.signed)
