"""One servo under any sequence of instructions, against the manual's rules written down twice."""

import math

import hypothesis.strategies as st
from hypothesis import settings
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from firmware_sim.firmware.codes import HardwareError, StatusError
from firmware_sim.firmware.control_table import Register
from firmware_sim.tables import find_model

from .plain_servo import GOALS, LEADING, PlainServo
from .solo import Solo, raw

TABLE = find_model("xm430-w350").table
MEASURED = {"Realtime Tick", "Moving", "Moving Status", "Model Number", "Model Information"} | {
    r.name for r in TABLE.registers if r.name.startswith("Present") or "Trajectory" in r.name
}
CAUSES = {"Temperature Limit", "Min Voltage Limit", "Max Voltage Limit", "Bus Watchdog"}
"""Registers that let errors happen by themselves: `test_shutdown` and `expire` are for them."""

KEPT = [r for r in TABLE.registers if r.name not in MEASURED and "Indirect" not in r.name]
WRITTEN = [r for r in TABLE.registers if r.name not in CAUSES and "Indirect" not in r.name]
TUNED = (
    "Startup Configuration",
    "Profile Velocity",
    "Profile Acceleration",
    "Position P Gain",
    "Feedforward 1st Gain",
)
OPTIONS = ((), ("ID",), ("ID", "Baud Rate"))


@st.composite
def writes(draw: st.DrawFn) -> tuple[Register, int]:
    """Draw a register and a value that its bytes can hold, often just in or out of its range."""
    register = draw(st.sampled_from(WRITTEN))
    low = -(256**register.size) // 2 if register.signed else 0
    high = low + 256**register.size - 1
    ends = (register.minimum, register.maximum)
    near = [e + d for e in ends for d in (-1, 0, 1) if low <= e + d <= high]
    inside = st.integers(*ends)
    value = draw(st.sampled_from([register.default, *near]) | inside | st.integers(low, high))
    return register, value


class AnyServo(RuleBasedStateMachine):
    """What was written must be read; what was refused must have changed nothing."""

    def __init__(self) -> None:
        super().__init__()
        self.solo = Solo(start_tick=1000)
        self.servo = self.solo.servo
        self.plain = PlainServo(TABLE)
        self.stopped = False
        """Whether the bus watchdog has stopped it where it was, since the torque came on."""
        self.look_at_the_horn()

    def look_at_the_horn(self) -> None:
        """Tell the plain servo where its goal was put."""
        self.plain.values["Goal Position"] = self.solo.read("Goal Position")

    def counting(self) -> tuple[int, int]:
        """What positions start anew from when it changes: mode and direction."""
        return self.plain.values["Operating Mode"], self.plain.values["Drive Mode"] & 1

    def check(self, error: StatusError, register: Register, value: int) -> None:
        """Compare a write's error, and let the plain servo do it too."""
        assert error == self.plain.refuses(register, value), register
        if error:
            return
        before = self.counting()
        self.plain.write(register, value)
        if self.counting() != before:
            assert self.solo.read("Goal Position") == self.solo.read("Present Position")
            self.look_at_the_horn()

    @rule(write=writes())
    def write(self, write: tuple[Register, int]) -> None:
        register, value = write
        self.check(self.solo.write(register.name, value), register, value)

    @rule(mode=st.sampled_from((0, 1, 3, 4, 5, 16)))
    def change_mode(self, mode: int) -> None:
        self.check(self.solo.write("Operating Mode", mode), TABLE["Operating Mode"], mode)

    @rule(on=st.integers(0, 1))
    def switch_torque(self, on: int) -> None:
        self.check(self.solo.write("Torque Enable", on), TABLE["Torque Enable"], on)

    @rule(name=st.sampled_from(sorted(GOALS)), goal=st.integers(-1200, 4200))
    def go(self, name: str, goal: int) -> None:
        self.check(self.solo.write(name, goal), TABLE[name], goal)

    @rule(name=st.sampled_from(TUNED), value=st.integers(0, 3))
    def tune(self, name: str, value: int) -> None:
        self.check(self.solo.write(name, value), TABLE[name], value)

    @rule(write=writes())
    def register(self, write: tuple[Register, int]) -> None:
        register, value = write
        error = self.servo.register_write(register.address, raw(value, register.size))
        assert error == self.plain.refuses(register, value)
        if not error:
            self.plain.registered = (register, value)
            self.plain.values["Registered Instruction"] = 1

    @rule()
    def act(self) -> None:
        kept, self.plain.registered = self.plain.registered, None
        self.plain.values["Registered Instruction"] = 0
        error = self.servo.act()
        if kept is None:
            assert error == StatusError.INSTRUCTION
        else:
            self.check(error, *kept)

    @rule(number=st.integers(1, 3), place=st.sampled_from([64, 65, 68, 84, 85, 230, 300, 661]))
    def aim(self, number: int, place: int) -> None:
        name = f"Indirect Address {number}"
        self.check(self.solo.write(name, place), TABLE[name], place)

    @rule(number=st.integers(1, 3), value=st.integers(0, 255))
    def write_indirectly(self, number: int, value: int) -> None:
        target = TABLE.at(self.plain.values[f"Indirect Address {number}"])
        error = self.servo.write(223 + number, bytes((value,)))
        if target is None:
            assert error == StatusError.ACCESS
        elif target.size > 1:
            assert error == StatusError.DATA_LENGTH
        else:
            self.check(error, target, value)

    @rule(duration=st.floats(0.0, 1.0))
    def wait(self, duration: float) -> None:
        self.solo.wait(duration)

    @rule()
    def expire(self) -> None:
        """Let the bus watchdog run out, if the torque comes on and it watches."""
        self.servo.feed(self.solo.world.now)
        self.switch_torque(1)
        self.check(self.solo.write("Bus Watchdog", 1), TABLE["Bus Watchdog"], 1)
        watches = self.plain.values["Torque Enable"] and self.plain.values["Protocol Type"] == 2
        self.solo.wait(0.03)
        if watches and self.plain.values["Bus Watchdog"] == 1:
            self.plain.expire()
            self.stopped = True
            if self.plain.values["Operating Mode"] not in LEADING:
                self.look_at_the_horn()
        if self.plain.values["Bus Watchdog"] == 1:
            self.check(self.solo.write("Bus Watchdog", 0), TABLE["Bus Watchdog"], 0)

    @rule()
    def clear_watchdog(self) -> None:
        self.check(self.solo.write("Bus Watchdog", 0), TABLE["Bus Watchdog"], 0)

    @rule(error=st.sampled_from(HardwareError))
    def fail(self, error: HardwareError) -> None:
        self.servo.raise_hardware_error(error)
        self.plain.values["Hardware Error Status"] |= error
        if error & self.plain.values["Shutdown"]:
            self.plain.shut_down = True
            self.plain.values["Torque Enable"] = 0

    @rule()
    def reboot(self) -> None:
        self.servo.reboot()
        self.plain.boot()
        self.look_at_the_horn()

    @rule(kept=st.sampled_from(OPTIONS))
    def factory_reset(self, kept: tuple[str, ...]) -> None:
        self.servo.factory_reset("ID" in kept, "Baud Rate" in kept)
        self.plain.factory_reset(kept)
        self.look_at_the_horn()

    @rule()
    def back_up(self) -> None:
        error = self.servo.backup()
        assert bool(error) == bool(self.plain.values["Torque Enable"])
        if not error:
            self.plain.store()

    @rule()
    def restore(self) -> None:
        error = self.servo.restore()
        assert bool(error) == bool(self.plain.values["Torque Enable"] or not self.plain.backup)
        if not error:
            self.plain.restore()
            self.look_at_the_horn()

    @invariant()
    def registers_hold_what_they_should(self) -> None:
        for register in KEPT:
            assert self.solo.read(register.name) == self.plain.values[register.name], register

    @invariant()
    def indirect_data_are_the_bytes_aimed_at(self) -> None:
        aims = [self.plain.values[f"Indirect Address {number}"] for number in range(1, 29)]
        error, data = self.servo.read(224, 28)
        assert error == StatusError.NONE
        assert list(data) == [self.plain.byte_at(target) for target in aims]

    @invariant()
    def identity_follows_the_registers(self) -> None:
        now, servo = self.plain.values, self.servo
        assert (servo.servo_id, servo.protocol) == (now["ID"], now["Protocol Type"])
        assert servo.return_delay == now["Return Delay Time"] * 2e-6
        assert servo.status_return_level == now["Status Return Level"]
        assert bool(servo.alert) == bool(now["Hardware Error Status"])

    @invariant()
    def torque_drives_or_does_not(self) -> None:
        assert self.solo.axis.torque_on == bool(self.plain.values["Torque Enable"])
        if not self.solo.axis.torque_on:
            assert self.solo.read("Present PWM") == self.solo.read("Present Current") == 0
            self.stopped = False

    @invariant()
    def no_goal_leads_out_of_the_limits(self) -> None:
        now, axis = self.plain.values, self.solo.axis
        low, high = now["Min Position Limit"], now["Max Position Limit"]
        if now["Operating Mode"] != 3 or not axis.torque_on or self.stopped or low > high:
            return
        ticks = round(axis.reference_goal / (2.0 * math.pi) * 4096)
        led = (-ticks if now["Drive Mode"] & 1 else ticks) + self.plain.offset()
        assert any(low <= led + turn * 4096 <= high for turn in range(-300, 300))


AnyServo.TestCase.settings = settings(max_examples=50, stateful_step_count=50, deadline=None)
TestAnyServo = AnyServo.TestCase
