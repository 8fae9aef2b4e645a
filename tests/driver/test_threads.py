"""Several threads on one session: one of them moves the arm, the others are told."""

import threading
from dataclasses import replace

import pytest

from armsyn.driver import Ending
from armsyn.errors import ArmFaultError, RefusedMotionError
from tests.driver.stepped import SteppedArm


def test_a_second_run_is_refused_while_one_is_under_way(stepped: SteppedArm) -> None:
    session = stepped.session()
    refusals: list[BaseException] = []

    def try_it() -> None:
        try:
            session.run(stepped.way(0.1))
        except ArmFaultError as error:
            refusals.append(error)

    def on_tick(path_time: float, _: float) -> None:
        if path_time > 0.1 and not refusals:
            thread = threading.Thread(target=try_it)
            thread.start()
            thread.join()

    recording = session.run(stepped.way(0.3), on_tick=on_tick)
    assert recording.ending is Ending.COMPLETED
    assert "another thread moves the arm" in str(refusals[0])
    assert session.fault is None


def test_a_run_after_a_refused_one_is_allowed(stepped: SteppedArm) -> None:
    session = stepped.session()
    way = stepped.way(0.3)
    assert way.angles is not None
    with pytest.raises(RefusedMotionError):
        session.run(replace(way, angles=way.angles + 0.5))
    assert session.run(stepped.way(0.2)).ending is Ending.COMPLETED
