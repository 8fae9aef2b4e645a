"""`armsyn reach`: a human-like reach on a real or simulated arm."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.arm_options import (
    DEFAULT_ARM,
    arm_of,
    arm_options,
    calibration_of,
    port_text,
    started,
)
from armsyn.cli.choices import IKS, MODELS, PLANS
from armsyn.cli.operating import own_process_option
from armsyn.cli.orientation_options import orientation_of, orientation_options

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription


@click.command()
@click.option(
    "--target",
    type=float,
    nargs=3,
    required=True,
    metavar="X Y Z",
    help="Where the hand goes: metres, arm base frame (koch faces -x).",
)
@orientation_options
@arm_options
@click.option("--rate", "rate_hz", type=float, default=200.0, show_default=True, help="Hz.")
@click.option(
    "--plan",
    type=PLANS,
    help="Roll-out with a learned synergy, whole motion predicted from captured ones (latent,"
    " linear), or a rule.  [default: latent for arms with an atlas, else synergy]",
)
@click.option("--ik", type=IKS, help="Optimiser of --plan synergy.  [default: svd]")
@click.option("--model", type=MODELS, help="Synergy model of --plan synergy.  [default: C]")
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
    help="Write what was commanded and measured (.npz or .csv), over a file of that name.",
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

    The reach is predicted from captured people (--plan), slowed as a whole until the arm's limits
    hold, and checked as a whole before torque goes on; a hand that would speed up twice is brought
    nearer to minimum jerk, and where it would touch something it is tried with the elbow
    elsewhere. How far a target lies outside what was captured is said. Afterwards
    the arm holds the target with its torque on; --park puts it to rest and lets go. Ctrl-C
    decelerates and, if the way is short and checked, goes to the rest posture; a second Ctrl-C
    holds at once.
    """
    from armsyn.cli.compiling import telling_of_compilation
    from armsyn.cli.reach_plot import draw_speeds
    from armsyn.cli.reach_report import report
    from armsyn.cli.reach_run import run, warm_up
    from armsyn.driver import check_recording_path, save_recording
    from armsyn.errors import InputError
    from armsyn.planning import planner_for

    name, directory = options["arm_name"] or DEFAULT_ARM, options["calibration"]
    _check(options)
    arm = arm_of(options).slowed(options["slower"])
    orientation = orientation_of(options)
    model = "A" if options["raw"] else options["model"]
    if options["record"]:
        check_recording_path(options["record"])
    with ExitStack() as stack:
        with telling_of_compilation():
            planner = planner_for(arm, options["plan"], directory, ik=options["ik"], model=model)
            if not getattr(planner, "complete", True):
                click.echo(
                    f"learning of {name}'s synergies was interrupted: run armsyn learn", err=True
                )
            port = options["port"] or stack.enter_context(started(arm, directory, options["plant"]))
            simulated = not options["port"]
            _say_port(arm, port, simulated=simulated, options=options)
            warm_up(planner, orientation, options)
        done = run(planner, orientation, port, options, simulated=simulated)
    # However the arm was left is said first; what could not be written comes after it
    failed: list[InputError] = []
    written: dict[str, Path | None] = {"record": None, "plot": None}
    writers: dict[str, Callable[[Path], None]] = {
        "record": lambda path: save_recording(path, done.recording, arm),
        "plot": lambda path: draw_speeds(path, done, directory),
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
    if options["raw"] and options["model"]:
        raise InputError("--raw is model A: give either --raw or --model")
    if options["orientation_tolerance"] and not (options["pointing"] or options["orientation"]):
        raise InputError("--orientation-tolerance needs --pointing or --orientation")
    plot = options["plot"]
    if plot and (plot.suffix.lower() != ".png" or not plot.parent.is_dir()):
        raise InputError(f"--plot {plot}: must end in .png, in a folder that exists")


def _say_port(arm: ArmDescription, port: str, *, simulated: bool, options: dict[str, Any]) -> None:
    bodies = " under gravity" if options["plant"] == "mujoco" else ""
    where = f"simulated {arm.name}{bodies} on {port} (firmware_sim; no hardware moves)"
    if not simulated:
        where = port_text(arm, port, calibration_of(arm, options))
    click.echo(where, err=options["as_json"])
