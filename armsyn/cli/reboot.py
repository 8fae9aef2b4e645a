"""`armsyn reboot`: restart servos that a hardware error has stopped."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

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

if TYPE_CHECKING:
    from armsyn.driver.operate_reboot import Rebooted
    from armsyn.driver.servos import ServoGroup

FAULTY = 3


@click.command()
@arm_options
@click.option(
    "--servo",
    "ids",
    type=int,
    multiple=True,
    metavar="ID",
    help="This servo, whatever its state; may be repeated.  [default: those with an error]",
)
@yes_option
def reboot(ids: tuple[int, ...], yes: bool, **options: Any) -> None:
    """Restart servos of an arm that a hardware error has stopped.

    Names them and their errors, and asks. A restarted servo is limp; its watchdog, profiles and
    goal are as at power-on (the next motion writes them anew), and its turns beyond one are
    forgotten. Each is restarted once: an error that comes back at once has its cause still there.

    Exit status: 0, or 3 when an error came back.
    """
    from armsyn.driver.operate import posture_of, read_latched, torque_is_on, what_falls
    from armsyn.driver.operate_reboot import Rebooter

    with present_arm(options) as (there, presence):
        group = presence.group
        errors = read_latched(group).errors
        chosen = _chosen(ids, errors, group, there.arm.name)
        if not chosen:
            say("no servo reports a hardware error: nothing was restarted", options)
        for servo_id in chosen:
            say(
                f"to be restarted: {group.title(servo_id)}, {_words(errors.get(servo_id, 0))}",
                options,
            )
        on = torque_is_on(group)
        joints = {s.joint for s in group.servos if s.id in chosen and on[s.id]}
        if joints:
            loads = what_falls(there.arm, posture_of(there.arm, group), joints)
            say(fall_text(there.arm, loads), options)
        if chosen:
            ask("Is the cause seen to and the arm supported? Restart?", yes=yes)
        rebooter = Rebooter(group)
        done = []
        for servo_id in chosen:
            if pause := rebooter.pause(servo_id):
                say(_cooling(group, servo_id, pause), options)
            done.append(rebooter.reboot(servo_id))
        for one in done:
            say(_line(group, one), options)
        if options["as_json"]:
            print_json({"rebooted": [_entry(one) for one in done]})
    click.get_current_context().exit(FAULTY if any(one.after for one in done) else 0)


def _chosen(
    ids: tuple[int, ...], errors: dict[int, int], group: ServoGroup, arm: str
) -> tuple[int, ...]:
    from armsyn.errors import InputError, ServoMissingError

    for servo_id in ids:
        if not 0 <= servo_id <= 252:
            raise InputError(f"--servo {servo_id}: IDs are 0 to 252")
        if servo_id not in group.ids:
            raise ServoMissingError(f"{arm} has no servo {servo_id} that answers", (servo_id,))
    return ids or tuple(errors)


def _words(error: int) -> str:
    from armsyn.driver.registers import hardware_error_names

    return f"hardware error: {hardware_error_names(error)}" if error else "no hardware error"


def _cooling(group: ServoGroup, servo_id: int, pause: float) -> str:
    return f"{group.title(servo_id)}: by its clock it may just have started; waiting {pause:.0f} s"


def _line(group: ServoGroup, one: Rebooted) -> str:
    turns = (
        f"; it reads {abs(one.turns)} turn(s) {'more' if one.turns > 0 else 'less'} now: check with"
        " armsyn calibrate --check"
        if one.turns
        else ""
    )
    if one.after:
        return (
            f"{group.title(one.servo_id)}: restarted, but {_words(one.after)} came back at once:"
            f" see to its cause (load, heat, supply, jam) before you try again{turns}"
        )
    return (
        f"{group.title(one.servo_id)}: answers again after {one.boot_time:.1f} s, without an error,"
        f" torque off, RAM as at power-on{turns}"
    )


def _entry(one: Rebooted) -> dict[str, Any]:
    return {
        "id": one.servo_id,
        "error_before": one.before,
        "error_after": one.after,
        "turns": one.turns,
        "boot_time_s": one.boot_time,
    }
