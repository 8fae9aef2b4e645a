"""One servo under any sequence of instructions, against rules that must always hold."""

import hypothesis.strategies as st
from hypothesis import settings
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from firmware_sim.codes import HardwareError, StatusError
from firmware_sim.control_table import Access, Area, Register
from firmware_sim.rig import ServoSettings
from firmware_sim.servo import BOOT_TIME
from firmware_sim.tables import find_model

from .conftest import FACTORY, Bench

MODEL = find_model("xm430-w350")
WRITABLE = [
    r
    for r in MODEL.table.registers
    if r.access is Access.READ_WRITE
    # Changing these would end the conversation, not test it.
    and r.name not in ("ID", "Baud Rate", "Status Return Level", "Return Delay Time")
]
LATCHING = int(HardwareError.OVERLOAD)


class AnyServo(RuleBasedStateMachine):
    """A model of the memory beside the servo: what was written and not refused must be read."""

    def __init__(self) -> None:
        super().__init__()
        self.bench = Bench([ServoSettings(MODEL, 1, registers=FACTORY)])
        self.servo = self.bench.servos[0]
        self.eeprom: dict[str, int] = {}
        self.latched = False

    @rule(data=st.data(), register=st.sampled_from(WRITABLE))
    def write(self, data: st.DataObject, register: Register) -> None:
        value = data.draw(
            st.sampled_from([register.minimum, register.default, register.maximum])
            | st.integers(register.minimum, register.maximum)
        )
        locked = register.area is Area.EEPROM and self.bench.read(64)
        watchdog = self.bench.read(98)
        error = self.bench.write(register.address, value, register.size) & 0x7F
        if locked:
            assert error == StatusError.ACCESS
        if register.name.startswith("Goal") and watchdog == 255:
            assert error == StatusError.DATA_RANGE
        if error == StatusError.NONE:
            read = self.bench.read(register.address, register.size, signed=register.signed)
            assert read == value
            if register.area is Area.EEPROM:
                self.eeprom[register.name] = value

    @rule()
    def torque_on(self) -> None:
        error = self.bench.write(64, 1) & 0x7F
        assert error == (StatusError.RESULT_FAIL if self.latched else StatusError.NONE)

    @rule(goal=st.integers(-5000, 5000))
    def move(self, goal: int) -> None:
        self.bench.write(116, goal, 4)

    @rule(duration=st.floats(0.0, 1.0))
    def wait(self, duration: float) -> None:
        self.bench.wait(duration)

    @rule()
    def overload(self) -> None:
        self.servo.raise_hardware_error(HardwareError.OVERLOAD)
        self.latched = self.latched or bool(self.servo.memory.value("Shutdown") & LATCHING)

    @rule()
    def reboot(self) -> None:
        self.bench.ask(1, 0x08)
        self.bench.wait(BOOT_TIME)
        self.latched = False
        assert self.bench.read(64) == self.bench.read(98) == 0

    @invariant()
    def eeprom_keeps_what_was_written(self) -> None:
        for name, value in self.eeprom.items():
            assert self.servo.memory.value(name) == value, name

    @invariant()
    def a_shutdown_has_no_torque(self) -> None:
        if self.latched:
            assert self.bench.read(64) == self.bench.read(124, 2) == 0

    @invariant()
    def without_torque_it_settles(self) -> None:
        if not self.bench.read(64):
            assert self.bench.read(124, 2) == self.bench.read(126, 2) == 0

    @invariant()
    def the_output_stays_under_goal_pwm(self) -> None:
        self.bench.wait(0.001)  # a new cap counts from the next control period on
        assert abs(self.bench.read(124, 2)) <= abs(self.bench.read(100, 2)) + 1


AnyServo.TestCase.settings = settings(max_examples=40, stateful_step_count=30, deadline=None)
TestAnyServo = AnyServo.TestCase
