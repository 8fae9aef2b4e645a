"""`armsyn clear`: clear what a fault left on an arm."""

from __future__ import annotations

from typing import Any

import click

from armsyn.cli.operating import arm_options, ask, present_arm, print_json, say, yes_option

FAULTY = 3


@click.command()
@arm_options
@yes_option
def clear(yes: bool, **options: Any) -> None:
    """Clear what a fault left on an arm, so that it may move again.

    Switches bus watchdogs off that are armed or have expired. Servos that theirs has stopped hold
    where they are (goal := what they are held at, or present); nothing moves, and torque stays as
    it is. Look at the arm first. Hardware errors stay: `armsyn reboot` ends those.

    Exit status: 0, or 3 when servos still report hardware errors.
    """
    from armsyn.driver.operate import clear as clear_group
    from armsyn.driver.operate import read_latched

    with present_arm(options) as (_, presence):
        group = presence.group
        found = read_latched(group)
        if found.armed:
            say(f"bus watchdog armed: {_named(group, found.armed)}", options)
        if found.expired:
            say(f"stopped by its bus watchdog: {_named(group, found.expired)}", options)
        cleared: tuple[int, ...] = ()
        if found.watchdogs:
            ask("Have you looked at the arm, and may it move again?", yes=yes)
            cleared = clear_group(group)
            say(f"cleared: servo {', '.join(map(str, cleared))}; nothing has moved", options)
        else:
            say("no bus watchdog is armed or expired", options)
        for servo_id, error in found.errors.items():
            say(_error(group, servo_id, error), options)
        if options["as_json"]:
            print_json(
                {"armed": found.armed, "expired": found.expired, "cleared": cleared}
                | {"hardware_errors": {str(i): error for i, error in found.errors.items()}}
            )
    click.get_current_context().exit(FAULTY if found.errors else 0)


def _named(group: Any, servo_ids: tuple[int, ...]) -> str:
    return ", ".join(group.title(servo_id) for servo_id in servo_ids)


def _error(group: Any, servo_id: int, error: int) -> str:
    from armsyn.driver.checks import cure_of_error
    from armsyn.driver.registers import hardware_error_names

    (servo,) = (servo for servo in group.servos if servo.id == servo_id)
    return (
        f"still there: {group.title(servo_id)} reports a hardware error:"
        f" {hardware_error_names(error)}; {cure_of_error(servo)}"
    )
