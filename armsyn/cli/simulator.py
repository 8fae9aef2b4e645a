"""A simulated arm in a process of its own, for commands that were given no port."""

from __future__ import annotations

import select
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from armsyn.arm import ArmDescription
from armsyn.arm.rig import build_rig
from armsyn.errors import PortError, PortLostError

_START_S = 60.0
"""How long to wait for the port, s: the first start on a machine compiles the physics."""

_ANNOUNCEMENTS = ("firmware-sim: starting", "firmware-sim: a simulation")
"""How the lines begin that it says when all is well."""

_STOP_S = 5.0
_LAST_WORDS_S = 1.0


@contextmanager
def simulated_arm(description: Path) -> Iterator[str]:
    """Run ``firmware_sim`` for an arm for as long as the block lasts.

    The simulator ends with its standard input, so that it outlives nobody, however this
    process ends. Ctrl-C is for the driver: the simulator runs in a session of its own.

    Parameters
    ----------
    description : Path
        The arm's TOML file.

    Yields
    ------
    str
        The port.

    Raises
    ------
    PortError
        When it does not start.
    PortLostError
        When it ends by itself while in use; the message says how.
    """
    yield from _simulated("--arm", description.stem, "--calibration", str(description.parent))


@contextmanager
def simulated_bodies(arm: ArmDescription) -> Iterator[str]:
    """Run ``firmware_sim`` with an arm's bodies under gravity; as `simulated_arm`, which see.

    Parameters
    ----------
    arm : ArmDescription
        Every joint with its link.

    Raises
    ------
    InputError
        A joint without mass.
    """
    with TemporaryDirectory(prefix="armsyn-") as folder:
        rig = Path(folder) / f"{arm.name}.rig.toml"
        rig.write_text(build_rig(arm), encoding="utf-8")
        yield from _simulated("--rig", str(rig), "--plant", "mujoco")


def _simulated(*arguments: str) -> Iterator[str]:
    process = subprocess.Popen(
        [sys.executable, "-m", "firmware_sim", *arguments, "--exit-with-stdin"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        yield _port_of(process)
    except PortLostError as error:
        status = _ended(process)
        if status is None:
            raise
        raise PortLostError(f"the simulated arm ended by itself: {status}") from error
    finally:
        _stop(process)


def _port_of(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None and process.stderr is not None  # noqa: S101, PT018 - pipes
    ready, _, _ = select.select([process.stdout], [], [], _START_S)
    port = process.stdout.readline().strip() if ready else ""
    if not port:
        process.kill()
        said = " ".join(process.stderr.read().split()) or "it said nothing"
        raise PortError(f"the simulated arm did not start: {said}")
    return port


def _ended(process: subprocess.Popen[str]) -> str | None:
    """How a simulator that runs no more ended, in one line; None when it still runs."""
    assert process.stderr is not None  # noqa: S101 - a pipe
    try:
        status = process.wait(_LAST_WORDS_S)
    except subprocess.TimeoutExpired:
        return None
    lines = process.stderr.read().strip().splitlines()
    said = [line for line in lines if not line.startswith(_ANNOUNCEMENTS)]
    return f"status {status}, {said[-1] if said else 'without a word'}"


def _stop(process: subprocess.Popen[str]) -> None:
    assert process.stdin is not None  # noqa: S101 - a pipe
    process.stdin.close()
    try:
        process.wait(_STOP_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    for pipe in (process.stdout, process.stderr):
        if pipe is not None:
            pipe.close()
