"""`armsyn status`: how an arm is, and what is wrong with it."""

from __future__ import annotations

from contextlib import closing, nullcontext
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.arm_options import arm_options, connected

if TYPE_CHECKING:
    from armsyn.cli.arm_options import Connection
    from armsyn.driver.status import ArmStatus
    from armsyn.driver.status_findings import Finding
    from armsyn.driver.transactions import Bus

PROBLEM = 3

_REFRESH_S = 0.5


@click.command()
@arm_options
@click.option("--watch", is_flag=True, help="Keep showing it until Ctrl-C.")
def status(watch: bool, **options: Any) -> None:
    """Show an arm's posture, voltages, temperatures, errors and settings.

    Nothing is written, and nothing moves; a damaged arm is told of, not refused. Angles are of
    the joints, positive as the description has it: move a limp joint by hand, and look whether
    its angle follows (--watch).

    Exit status: 0, or 3 when there is a problem.
    """
    from armsyn.driver.status import read_status
    from armsyn.driver.status_findings import find
    from armsyn.driver.transactions import Bus
    from armsyn.errors import InputError

    if watch and options["as_json"]:
        raise InputError("--watch shows a table: leave out --json")
    with connected(options) as there:
        with closing(Bus(there.port, there.arm.servo[0].baud)) as bus:
            found = read_status(bus, there.arm)
            if watch:
                found = _watch(bus, found)
        findings = find(found)
        if options["as_json"]:
            from armsyn.cli.status_tables import document

            _print_json(document(found, findings) | _connection(there))
        else:
            _print(found, findings)
    problems = any(finding.level == "problem" for finding in findings)
    click.get_current_context().exit(PROBLEM if problems else 0)


def _connection(there: Connection) -> dict[str, Any]:
    overlay = there.calibration
    return {
        "simulated": there.simulated,
        "calibration": None if overlay is None else str(overlay),
    }


def _watch(bus: Bus, first: ArmStatus) -> ArmStatus:
    """Show the state again and again; return the last."""
    import time

    from rich.live import Live

    from armsyn.cli.status_tables import console, live_view
    from armsyn.driver.status import read_status
    from armsyn.driver.status_findings import find

    screen, shown = console(), first
    live = Live(console=screen, auto_refresh=False) if screen.is_terminal else None
    try:
        with live or nullcontext():
            while True:
                view = live_view(shown, find(shown))
                if live is not None:
                    live.update(view, refresh=True)
                else:
                    screen.print(view)
                time.sleep(_REFRESH_S)
                shown = read_status(bus, first.arm, look_around=False)
    except KeyboardInterrupt:
        return shown


def _print(found: ArmStatus, findings: tuple[Finding, ...]) -> None:
    from armsyn.cli.status_tables import (
        bus_line,
        console,
        finding_lines,
        hand_line,
        settings_table,
        state_table,
    )

    screen = console()
    if not found.fits:  # tables of another arm say little: what does not fit comes first
        for line in finding_lines(findings):
            screen.print(line, soft_wrap=True)
        if not any(servo.answers for servo in found.servos):
            return
        screen.print()
    screen.print(state_table(found))
    screen.print(hand_line(found))
    screen.print()
    screen.print(settings_table(found))
    screen.print(bus_line(found))
    if not found.fits:
        return
    screen.print()
    if not findings:
        screen.print("no problem found")
    for line in finding_lines(findings):
        screen.print(line, soft_wrap=True)


def _print_json(content: dict[str, Any]) -> None:
    import json

    click.echo(json.dumps(content, indent=2, allow_nan=False))
