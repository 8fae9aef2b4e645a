"""Stop requests and the collector: what is taken over is given back."""

import gc
import os
import signal
import threading

import pytest

from armsyn.driver.collector import collector_frozen
from armsyn.driver.signals import SIGNALS, StopRequests


@pytest.mark.parametrize("number", SIGNALS)
def test_signals_are_counted_and_given_back(number: signal.Signals) -> None:
    before = signal.getsignal(number)
    with StopRequests() as stops:
        os.kill(os.getpid(), number)
        os.kill(os.getpid(), number)
        assert stops.count == 2
    assert signal.getsignal(number) == before


def test_every_time_it_counts_from_zero() -> None:
    stops = StopRequests()
    for _ in range(2):
        with stops:
            stops.request()
        assert stops.count == 1


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
