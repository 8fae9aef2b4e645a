"""Real-time scheduling: asked for, refused, given back."""

import os
from types import SimpleNamespace

import pytest

from armsyn.driver import Ending
from armsyn.driver import realtime as module
from armsyn.driver.realtime import CURE, PRIORITY, realtime
from tests.driver.stepped import SteppedArm


class Scheduler:
    """What the module uses of `os`, with or without permission."""

    SCHED_FIFO, SCHED_RESET_ON_FORK = 1, 0x40000000
    sched_param = SimpleNamespace

    def __init__(self, *, permits: bool, privileged: bool = True) -> None:
        self.policy, self.parameters = 0, SimpleNamespace(sched_priority=0)
        self.permits, self.privileged = permits, privileged

    def sched_getscheduler(self, _: int) -> int:
        return self.policy

    def sched_getparam(self, _: int) -> SimpleNamespace:
        return self.parameters

    def sched_setscheduler(self, _: int, policy: int, parameters: object) -> None:
        takes_back = self.policy & self.SCHED_RESET_ON_FORK & ~policy
        if not self.permits or (takes_back and not self.privileged):
            raise PermissionError
        self.policy, self.parameters = policy, parameters  # type: ignore[assignment]


def test_it_is_asked_for_and_given_back(monkeypatch: pytest.MonkeyPatch) -> None:
    system = Scheduler(permits=True)
    system.sched_param = lambda priority: SimpleNamespace(sched_priority=priority)  # type: ignore[assignment, method-assign]
    monkeypatch.setattr(module, "os", system)
    with realtime() as refusal:
        assert refusal == ""
        assert system.policy == system.SCHED_FIFO | system.SCHED_RESET_ON_FORK
        assert system.parameters.sched_priority == PRIORITY
    assert system.policy == 0


def test_without_privileges_children_stay_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    system = Scheduler(permits=True, privileged=False)
    system.sched_param = lambda priority: SimpleNamespace(sched_priority=priority)  # type: ignore[assignment, method-assign]
    monkeypatch.setattr(module, "os", system)
    with realtime():
        pass
    assert system.policy == system.SCHED_RESET_ON_FORK  # no longer real-time


def test_a_refusal_is_said_with_its_cure_and_is_no_error(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    session = stepped.session()
    session.realtime = True
    recording = session.run(stepped.way(0.3))
    assert recording.ending is Ending.COMPLETED
    assert recording.events[0][1:] == (CURE, "warning")


def test_nothing_is_asked_for_that_is_not_wanted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "os", None)
    with realtime(wanted=False) as refusal:
        assert refusal == ""
