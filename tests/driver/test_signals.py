"""Stop requests and the collector: what is taken over is given back."""

import gc
import multiprocessing
import os
import signal
import threading
import time
from types import ModuleType

import pytest

from armsyn.driver import Ending, power, process, run, session
from armsyn.driver.collector import collector_frozen
from armsyn.driver.path import straight_way
from armsyn.driver.signals import SIGNALS, STUCK_AFTER, StopRequests
from armsyn.errors import (
    ArmFaultError,
    BusTimeoutError,
    HardwareFaultError,
    PortLostError,
    ServoMismatchError,
    ServoMissingError,
    StopRequestedError,
)
from tests.driver.stepped import SteppedArm


@pytest.mark.parametrize("number", SIGNALS)
def test_signals_are_counted_and_given_back(number: signal.Signals) -> None:
    before = signal.getsignal(number)
    with StopRequests() as stops:
        os.kill(os.getpid(), number)
        os.kill(os.getpid(), number)
        assert stops.count == 2
    assert signal.getsignal(number) == before


def test_requests_that_are_taken_over_twice_are_given_back_to_who_had_them() -> None:
    before = [signal.getsignal(number) for number in SIGNALS]
    with StopRequests() as stops:
        with stops:
            os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)  # the inner one leaves the outer one's
        assert stops.count == 2
    assert [signal.getsignal(number) for number in SIGNALS] == before


def test_requests_are_kept_until_they_are_met() -> None:
    stops = StopRequests()
    stops.request()
    with stops:
        assert stops.count == 1
        stops.request()
    assert stops.count == 2
    stops.met()
    with stops:
        assert stops.count == 0


def test_a_request_from_before_a_run_keeps_the_torque_off(stepped: SteppedArm) -> None:
    opened = stepped.session()
    opened.stops.request()
    stepped.bus.serial_port.written.clear()
    with pytest.raises(StopRequestedError, match="nothing has moved") as caught:
        opened.run(stepped.way(0.3))
    assert caught.value.exit_status == 130
    assert {packet[7] for packet in stepped.bus.serial_port.written} == {0x82}  # read only
    assert opened.run(stepped.way(0.3)).ending is Ending.COMPLETED  # it was met


@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("module", [session, run], ids=["posture", "facts"])
def test_a_signal_during_the_checks_keeps_the_torque_off(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch, number: signal.Signals, module: ModuleType
) -> None:
    """Before the trajectory is judged, and as the servos are read before torque."""
    name = "check_trajectory" if module is session else "read_facts"
    check = getattr(module, name)

    def interrupted(*arguments: object, **options: object) -> object:
        os.kill(os.getpid(), number)
        return check(*arguments, **options)

    opened = stepped.session()
    monkeypatch.setattr(module, name, interrupted)
    with pytest.raises(StopRequestedError):
        opened.run(stepped.way(0.3))
    assert stepped.torque() == [0] * 7
    assert opened.fault is None


def test_servos_that_are_silent_after_a_signal_are_a_stop_too(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    def silent(*_: object) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        raise BusTimeoutError("no answer from servo 3", (3,))

    opened = stepped.session()
    with monkeypatch.context() as patch:
        patch.setattr(run, "read_facts", silent)
        with pytest.raises(StopRequestedError, match="nothing has moved"):
            opened.run(stepped.way(0.3))
    assert opened.run(stepped.way(0.3)).ending is Ending.COMPLETED


@pytest.mark.parametrize(
    "fault",
    [HardwareFaultError("servo 4 has an error", 4), PortLostError("port stepped was lost")],
    ids=["hardware", "port"],
)
def test_a_fault_before_torque_is_said_whoever_asked_to_stop(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch, fault: ArmFaultError
) -> None:
    opened = stepped.session()

    def fails(*_: object) -> None:
        opened.stops.request()
        raise fault

    monkeypatch.setattr(run, "read_facts", fails)
    with pytest.raises(type(fault)) as caught:
        opened.run(stepped.way(0.3))
    assert caught.value is fault


@pytest.mark.parametrize(
    "fault",
    [HardwareFaultError("servo 4 moved by 80 ticks", 4), BusTimeoutError("no answer", (3,))],
    ids=["moved", "silent"],
)
def test_a_fault_as_torque_came_on_is_said_whoever_asked_to_stop(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch, fault: ArmFaultError
) -> None:
    """Nobody may then say that nothing has moved."""
    opened = stepped.session()

    def moved(*_: object) -> None:
        assert stepped.torque() == [1] * 7
        opened.stops.request()
        raise fault

    monkeypatch.setattr(power, "_check_still", moved)
    with pytest.raises(type(fault)) as caught:
        opened.run(stepped.way(0.3))
    assert caught.value is fault
    assert stepped.torque() == [0] * 7


@pytest.mark.parametrize(
    "fault",
    [ServoMismatchError("servo 3 is another model"), HardwareFaultError("servo 3 is hot", 3)],
    ids=["mismatch", "hardware"],
)
def test_a_job_whose_arm_is_not_fit_says_so_whoever_asked_to_stop(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch, fault: ArmFaultError
) -> None:
    stops = StopRequests()

    def unfit(*_: object, **__: object) -> None:
        stops.request()
        raise fault

    monkeypatch.setattr(session.ArmSession, "open", unfit)
    job = process.Job("stepped", stepped.description, 200.0, ((stepped.way(0.3), None),))
    assert process.run_here(job, stops).error is fault


@pytest.mark.parametrize("asked", [False, True], ids=["nobody asked", "asked to stop"])
def test_a_job_whose_arm_is_not_there(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch, *, asked: bool
) -> None:
    stops = StopRequests()

    def nobody(*_: object, **__: object) -> None:
        if asked:
            stops.request()
        raise ServoMissingError("no answer from servo 3", (3,))

    monkeypatch.setattr(session.ArmSession, "open", nobody)
    job = process.Job("stepped", stepped.description, 200.0, ((stepped.way(0.3), None),))
    error = process.run_here(job, stops).error
    assert isinstance(error, StopRequestedError if asked else ServoMissingError)
    assert "no answer from servo 3" in str(error)


@pytest.mark.parametrize("asked", [0, 1, 2])
def test_a_caller_that_dies_asks_to_stop_where_nobody_has(stepped: SteppedArm, asked: int) -> None:
    """Ctrl-C and closing the terminal come to one gentle stop; two Ctrl-C still hold at once."""
    opened = stepped.session()
    opened.stops = stops = process._Told()
    ours, theirs = multiprocessing.Pipe()

    def die() -> None:
        for _ in range(asked):
            ours.send("stop")
        ours.close()
        process._heed(theirs, stops)

    stepped.at(0.3, die)
    with theirs:
        recording = opened.run(stepped.way(0.6))
    assert recording.ending is (Ending.STOPPED_HOLDING if asked < 2 else Ending.ABORTED)
    assert stops.alone


def test_an_arm_that_stops_holds_when_its_caller_dies_meanwhile(stepped: SteppedArm) -> None:
    opened = stepped.session()
    opened.stops = stops = process._Told()
    ours, theirs = multiprocessing.Pipe()

    def die() -> None:
        ours.close()
        process._heed(theirs, stops)

    stepped.at(0.3, stops.request)
    stepped.at(0.35, die)
    with theirs:
        assert opened.run(stepped.way(0.6)).ending is Ending.STOPPED_HOLDING
    assert opened.fault is None
    assert stepped.torque() == [1] * 7


def test_a_stop_that_was_met_does_not_stop_the_next_run(stepped: SteppedArm) -> None:
    opened = stepped.session()
    stepped.at(0.2, opened.stops.request)
    assert opened.run(stepped.way(0.6)).ending is Ending.STOPPED_PARKED
    assert opened.run(stepped.way(0.3)).ending is Ending.COMPLETED


def test_a_request_that_came_too_late_stops_the_next_run(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = stepped.session()
    disarm = power.disarm_watchdog

    def interrupted(*arguments: object) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        disarm(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(power, "disarm_watchdog", interrupted)
    assert opened.run(stepped.way(0.3)).ending is Ending.COMPLETED
    here = opened.read_posture()
    with pytest.raises(StopRequestedError):
        opened.run(straight_way(here, stepped.description.rest, stepped.description, 200.0))


def test_another_thread_only_requests() -> None:
    seen = []

    def work() -> None:
        with StopRequests() as stops:
            stops.request()
            seen.append(stops.count)

    before = signal.getsignal(signal.SIGINT)
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [1]
    assert signal.getsignal(signal.SIGINT) == before


def test_the_collector_rests_and_comes_back() -> None:
    assert gc.isenabled()
    with collector_frozen():
        assert not gc.isenabled()
        assert gc.get_freeze_count() > 0
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0


def test_a_collector_that_was_off_stays_off() -> None:
    gc.disable()
    try:
        with collector_frozen():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_a_second_signal_breaks_into_a_function_that_is_stuck(stepped: SteppedArm) -> None:
    """Which neither decelerates nor comes back by itself; the arm is held."""
    signals = iter((signal.SIGINT, signal.SIGINT))

    def on_tick(path_time: float, _: float) -> None:
        while path_time > 0.2:
            time.sleep(1.5 * STUCK_AFTER)
            os.kill(os.getpid(), next(signals))

    opened = stepped.session()
    with pytest.raises(ArmFaultError, match="a function called at each tick is stuck") as caught:
        opened.run(stepped.way(0.3), on_tick=on_tick)
    assert "holding, watchdog armed" in str(caught.value)
    assert opened.recording is not None
    assert opened.recording.ending is Ending.FAULT


def test_two_signals_break_into_nothing_while_the_stream_goes_on() -> None:
    with StopRequests() as stops:
        stops.beat()
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)
        assert stops.count == 2


def test_two_signals_after_the_stream_are_not_a_stuck_function(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = stepped.session()
    disarm = power.disarm_watchdog

    def interrupted(*arguments: object) -> None:
        time.sleep(1.5 * STUCK_AFTER)  # a slow bus
        for _ in range(2):
            os.kill(os.getpid(), signal.SIGINT)
        disarm(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(power, "disarm_watchdog", interrupted)
    assert opened.run(stepped.way(0.3)).ending is Ending.COMPLETED
    assert opened.fault is None


def test_a_stop_between_two_motions_says_that_the_arm_has_moved(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = stepped.session()
    stops = StopRequests()
    disarm = power.disarm_watchdog

    def interrupted(*arguments: object) -> None:
        stops.request()
        disarm(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(power, "disarm_watchdog", interrupted)
    monkeypatch.setattr(session.ArmSession, "open", lambda *_, **__: opened)
    arm, out = stepped.description, stepped.way(0.3)
    assert out.angles is not None
    back = straight_way(out.angles[-1], arm.rest, arm, 200.0)
    job = process.Job("stepped", arm, 200.0, ((out, None), (back, None)))
    result = process.run_here(job, stops)
    assert isinstance(result.error, StopRequestedError)
    assert "before motion 2 of 2 began: the arm has moved and holds" in str(result.error)
    assert "nothing has moved" not in str(result.error)
    assert len(result.recordings) == 1
