"""The control socket of a simulation behind a port."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from firmware_sim.command.pty_port import PtyPort
from firmware_sim.control.socket import ControlSocket
from firmware_sim.simulation import Simulation


class PortControl(ControlSocket):
    """Answers when the port is as the answer says: a test may rely on it.

    Parameters
    ----------
    simulation : Simulation
        What requests act on.
    path : Path
        Where address and token go.
    port : PtyPort
        Which follows the simulation when it is unplugged or forbidden.
    """

    def __init__(self, simulation: Simulation, path: Path, port: PtyPort) -> None:
        super().__init__(simulation, path)
        self._port = port

    def _answer(self, line: bytes) -> tuple[dict[str, Any], bool]:
        try:
            return super()._answer(line)
        finally:
            self._port.follow(self._simulation.unplugged, self._simulation.forbidden)
