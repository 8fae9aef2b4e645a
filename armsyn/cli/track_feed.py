"""The thread of `armsyn track` that reads targets, plans how to follow them, and tells of it."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Mapping
from typing import Any, Self

from armsyn.cli.orientation_options import asked
from armsyn.cli.track_lines import LineReader, NumberedTarget, parse_target, turned
from armsyn.cli.track_waiting import WaitingTargets
from armsyn.errors import FormatError, InputError, RefusedMotionError
from armsyn.planning.tracking import ReachTracker
from armsyn.planning.tracking_state import Arrival

LOOK_S = 0.01
"""Seconds between two looks at what has happened while no line comes."""

NOT_TURNED = dict.fromkeys(("pointing", "orientation", "orientation_tolerance"))
"""Options of who asks for no orientation."""

Tell = Callable[[dict[str, Any]], None]


class TargetFeed(threading.Thread):
    """Reads lines, and turns the tracker to each target when it is due.

    Nothing is planned before the stream has begun, of which it tells as ``ready``; once the arm
    stops, nothing any more. Which target is next, `armsyn.cli.track_waiting` says.

    Parameters
    ----------
    tracker : ReachTracker
        Its `on_end` must be this feed's `ended`.
    reader : LineReader
    tell : callable
        Takes what has happened, ready for JSON; called in this thread, and on leaving.
    each : bool
        Whether to turn to a target only when the hand has arrived at the one before.
    longest : float
        Seconds after which tracking ends: no line's time may be beyond.
    options : mapping
        How hands are turned whose lines do not say, as `armsyn.cli.orientation_options` gives it.
    stopping : callable
        Whether the arm stops, and turns to no target any more.

    Attributes
    ----------
    error : Exception or None
        What ended the thread too early; the tracker finishes then.
    """

    def __init__(
        self,
        tracker: ReachTracker,
        reader: LineReader,
        tell: Tell,
        *,
        each: bool = False,
        longest: float = float("inf"),
        options: Mapping[str, Any] = NOT_TURNED,
        stopping: Callable[[], bool] = lambda: False,
    ) -> None:
        super().__init__(name="armsyn targets", daemon=True)
        self.tracker = tracker
        self.error: Exception | None = None
        self._reader = reader
        self._tell = tell
        self._each = each
        self._longest = longest
        self._options = options
        self._stopping = stopping
        self._waiting = WaitingTargets(each=each)
        self._followed: dict[int, NumberedTarget] = {}
        self._ends: queue.SimpleQueue[Arrival] = queue.SimpleQueue()
        self._left = threading.Event()
        self._ready = self._stopped = False

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
        for target in (*self._followed.values(), *self._waiting.give_up()):
            self._say("unfinished", target)

    def run(self) -> None:
        """Work until the stream has ended."""
        try:
            while not self._left.is_set():
                self._look()
        except Exception as error:  # noqa: BLE001 - it is raised once the arm is at rest
            self.error = error
            self.tracker.finish()

    def _look(self) -> None:
        self._read()
        if not self._streams():
            return
        self._tell_ends()
        target = None
        if not self._stops() and (not self._each or self.tracker.at_rest):
            target = self._waiting.next(self.tracker.now)
        if target is not None:
            self._aim(target)
        elif self._reader.ended and not self._waiting:
            self.tracker.finish()

    def _read(self) -> None:
        if self._reader.ended or self._waiting.full:
            self._left.wait(LOOK_S)
            return
        for number, text in self._reader.read(LOOK_S):
            self._take(number, text)

    def _streams(self) -> bool:
        """Whether the arm takes setpoints already; says once when it begins to."""
        if not self._ready and self.tracker.now > 0.0:
            self._ready = True
            self._tell({"event": "ready"})
        return self._ready

    def _stops(self) -> bool:
        """Whether the arm stops; for good, as a request that is met is forgotten elsewhere."""
        self._stopped = self._stopped or self._stopping()
        return self._stopped

    def _take(self, number: int, text: bytes) -> None:
        try:
            line = parse_target(text, self._longest)
            target = NumberedTarget(number, line, turned(line, self._options))
        except FormatError as error:
            self._tell({"event": "malformed", "line": number, "id": None, "reason": str(error)})
            return
        if self._stops():
            self._say("refused", target, reason="the arm is stopping", kind="StopRequestedError")
            return
        for other in self._waiting.add(target, self.tracker.now):
            self._say("passed_over", other)

    def _aim(self, target: NumberedTarget) -> None:
        line = target.line
        try:
            aim = self.tracker.aim(
                line.target, line.t or 0.0, tag=target, orientation=target.orientation
            )
        except (RefusedMotionError, InputError) as error:
            self._waiting.refused(target)
            self._say(
                "refused", target, reason=" ".join(str(error).split()), kind=type(error).__name__
            )
            return
        self._followed[target.number] = target
        for other in self._waiting.accepted(target):
            self._say("passed_over", other)
        chosen = aim.planned.chosen
        self._say(
            "accepted",
            target,
            t_s=aim.begin,
            target_m=list(line.target),
            orientation=asked(target.orientation),
            captured=chosen.learned,
            captured_rank=chosen.rank,
            outside_m=chosen.outside,
            time_scale=chosen.time_scale,
            planned_time_s=aim.planned.duration,
        )

    def _tell_ends(self) -> None:
        while not self._ends.empty():
            end = self._ends.get()
            target: NumberedTarget = end.aim.tag
            self._followed.pop(target.number, None)
            self._say(
                end.how,
                target,
                t_s=max(end.time, end.aim.begin),  # of one that another takes the place of first
                elapsed_s=max(0.0, end.time - end.aim.begin),
                hand_error_m=end.error,
                orientation_error_rad=None if target.orientation is None else end.turn,
            )

    def _say(self, event: str, target: NumberedTarget, **facts: Any) -> None:
        self._tell({"event": event, "line": target.number, "id": target.line.id, **facts})
