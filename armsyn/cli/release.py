"""`armsyn release`: switch an arm's torque off."""

from __future__ import annotations

from typing import Any

import click

from armsyn.cli.operating import (
    arm_options,
    ask,
    fall_text,
    present_arm,
    print_json,
    say,
    yes_option,
)


@click.command()
@arm_options
@click.option(
    "--joint",
    "joints",
    multiple=True,
    metavar="JOINT",
    help="Only this joint, or the gripper; may be repeated.",
)
@yes_option
def release(joints: tuple[str, ...], yes: bool, **options: Any) -> None:
    """Switch an arm's torque off: what is raised falls.

    Says which joints will fall, and asks. Works on an arm with missing or faulty servos, too.
    `armsyn park` goes to rest first.
    """
    from armsyn.driver.operate import posture_of, torque_is_on, what_falls
    from armsyn.driver.operate import release as let_go

    with present_arm(options) as (there, presence):
        arm, group = there.arm, presence.group
        chosen = _joints(arm, joints)
        held = {
            servo.joint
            for servo in group.servos
            if servo.joint in chosen and torque_is_on(group.only([servo]))[servo.id]
        }
        if held:
            loads = what_falls(arm, posture_of(arm, group), held)
            say(f"about to let go of {', '.join(j for j in chosen if j in held)}", options)
            say(fall_text(arm, loads), options)
            ask("Let go?", yes=yes)
        released = let_go(group, chosen)
        if options["as_json"]:
            print_json({"let_go": released.let_go, "limp_before": released.limp})
        elif released.let_go:
            say(f"torque off: servo {', '.join(map(str, released.let_go))}", options)
        else:
            say("the torque was off already: nothing has changed", options)


def _joints(arm: Any, joints: tuple[str, ...]) -> list[str]:
    """Check the names; all joints and the gripper where none is given."""
    from armsyn.errors import InputError, meant

    names = list(dict.fromkeys(servo.joint for servo in arm.servo))
    for joint in joints:
        if joint not in names:
            there = f"it has {', '.join(names)}{meant(joint, names)}"
            raise InputError(f"{arm.name} has no joint {joint!r}; {there}")
    return list(joints) or names
