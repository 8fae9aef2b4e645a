"""`armsyn jog`: move one joint of an arm by a little."""

from __future__ import annotations

import math
from typing import Any

import click

from armsyn.cli.arm_options import arm_of
from armsyn.cli.moving import session_on, status_of, with_progress
from armsyn.cli.operating import arm_options, consent_option, print_json, rate_option, say

_HAIR = 0.05
"""Degrees beyond a joint's range that are not worth a word."""


@click.command(context_settings={"ignore_unknown_options": True})
@click.argument("joint")
@click.argument("degrees", type=float)
@arm_options
@click.option(
    "--speed",
    type=float,
    default=10.0,
    show_default=True,
    metavar="DEG/S",
    help="That the joint does not exceed.",
)
@rate_option
@consent_option
def jog(joint: str, degrees: float, speed: float, **options: Any) -> None:
    """Move JOINT by DEGREES (at most 45, negative backwards), slowly; then hold.

    Checked like any motion before torque goes on: ranges, collisions. A limp joint that leans up to
    1.4 degrees beyond its range is moved back into it, never further out. The arm holds afterwards
    with its torque on: `armsyn park` puts it to rest, `armsyn release` lets it go.
    """
    from armsyn.driver import still_posture
    from armsyn.driver.operate_move import jog as move
    from armsyn.driver.operate_move import joint_row

    arm = arm_of(options)
    row = joint_row(arm, joint) if arm.servo else 0  # of an arm without servos more is wrong
    with session_on(options) as (there, session):
        before = still_posture(session)
        beyond = math.degrees(abs(session.read_posture()[row] - before[row]))
        if beyond > _HAIR and before[row] in (
            there.arm.chain.lower[row],
            there.arm.chain.upper[row],
        ):
            say(f"{joint} is {beyond:.1f} degrees beyond its range: back from there only", options)
        recording = with_progress(
            lambda show: move(session, joint, math.radians(degrees), math.radians(speed), show)
        )
        start, end = (math.degrees(p[row]) for p in (before, session.read_posture()))
        if options["as_json"]:
            print_json(
                {
                    "joint": joint,
                    "before_rad": math.radians(start),
                    "after_rad": math.radians(end),
                    "ending": recording.ending.value,
                }
            )
        else:
            text = f"{joint}: {start:z.1f} to {end:z.1f} degrees ({end - start:+z.1f})"
            say(f"{text}; {recording.ending.value}", options)
    click.get_current_context().exit(status_of(recording.ending))
