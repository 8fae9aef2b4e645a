"""`armsyn scan`: which servos are on a port, at whatever baud rate and in which protocol."""

from __future__ import annotations

from contextlib import closing
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.baud import BAUD

if TYPE_CHECKING:
    from armsyn.driver.scan import ScanProgress, ScanResult


@click.command()
@click.option("--port", metavar="PATH", required=True, help="Serial port.")
@click.option(
    "--baud",
    "bauds",
    type=BAUD,
    multiple=True,
    metavar="N",
    help="Try only this rate, bit/s (1M: 1000000); may be given several times.",
)
@click.option(
    "--protocol",
    "protocols",
    type=click.Choice(["1", "2"]),
    multiple=True,
    help="Try only this protocol.",
)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def scan(port: str, bauds: tuple[int, ...], protocols: tuple[str, ...], as_json: bool) -> None:
    """Look for servos at all baud rates, in both protocols; takes about half a minute.

    Every servo is listed with how it can be reached, its model and its firmware. IDs from which
    garbled replies come are listed too: two servos of one ID, most likely. Nothing is written.

    Exit status: 0 when servos were found and none is suspect, else 3.
    """
    from armsyn.driver.scan import BAUD_RATES, PROTOCOLS
    from armsyn.driver.scan import scan as look
    from armsyn.driver.transactions import Bus

    rates = tuple(dict.fromkeys(bauds)) or BAUD_RATES
    spoken = tuple(sorted({int(text) for text in protocols}, reverse=True)) or PROTOCOLS
    with closing(Bus(port, 1_000_000)) as bus, progress_bar() as show:
        result = look(bus, rates, spoken, show)
    if as_json:
        import json

        click.echo(json.dumps(_document(port, result), indent=2, allow_nan=False))
    else:
        _show(port, result)
    click.get_current_context().exit(0 if result.servos and not result.suspects else 3)


class progress_bar:  # noqa: N801 - used as a function
    """A bar on a terminal's standard error while servos are looked for; nothing elsewhere."""

    def __init__(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        console = Console(stderr=True)
        columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
        self._bar = Progress(*columns, console=console, transient=True)
        self._shown = console.is_terminal

    def __enter__(self) -> ScanProgress | None:
        if not self._shown:
            return None
        self._bar.start()
        self._task = self._bar.add_task("looking for servos", total=1.0)
        return self._show

    def __exit__(self, *_: object) -> None:
        if self._shown:
            self._bar.stop()

    def _show(self, part: float, baud: int, protocol: int, found: int) -> None:
        text = f"{baud} baud, protocol {protocol}; {found} found"
        self._bar.update(self._task, completed=part, description=text)


def _document(port: str, result: ScanResult) -> dict[str, Any]:
    return {
        "port": port,
        "servos": [
            {
                "baud": servo.baud,
                "protocol": servo.protocol,
                "id": servo.servo_id,
                "model": servo.model,
                "model_number": servo.model_number,
                "firmware": servo.firmware,
            }
            for servo in result.servos
        ],
        "garbled": [
            {"baud": s.baud, "protocol": s.protocol, "id": s.servo_id} for s in result.suspects
        ],
        "refused_bauds": list(result.refused),
        "noisy_bauds": list(result.noisy),
    }


def _show(port: str, result: ScanResult) -> None:
    from rich.console import Console
    from rich.table import Table

    if result.servos:
        table = Table("baud", "protocol", "ID", "model", "firmware", box=None)
        for servo in result.servos:
            firmware = "" if servo.firmware is None else str(servo.firmware)
            where = (str(servo.baud), f"{servo.protocol}.0", str(servo.servo_id))
            table.add_row(*where, servo.model, firmware)
        Console().print(table)
    elif not result.suspects:
        click.echo(f"no servo answers on {port}: check its power and cable, and the port's name")
    for suspect in result.suspects:
        click.echo(
            f"ID {suspect.servo_id} at {suspect.baud} baud (protocol {suspect.protocol}.0) answers"
            " garbled: probably two servos have this ID; connect one at a time and run armsyn setup"
        )
    if result.noisy:
        rates = ", ".join(map(str, result.noisy))
        click.echo(f"only garbage at {rates} baud: of no account, unless a servo is missing above")
    if result.refused:
        rates = ", ".join(map(str, result.refused))
        click.echo(f"not tried, for the adapter refuses them: {rates} baud")
