"""What `armsyn reach` does on a port: plan from where the arm is, say so, and move."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import click
import numpy as np

from armsyn.cli.moving import with_progress
from armsyn.cli.stream_report import keep
from armsyn.driver import ArmMonitor, ArmSession, still_posture, straight_way
from armsyn.errors import ArmsynError
from armsyn.planning import HandOrientation, PlannedReach, Planner, concatenated

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.driver import Recording
    from armsyn.driver.stillness import Watched
    from armsyn.motion import FloatArray, Motion

OUTSIDE_M = 1e-3
"""A target that is this far outside what was captured is told to be."""


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


def warm_up(planner: Planner, orientation: HandOrientation | None, options: dict[str, Any]) -> None:
    """Plan once from rest, so that nothing is left to compile while a port is open.

    Parameters
    ----------
    planner : Planner
    orientation : HandOrientation or None
        Of the hand at the target.
    options : dict
        Of the command.
    """
    arm = planner.arm
    # What is refused from rest is judged again, and said, from where the arm is
    with suppress(ArmsynError):
        out = planner.plan(arm.rest, np.array(options["target"]), orientation=orientation)
        straight_way(out.angles[-1], arm.rest, arm, options["rate_hz"])


def run(
    planner: Planner,
    orientation: HandOrientation | None,
    port: str,
    options: dict[str, Any],
    *,
    simulated: bool,
) -> Done:
    """Plan a reach and make it; keep what was recorded also when a fault ends it.

    Parameters
    ----------
    planner : Planner
    orientation : HandOrientation or None
        Of the hand at the target.
    port : str
    options : dict
        Of the command.
    simulated : bool

    Returns
    -------
    Done

    Raises
    ------
    RefusedMotionError
        Nothing has moved.
    ArmFaultError
        Of the arm or its bus.
    """
    move = _in_process if options["own_process"] else _in_session
    return move(planner, orientation, port, options, simulated=simulated)


def _in_session(
    planner: Planner,
    orientation: HandOrientation | None,
    port: str,
    options: dict[str, Any],
    *,
    simulated: bool,
) -> Done:
    arm, consent = planner.arm, options["accept_no_watchdog"]
    with ArmSession.open(
        port, arm, options["rate_hz"], simulated=simulated, accept_no_watchdog=consent
    ) as session:
        session.gravity, session.realtime = not options["no_gravity"], options["realtime"]
        plan = _planned(planner, orientation, session, options)
        try:
            recording = with_progress(lambda show: session.run(plan.trajectory, plan.park, show))
        except BaseException:
            recorded = () if session.recording is None else (session.recording,)
            keep([_with_target(one, options) for one in recorded], arm, options)
            raise
    return Done(arm, plan.start, plan.out, plan.back, _with_target(recording, options))


def _with_target(recording: Recording, options: dict[str, Any]) -> Recording:
    """The driver is given a trajectory, and knows of no target."""
    return replace(recording, target_m=tuple(options["target"]))


def _in_process(
    planner: Planner,
    orientation: HandOrientation | None,
    port: str,
    options: dict[str, Any],
    *,
    simulated: bool,
) -> Done:
    """Plan from where the arm is, and run in a process of its own."""
    from armsyn.driver.process import Job, run_in_process

    arm = planner.arm
    with ArmMonitor.open(port, arm) as monitor:
        plan = _planned(planner, orientation, monitor, options)
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
    recordings = [_with_target(recording, options) for recording in result.recordings]
    if result.error is not None:
        keep(recordings, arm, options)
        raise result.error
    return Done(arm, plan.start, plan.out, plan.back, recordings[-1])


def _planned(
    planner: Planner, orientation: HandOrientation | None, watched: Watched, options: dict[str, Any]
) -> _Plan:
    """Plan from where the arm is: there, perhaps back, perhaps to rest."""
    arm, start = planner.arm, still_posture(watched)
    out = planner.plan(start, np.array(options["target"]), orientation=orientation)
    _tell("the target", out)
    trajectory, back = out.trajectory, None
    if options["come_back"]:
        back = planner.plan(out.angles[-1], arm.chain.forward(start).tip)
        _tell("where the hand started", back)
        trajectory = concatenated(trajectory, back.trajectory)
    park = None
    if options["park"]:
        assert trajectory.angles is not None  # noqa: S101 - planned
        park = straight_way(trajectory.angles[-1], arm.rest, arm, options["rate_hz"])
    return _Plan(start, out, back, trajectory, park)


def _tell(place: str, planned: PlannedReach) -> None:
    """Say, before anything moves, what is unusual about a plan."""
    if planned.outside_m is not None and planned.outside_m > OUTSIDE_M:
        click.echo(
            f"{place} lies {planned.outside_m * 100:.1f} cm outside the captured workspace",
            err=True,
        )
    other = []
    if planned.swivel_m is not None:
        other.append(f"with the elbow {planned.swivel_m * 100:.0f} cm from where it would end")
    if planned.evened:
        other.append(f"{planned.evened:.1%} nearer to minimum jerk of every joint")
    if other:
        why = planned.refused.split(": ")[0]
        click.echo(f"{' and '.join(other)}, for as predicted {why}", err=True)
