"""`armsyn stream`: a trajectory or a recording on a real or simulated arm."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.arm_options import arm_of, arm_options, connected
from armsyn.cli.choices import FiniteRange
from armsyn.cli.operating import consent_option, own_process_option

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.cli.arm_options import Connection
    from armsyn.driver import Recording
    from armsyn.driver.replay import Replay
    from armsyn.motion import Motion


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@arm_options
@click.option(
    "--rate",
    "rate_hz",
    type=FiniteRange(10.0, 2000.0),
    default=200.0,
    show_default=True,
    help="Commands a second.",
)
@click.option("--slower", type=float, metavar="FACTOR", help="Take FACTOR times the file's time.")
@click.option("--duration", type=float, metavar="S", help="Take S seconds instead.")
@click.option(
    "--loop",
    type=click.IntRange(1, 1000),
    default=1,
    show_default=True,
    metavar="N",
    help="Stream it N times, with straight ways back in between where it ends elsewhere.",
)
@click.option("--dry-run", is_flag=True, help="Check and say what to expect; nothing moves.")
@click.option("--park", is_flag=True, help="Afterwards go to the rest posture; torque off.")
@click.option(
    "--record",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write what was commanded and measured (.npz or .csv).",
)
@click.option(
    "--no-gravity", is_flag=True, help="Let goals not lead against what the arm's weight bends."
)
@click.option(
    "--realtime", is_flag=True, help="Ask the system for real-time scheduling while the arm moves."
)
@own_process_option
@consent_option
def stream(**options: Any) -> None:
    """Stream a trajectory or a recording to an arm.

    FILE is a motion with joint angles (.npz or .csv of armsyn-motion-1). Of a recording of a run,
    what was wanted of the arm then is streamed, and may come as near to things as it did; of one
    that `armsyn record` made, what was measured, smoothed. The arm first goes straight to where the
    file starts. Both ways are checked as a whole (ranges, speeds, accelerations, jerk, collisions)
    before torque goes on. Afterwards the arm holds; --park puts it to rest and lets go. Ctrl-C
    decelerates and, if the way is short and checked, goes to the rest posture; a second Ctrl-C
    holds at once.

    --dry-run without --port looks at the file and the arm's description only; with it, at the way
    from where the arm is, too.
    """
    from armsyn.cli.stream_report import print_expected, report
    from armsyn.driver import check_recording_path

    if options["record"]:
        check_recording_path(options["record"])
    arm = arm_of(options)
    replay = _prepared(arm, options)
    if options["dry_run"] and not options["port"]:
        print_expected(replay, arm, None, options)
        return
    with connected(options) as there:
        if options["dry_run"]:
            print_expected(replay, arm, _way_there(there, replay.motion, options), options)
            return
        recordings = _run(there, replay, options)
    status = report(recordings, replay, arm, options)
    click.get_current_context().exit(status)


def _prepared(arm: ArmDescription, options: dict[str, Any]) -> Replay:
    """The file's motion, scaled and checked."""
    from armsyn.cli.moving import check_slower
    from armsyn.driver.replay import load_replay, looped, slowed
    from armsyn.errors import InputError
    from armsyn.safety import check_trajectory

    if options["slower"] is not None and options["duration"] is not None:
        raise InputError("give either --slower or --duration")
    rate = options["rate_hz"]
    factor = 1.0 if options["slower"] is None else options["slower"]
    check_slower(factor)
    replay = load_replay(options["file"], arm, rate)
    motion = replay.motion
    if options["duration"] is not None:
        factor = options["duration"] / motion.duration
    motion = looped(slowed(motion, factor, rate), options["loop"], arm, rate)
    check_trajectory(motion, arm, margin=replay.margin)
    return replay._replace(motion=motion)


def _way_there(there: Connection, motion: Motion, options: dict[str, Any]) -> Motion | None:
    """The checked way from where the arm is to the motion's start; nothing is written."""
    from armsyn.driver import ArmMonitor, still_posture
    from armsyn.driver.replay import approach
    from armsyn.safety import check_trajectory

    with ArmMonitor.open(there.port, there.arm) as monitor:
        present = still_posture(monitor)
    way = approach(present, motion, there.arm, options["rate_hz"])
    if way is not None:
        check_trajectory(way, there.arm, present)
    return way


def _run(there: Connection, replay: Replay, options: dict[str, Any]) -> list[Recording]:
    """Go there and stream; returns a recording of each."""
    from armsyn.cli.moving import with_progress
    from armsyn.cli.stream_report import keep
    from armsyn.driver import straight_way
    from armsyn.driver.process import Job, run_here, run_in_process
    from armsyn.safety import check_trajectory

    arm, rate, motion = there.arm, options["rate_hz"], replay.motion
    park = None
    if options["park"]:
        assert motion.angles is not None  # noqa: S101 - of a replay
        park = straight_way(motion.angles[-1], arm.rest, arm, rate)
        check_trajectory(park, arm)
    way = _way_there(there, motion, options)
    motions = ((motion, park),) if way is None else ((way, None), (motion, park))
    job = Job(
        there.port,
        arm,
        rate,
        motions,
        simulated=there.simulated,
        accept_no_watchdog=options["accept_no_watchdog"],
        gravity=not options["no_gravity"],
        realtime=options["realtime"],
        margin=replay.margin,
    )
    run = run_in_process if options["own_process"] else run_here
    result = with_progress(lambda on_tick: run(job, on_tick=on_tick))
    if result.error is not None:
        keep(result.recordings, arm, options)
        raise result.error
    return list(result.recordings)
