"""Asking a setpoint function of the caller's in a thread of its own.

One that does not answer in time cannot hold up the loop: the arm is held, and the run ends with a
fault. Were the loop itself held up, the servos' own watchdog would stop them
(`armsyn.driver.timing.WATCHDOG_SECONDS`).
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from typing import Any, Self

from numpy.typing import ArrayLike

from armsyn.driver.clock import Clock
from armsyn.driver.joints import JointState
from armsyn.errors import SetpointError

Setpoint = Callable[[float, JointState], ArrayLike | None]
"""``setpoint(t, state)``: the posture wanted, shape (n,), rad, `t` seconds after the start; None
when it is finished. `state` is what the joints answered last, in arrays of its own. `t` goes on
by one period a tick: it does not jump over ticks that were missed, and it runs slowly for
a while after a stall, from which the arm starts again from rest. Called once more, with 0, before
torque, to see where it starts."""

PATIENCE = 0.1
"""Seconds that a setpoint function may take: a third of the servos' watchdog."""


class SetpointThread:
    """Asks a setpoint function in a thread of its own.

    Leaving the context lets the thread end; one that is stuck in the function stays behind (it
    is a daemon), for nothing can end it.

    Parameters
    ----------
    setpoint : Setpoint
    clock : Clock
        Of the stream.
    """

    def __init__(self, setpoint: Setpoint, clock: Clock) -> None:
        self._setpoint = setpoint
        self._clock = clock
        self._questions: queue.SimpleQueue[tuple[float, JointState] | None] = queue.SimpleQueue()
        self._answers: queue.SimpleQueue[tuple[Any, BaseException | None]] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._serve, name="armsyn setpoint", daemon=True)
        self._stuck = False

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._questions.put(None)
        if not self._stuck:
            self._thread.join()

    def ask(self, t: float, state: JointState) -> ArrayLike | None:
        """Ask for the setpoint at a time.

        Raises
        ------
        SetpointError
            No answer in time.
        Exception
            What the function raised.
        """
        begin = self._clock.now()
        self._questions.put((t, state))
        try:
            answer, error = self._answers.get(timeout=PATIENCE)
        except queue.Empty:
            self._stuck = True
            raise _too_slow(t) from None
        if error is not None:
            raise error
        if self._clock.now() - begin > PATIENCE:
            raise _too_slow(t)
        return answer  # type: ignore[no-any-return]

    def _serve(self) -> None:
        while (question := self._questions.get()) is not None:
            try:
                answer = (self._setpoint(*question), None)
            except BaseException as error:  # noqa: BLE001 - it is raised where it was asked for
                self._answers.put((None, error))
            else:
                self._answers.put(answer)


def _too_slow(t: float) -> SetpointError:
    return SetpointError(
        f"the setpoint function took more than {PATIENCE:g} s for the setpoint at {t:.3f} s: let"
        " it answer at once, and compute elsewhere"
    )
