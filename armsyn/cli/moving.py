"""What `armsyn park` and `armsyn jog` share: a session on the arm, a progress bar, the ending."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

from armsyn.cli.arm_options import Connection, connected

if TYPE_CHECKING:
    from armsyn.driver import Ending

Result = TypeVar("Result")

STOPPED = 130
FAULTY = 3

_REFRESH_S = 0.2


@contextmanager
def session_on(options: dict[str, Any], slower: float = 1.0) -> Iterator[tuple[Connection, Any]]:
    """Open a session on the arm of `arm_options`, with its speeds divided by `slower`."""
    from armsyn.driver import ArmSession

    check_slower(slower)
    with (
        connected(options) as there,
        ArmSession.open(
            there.port,
            there.arm.slowed(slower),
            options["rate_hz"],
            simulated=there.simulated,
            **_consent(options),
        ) as session,
    ):
        yield there, session


def check_slower(factor: float) -> None:
    """Refuse what an arm cannot be slowed by; InputError."""
    from armsyn.arm.description import LARGEST_SLOWING
    from armsyn.errors import InputError

    if not factor >= 1.0:
        raise InputError(f"--slower must be at least 1, got {factor:g}")
    if factor > LARGEST_SLOWING:
        raise InputError(f"--slower must be at most {LARGEST_SLOWING:.0f}, got {factor:g}")


def _consent(options: dict[str, Any]) -> dict[str, bool]:
    return {"accept_no_watchdog": True} if options["accept_no_watchdog"] else {}


def with_progress(run: Callable[[Callable[[float, float], None] | None], Result]) -> Result:
    """Run a motion that takes an ``on_tick``, with a progress bar on a terminal."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    if not console.is_terminal:
        return run(None)
    with Progress(console=console, transient=True, auto_refresh=False) as bar:
        task, shown = bar.add_task("moving", total=1.0), 0.0

        def show(path_time: float, duration: float) -> None:
            nonlocal shown
            if abs(path_time - shown) >= _REFRESH_S:  # a terminal must not cost ticks
                shown = path_time
                bar.update(task, completed=path_time / duration, refresh=True)

        return run(show)


def status_of(ending: Ending) -> int:
    """Exit status for an ending."""
    from armsyn.driver import Ending

    if ending is Ending.PARK_MISSED:
        return FAULTY
    stopped = (Ending.STOPPED_HOLDING, Ending.STOPPED_PARKED, Ending.ABORTED)
    return STOPPED if ending in stopped else 0
