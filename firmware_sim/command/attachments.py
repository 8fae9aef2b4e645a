"""What serves beside the port: control socket, state file, trace, table, and their complaints."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from firmware_sim.command.pty_port import PtyPort
from firmware_sim.command.server import Chore, Guest
from firmware_sim.command.strike_teller import StrikeTeller
from firmware_sim.command.words import complain
from firmware_sim.simulation import Simulation
from firmware_sim.wire.observed import Heard, Said

if TYPE_CHECKING:
    from firmware_sim.rig.state_file import StateKeeper

_COMPLAINT_PERIOD = 1.0  # s


class Attachments:
    """Attaches what a command line asks for to a simulation and its port.

    Parameters
    ----------
    simulation : Simulation
        The servos.
    port : PtyPort
        Where clients come.
    names : sequence of str
        ``MODEL:ID`` of each servo, as it was asked for.
    stack : ExitStack
        Is told how each attachment ends.
    """

    def __init__(
        self, simulation: Simulation, port: PtyPort, names: Sequence[str], stack: ExitStack
    ) -> None:
        self._simulation = simulation
        self._port = port
        self._names = names
        self._stack = stack
        self.guests: list[Guest] = []
        self.chores: list[Chore] = []
        self.complaints: list[Callable[[], str]] = []
        """Say what is wrong now, nothing if nothing is."""
        if port.link is not None:
            self.complaints.append(lambda: port.problem)

    def open_control(self, path: Path) -> None:
        """Let faults be injected through a socket whose address is in a file.

        Raises
        ------
        OutputError
            If the file cannot be made.
        """
        from firmware_sim.command.port_control import PortControl  # noqa: PLC0415 - not for most

        control = PortControl(self._simulation, path, self._port)
        self._stack.callback(control.close)
        self.guests.append(control)

    def write_files(self, state: Path | None, *, trace: bool) -> None:
        """Keep what the servos remember in a file, and write the trace of a `TracedSimulation`.

        Raises
        ------
        OutputError
            If one of them cannot be written; neither has been made then.
        """
        keeper = None if state is None else self._make_keeper(state)
        if trace:
            self._write_trace()
        if keeper is not None:
            keeper.begin()
            self._stack.callback(keeper.close)
            self.chores.append(keeper)
            self.complaints.append(lambda: keeper.problem)

    def _make_keeper(self, path: Path) -> StateKeeper:
        from firmware_sim.rig.state_file import StateKeeper  # noqa: PLC0415 - not for most

        simulation = self._simulation
        return StateKeeper(path, simulation.bus.servos, self._names, simulation.snapshot)

    def _write_trace(self) -> None:
        from firmware_sim.trace.record import TracedSimulation  # noqa: PLC0415 - not for most

        if not isinstance(self._simulation, TracedSimulation):
            raise TypeError("this simulation keeps no trace")
        trace = self._simulation.trace
        trace.file.open()
        self._stack.callback(trace.close)
        self.chores.append(trace)
        self.complaints.append(lambda: trace.problem)

    def show_table(self) -> None:
        """Show the servos on the terminal."""
        from firmware_sim.command.table_feed import TableFeed  # noqa: PLC0415 - not for most

        counts = PacketCounts()
        self._simulation.bus.observers.append(counts.note)
        feed = TableFeed(
            self._simulation.bus.servos, self._title, counts.of, self._faults_at, self._caption
        )
        self._stack.callback(feed.close)
        self.chores.append(feed)

    def complain(self) -> None:
        """Say on standard error what goes wrong, once each; for where there is no table."""
        self.chores.append(Complainer(self._note))

    def tell_strikes(self) -> None:
        """Say on standard error what faults do; for where nobody else asks for it."""
        teller = StrikeTeller(self._simulation)
        self._stack.callback(teller.close)
        self.chores.append(teller)

    def _title(self) -> str:
        link = f" ({self._port.link})" if self._port.link else ""
        where = self._port.name if self._port.plugged else "unplugged"
        return f"firmware-sim, no hardware: {where}{link}"

    def _note(self) -> str:
        return "; ".join(filter(None, (complaint() for complaint in self.complaints)))

    def _caption(self) -> str:
        """Return what is wrong, and the faults that concern no servo in particular."""
        common = [f.spec.kind.name for f in self._simulation.faults if f.spec.servo_id is None]
        faults = f"faults on the bus: {', '.join(common)}" if common else ""
        return "; ".join(filter(None, (faults, self._note())))

    def _faults_at(self, servo_id: int) -> list[str]:
        return [
            fault.spec.kind.name
            for fault in self._simulation.faults
            if fault.spec.servo_id == servo_id
        ]


class PacketCounts:
    """Counts the packets that concern each servo: an observer of a bus."""

    def __init__(self) -> None:
        self._counts: Counter[int] = Counter()

    def note(self, event: Heard | Said) -> None:
        """Count one."""
        if isinstance(event, Heard):
            self._counts[event.packet.servo_id] += 1
        else:
            self._counts[event.data[4 if event.protocol == 2 else 2]] += 1

    def of(self, servo_id: int) -> int:
        """Return how many were to a servo alone, or of it."""
        return self._counts[servo_id]


class Complainer:
    """Prints what goes wrong, when it begins: a `server.Chore`."""

    def __init__(self, complaint: Callable[[], str]) -> None:
        self._complaint = complaint
        self._said = ""
        self.next_due = 0.0

    def work(self, now: float) -> None:
        """Look whether anything new is wrong."""
        complaint = self._complaint()
        if complaint and complaint != self._said:
            complain(complaint)
        self._said = complaint
        self.next_due = now + _COMPLAINT_PERIOD
