"""`armsyn track`: follow targets that come while the arm moves."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.arm_options import connected, which_arm_options
from armsyn.cli.choices import IKS, MODELS, FiniteRange
from armsyn.cli.operating import consent_option
from armsyn.cli.orientation_options import orientation_options

if TYPE_CHECKING:
    from armsyn.cli.arm_options import Connection
    from armsyn.cli.track_feed import TargetFeed
    from armsyn.cli.track_lines import LineReader
    from armsyn.cli.track_teller import Teller
    from armsyn.driver import ArmSession, Recording
    from armsyn.planning.tracking_plan import LawPlanner

SWITCH_S = 5e-4
"""Seconds after which the thread that plans gives way to a tick; Python's own are 5 ms, a tick."""

LONGEST_S = 1e6
"""Seconds; eleven days."""

RECORDED_S, _UNRECORDED_S = 3600.0, 10.0
"""Seconds that are kept, and the same where nobody wants a record."""


@click.command()
@which_arm_options
@click.option("--json", "as_json", is_flag=True, help="Every event as a line of JSON.")
@click.option(
    "--rate",
    "rate_hz",
    type=FiniteRange(10.0, 2000.0),
    default=200.0,
    show_default=True,
    help="Commands a second.",
)
@click.option("--ik", type=IKS, help="Optimiser, of learned reaches' synergies.  [default: svd]")
@click.option("--model", type=MODELS, help="Synergy model, of the same.  [default: C]")
@orientation_options
@click.option(
    "--slower",
    type=float,
    default=1.0,
    metavar="FACTOR",
    help="Allow only 1/FACTOR of the arm's speed.",
)
@click.option(
    "--each", is_flag=True, help="Turn to a target only when the hand is at the one before."
)
@click.option(
    "--longest",
    type=FiniteRange(1.0, LONGEST_S),
    metavar="S",
    help="Come to rest after so many seconds, whatever is still to come.  [default: never]",
)
@click.option("--park", is_flag=True, help="Afterwards go to the rest posture; torque off.")
@click.option(
    "--record",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write what was commanded and measured (.npz or .csv), at most an hour at 200 Hz.",
)
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    metavar="FILE.png",
    help="Draw targets, hand and its speed.",
)
@click.option(
    "--no-gravity", is_flag=True, help="Let goals not lead against what the arm's weight bends."
)
@click.option(
    "--realtime", is_flag=True, help="Ask the system for real-time scheduling while the arm moves."
)
@consent_option
def track(**options: Any) -> None:
    """Follow targets that come as lines of JSON on standard input.

    \b
    {"target": [0.42, -0.25, -0.05]}
    {"target": [0.40, 0.15, 0.02], "t": 0.7, "id": "second"}
    {"target": [0.35, -0.10, -0.15], "pointing": [0, 0, -1]}

    Metres, arm base frame. A hand is turned as its line says ("pointing": a direction, or
    "orientation": roll, pitch and yaw in degrees), else as --pointing or --orientation say.
    It moves by the controller with the synergy of the place, by the arm's atlas; without an
    atlas, with --ik or --model, or where that one does not arrive, with that of the nearest
    learned reach. A new target may come at any moment: the hand turns to it from
    wherever it is, at the speed that it has. Of targets that have come together the newest that
    can be reached counts (--each goes to one after the other); one with "t" waits until so many
    seconds after the start, and holds up no other. A line that is no target, or whose target
    cannot be reached, is answered by its number on standard error, and the arm goes on to the last
    good one; without a new one it holds. What comes before the arm is ready (a line says so) waits.

    At the end of the input the last motion is finished, and the arm holds; --park puts it to
    rest and lets go. It all runs in one process: the --own-process of other commands is for
    motions that are known beforehand. Ctrl-C decelerates and, if the way is short and checked,
    goes to the rest posture; a second Ctrl-C holds at once. With --json every event is one line
    of JSON.
    """  # noqa: D301 - after \b click leaves a paragraph as it stands
    from armsyn.cli.compiling import telling_of_compilation
    from armsyn.cli.orientation_options import orientation_of
    from armsyn.cli.track_lines import LineReader
    from armsyn.cli.track_report import check_plot
    from armsyn.cli.track_teller import Teller
    from armsyn.driver import check_recording_path
    from armsyn.errors import ArmsynError, InputError
    from armsyn.planning.tracking_plan import LawPlanner
    from armsyn.planning.tracking_sources import sources_of

    if sys.stdin is None:
        raise InputError("there is no standard input to read targets from")
    reader = LineReader(sys.stdin.fileno())
    context = click.get_current_context()
    if options["record"]:
        check_recording_path(options["record"])
    check_plot(options["plot"])
    orientation_of(options)  # refuses what is none
    teller = Teller(as_json=options["as_json"], keeping=bool(options["plot"]))
    try:
        with connected(options) as there:
            arm = there.arm.slowed(_slower(options))
            ik, model = options["ik"], options["model"]
            with telling_of_compilation():
                sources = sources_of(arm, options["calibration"], ik=ik, model=model)
                planner = LawPlanner(arm, sources, ik or "svd")
                planner.prepare()
            status = _track(there, planner, reader, teller, options)
    except ArmsynError as error:
        if not options["as_json"]:
            raise
        teller.fault(error)
        status = error.exit_status
    context.exit(status)


def _slower(options: dict[str, Any]) -> float:
    from armsyn.cli.moving import check_slower

    check_slower(options["slower"])
    return float(options["slower"])


def _track(
    there: Connection,
    planner: LawPlanner,
    reader: LineReader,
    teller: Teller,
    options: dict[str, Any],
) -> int:
    """Track, perhaps park, and write what there is to write; returns the exit status."""
    from armsyn.cli.track_report import finish
    from armsyn.driver import ArmSession, Ending
    from armsyn.driver.operate_move import park

    with (
        _quick_switching(),
        ArmSession.open(
            there.port,
            planner.arm,
            options["rate_hz"],
            simulated=there.simulated,
            accept_no_watchdog=options["accept_no_watchdog"],
        ) as session,
    ):
        session.gravity, session.realtime = not options["no_gravity"], options["realtime"]
        recording = _follow(session, planner, reader, teller, options)
        ending = recording.ending
        if options["park"] and ending is Ending.COMPLETED:
            ending = park(session).ending
    return finish(recording, ending, planner.arm, teller, options)


@contextmanager
def _quick_switching() -> Iterator[None]:
    """Let the thread that plans give way at once to the one that streams."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_S)
    try:
        yield
    finally:
        sys.setswitchinterval(before)


def _follow(
    session: ArmSession,
    planner: LawPlanner,
    reader: LineReader,
    teller: Teller,
    options: dict[str, Any],
) -> Recording:
    """Stream until the input has ended and the last motion with it."""
    from armsyn.cli.stream_report import keep
    from armsyn.cli.track_feed import TargetFeed
    from armsyn.driver import still_posture
    from armsyn.driver.path import BLEND
    from armsyn.planning.tracking import LEAD_S, ReachTracker

    tracker = ReachTracker(planner, still_posture(session), earliest=BLEND)
    longest = options["longest"] or LONGEST_S

    def stopping() -> bool:
        return session.stops.count > 0 or tracker.now + LEAD_S >= longest

    feed = TargetFeed(
        *(tracker, reader, teller.tell),
        each=options["each"],
        longest=longest,
        options=options,
        stopping=stopping,
    )
    tracker.on_end = feed.ended
    kept = RECORDED_S if options["record"] or options["plot"] else _UNRECORDED_S
    try:
        with feed:
            recording = session.run_setpoint(
                tracker.setpoint,
                longest,
                teller.tick,
                recorded=min(kept, longest),
            )
        _raise_of(feed)
    except BaseException:
        last = () if session.recording is None else (session.recording,)
        keep(last, planner.arm, options)
        raise
    return recording


def _raise_of(feed: TargetFeed) -> None:
    """Raise what ended the thread of targets too early."""
    if feed.error is not None:
        raise feed.error
