"""`armsyn reach`: a human-like reach on a real or simulated arm."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from armsyn.cli.arm_options import (
    DEFAULT_ARM,
    arm_of,
    arm_options,
    calibration_of,
    port_text,
    started,
)
from armsyn.cli.choices import IKS, MODELS
from armsyn.cli.operating import own_process_option

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.driver import Recording
    from armsyn.driver.stillness import Watched
    from armsyn.motion import FloatArray, Motion
    from armsyn.planning import PlannedReach, ReachPlanner


@dataclass(frozen=True)
class Done:
    """A reach that was made: what was planned, and what was recorded.

    Parameters
    ----------
    arm : ArmDescription
    start : array, shape (n,)
        Posture before it, rad.
    out : PlannedReach
    back : PlannedReach or None
        The way back, with ``--return``.
    recording : Recording
        Of both.
    """

    arm: ArmDescription
    start: FloatArray
    out: PlannedReach
    back: PlannedReach | None
    recording: Recording


class _Plan(NamedTuple):
    """What a reach is to be, from a start."""

    start: FloatArray
    out: PlannedReach
    back: PlannedReach | None
    trajectory: Motion
    park: Motion | None


@click.command()
@click.option(
    "--target",
    type=float,
    nargs=3,
    required=True,
    metavar="X Y Z",
    help="Where the hand goes: metres, arm base frame (koch faces -x).",
)
@arm_options
@click.option("--rate", "rate_hz", type=float, default=200.0, show_default=True, help="Hz.")
@click.option(
    "--ik",
    type=IKS,
    default="svd",
    show_default=True,
    help="Optimiser.",
)
@click.option(
    "--model",
    type=MODELS,
    help="Synergy model.  [default: C]",
)
@click.option("--raw", is_flag=True, help="The controller without synergy: the paper's S_A.")
@click.option(
    "--slower",
    type=float,
    default=1.0,
    metavar="FACTOR",
    help="Allow every motion only 1/FACTOR of the arm's speed (and the way to rest, too).",
)
@click.option("--return", "come_back", is_flag=True, help="Come back to where the hand started.")
@click.option("--park", is_flag=True, help="Afterwards go to the rest posture; torque off.")
@click.option(
    "--record",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write what was commanded and measured (.npz or .csv).",
)
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    metavar="FILE.png",
    help="Draw the hand's speed: captured, planned, measured, raw.",
)
@click.option(
    "--accept-no-watchdog",
    is_flag=True,
    help="Move servos that have no bus watchdog, too: nothing stops them if this program dies.",
)
@click.option(
    "--no-gravity", is_flag=True, help="Let goals not lead against what the arm's weight bends."
)
@click.option(
    "--realtime", is_flag=True, help="Ask the system for real-time scheduling while the arm moves."
)
@own_process_option
def reach(**options: Any) -> None:
    """Reach a target as a person would, on a real or simulated arm.

    The reach uses the synergy of the nearest learned target, slowed as a whole until the arm's
    limits hold. It is checked as a whole before torque goes on. Afterwards the arm holds the
    target with its torque on; --park puts it to rest and lets go. Ctrl-C decelerates and, if the
    way is short and checked, goes to the rest posture; a second Ctrl-C holds at once.
    """
    from armsyn.arm import find_file
    from armsyn.cli.reach_report import draw_speeds, report
    from armsyn.driver import check_recording_path, save_recording
    from armsyn.errors import InputError
    from armsyn.planning import ReachPlanner
    from armsyn.synergy import load_library

    name, directory = options["arm_name"] or DEFAULT_ARM, options["calibration"]
    _check(options)
    arm = arm_of(options).slowed(options["slower"])
    library = load_library(find_file(name, ".synergies.json", directory))
    if options["raw"] and options["model"]:
        raise InputError("--raw is model A: give either --raw or --model")
    model = "A" if options["raw"] else options["model"] or "C"
    planner = ReachPlanner(arm, library, options["ik"], model)
    if not library.complete:
        click.echo(f"learning of {name}'s synergies was interrupted: run armsyn learn", err=True)
    if options["record"]:
        check_recording_path(options["record"])
    with ExitStack() as stack:
        port = options["port"] or stack.enter_context(started(arm, directory, options["plant"]))
        simulated = not options["port"]
        _say_port(arm, port, simulated=simulated, options=options)
        done = _reach(planner, port, options, simulated=simulated)
    # However the arm was left is said first; what could not be written comes after it
    failed: list[InputError] = []
    written: dict[str, Path | None] = {"record": None, "plot": None}
    writers: dict[str, Callable[[Path], None]] = {
        "record": lambda path: save_recording(path, done.recording, arm),
        "plot": lambda path: draw_speeds(path, done, planner),
    }
    for kind, write in writers.items():
        if options[kind]:
            try:
                write(options[kind])
                written[kind] = options[kind]
            except InputError as error:
                failed.append(error)
    first = failed[0] if failed else None
    status = report(done, **written, as_json=options["as_json"], failed=first)
    click.get_current_context().exit(status)


def _check(options: dict[str, Any]) -> None:
    """What can be known to be wrong before any port is opened."""
    import math

    from armsyn.cli.moving import check_slower
    from armsyn.errors import InputError

    if not all(math.isfinite(value) for value in options["target"]):
        raise InputError(f"--target must be three finite numbers of metres: {options['target']}")
    if not (math.isfinite(options["rate_hz"]) and 0 < options["rate_hz"] <= 2000):
        raise InputError(f"--rate must be above 0 and at most 2000 Hz, got {options['rate_hz']:g}")
    check_slower(options["slower"])
    plot = options["plot"]
    if plot and (plot.suffix.lower() != ".png" or not plot.parent.is_dir()):
        raise InputError(f"--plot {plot}: must end in .png, in a folder that exists")


def _say_port(arm: ArmDescription, port: str, *, simulated: bool, options: dict[str, Any]) -> None:
    bodies = " under gravity" if options["plant"] == "mujoco" else ""
    where = f"simulated {arm.name}{bodies} on {port} (firmware_sim; no hardware moves)"
    if not simulated:
        where = port_text(arm, port, calibration_of(arm, options))
    click.echo(where, err=options["as_json"])


def _reach(planner: ReachPlanner, port: str, options: dict[str, Any], *, simulated: bool) -> Done:
    run = _in_process if options["own_process"] else _in_session
    return run(planner, port, options, simulated=simulated)


def _in_session(
    planner: ReachPlanner, port: str, options: dict[str, Any], *, simulated: bool
) -> Done:
    """Plan and run; keep what was recorded also when a fault ends it."""
    from armsyn.cli.moving import with_progress
    from armsyn.cli.stream_report import keep
    from armsyn.driver import ArmSession

    arm, consent = planner.arm, options["accept_no_watchdog"]
    with ArmSession.open(
        port, arm, options["rate_hz"], simulated=simulated, accept_no_watchdog=consent
    ) as session:
        session.gravity, session.realtime = not options["no_gravity"], options["realtime"]
        plan = _planned(planner, session, options)
        try:
            recording = with_progress(lambda show: session.run(plan.trajectory, plan.park, show))
        except BaseException:
            keep(() if session.recording is None else (session.recording,), arm, options)
            raise
    return Done(arm, plan.start, plan.out, plan.back, recording)


def _in_process(
    planner: ReachPlanner, port: str, options: dict[str, Any], *, simulated: bool
) -> Done:
    """Plan from where the arm is, and run in a process of its own."""
    from armsyn.cli.moving import with_progress
    from armsyn.cli.stream_report import keep
    from armsyn.driver import ArmMonitor
    from armsyn.driver.process import Job, run_in_process

    arm = planner.arm
    with ArmMonitor.open(port, arm) as monitor:
        plan = _planned(planner, monitor, options)
    job = Job(
        port,
        arm,
        options["rate_hz"],
        ((plan.trajectory, plan.park),),
        simulated=simulated,
        accept_no_watchdog=options["accept_no_watchdog"],
        gravity=not options["no_gravity"],
        realtime=options["realtime"],
    )
    result = with_progress(lambda show: run_in_process(job, on_tick=show))
    if result.error is not None:
        keep(result.recordings, arm, options)
        raise result.error
    return Done(arm, plan.start, plan.out, plan.back, result.recordings[-1])


def _planned(planner: ReachPlanner, watched: Watched, options: dict[str, Any]) -> _Plan:
    """Plan from where the arm is: there, perhaps back, perhaps to rest."""
    import numpy as np

    from armsyn.driver import still_posture, straight_way
    from armsyn.planning import joined

    arm, start = planner.arm, still_posture(watched)
    out = planner.plan(start, np.array(options["target"]))
    trajectory, back = out.trajectory, None
    if options["come_back"]:
        assert trajectory.angles is not None  # noqa: S101 - planned
        back = planner.plan(trajectory.angles[-1], arm.chain.forward(start).tip)
        trajectory = joined(trajectory, back.trajectory)
    park = None
    if options["park"]:
        assert trajectory.angles is not None  # noqa: S101 - planned
        park = straight_way(trajectory.angles[-1], arm.rest, arm, options["rate_hz"])
    return _Plan(start, out, back, trajectory, park)
