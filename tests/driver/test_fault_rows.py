"""Rows of the table of faults (`armsyn/driver/faults.md`) that the simulator's faults show."""

import ast
import time
from pathlib import Path

import pytest

import armsyn
from armsyn.driver import Ending, Recording
from armsyn.errors import (
    ArmFaultError,
    HardwareFaultError,
    PortLostError,
    ServoMissingError,
)
from tests.driver.stepped import SteppedArm, deafen, present_tick
from tests.driver.witness import Witness, register

LARGE = (0.6, 0.3, -0.6, 0.9)
RATE = 200.0
READ_ONLY = {0x01, 0x02, 0x82, 0x8A}
REBOOT = 0x08


def inject(stepped: SteppedArm, fault: str) -> None:
    stepped.port.simulation.catch_up(stepped.now())
    stepped.port.simulation.inject(fault)


def instructions(stepped: SteppedArm) -> set[int]:
    return {packet[7] for packet in stepped.bus.serial_port.written}


def recorded(stepped: SteppedArm, fault: str, at: float = 0.3) -> Recording:
    """A large motion that a fault strikes, and the arm gets through."""
    stepped.at(at, lambda: inject(stepped, fault))
    return stepped.session().run(stepped.way(*LARGE))


@pytest.mark.fault(7)
def test_two_servos_of_one_id_are_refused(stepped: SteppedArm) -> None:
    inject(stepped, "duplicate-id:id=3,as=2")
    with pytest.raises(ServoMissingError, match=r"servo 3 \(shoulder_rotation\)"):
        stepped.session()
    assert instructions(stepped) <= READ_ONLY


@pytest.mark.fault(14)
def test_a_wrong_baud_rate_is_asked_about_and_nothing_is_written(stepped: SteppedArm) -> None:
    inject(stepped, "wrong-baud:baud=57600")
    with pytest.raises(ServoMissingError, match=r"at 1000000 baud .*armsyn scan") as caught:
        stepped.session()
    assert caught.value.servo_ids == tuple(range(1, 8))
    assert instructions(stepped) <= READ_ONLY


@pytest.mark.fault(2, 3, 4, 5, 6)
@pytest.mark.parametrize(
    "fault",
    [
        "truncated-status:probability=0.02",
        "lost-bytes:probability=0.02",
        "crc-error:probability=0.02",
        "missing-stuffing",
        "lying-length:probability=0.02",
        "lying-length:length=0,probability=0.02",
        "local-echo",
        "local-echo:share=0.5",
        "chunked-reply:bytes=16,gap=0.0002",
        "duplicate-reply",
    ],
)
def test_a_line_that_is_damaged_a_little_does_no_harm(stepped: SteppedArm, fault: str) -> None:
    witness = Witness(stepped, RATE)
    witness.begin("run")
    recording = recorded(stepped, fault)
    assert recording.ending is Ending.COMPLETED
    assert not witness.broken
    assert stepped.port.simulation.strikes or "stuffing" in fault  # which few replies need
    off = abs(recording.measured_rad - recording.commanded_rad)[~recording.stale]
    assert off.max() < 0.35


@pytest.mark.fault(18, 19)
@pytest.mark.parametrize(
    "error", ["overload", "overheating", "electrical-shock", "encoder-error", "input-voltage"]
)
def test_a_hardware_error_is_latched_and_nobody_reboots_the_servo(
    stepped: SteppedArm, error: str
) -> None:
    session = stepped.session()
    stepped.at(0.3, lambda: inject(stepped, f"{error}:id=4,count=1"))
    with pytest.raises(HardwareFaultError, match=r"servo 4 \(elbow_flexion\) reports") as caught:
        session.run(stepped.way(*LARGE))
    assert caught.value.servo_id == 4
    stepped.clock.advance(1.0)
    for _ in range(2):
        with pytest.raises(ArmFaultError):
            session.run(stepped.way(*LARGE))
        with pytest.raises(HardwareFaultError):
            stepped.session()
    assert REBOOT not in instructions(stepped)
    assert stepped.by_id[4].alert


@pytest.mark.fault(19)
def test_a_servo_that_gets_hot_is_warned_of(stepped: SteppedArm) -> None:
    limit = register(stepped.by_id[4], "Present Temperature") + 3
    stepped.by_id[4].memory.store("Temperature Limit", limit)
    recording = stepped.session().run(stepped.way(*LARGE))
    assert recording.ending is Ending.COMPLETED
    warnings = [event.text for event in recording.events if event.level == "warning"]
    assert len(warnings) == 1
    assert warnings[0].startswith("elbow_flexion is ")
    assert f"its servo stops at {limit}" in warnings[0]


@pytest.mark.fault(25)
def test_a_watchdog_that_expires_in_mid_stream_is_found_and_latched(stepped: SteppedArm) -> None:
    session = stepped.session()
    stepped.at(0.3, lambda: inject(stepped, "watchdog-expired:id=4"))
    with pytest.raises(
        HardwareFaultError, match=r"servo 4 .* stopped by its bus watchdog"
    ) as found:
        session.run(stepped.way(*LARGE))
    assert found.value.servo_id == 4
    assert "armsyn clear" in str(found.value)
    with pytest.raises(HardwareFaultError, match="armsyn clear"):
        stepped.session()


@pytest.mark.fault(12)
def test_a_port_that_comes_back_moves_nothing(stepped: SteppedArm) -> None:
    session = stepped.session()
    stepped.at(0.3, lambda: inject(stepped, "unplugged:for=0.1"))
    with pytest.raises(PortLostError, match="was lost while in use"):
        session.run(stepped.way(*LARGE))
    stepped.port.wait_until(stepped.now() + 0.4)
    goals, here = stepped.value("Goal Position"), stepped.positions()
    stepped.port.wait_until(stepped.now() + 1.0)
    assert stepped.value("Goal Position") == goals
    assert abs(stepped.positions() - here).max() < 0.002
    with pytest.raises(ArmFaultError, match="ended with a fault"):
        session.run(stepped.way(*LARGE))


@pytest.mark.fault(21)
def test_a_goal_that_a_servo_does_not_take_is_found_by_reading_back(stepped: SteppedArm) -> None:
    elbow = stepped.by_id[4]
    present = present_tick(elbow)
    elbow.memory.store("Goal Position", present + 300)
    deafen(elbow, 116, present)
    with pytest.raises(HardwareFaultError, match=r"servo 4 .* as its Goal Position"):
        stepped.session().run(stepped.way(*LARGE))
    assert stepped.torque() == [0] * 7


@pytest.mark.fault(28)
def test_no_clock_that_can_be_set_is_looked_at(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    def set_by_somebody() -> float:
        raise AssertionError("the wall clock was asked")

    monkeypatch.setattr(time, "time", set_by_somebody)
    assert stepped.session().run(stepped.way(0.3)).ending is Ending.COMPLETED
    folder = Path(armsyn.__file__).parent
    for path in (*(folder / "driver").glob("*.py"), *(folder / "safety").glob("*.py")):
        names = {ast.unparse(n) for n in ast.walk(ast.parse(path.read_text())) if is_time(n)}
        assert names <= {"time.monotonic", "time.sleep"}, path.name


def is_time(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Name)
        and node.value.id == "time"
        and node.attr in vars(time)
    )


@pytest.mark.fault(40)
def test_another_master_is_heard_and_told_of(stepped: SteppedArm) -> None:
    recording = recorded(stepped, "foreign-traffic:every=0.02")
    assert recording.ending is Ending.COMPLETED
    told = [event for event in recording.events if "another master" in event.text]
    assert len(told) == 1
    assert told[0].level == "warning"
    assert stepped.bus.foreign_traffic > 10


@pytest.mark.fault(40)
def test_an_arm_to_itself_hears_no_strangers(stepped: SteppedArm) -> None:
    recording = stepped.session().run(stepped.way(*LARGE))
    assert not any("another master" in event.text for event in recording.events)


@pytest.mark.fault(15, 16)
@pytest.mark.parametrize("fault", ["return-delay:for=0.5", "latency-timer:latency=0.004,for=0.5"])
def test_replies_that_become_late_are_waited_for(stepped: SteppedArm, fault: str) -> None:
    stepped.at(0.3, lambda: inject(stepped, fault))
    recording = stepped.session(rate=50.0).run(stepped.way(*LARGE))
    assert recording.ending is Ending.COMPLETED
    assert recording.command_success_rate == 1.0


@pytest.mark.fault(17)
def test_an_answer_of_before_does_not_count_as_what_was_written(stepped: SteppedArm) -> None:
    stepped.at(0.0, lambda: inject(stepped, "duplicate-reply"))
    recording = stepped.session().run(stepped.way(*LARGE))
    assert recording.ending is Ending.COMPLETED
    assert stepped.value("Bus Watchdog") == [0] * 7
