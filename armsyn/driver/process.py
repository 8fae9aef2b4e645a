"""Running an arm in a process of its own, which nothing that the caller does can hold up.

The child opens the port, runs the motions and answers with what it recorded. Requests to stop go to
it through a pipe. When the caller dies, the pipe ends: the child lets the arm decelerate and hold,
switches the watchdog off as after any stop, and ends, so that no orphan goes on moving. When the
child dies, the servos' own watchdog stops them, and the caller says so.
"""

from __future__ import annotations

import queue
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from types import FrameType
from typing import Any

from armsyn.arm import ArmDescription
from armsyn.driver.recording import Ending, Recording
from armsyn.driver.session import ArmSession
from armsyn.driver.signals import SIGNALS, StopRequests
from armsyn.driver.stream import OnTick
from armsyn.errors import (
    ArmFaultError,
    ArmsynError,
    BusTimeoutError,
    ServoMissingError,
    StopRequestedError,
)
from armsyn.motion import Motion
from armsyn.safety.collision import MARGIN

LISTENING = 0.05
"""Seconds between two looks at requests to stop."""

REPORTING = 0.1
"""Seconds of path time between two reports of progress."""

ENDING = 10.0
"""Seconds that a child may take to end once it has answered."""


@dataclass(frozen=True)
class Job:
    """What a process is to do.

    Parameters
    ----------
    port : str
    arm : ArmDescription
    rate_hz : float
    motions : tuple of (Motion, Motion or None)
        One after the other, each with its way to rest or None, as `ArmSession.run` takes them;
        after one that does not arrive, no other follows.
    simulated, accept_no_watchdog : bool
        As `ArmSession.open`.
    gravity, realtime : bool
        As the attributes of `ArmSession`.
    margin : float
        m that the last motion keeps from what must not touch, as of `ArmSession.run`.
    """

    port: str
    arm: ArmDescription
    rate_hz: float
    motions: tuple[tuple[Motion, Motion | None], ...]
    simulated: bool = False
    accept_no_watchdog: bool = False
    gravity: bool = True
    realtime: bool = False
    margin: float = MARGIN


class JobFailedError(ArmFaultError):
    """The process of a job ended without a word."""


@dataclass(frozen=True)
class JobResult:
    """What came of a job.

    Attributes
    ----------
    recordings : tuple of Recording
        One a motion that was streamed, also of one that failed.
    error : Exception or None
        What ended it.
    """

    recordings: tuple[Recording, ...]
    error: BaseException | None = None


def run_in_process(
    job: Job, stops: StopRequests | None = None, on_tick: OnTick | None = None
) -> JobResult:
    """Run motions in a process of its own.

    Parameters
    ----------
    job : Job
    stops : StopRequests, optional
        Requests to stop; signals count meanwhile, as in `ArmSession.run`.
    on_tick : callable, optional
        Called every tenth of a second, with path time and duration, s.

    Returns
    -------
    JobResult
        Errors of the arm are in it, so that what was recorded is not lost.

    Raises
    ------
    JobFailedError
        The process died; the servos' own watchdog stops them.
    """
    stops = StopRequests() if stops is None else stops
    with stops:
        child, pipe = _start()
        try:
            return _listen(pipe, child.pid, job, stops, on_tick)
        finally:
            pipe.close()  # which a child that still moves takes as a request to stop
            try:
                child.wait(ENDING)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()


def run_here(
    job: Job, stops: StopRequests | None = None, on_tick: OnTick | None = None
) -> JobResult:
    """Run motions in this process; as `run_in_process`."""
    recordings: list[Recording] = []
    error: BaseException | None = None
    try:
        _run(job, StopRequests() if stops is None else stops, recordings, on_tick)
    except Exception as caught:  # noqa: BLE001 - it is in the result, with what was recorded
        error = caught
    return JobResult(tuple(recordings), error)


def _start() -> tuple[subprocess.Popen[bytes], Connection]:
    """Start a child, and return it with our end of the pipe."""
    ours, theirs = socket.socketpair()
    with theirs:
        child = subprocess.Popen(
            [sys.executable, "-m", "armsyn.driver.process_child", str(theirs.fileno())],
            stdin=subprocess.DEVNULL,
            pass_fds=(theirs.fileno(),),
            start_new_session=True,  # Ctrl-C at the terminal is ours, who pass it on
        )
    return child, Connection(ours.detach())


def _listen(
    pipe: Connection, process: int, job: Job, stops: StopRequests, on_tick: OnTick | None
) -> JobResult:
    told = 0
    _tell(pipe, job)
    while True:
        while told < stops.count:
            told += 1
            _tell(pipe, "stop")
        if not pipe.poll(LISTENING):
            continue
        try:
            kind, content = pipe.recv()
        except (EOFError, OSError) as error:
            raise JobFailedError(
                f"process {process}, which moved the arm, died: the servos stop by their own"
                " watchdog; look at the arm, then armsyn clear lets it move again"
            ) from error
        if kind == "tick" and on_tick is not None:
            on_tick(*content)
        if kind == "result":
            recordings, packed = content
            return JobResult(recordings, None if packed is None else _unpacked(packed))


def _tell(pipe: Connection, what: object) -> None:
    try:
        pipe.send(what)
    except OSError:
        return  # it has ended; what it said last is still to be read


def serve(pipe: Connection) -> None:
    """Do the job that comes through a pipe, and answer; runs in the child.

    Parameters
    ----------
    pipe : Connection
    """
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    try:
        job: Job = pipe.recv()
    except EOFError:
        return  # the caller died
    stops = _Told()
    listener = threading.Thread(target=_heed, args=(pipe, stops), daemon=True)
    listener.start()
    reports: queue.SimpleQueue[Any] = queue.SimpleQueue()
    reporter = threading.Thread(target=_report, args=(pipe, reports), daemon=True)
    reporter.start()
    recordings: list[Recording] = []
    error = None
    try:
        _run(job, stops, recordings, _progress(reports))
    except BaseException as caught:  # noqa: BLE001 - it is the caller's, who waits for it
        error = _packed(caught)
    reports.put(("result", (tuple(recordings), error)))
    reports.put(None)
    reporter.join()


def _run(
    job: Job, stops: StopRequests, recordings: list[Recording], on_tick: OnTick | None
) -> None:
    with _opened(job, stops) as session:
        session.stops, session.gravity, session.realtime = stops, job.gravity, job.realtime
        for number, (motion, park) in enumerate(job.motions, 1):
            margin = job.margin if number == len(job.motions) else MARGIN
            try:
                session.run(motion, park, on_tick, margin=margin)
            except StopRequestedError as error:
                if recordings:
                    raise _stopped_between(number, len(job.motions)) from error
                raise
            finally:
                if session.recording is not None:
                    recordings.append(session.recording)
            if recordings[-1].ending is not Ending.COMPLETED:
                return


def _opened(job: Job, stops: StopRequests) -> ArmSession:
    """Open the session; silent servos are of no interest to who has asked to stop meanwhile."""
    try:
        return ArmSession.open(
            job.port,
            job.arm,
            job.rate_hz,
            simulated=job.simulated,
            accept_no_watchdog=job.accept_no_watchdog,
        )
    except (BusTimeoutError, ServoMissingError) as error:
        if not stops.count:
            raise
        raise StopRequestedError(
            f"asked to stop while the arm was looked for: nothing has moved ({error})"
        ) from error


def _stopped_between(number: int, motions: int) -> StopRequestedError:
    return StopRequestedError(
        f"asked to stop before motion {number} of {motions} began: the arm has moved and holds"
        f" where motion {number - 1} ended; armsyn park takes it to rest"
    )


class _Told(StopRequests):
    """Requests through a pipe: a signal to both processes is one request, which the caller tells.

    Attributes
    ----------
    alone : bool
        There is no caller any more: signals count.
    """

    def __init__(self) -> None:
        super().__init__()
        self.alone = False

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        if self.alone:
            super()._on_signal(number, frame)


def _heed(pipe: Connection, stops: _Told) -> None:
    """Take each word as a request to stop, and the end of the pipe as one if nobody has asked."""
    try:
        while True:
            pipe.recv()
            stops.request()
    except (EOFError, OSError):
        stops.alone, stops.park = True, False
        if not stops.count:  # a second one would hold at once what is decelerating already
            stops.request()


def _report(pipe: Connection, reports: queue.SimpleQueue[Any]) -> None:
    """Send what there is; a caller that does not listen holds up nobody but this thread."""
    while (report := reports.get()) is not None:
        try:
            pipe.send(report)
        except OSError:
            return


def _progress(reports: queue.SimpleQueue[Any]) -> Callable[[float, float], None]:
    said = -REPORTING

    def on_tick(path_time: float, duration: float) -> None:
        nonlocal said
        if abs(path_time - said) >= REPORTING and reports.qsize() < 10:
            said = path_time
            reports.put(("tick", (path_time, duration)))

    return on_tick


def _packed(error: BaseException) -> tuple[type[BaseException], str, dict[str, Any]]:
    """An error as what a pipe takes, whatever its constructor wants."""
    notes = "; ".join(getattr(error, "__notes__", ()))
    text = "; ".join(filter(None, (str(error), notes)))
    if isinstance(error, ArmsynError):
        return type(error), text, {k: v for k, v in vars(error).items() if k != "__notes__"}
    return ArmFaultError, f"{type(error).__name__}: {text}", {}


def _unpacked(packed: tuple[type[BaseException], str, dict[str, Any]]) -> BaseException:
    kind, text, evidence = packed
    error = kind.__new__(kind, text)
    error.args = (text,)
    vars(error).update(evidence)
    return error
