"""Servos on a stepped clock behind a driver's bus that may change its baud rate."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from armsyn.arm import ArmDescription, ServoDescription
from armsyn.arm.calibration_file import ArmCalibration
from armsyn.driver.calibrating import ArmCalibrator
from armsyn.driver.eeprom import EepromImage
from armsyn.driver.setup import ServoPlan, find_lone_servo, plan_servo
from armsyn.driver.setup_restore import RestorePlan
from armsyn.driver.setup_write import write_changes
from armsyn.driver.transactions import Bus
from armsyn.errors import PortError
from firmware_sim.faults.handling import hands
from firmware_sim.testing import SteppedPort, stepped


class SteppedLine:
    """What `armsyn.driver.serial_port.SerialPort` offers, on a stepped port."""

    def __init__(self, port: SteppedPort) -> None:
        self.port = port
        self.serial = None
        self.refuses: set[int] = set()

    def now(self) -> float:
        return self.port.clock.now()

    def set_baud(self, baud: int) -> None:
        if baud in self.refuses:
            raise PortError(f"port stepped does not take {baud} baud")
        self.port.baud_rate = baud

    def write(self, data: bytes) -> None:
        self.port.write(data)

    def read(self, deadline: float) -> bytes:
        """Wait for the first byte only, as the port does."""
        first = self.port.read(1, max(0.0, deadline - self.now()))
        return first + self.read_now()

    def read_now(self) -> bytes:
        return self.port.read(self.port.in_waiting(), 0.0)

    def gather(
        self, count: int, expected: float, look: Callable[[bytes], None] | None = None
    ) -> bytes:
        data = self.read_now()
        while len(data) < count and (chunk := self.read(expected)):
            data += chunk
            if look is not None:
                look(data)
        return data

    def close(self) -> None:
        pass


class SteppedLineBus(Bus):
    """A bus on a stepped port."""

    def __init__(self, port: SteppedPort) -> None:
        self.line = SteppedLine(port)
        super().__init__("stepped", int(port.baud_rate))

    def openPort(self) -> bool:  # noqa: N802 - the SDK's name
        self.serial_port = self.line  # type: ignore[assignment]
        self.is_open = True
        return True

    @property
    def port(self) -> SteppedPort:
        """What the servos are on."""
        return self.line.port

    def value(self, servo_id: int, register: str) -> int:
        """What a servo's register really holds."""
        (servo,) = (s for s in self.port.bus.servos if s.servo_id == servo_id)
        return int(servo.memory.value(register))

    def wait(self, seconds: float) -> None:
        self.port.wait_until(self.port.clock.now() + seconds)


def bench(*servos: str, **settings: Any) -> SteppedLineBus:
    """A bus of servos as `firmware_sim.testing.stepped` makes them."""
    return SteppedLineBus(stepped(*servos, **settings))


def arm_bench(
    folder: Path,
    servos: Iterable[ServoDescription],
    registers: Mapping[int, Mapping[str, int]] | None = None,
    start: Mapping[int, int] | None = None,
) -> SteppedLineBus:
    """A bus of an arm's servos, each with its own joint, so that hands can move them one by one.

    Parameters
    ----------
    folder : Path
        For the rig file.
    servos : iterable of ServoDescription
    registers : mapping of int to mapping of str to int, optional
        What registers of a servo hold, by the simulator's names.
    start : mapping of int to int, optional
        Tick at which a servo lies, instead of its `rest_tick`.
    """
    rows, baud = [], 1_000_000
    for servo in servos:
        baud = servo.baud
        held = ", ".join(
            f'"{name}" = {value}' for name, value in (registers or {}).get(servo.id, {}).items()
        )
        shadow = "" if servo.shadow_of is None else f"shadow_of = {servo.shadow_of}\n"
        rows.append(
            f'[[servo]]\nid = {servo.id}\nmodel = "{servo.model}"\njoint = "{servo.joint}"\n'
            f"protocol = {servo.protocol}\nbaud = {servo.baud}\n"
            f"return_delay_us = {servo.return_delay_us}\ndrive_mode = {servo.drive_mode}\n"
            f"start_tick = {(start or {}).get(servo.id, servo.rest_tick)}\n{shadow}"
            f"zero_tick = {servo.zero_tick}\ndirection = {servo.direction}\n"
            f"registers = {{ {held} }}\n"
        )
    rig = folder / "bench.rig.toml"
    rig.write_text("\n".join(rows))
    return bench(rig=rig, baud=baud)


def move(
    bus: SteppedLineBus, look: Callable[[], object], ticks: Mapping[int, int], seconds: float = 1.0
) -> None:
    """Turn horns by hand while somebody looks, and hold them there."""
    for fault in hands(ticks, speed=8.0):
        bus.port.simulation.inject(f"{fault},for={seconds}")
    end = bus.port.clock.now() + seconds
    while bus.port.clock.now() < end:
        look()
        bus.wait(0.01)


def servo_of(arm: ArmDescription, servo_id: int) -> ServoDescription:
    """A servo of an arm by its ID."""
    return next(servo for servo in arm.servo if servo.id == servo_id)


def planned(bus: SteppedLineBus, arm: ArmDescription, servo_id: int) -> ServoPlan:
    """What is to be written to the only servo on a bus, that it becomes one of an arm's."""
    servo = servo_of(arm, servo_id)
    return plan_servo(bus, arm, servo, find_lone_servo(bus, servo))


def carried_out(bus: SteppedLineBus, plan: ServoPlan) -> EepromImage:
    """Write a plan."""
    return write_changes(bus, plan.image, plan.changes, plan.title)


def names(plan: ServoPlan | RestorePlan) -> list[str]:
    """Registers that a plan writes, in its order."""
    return [change.name for change in plan.changes]


def remounted(arm: ArmDescription, **servos: dict[str, int]) -> ArmDescription:
    """The same arm with horns screwed on otherwise: ``s12={"zero_tick": 2100}``."""
    rest = {joint.name: joint.rest for joint in arm.joint}
    if arm.gripper is not None:
        rest[arm.gripper.name] = arm.gripper.rest_angle
    changed = []
    for servo in arm.servo:
        fields: dict[str, Any] = servos.get(f"s{servo.id}", {})
        found = msgspec.structs.replace(servo, **fields)
        lies = found.zero_tick + found.direction * rest[servo.joint] / (math.tau / 4096)
        changed.append(msgspec.structs.replace(found, rest_tick=round(lies)))
    return msgspec.structs.replace(arm, servo=tuple(changed))


def calibrator_of(
    folder: Path, real: ArmDescription, described: ArmDescription, **settings: Any
) -> tuple[SteppedLineBus, ArmCalibrator]:
    bus = arm_bench(folder, real.servo, **settings)
    return bus, ArmCalibrator(bus, described)


def by_rest(calibrator: ArmCalibrator) -> ArmCalibration:
    assert calibrator.mark_rest()
    return calibrator.result("rest", None)


def loose(
    folder: Path, arm: ArmDescription, start: dict[int, int] | None = None
) -> tuple[SteppedLineBus, ArmCalibrator]:
    """The arm with horns that do not hold on to each other."""
    servos = [
        msgspec.structs.replace(s, joint=f"{s.joint} {s.id}", shadow_of=None) for s in arm.servo
    ]
    registers = {s.id: {"Secondary(Shadow) ID": s.shadow_of} for s in arm.servo if s.shadow_of}
    bus = arm_bench(folder, servos, registers, start)
    return bus, ArmCalibrator(bus, arm)
