"""Servos in this process, on a clock that moves only by waiting."""

from __future__ import annotations

import errno
import math
from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from firmware_sim.clock import SteppedClock
from firmware_sim.control.hands import Hands, positions_of
from firmware_sim.errors import RigError
from firmware_sim.rig.arm_search import find_arm
from firmware_sim.rig.file import SET_UP, parse_rig, read_rig
from firmware_sim.rig.settings import Rig, check_ids, parse_servo, with_baud_rate, with_protocol
from firmware_sim.simulation import Simulation, queue
from firmware_sim.wire.bus import Bus, Transmission


class SteppedPort:
    """A serial port to a simulation in the same process, on a clock that moves only by waiting.

    The same requests at the same times give the same bytes, however slow the machine.

    Parameters
    ----------
    simulation : Simulation or Bus
        The servos, with or without faults.
    clock : SteppedClock
        Their time.
    baud_rate : float
        The client's, bit/s.

    Raises
    ------
    OSError
        From `write`, `in_waiting`, `read` and a new `baud_rate`, while the simulation is unplugged.
    """

    def __init__(self, simulation: Simulation | Bus, clock: SteppedClock, baud_rate: float) -> None:
        if not isinstance(simulation, Simulation):
            simulation = Simulation(simulation, start=clock.now())
        self.simulation = simulation
        self.clock = clock
        self._due: deque[Transmission] = deque()
        self._arrived = bytearray()
        self.baud_rate = baud_rate

    @property
    def baud_rate(self) -> float:
        """The client's, bit/s; when it is set to another, answers on their way are lost.

        Raises
        ------
        ValueError
            When it is set to what is no rate: not above 0, as on a line that is hung up.
        """
        return self._baud_rate

    @baud_rate.setter
    def baud_rate(self, baud_rate: float) -> None:
        if not 0.0 < baud_rate < math.inf:
            raise ValueError(f"a baud rate is above 0 bit/s, not {baud_rate!r}")
        if baud_rate != getattr(self, "_baud_rate", baud_rate):
            self.in_waiting()
            self._due.clear()
            self.simulation.free_wire(self.clock.now())
        self._baud_rate = baud_rate

    @property
    def bus(self) -> Bus:
        """The servos' bus."""
        return self.simulation.bus

    def write(self, data: bytes) -> None:
        """Send bytes; no time passes."""
        self._check_plug()
        now = self.clock.now()
        queue(self._due, self.simulation.receive(data, now, self.baud_rate))

    def in_waiting(self) -> int:
        """How many bytes have arrived by now."""
        self._check_plug()
        now, due = self.clock.now(), self._due
        while due and due[0].due <= now:
            self._arrived += due.popleft().data
        return len(self._arrived)

    def read(self, size: int, timeout: float) -> bytes:
        """Return up to `size` bytes, waiting for them for at most `timeout` s."""
        deadline = self.clock.now() + timeout
        while self.in_waiting() < size and self.clock.now() < deadline:
            self.wait_until(min(deadline, self._due[0].due if self._due else deadline))
        taken = bytes(self._arrived[:size])
        del self._arrived[:size]
        return taken

    def exchange(self, request: bytes) -> bytes:
        """Send a request, wait until all answers have left the wire, and return them."""
        self.write(request)
        self.wait_until(max([self.simulation.wire_free, *(sent.due for sent in self._due)]))
        return self.read(self.in_waiting(), 0.0)

    def wait_until(self, when: float) -> None:
        """Let time pass until `when`, s, with all that happens by itself until then."""
        event = self.simulation.next_event
        while event is not None and event <= when:
            self.clock.advance_to(event)
            queue(self._due, self.simulation.advance(self.clock.now()))
            following = self.simulation.next_event
            if following is not None and following <= event:
                break
            event = following
        self.clock.advance_to(when)

    def wait_for_next(self) -> bool:
        """Let time pass until something arrives or happens; return False if nothing will."""
        moments = [self._due[0].due] if self._due else []
        if self.simulation.next_event is not None:
            moments.append(self.simulation.next_event)
        if moments:
            self.wait_until(max(min(moments), self.clock.now()))
        return bool(moments)

    @property
    def hands(self) -> Hands:
        """Hands of a person: ``port.hands.turn({1: 2048, 2: 1000})``."""
        simulation = self.simulation

        def inject(text: str) -> int:
            simulation.catch_up(self.clock.now())
            return simulation.inject(text).number

        def positions() -> dict[int, int]:
            simulation.catch_up(self.clock.now())
            return positions_of(simulation.bus.servos)

        def wait(duration: float) -> None:
            self.wait_until(self.clock.now() + duration)

        return Hands(inject, simulation.clear, positions, wait)

    def _check_plug(self) -> None:
        event = self.simulation.next_event
        if event is not None and event <= self.clock.now():
            queue(self._due, self.simulation.advance(self.clock.now()))
        if self.simulation.unplugged:
            self._due.clear()
            self._arrived.clear()
            raise OSError(errno.EIO, "the simulated port is unplugged")


def stepped(
    *servos: str,
    baud: int | None = None,
    protocol: int | None = None,
    faults: Sequence[str] = (),
    seed: int = 0,
    gap_rule: bool = True,
    rig: Path | str | None = None,
    arm: str | None = None,
    mujoco: bool = False,
) -> SteppedPort:
    """Return a port to servos on a stepped clock that stands at 0 s.

    Parameters
    ----------
    servos : str
        ``MODEL:ID`` or ``MODEL@FIRMWARE:ID`` each; none with `rig` or `arm`.
    baud : int, optional
        Of all servos, bit/s; by default each has its factory's, and the port the first servo's.
    protocol : int, optional
        1 or 2, of all servos; by default each speaks its factory's.
    faults : sequence of str
        Such as ``"crc-error:id=1,probability=0.1"``.
    seed : int
        Of the faults' chance.
    gap_rule : bool
        Whether a silence within an instruction makes the servos give it up.
    rig : Path or str, optional
        A rig file with the servos, as for the command's ``--rig``, or the text of one.
    arm : str, optional
        The name of an arm's description with the servos, as for the command's ``--arm``.
    mujoco : bool
        Whether the rig's arm moves as a whole under gravity.

    Returns
    -------
    SteppedPort
        With the ``clock`` and the ``simulation`` behind it.

    Raises
    ------
    RigError
        If there are no such servos, or none at all.
    PlantError
        If `mujoco` is asked for and cannot be had.
    FaultError
        If a fault or the seed makes no sense.
    """
    from firmware_sim.assembly import build_simulation  # noqa: PLC0415 - the physics take a while
    from firmware_sim.faults.parsing import parse_fault  # noqa: PLC0415
    from firmware_sim.faults.scenario import check_seed  # noqa: PLC0415

    found = _rig_of(servos, rig, arm)
    settings = found.servos
    check_ids(settings)
    if protocol is not None:
        settings = [with_protocol(servo, protocol) for servo in settings]
    if baud is not None:
        settings = [with_baud_rate(servo, baud) for servo in settings]
    simulation = build_simulation(
        replace(found, servos=settings),
        gap_rule=gap_rule,
        mujoco=mujoco,
        faults=[parse_fault(text) for text in faults],
        seed=check_seed(seed),
    )
    rate = simulation.bus.servos[0].baud_rate
    return SteppedPort(simulation, SteppedClock(), rate)


def _rig_of(servos: Sequence[str], rig: Path | str | None, arm: str | None) -> Rig:
    """Return what one of three ways of saying it means."""
    if bool(servos) + (rig is not None) + (arm is not None) != 1:
        raise RigError("say which servos: MODEL:ID each, a rig, or an arm")
    if arm is not None:
        return read_rig(find_arm(arm, None), SET_UP)
    if isinstance(rig, str):
        return parse_rig(rig)
    return Rig([parse_servo(text) for text in servos]) if rig is None else read_rig(rig)
