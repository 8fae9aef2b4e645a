"""Which serial ports there are, who may and does use them, and on which of them servos answer.

What the system tells of ports comes from pyserial's ``list_ports``, ``/sys`` and ``/proc`` (Linux;
elsewhere adapters' timers and other programs are not known). Nothing but pings is ever sent.
"""

from __future__ import annotations

import contextlib
import grp
import os
import stat
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from serial.tools import list_ports

from armsyn.driver.adapter import adapter_latency
from armsyn.driver.port_lock import look
from armsyn.driver.timing import SHORTEST_LATENCY

PROCESSES = Path("/proc")
PSEUDO_TERMINALS = "/dev/pts/"


class SystemPort(Protocol):
    """What pyserial tells of a port (its ``ListPortInfo``)."""

    device: str
    description: str
    vid: int | None
    pid: int | None
    serial_number: str | None


Listing = Callable[[], Iterable[SystemPort]]


@dataclass(frozen=True)
class PortFacts:
    """A serial port as the system shows it.

    Attributes
    ----------
    path : str
    description : str
        Of the adapter; empty when the system has none.
    usb_id : str or None
        Vendor and product, such as ``0403:6014``; None for what is no USB adapter.
    serial_number : str or None
        Of the adapter.
    latency : float
        For which the adapter may keep bytes to itself, s; 0 where it has no such timer.
    forbidden : str or None
        Why this user may not open it, and the cure; None when allowed.
    taken : str or None
        Which program uses it, and the cure; None when nobody is known to.
    named : bool
        The user named it: it is probed whatever it is.
    """

    path: str
    description: str
    usb_id: str | None
    serial_number: str | None
    latency: float
    forbidden: str | None
    taken: str | None
    named: bool = False

    @property
    def slow(self) -> bool:
        """Whether the adapter's latency timer is longer than it has to be."""
        return self.latency > SHORTEST_LATENCY

    @property
    def unfit(self) -> str | None:
        """Why it is not probed; None when it can be."""
        if self.forbidden:
            return self.forbidden
        if self.taken:
            return self.taken
        if self.usb_id is None and not self.named:
            return f"not probed: no USB adapter (--also {self.path} probes it)"
        return None


def find_ports(also: Sequence[str] = (), listing: Listing | None = None) -> tuple[PortFacts, ...]:
    """List the serial ports of this machine.

    Parameters
    ----------
    also : sequence of str
        Paths of more ports, such as pseudo-terminals, which the system does not list; those that
        do not exist are left out.
    listing : callable, optional
        What lists the system's ports; pyserial by default.

    Returns
    -------
    tuple of PortFacts
        USB adapters first, then by path; `also` as named, last.
    """
    found = list(listing() if listing is not None else list_ports.comports())
    named = {str(Path(path).resolve()) for path in also}
    facts = [_facts(port) for port in found if str(Path(port.device).resolve()) not in named]
    facts.sort(key=lambda port: (port.usb_id is None, port.path))
    known = {str(Path(port.device).resolve()): port for port in found}
    there = [path for path in also if Path(path).exists()]
    return (*facts, *(_facts(known.get(str(Path(path).resolve())), path) for path in there))


def vanished(before: Iterable[PortFacts], after: Iterable[PortFacts]) -> tuple[PortFacts, ...]:
    """Ports that were there before and are not afterwards: what was unplugged."""
    left = {port.path for port in after}
    return tuple(port for port in before if port.path not in left)


def _facts(port: SystemPort | None, named: str | None = None) -> PortFacts:
    path = named or (port.device if port is not None else "")
    description = port.description if port is not None else ""
    usb = port is not None and port.vid is not None and port.pid is not None
    return PortFacts(
        path=path,
        description=_adapter(path) if description in ("", "n/a") else description,
        usb_id=f"{port.vid:04x}:{port.pid:04x}" if usb and port is not None else None,
        serial_number=port.serial_number if port is not None else None,
        latency=adapter_latency(path),
        forbidden=forbidden(path),
        taken=taken(path),
        named=named is not None,
    )


def _adapter(path: str) -> str:
    pseudo = str(Path(path).resolve()).startswith(PSEUDO_TERMINALS)
    return "pseudo-terminal (a simulator?)" if pseudo else "serial line"


def forbidden(path: str, access: Callable[[str, int], bool] = os.access) -> str | None:
    """Why this user may not open a port, with the cure; None when allowed.

    Parameters
    ----------
    path : str
    access : callable
        What asks the system; `os.access`.
    """
    try:
        state = Path(path).stat()
    except OSError as error:
        return f"cannot be looked at: {error.strerror}"
    if not stat.S_ISCHR(state.st_mode):
        return "is not a serial port"
    if access(path, os.R_OK | os.W_OK):
        return None
    group = str(state.st_gid)
    with contextlib.suppress(KeyError):
        group = grp.getgrgid(state.st_gid).gr_name
    return (
        f"no permission: join the group {group} (sudo usermod -aG {group} $USER) and log in again"
    )


def taken(path: str, processes: Path = PROCESSES) -> str | None:
    """Say which program uses a port, and the cure; None when nobody is known to.

    First the driver's own lock, then, on Linux, the descriptors of the programs that this user
    may look at. Of a pseudo-terminal the descriptors say nothing: a simulator keeps one.

    Parameters
    ----------
    path : str
    processes : Path
        Where the system shows its processes.
    """
    locked = look(path)
    if locked is not None:
        return str(locked).removeprefix(f"port {path} ")
    device = str(Path(path).resolve())
    if device.startswith(PSEUDO_TERMINALS):
        return None
    process = _descriptor_holder(device, processes)
    if process is None:
        return None
    name = ""
    with contextlib.suppress(OSError):
        name = f" ({(processes / process / 'comm').read_text().strip()})"
    return f"is taken by process {process}{name}: end it first"


def _descriptor_holder(device: str, processes: Path) -> str | None:
    for entry in processes.glob("[0-9]*"):
        if entry.name == str(os.getpid()):
            continue
        with contextlib.suppress(OSError):
            for descriptor in (entry / "fd").iterdir():
                with contextlib.suppress(OSError):
                    if str(descriptor.readlink()) == device:
                        return entry.name
    return None
