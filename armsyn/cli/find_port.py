"""`armsyn find-port`: which serial port an arm is plugged into."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.arm_options import json_option
from armsyn.cli.prompts import person

if TYPE_CHECKING:
    from armsyn.driver.find_port import PortFacts
    from armsyn.driver.port_probe import Probe

NOTHING_FOUND = 3

_PLUG_IN = (
    "plug the arm's adapter in (lsusb shows whether it is seen), then run armsyn find-port again;"
    " without --port, commands such as armsyn reach move a simulated arm"
)


@click.command(name="find-port")
@click.option(
    "--also",
    multiple=True,
    metavar="PATH",
    help="Look at this port, too: a built-in serial line, a pseudo-terminal. May be repeated.",
)
@click.option("--no-probe", is_flag=True, help="Only list the ports: open none, send nothing.")
@click.option(
    "--unplug", is_flag=True, help="Find the port that vanishes as you unplug its adapter."
)
@json_option
def find_port(also: tuple[str, ...], no_probe: bool, unplug: bool, as_json: bool) -> None:
    """Find the serial port that an arm is plugged into.

    Lists the serial ports with their adapters, and says which may be opened, which another
    program uses, whose adapter keeps bytes for too long, and on which of them servos answer.
    Only pings are sent, to USB adapters and to ports named by --also, at usual baud rates, in both
    protocols; `armsyn scan` tries every rate.

    Exit status: 0 when servos answered (or, not probing, when there are ports), otherwise 3.
    """
    from armsyn.driver.find_port import find_ports

    if unplug:
        _unplug(also, as_json=as_json)
        return
    ports = find_ports(also)
    if not as_json:
        _warn_of_absent(also, ports)
    probes = {} if no_probe else _probe_all(ports)
    if as_json:
        import json

        document = {"ports": [_entry(port, probes.get(port.path)) for port in ports]}
        click.echo(json.dumps(document, indent=2, allow_nan=False))
    else:
        _show(ports, probes, probing=not no_probe)
    good = bool(ports) if no_probe else any(probe.servos for probe in probes.values())
    click.get_current_context().exit(0 if good else NOTHING_FOUND)


def _warn_of_absent(also: tuple[str, ...], ports: tuple[PortFacts, ...]) -> None:
    for path in also:
        if path not in {port.path for port in ports}:
            click.echo(f"{path} does not exist: plug the adapter in, or check the name", err=True)


def _probe_all(ports: tuple[PortFacts, ...]) -> dict[str, Probe]:
    """Ask every port that may be asked, with a progress bar on a terminal."""
    from rich.console import Console
    from rich.progress import Progress

    from armsyn.driver.port_probe import probe

    console = Console(stderr=True)
    probes: dict[str, Probe] = {}
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        for port in ports:
            if port.unfit is None:
                task = bar.add_task(f"asking {port.path}", total=None)

                def step(done: int, total: int, task: Any = task) -> None:
                    bar.update(task, completed=done, total=total)

                probes[port.path] = probe(port.path, on_step=step)
                bar.remove_task(task)
    return probes


def _unplug(also: tuple[str, ...], *, as_json: bool) -> None:
    from armsyn.driver.find_port import find_ports, vanished
    from armsyn.errors import PortError

    before = find_ports(also)
    if not before:
        raise PortError("there is no serial port at all: plug the arm's adapter in first")
    click.echo(f"{len(before)} serial port(s): {', '.join(port.path for port in before)}", err=True)
    person().ask("Unplug the arm's adapter, then press Enter:")
    gone = vanished(before, find_ports(also))
    if not gone:
        raise PortError("no port has vanished: was it another cable? Plug it in and try again")
    if as_json:
        import json

        click.echo(json.dumps({"vanished": [_entry(port, None) for port in gone]}, indent=2))
        return
    for port in gone:
        click.echo(f"{port.path} has vanished: it is the arm's port ({_adapter(port)})")
    click.echo("Plug it in again; it may get another number then: run armsyn find-port")


def _entry(port: PortFacts, probe: Probe | None) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "path": port.path,
        "description": port.description,
        "usb_id": port.usb_id,
        "serial_number": port.serial_number,
        "latency_s": port.latency,
        "forbidden": port.forbidden,
        "taken": port.taken,
        "probed": probe is not None,
    }
    if probe is not None:
        entry |= {"baud": probe.baud, "garbled": probe.garbled, "problem": probe.problem}
        entry["servos"] = [
            {"id": s.servo_id, "model": s.model, "protocol": s.protocol} for s in probe.servos
        ]
    return entry


def _adapter(port: PortFacts) -> str:
    parts = [port.description, port.usb_id, port.serial_number]
    return ", ".join(part for part in parts if part)


def _show(ports: tuple[PortFacts, ...], probes: dict[str, Probe], *, probing: bool) -> None:
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True, markup=False)
    if not ports:
        console.print(f"no serial port: {_PLUG_IN}")
    for port in ports:
        console.print(f"{port.path}: {_adapter(port)}")
        for line in _findings(port, probes.get(port.path), probing=probing):
            console.print(f"  {line}")
    if ports and all(port.usb_id is None and not port.named for port in ports):
        console.print(f"no USB adapter among them: {_PLUG_IN}")


def _findings(port: PortFacts, probe: Probe | None, *, probing: bool) -> list[str]:
    lines = []
    if port.slow:
        name = Path(port.path).resolve().name
        lines.append(
            f"its adapter keeps bytes for {port.latency * 1e3:.0f} ms (1 ms is asked for as it is"
            " opened; where that is not allowed: echo 1 | sudo tee"
            f" /sys/bus/usb-serial/devices/{name}/latency_timer)"
        )
    if port.unfit is not None:
        return [*lines, port.unfit]
    if probe is not None:
        lines.append(_answer(probe))
    elif not probing:
        lines.append("may be opened; not asked for servos")
    return lines


def _answer(probe: Probe) -> str:
    if probe.problem is not None:
        return probe.problem
    if not probe.servos:
        if probe.garbled:
            return (
                "garbled answers: another baud rate, two servos with one ID, or noise: armsyn scan"
            )
        return "no servo answers: check the servos' supply and cable; armsyn scan tries every rate"
    named = ", ".join(f"{servo.servo_id} {servo.model}" for servo in probe.servos)
    protocols = " and ".join(str(p) for p in sorted({servo.protocol for servo in probe.servos}))
    garbled = "; some answers are garbled: two servos with one ID?" if probe.garbled else ""
    return (
        f"{len(probe.servos)} servo(s) at {probe.baud} baud, protocol {protocols}: {named}{garbled}"
    )
