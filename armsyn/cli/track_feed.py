"""The thread of `armsyn track` that reads targets, plans how to follow them, and tells of it."""

from __future__ import annotations

import queue
import threading
from collections import deque
from collections.abc import Callable
from typing import Any, Self

from armsyn.cli.track_lines import LineReader, NumberedTarget, parse_target
from armsyn.errors import FormatError, InputError, RefusedMotionError
from armsyn.planning.tracking import LEAD_S, ReachTracker
from armsyn.planning.tracking_state import Arrival

LOOK_S = 0.01
"""Seconds between two looks at what has happened while no line comes."""

Tell = Callable[[dict[str, Any]], None]


class TargetFeed(threading.Thread):
    """Reads lines, and turns the tracker to each target when it is due.

    Nothing is planned before the stream has begun, of which it tells as ``ready``. A line with a
    time waits for it, and those after it wait, too. Of lines without, the newest that
    has come counts: those before it are passed over, unless each is to be gone to in turn.

    Parameters
    ----------
    tracker : ReachTracker
        Its `on_end` must be this feed's `ended`.
    reader : LineReader
    tell : callable
        Takes what has happened, ready for JSON; called in this thread only.
    each : bool
        Whether to turn to a target only when the hand has arrived at the one before.

    Attributes
    ----------
    error : Exception or None
        What ended the thread too early; the tracker finishes then.
    """

    def __init__(
        self, tracker: ReachTracker, reader: LineReader, tell: Tell, *, each: bool = False
    ) -> None:
        super().__init__(name="armsyn targets", daemon=True)
        self.tracker = tracker
        self.error: Exception | None = None
        self._reader = reader
        self._tell = tell
        self._each = each
        self._due: deque[NumberedTarget] = deque()
        self._ends: queue.SimpleQueue[Arrival] = queue.SimpleQueue()
        self._left = threading.Event()
        self._ready = False

    def ended(self, arrival: Arrival) -> None:
        """Take the end of following a target, in the stream's thread."""
        self._ends.put(arrival)

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._left.set()
        self.join()
        self._tell_ends()

    def run(self) -> None:
        """Work until the stream has ended."""
        try:
            while not self._left.is_set():
                self._look()
        except Exception as error:  # noqa: BLE001 - it is raised once the arm is at rest
            self.error = error
            self.tracker.finish()

    def _look(self) -> None:
        if self._reader.ended:
            self._left.wait(LOOK_S)
        for number, text in self._reader.read(LOOK_S):
            self._take(number, text)
        if not self._streams():
            return
        self._tell_ends()
        target = self._next()
        if target is not None:
            self._aim(target)
        elif self._reader.ended and not self._due:
            self.tracker.finish()

    def _streams(self) -> bool:
        """Whether the arm takes setpoints already; says once when it begins to."""
        if not self._ready and self.tracker.now > 0.0:
            self._ready = True
            self._tell({"event": "ready"})
        return self._ready

    def _take(self, number: int, text: bytes) -> None:
        try:
            self._due.append(NumberedTarget(number, parse_target(text)))
        except FormatError as error:
            self._say("malformed", number, None, reason=str(error))

    def _next(self) -> NumberedTarget | None:
        """The target to turn to now."""
        if self._each and not self.tracker.at_rest:
            return None
        while self._is_due(0):
            target = self._due.popleft()
            if self._each or not self._is_due(0):
                return target
            self._say("passed_over", target.number, target.line.id)
        return None

    def _is_due(self, place: int) -> bool:
        if place >= len(self._due):
            return False
        t = self._due[place].line.t
        return t is None or t <= self.tracker.now + 2.0 * LEAD_S

    def _aim(self, target: NumberedTarget) -> None:
        number, line = target.number, target.line
        try:
            aim = self.tracker.aim(line.target, line.t or 0.0, tag=target)
        except (RefusedMotionError, InputError) as error:
            reason = " ".join(str(error).split())
            self._say("refused", number, line.id, reason=reason, kind=type(error).__name__)
            return
        self._say(
            "accepted",
            number,
            line.id,
            target_m=list(line.target),
            t_s=aim.begin,
            like=aim.planned.learned,
            time_scale=aim.planned.time_scale,
            expected_s=aim.planned.duration,
        )

    def _tell_ends(self) -> None:
        while not self._ends.empty():
            end = self._ends.get()
            target: NumberedTarget = end.aim.tag
            self._say(
                end.how,
                target.number,
                target.line.id,
                t_s=end.time,
                time_s=max(0.0, end.time - end.aim.begin),
                error_mm=1e3 * end.error,
            )

    def _say(self, event: str, number: int, given: Any, **facts: Any) -> None:
        self._tell({"event": event, "line": number, "id": given, **facts})
