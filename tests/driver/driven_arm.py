"""A driver, an arm and an operator while things go wrong, as a state machine of hypothesis."""

from __future__ import annotations

import contextlib
import gc
import signal
import threading
from collections import Counter
from collections.abc import Callable, Iterable
from typing import ClassVar
from unittest.mock import patch

import hypothesis.strategies as st
import numpy as np
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from armsyn.driver import ArmSession, Ending, Recording
from armsyn.driver.budget import ErrorBudget
from armsyn.driver.joints import JointState
from armsyn.driver.operate import clear, release
from armsyn.driver.operate_reboot import Rebooter
from armsyn.driver.path import straight_way
from armsyn.driver.servos import ServoGroup
from armsyn.errors import ArmFaultError, ArmsynError
from firmware_sim.firmware.servo import Servo
from tests.driver.mixed_arm import AX, MX, mixed_arm
from tests.driver.stepped import SteppedArm
from tests.driver.troubles import RESTARTING, Trouble, idle_troubles, troubles
from tests.driver.verdict import NEAR_REST, check_latch, check_recording
from tests.driver.witness import Witness, register

RATE = 100.0
ARM = mixed_arm()
SPAN = np.array([0.8, 0.6, -0.8, 0.8, -0.6, 0.8])
"""rad from rest that the joints are sent to at most."""

READ_OFF = 0.06
"""rad that an answer may be off where the joint is at the tick's end: it moves meanwhile."""

CLEARED_OFF = 64
"""Ticks off where it stands to which a limp servo may be cleared: somebody may be moving it."""

HELD_OFF = 150
"""Ticks (0.23 rad) off where it stands at which a servo under torque may be held on: something may
be pulling it off what it holds, which stays its goal (`armsyn.driver.power.GOAL_TOLERANCE`)."""

RESTARTED = 1.0
"""Seconds in which a servo that restarts has lost its torque."""

CALM = 1.0
"""Seconds in which servos have started anew and joints have come to rest."""

COOLINGS, COOLING = 4, 300.0
"""How often servos with an error are switched off and on, and seconds that they cool down for."""

PATIENT = 10.0
"""Seconds of real time in which a setpoint function has come to its end."""

SETPOINTS = ("sound", "nan", "jump", "text", "raises", "slow", "ends", "outside")


class TheirError(Exception):
    """Of a caller's setpoint function."""


class DrivenArm(RuleBasedStateMachine):
    """Whatever goes wrong, the rules of `Witness` and of `tests.driver.verdict` are kept.

    Attributes
    ----------
    seen : Counter of str
        Steps, runs, faults and endings of all machines of this process.
    """

    seen: ClassVar[Counter[str]] = Counter()

    def __init__(self) -> None:
        super().__init__()
        self.stepped = SteppedArm(ARM)
        self.witness = Witness(self.stepped, RATE)
        self.session: ArmSession | None = None
        self.torque = self.stepped.torque()
        self.excused: dict[int, float] = {}
        self.refused = ""
        self.before = 0.0
        self.everybody = ServoGroup(self.stepped.bus, ARM.servo)
        self.held = held()

    @rule(
        way=st.lists(st.floats(0.0, 1.0), min_size=6, max_size=6),
        park=st.booleans(),
        gravity=st.booleans(),
        wrong=st.lists(troubles(ARM), max_size=3),
    )
    def move(self, way: list[float], park: bool, gravity: bool, wrong: list[Trouble]) -> None:
        """Go somewhere, and perhaps to rest, while things go wrong."""
        session = self.ready(gravity=gravity)
        if session is None:
            return
        with contextlib.suppress(ArmFaultError):
            here, goal = session.read_posture(), ARM.rest + SPAN * way
            out = straight_way(here, goal, ARM, RATE)
            back = straight_way(goal, ARM.rest, ARM, RATE) if park else None
            self.run(wrong, lambda: session.run(out, back, self.look), parking=park)

    @rule(
        kind=st.sampled_from(SETPOINTS),
        speed=st.floats(-0.6, 0.6),
        gravity=st.booleans(),
        wrong=st.lists(troubles(ARM), max_size=2),
    )
    def follow(self, kind: str, speed: float, gravity: bool, wrong: list[Trouble]) -> None:
        """Follow a function of the caller's that is sound or worse."""
        session = self.ready(gravity=gravity)
        if session is not None:
            function = setpoints(kind, speed, self.stepped)
            self.run(wrong, lambda: session.run_setpoint(function, 0.6, self.look))

    def ready(self, *, gravity: bool) -> ArmSession | None:
        """Return a session that may run; the operator clears what a fault has latched."""
        if self.session is not None and self.session.fault is not None:
            self.disconnect()
        if self.session is None:
            self.connect()
        if self.session is None:
            self.operate("clear", 0)
            self.connect()
        if self.session is not None:
            self.session.gravity = gravity
        return self.session

    def connect(self) -> None:
        """A session opens, unless something is wrong with the arm; nothing is written."""
        if self.stepped.bus.serial_port.lost:
            self.stepped.bus.reopen()
        try:
            self.session = self.stepped.session(RATE, accept_no_watchdog=True)
        except ArmFaultError as error:
            self.refused = str(error)
        else:
            stopped = [s.servo_id for s in self.stepped.servos if stopped_by_watchdog(s)]
            assert not stopped, f"servos {stopped} were stopped, and nobody has cleared the arm"

    def disconnect(self) -> None:
        """The port is given back."""
        assert self.session is not None
        self.session.close()
        self.session = None
        assert self.stepped.bus.serial_port.lost
        assert not self.stepped.bus.is_open

    @rule(
        what=st.sampled_from(("clear", "reboot", "release", "end")),
        number=st.integers(0, len(ARM.servo) - 1),
    )
    def operate(self, what: str, number: int) -> None:
        """The operator does something, as a program of its own would."""
        if self.session is not None:
            self.disconnect()
        self.stepped.bus.reopen()
        self.witness.begin(what)
        match what:
            case "clear":
                self.clear()
            case "release":
                self.let_go()
            case "reboot":
                self.reboot(number)
        self.witness.begin("")

    def clear(self) -> None:
        """The operator looks at the arm and clears it: all servos stay where they are."""
        with contextlib.suppress(ArmFaultError):
            clear(self.everybody)
        for servo_id, goal in (one for goals in self.witness.before for one in goals.items()):
            servo = self.stepped.by_id[servo_id]
            here, holds = register(servo, "Present Position"), register(servo, "Torque Enable")
            allowed = HELD_OFF if holds else CLEARED_OFF
            assert abs(goal - here) <= allowed, f"cleared to {goal}, stands at {here}"

    def let_go(self) -> None:
        """The operator supports the arm and releases it."""
        with contextlib.suppress(ArmFaultError):
            release(self.everybody)
            assert not any(self.stepped.torque())
        self.excuse(self.witness.let_go)

    def reboot(self, number: int) -> None:
        """The operator restarts a servo that reports an error, or any."""
        latched = [servo.servo_id for servo in self.stepped.servos if in_error(servo)]
        servo_id = latched[0] if latched else ARM.servo[number].id
        self.excuse([servo_id])
        if servo_id in (MX, AX):  # they have no such instruction: pull their plug
            self.stepped.by_id[servo_id].power_cycle()
        with contextlib.suppress(ArmFaultError):
            Rebooter(self.everybody, self.stepped).reboot(servo_id)

    @rule(trouble=idle_troubles(ARM), pause=st.floats(0.01, 1.0))
    def go_wrong(self, trouble: Trouble, pause: float) -> None:
        """Something goes wrong while nothing runs."""
        self.happen(trouble)
        self.wait(pause)

    def wait(self, duration: float) -> None:
        """Nothing is asked of the arm."""
        self.stepped.port.wait_until(self.stepped.now() + duration)
        self.stepped.port.simulation.catch_up(self.stepped.now())

    @precondition(lambda self: self.session is None or self.session.fault is not None)
    @rule()
    def mend(self) -> None:
        """All is put right, the operator clears the arm: it must work as on the first day."""
        if self.session is not None:
            self.disconnect()
        self.put_right()
        self.connect()
        assert self.session is not None, self.refused
        here = self.session.read_posture()
        self.witness.begin("run")
        with patch.object(gc, "collect"):
            recording = self.session.run(straight_way(here, here, ARM, RATE), on_tick=self.look)
        assert recording.ending is Ending.COMPLETED, recording.events
        check_recording(self.witness, recording, None)
        self.witness.begin("")
        self.seen["mended"] += 1

    def put_right(self) -> None:
        """Undo all that went wrong, with a screwdriver and all the time in the world."""
        if self.stepped.port.simulation.faults:
            self.stepped.port.simulation.clear("all")
        self.wait(CALM)
        for _ in range(COOLINGS):
            ill = [servo for servo in self.stepped.servos if in_error(servo)]
            for servo in ill:
                self.excuse([servo.servo_id])
                servo.power_cycle()
            self.wait(COOLING if ill else CALM)
        self.stepped.bus.budget = ErrorBudget()  # as a program has that starts anew
        self.operate("clear", 0)
        low, high = ARM.chain.lower + 0.01, ARM.chain.upper - 0.01
        here = self.stepped.positions()
        if ((here < low) | (here > high)).any():
            self.operate("release", 0)
            ticks = ARM.calibration.to_ticks(np.clip(here, low, high)).tolist()
            self.stepped.port.hands.turn(dict(zip(self.witness.range, ticks, strict=True)))
            self.wait(1.0)

    def run(
        self, wrong: list[Trouble], act: Callable[[], Recording], *, parking: bool = False
    ) -> None:
        """Run something, and judge how it went and how it left the arm."""
        session, before = self.session, self.stepped.torque()
        assert session is not None
        for trouble in wrong:
            self.stepped.at(trouble.after, lambda trouble=trouble: self.happen(trouble))
        self.witness.begin("run")
        error: BaseException | None = None
        try:
            with patch.object(gc, "collect"):  # of a test's large heap it takes longer than the run
                ended = act().ending.name
        except (ArmsynError, TheirError) as raised:
            error, ended = raised, type(raised).__name__
        self.stepped.forget_events()
        self.seen.update(["runs", ended])
        witness = self.witness
        if witness.streamed:
            assert session.recording is not None
            check_recording(witness, session.recording, error)
            assert not witness.let_go or parking, "dropped without being asked"
            assert witness.off_rest < NEAR_REST or witness.disturbed, "let go away from rest"
        else:
            found = {s.servo_id for s, on in zip(self.stepped.servos, before, strict=True) if on}
            assert not witness.let_go & found, "an arm that held itself was dropped"
            if session.fault is None:
                assert self.torque_on() <= found, "left with torque though nothing moved"
        self.excuse(witness.let_go)
        if session.fault is not None:
            check_latch(witness, session, error)
        witness.begin("")

    def torque_on(self) -> set[int]:
        """IDs of the servos that are under torque."""
        on = zip(self.stepped.servos, self.stepped.torque(), strict=True)
        return {servo.servo_id for servo, torque in on if torque}

    def look(self, *_: float) -> None:
        """What the driver takes for an answer is where the joint is."""
        assert self.session is not None
        if self.witness.disturbed:
            return
        state = self.session._joints._state
        lines = bool(self.stepped.port.simulation.faults)  # a checksum of 8 bits is not much
        sure = [servo.protocol == 2 or not lines for servo in ARM.leaders]
        off = np.abs(state.position - self.stepped.positions())[state.fresh & sure]
        assert (off < READ_OFF).all(), f"took an answer that is {off.max():.3f} rad off"

    def happen(self, trouble: Trouble) -> None:
        """Let something go wrong now."""
        stepped, simulation = self.stepped, self.stepped.port.simulation
        if trouble.name == "stop":
            if self.session is not None:
                self.session.stops.request()
        elif trouble.name == "stall":
            stepped.clock.advance(float(trouble.what.partition(":")[2]))
        elif trouble.name == "close":
            stepped.bus.serial_port.close()
        elif trouble.name == "torque-off":
            servo = stepped.by_id[trouble.servo_id]
            type(servo).write(servo, servo.model.table["Torque Enable"].address, b"\x00")
        else:
            simulation.catch_up(stepped.now())
            end = "," if ":" in trouble.what else ":"
            which = f"{end}id={trouble.servo_id}" if trouble.servo_id else ""
            simulation.inject(trouble.what + which)
        if trouble.name in RESTARTING:
            everybody = {servo.servo_id for servo in stepped.servos}
            self.excuse({trouble.servo_id} if trouble.servo_id else everybody)

    def excuse(self, servo_ids: Iterable[int]) -> None:
        """Let servos lose their torque within the time that restarting takes."""
        self.excused |= dict.fromkeys(servo_ids, self.stepped.now() + RESTARTED)

    @invariant()
    def nothing_falls(self) -> None:
        """Torque goes off by an error of the servo's own, or because somebody asked for it."""
        self.seen["steps"] += 1
        now = self.stepped.torque()
        for servo, was, on in zip(self.stepped.servos, self.torque, now, strict=True):
            excused = self.excused.get(servo.servo_id, -1.0) >= self.before
            assert not was or on or in_error(servo) or excused, (
                f"servo {servo.servo_id} has lost its torque"
            )
        self.torque, self.before = now, self.stepped.now()

    @invariant()
    def no_rule_is_broken(self) -> None:
        """None of those that the witness knows."""
        assert not self.witness.broken, self.witness.broken

    @invariant()
    def all_is_given_back(self) -> None:
        """Signals, threads and the collector are as they were."""
        for thread in threading.enumerate():
            if thread.name == "armsyn setpoint":  # on a busy machine it may count as stuck
                thread.join(PATIENT)
        assert held() == self.held


def held() -> tuple[object, ...]:
    """What a run takes over for its time."""
    handlers = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    return (*handlers, threading.active_count(), gc.isenabled(), gc.get_freeze_count() > 0)


def in_error(servo: Servo) -> bool:
    """Whether a servo reports a hardware error, or has shut itself down."""
    if servo.protocol == 1:
        return bool(servo.firmware.error_bits) or register(servo, "Torque Limit") == 0
    return bool(servo.alert)


def stopped_by_watchdog(servo: Servo) -> bool:
    """Whether a servo hears, and its bus watchdog has stopped it."""
    watched = "Bus Watchdog" in servo.model.table.by_name
    return watched and servo.hears and register(servo, "Bus Watchdog") in (-1, 255)


def setpoints(kind: str, speed: float, stepped: SteppedArm) -> Callable[..., object]:
    """Return a setpoint function: it moves the first joint, and then does what its kind says."""
    start: list[np.ndarray] = []

    def sound(t: float, state: JointState) -> np.ndarray:
        if not start:
            start.append(state.position.copy())
        posture = start[0].copy()
        posture[0] += speed * t**3 / (0.2 + t**2)
        return posture

    def setpoint(t: float, state: JointState) -> object:
        posture = sound(t, state)
        if t < 0.3:
            return posture
        if kind == "raises":
            raise TheirError
        if kind == "slow":
            stepped.clock.advance(0.2)
        wrong = {
            "nan": posture * np.nan,
            "jump": posture + 0.3,
            "text": "there",
            "ends": None,
            "outside": posture + 10.0 * (t - 0.3),
        }
        return wrong.get(kind, posture)

    return setpoint
