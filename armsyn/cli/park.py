"""`armsyn park`: put an arm to its rest posture and switch its torque off."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.moving import session_on, status_of, with_progress
from armsyn.cli.operating import arm_options, consent_option, print_json, rate_option, say

if TYPE_CHECKING:
    from armsyn.driver import ArmSession, Recording


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
    from armsyn.driver import Ending
    from armsyn.driver.operate_move import is_parked
    from armsyn.driver.operate_move import park as go_to_rest

    with session_on(options, slower) as (_, session):
        if is_parked(session):
            _tell(
                "at rest, and limp, already: nothing has moved",
                {"ending": "already parked"},
                options,
            )
            return
        recording = with_progress(lambda show: go_to_rest(session, show))
        joint, off = _farthest(recording, session)
        when = ", before the torque went off" if recording.ending is Ending.PARKED else ""
        words = f"{joint} was {math.degrees(off):z.1f} degrees off rest{when}, the farthest"
        _tell(
            f"{recording.ending.value} ({words})",
            {"ending": recording.ending.value, "farthest_joint": joint, "off_rest_rad": off},
            options,
        )
    click.get_current_context().exit(status_of(recording.ending))


def _farthest(recording: Recording, session: ArmSession) -> tuple[str, float]:
    """Which joint was farthest off rest in the run's last look at all of them, and by how many rad.

    What is released falls by what holds it no more: that is no matter of how well it was parked.
    """
    import numpy as np

    measured = recording.measured_rad[np.isfinite(recording.measured_rad).all(axis=1)]
    last = measured[-1] if len(measured) else session.read_posture()
    off = np.abs(last - session.arm.rest)
    joint = int(np.argmax(off))
    return recording.joint_names[joint], float(off[joint])


def _tell(words: str, document: dict[str, Any], options: dict[str, Any]) -> None:
    if options["as_json"]:
        print_json(document)
    else:
        say(words, options)
