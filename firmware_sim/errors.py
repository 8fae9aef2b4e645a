"""The errors of firmware_sim, each with the exit status the command ends with.

::

    SimulatorError                 never raised itself
    +-- RigError (ValueError)      exit 2: which servos to simulate
    +-- PlantError (ValueError)    exit 2: the plant asked for cannot be had
    +-- FaultError (ValueError)    exit 2: a fault, scenario or seed that makes no sense
    +-- StateFileError (ValueError) exit 2: a state file that is not one, or of other servos
    +-- ControlError               exit 2: no simulator to be reached by its control file
    +-- OutputError                exit 2: a file to be written cannot be made
    +-- LinkTakenError             exit 2: the name for the port exists already
    +-- SimulatorStartError        the simulator's process did not offer a port

What arrives on the wire never raises: malformed bytes are dropped and counted (``parser``), and
refused requests are answered with an error number (``protocol2``).
"""

from __future__ import annotations

from typing import ClassVar


class SimulatorError(Exception):
    """Any error that firmware_sim raises on purpose."""

    exit_status: ClassVar[int] = 1


class RigError(SimulatorError, ValueError):
    """The servos to simulate are not described in a usable way.

    Parameters
    ----------
    message : str
        One line.
    file : str
        The file that says so; empty for the command line.
    table : int
        Which ``[[servo]]`` table, counted from 1; 0 for the file as a whole.
    field : str
        Which field of it; empty for the table as a whole.
    """

    exit_status = 2

    def __init__(self, message: str, file: str = "", table: int = 0, field: str = "") -> None:
        super().__init__(message)
        self.file = file
        self.table = table
        self.field = field


class PlantError(SimulatorError, ValueError):
    """The physics asked for cannot be had: no model of the arm, or MuJoCo is not installed."""

    exit_status = 2


class FaultError(SimulatorError, ValueError):
    """A fault or a scenario makes no sense.

    Parameters
    ----------
    message : str
        One line.
    file : str
        The scenario that says so; empty for the command line and the control socket.
    """

    exit_status = 2

    def __init__(self, message: str, file: str = "") -> None:
        super().__init__(message)
        self.file = file


class StateFileError(SimulatorError, ValueError):
    """A state file is malformed, or belongs to other servos.

    Parameters
    ----------
    message : str
        One line.
    file : str
        The file.
    """

    exit_status = 2

    def __init__(self, message: str, file: str) -> None:
        super().__init__(message)
        self.file = file


class ControlError(SimulatorError):
    """No running simulator can be reached through a control file, or it refused."""

    exit_status = 2


class OutputError(SimulatorError):
    """A file to be written cannot be made.

    Parameters
    ----------
    message : str
        One line.
    path : str
        The file.
    """

    exit_status = 2

    def __init__(self, message: str, path: str) -> None:
        super().__init__(message)
        self.path = path


class LinkTakenError(SimulatorError):
    """The path wanted for the port's symbolic link is in use.

    Parameters
    ----------
    message : str
        One line.
    path : str
        The path.
    """

    exit_status = 2

    def __init__(self, message: str, path: str) -> None:
        super().__init__(message)
        self.path = path


class SimulatorStartError(SimulatorError):
    """A simulator started as a process ended before it offered a port.

    Parameters
    ----------
    message : str
        One line.
    exit_status_seen : int
        Its exit status; negative when it had to be killed.
    """

    def __init__(self, message: str, exit_status_seen: int) -> None:
        super().__init__(message)
        self.exit_status_seen = exit_status_seen
