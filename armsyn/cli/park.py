"""`armsyn park`: put an arm to its rest posture and switch its torque off."""

from __future__ import annotations

from typing import Any

import click

from armsyn.cli.moving import degrees_off, session_on, status_of, with_progress
from armsyn.cli.operating import arm_options, consent_option, print_json, rate_option, say


@click.command()
@arm_options
@click.option(
    "--slower",
    type=float,
    default=1.0,
    metavar="FACTOR",
    help="Allow only 1/FACTOR of the arm's speed.",
)
@rate_option
@consent_option
def park(slower: float, **options: Any) -> None:
    """Put an arm to its rest posture and switch its torque off.

    All joints go straight there together; the way is checked as a whole before torque goes on
    (ranges, speeds, collisions). The torque goes off only if the arm got there; an arm that
    something keeps from rest holds. The gripper keeps what it has.

    Exit status: 0; 3 when it stopped short of rest; 4 when the way is refused: take a joint out
    of the way with `armsyn jog`.
    """
    from armsyn.driver.operate_move import is_parked
    from armsyn.driver.operate_move import park as go_to_rest

    with session_on(options, slower) as (there, session):
        if is_parked(session):
            _tell("at rest, and limp, already: nothing has moved", "already parked", options)
            return
        recording = with_progress(lambda show: go_to_rest(session, show))
        joint, off = degrees_off(session, there.arm.rest)
        words = f"{recording.ending.value} ({joint} is {off:z.1f} degrees off rest, the farthest)"
        _tell(words, recording.ending.value, options)
    click.get_current_context().exit(status_of(recording.ending))


def _tell(words: str, ending: str, options: dict[str, Any]) -> None:
    if options["as_json"]:
        print_json({"ending": ending})
    else:
        say(words, options)
