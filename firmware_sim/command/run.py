"""What the command does: from its arguments to a simulator that serves."""

from __future__ import annotations

import argparse
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, NoReturn

from firmware_sim.command.stopping import catch_stops
from firmware_sim.command.words import complain, say
from firmware_sim.errors import OutputError, RigError
from firmware_sim.rig.settings import (
    Rig,
    ServoSettings,
    check_ids,
    parse_servo,
    with_baud_rate,
    with_protocol,
)

if TYPE_CHECKING:
    from firmware_sim.command.attachments import Attachments
    from firmware_sim.command.pty_port import PtyPort
    from firmware_sim.command.server import Server
    from firmware_sim.faults.spec import FaultSpec
    from firmware_sim.rig.state_file import SavedState

_MAX_RETURN_DELAY = 254

_OPTIONS = {"baud": "Baud Rate", "return_delay": "Return Delay Time", "protocol": "Protocol Type"}
"""Options, and the registers that they set."""

_OVERRIDDEN_SHOWN = 5

_FILES = ("rig", "scenario", "state", "trace", "control", "link")
"""Options that name a file; one file cannot be two of them."""

_QUIET_START = 3.0
"""A start that takes longer explains itself, s."""


def choose_rig(arguments: argparse.Namespace) -> Rig:
    """Return what a command line asks to be simulated.

    Raises
    ------
    RigError
        If it asks for the impossible.
    """
    if arguments.servo:
        rig = Rig([parse_servo(text) for text in arguments.servo])
        check_ids(rig.servos)
    else:
        rig = _read_rig(arguments)
    return replace(rig, servos=[_override(servo, arguments) for servo in rig.servos])


def _read_rig(arguments: argparse.Namespace) -> Rig:
    from firmware_sim.rig.arm_search import find_arm  # noqa: PLC0415 - no TOML reader for --servo
    from firmware_sim.rig.file import SET_UP, read_rig  # noqa: PLC0415

    if arguments.rig:
        return read_rig(arguments.rig)
    return read_rig(find_arm(arguments.arm, arguments.calibration), SET_UP)


def _override(servo: ServoSettings, arguments: argparse.Namespace) -> ServoSettings:
    """Return a servo with what the command line sets for all."""
    if arguments.protocol is not None:
        servo = with_protocol(servo, arguments.protocol)
    if arguments.baud is not None:
        servo = with_baud_rate(servo, arguments.baud)
    delay = arguments.return_delay
    if delay is None:
        return servo
    if not 0 <= delay <= _MAX_RETURN_DELAY:
        raise RigError(f"--return-delay {delay} is not 0 to 254 (of 2 us)")
    return servo.with_registers({"Return Delay Time": delay})


def serve(arguments: argparse.Namespace) -> None:
    """Simulate until a signal or the end of standard input.

    Parameters
    ----------
    arguments : argparse.Namespace
        Of `arguments.build_parser`.

    Raises
    ------
    SimulatorError
        If what they ask for is not possible; nothing has been made then.
    """
    check_files(arguments)
    rig = choose_rig(arguments)
    catch_stops(_leave)
    with ExitStack() as stack:
        with _explained(), _without_scipy():
            server, port = _prepare(rig, arguments, stack)
        server.run(lambda: _announce(port.name, rig.servos))


def check_files(arguments: argparse.Namespace) -> None:
    """Refuse options that name one file: one of them would be overwritten.

    Raises
    ------
    OutputError
        If two do.
    """
    owners: dict[Path, str] = {}
    for option in _FILES:
        path = getattr(arguments, option)
        if path is None:
            continue
        whole = path.parent.resolve() / path.name if option == "link" else path.resolve()
        owner = owners.setdefault(whole, option)
        if owner != option:
            raise OutputError(f"{path} cannot be both --{owner} and --{option}", str(path))


def _leave(_number: int, _frame: FrameType | None) -> NoReturn:
    """End a simulator that has not begun to serve, with nothing left behind."""
    raise SystemExit(0)


def _prepare(rig: Rig, arguments: argparse.Namespace, stack: ExitStack) -> tuple[Server, PtyPort]:
    """Make everything, and leave in `stack` how it is undone."""
    from firmware_sim.assembly import build_simulation, warm_up  # noqa: PLC0415 - not for bad input
    from firmware_sim.clock import RealClock  # noqa: PLC0415
    from firmware_sim.command.attachments import Attachments  # noqa: PLC0415
    from firmware_sim.command.pty_port import PtyPort  # noqa: PLC0415
    from firmware_sim.command.server import Server  # noqa: PLC0415

    faults, seed = choose_faults(arguments)
    state = _read_state(rig, arguments, stack)
    stdin = _stdin() if arguments.exit_with_stdin else None
    mujoco = arguments.plant == "mujoco"
    warm_up(rig, mujoco)
    simulation = build_simulation(
        rig,
        gap_rule=not arguments.no_gap_rule,
        mujoco=mujoco,
        faults=faults,
        seed=seed,
        state=state,
        trace=arguments.trace,
        when=RealClock().now(),
    )
    port = PtyPort(arguments.link)
    stack.callback(port.close)
    names = [servo.name for servo in rig.servos]
    attachments = Attachments(simulation, port, names, stack)
    _attach(attachments, arguments)
    return Server(simulation, port, stdin, attachments.guests, attachments.chores), port


def _stdin() -> int:
    if sys.stdin is None:
        raise OutputError("--exit-with-stdin: standard input is closed", "standard input")
    return sys.stdin.fileno()


def _attach(attachments: Attachments, arguments: argparse.Namespace) -> None:
    if arguments.control:
        attachments.open_control(arguments.control)
    attachments.write_files(arguments.state, trace=bool(arguments.trace))
    if not arguments.no_table and sys.stderr is not None and sys.stderr.isatty():
        attachments.show_table()
        return
    if attachments.complaints:
        attachments.complain()
    if not arguments.control and (arguments.fault or arguments.scenario):
        attachments.tell_strikes()


def _read_state(rig: Rig, arguments: argparse.Namespace, stack: ExitStack) -> SavedState | None:
    """Return what the servos remember, but for what the command line says itself."""
    if not arguments.state:
        return None
    from firmware_sim.rig.state_file import lock_state, read_state  # noqa: PLC0415 - not for most

    arguments.state = arguments.state.resolve()
    stack.callback(lock_state(arguments.state).close)
    state = read_state(arguments.state, [servo.name for servo in rig.servos])
    if state is None:
        return None
    given = {name for option, name in _OPTIONS.items() if getattr(arguments, option) is not None}
    own = [
        {name: value for name, value in _settings_of(servo).items() if name in given}
        for servo in rig.servos
    ]
    state = state.with_registers(own)
    overridden = state.differences([{"ID": s.servo_id, **s.registers} for s in rig.servos])
    if overridden:
        shown = "; ".join(overridden[:_OVERRIDDEN_SHOWN])
        more = len(overridden) - _OVERRIDDEN_SHOWN
        tail = f"; and {more} more" if more > 0 else ""
        complain(f"as {arguments.state} says: {shown}{tail}")
    return state


def _settings_of(servo: ServoSettings) -> dict[str, int]:
    """Return the registers of a servo that the command line may set, as they are to be."""
    table = servo.model.table.by_name
    defaults = {name: table[name].default for name in _OPTIONS.values() if name in table}
    return {**defaults, **servo.registers}


def choose_faults(arguments: argparse.Namespace) -> tuple[list[FaultSpec], int]:
    """Return the faults that a command line asks for, and the seed of their chance.

    Raises
    ------
    FaultError
        If one makes no sense, or the scenario cannot be read.
    """
    if not (arguments.fault or arguments.scenario):
        return [], arguments.seed or 0
    from firmware_sim.faults.parsing import parse_fault  # noqa: PLC0415 - not for most
    from firmware_sim.faults.scenario import Scenario, check_seed, read_scenario  # noqa: PLC0415

    scenario = read_scenario(arguments.scenario) if arguments.scenario else Scenario(())
    seed = scenario.seed if arguments.seed is None else check_seed(arguments.seed)
    return [*scenario.faults, *map(parse_fault, arguments.fault)], seed or 0


def _announce(port_name: str, servos: Sequence[ServoSettings]) -> None:
    say(port_name)
    names = ", ".join(servo.name for servo in servos)
    complain(f"a simulation, no hardware: {names}")


@contextmanager
def _explained() -> Iterator[None]:
    """Say what takes so long, if it does: the physics are compiled once on each machine."""
    line = "starting; the first start compiles the physics, up to a minute"
    timer = threading.Timer(_QUIET_START, complain, (line,))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        timer.join()


@contextmanager
def _without_scipy() -> Iterator[None]:
    """Keep numba from importing SciPy for a BLAS that no physics here uses: 13 MB and 0.2 s."""
    if "scipy" in sys.modules:
        yield
        return
    sys.modules["scipy"] = None  # type: ignore[assignment]  # so import says "not there"
    try:
        yield
    finally:
        del sys.modules["scipy"]
