"""Setting servos up: what is written, in which order, what is refused, and the way back."""

import tempfile
from pathlib import Path

import msgspec
import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.driver.scan import FoundServo
from armsyn.driver.setup import find_lone_servo, plan_arm, plan_servo
from armsyn.errors import (
    HardwareFaultError,
    PortLostError,
    ServoMismatchError,
    ServoMissingError,
    TorqueOnError,
)
from tests.driver.set_up_bench import (
    SteppedLineBus,
    arm_bench,
    bench,
    carried_out,
    names,
    planned,
    servo_of,
)


@pytest.fixture(scope="module")
def widowx() -> ArmDescription:
    return load_arm("widowx_250s", calibrated=False)


def test_a_factory_fresh_servo_becomes_a_shadow(widowx: ArmDescription) -> None:
    bus = bench("xm430-w350:1")
    plan = planned(bus, widowx, 3)
    assert names(plan) == ["Return Delay Time", "Drive Mode", "Secondary ID", "ID", "Baud Rate"]
    assert plan.target == FoundServo(1_000_000, 2, 3, 1020, 45)
    now = carried_out(bus, plan)
    assert now.found == plan.target
    assert bus.baudrate == 1_000_000
    assert bus.value(3, "Secondary(Shadow) ID") == 2
    assert bus.value(3, "Drive Mode") == 1
    assert bus.value(3, "Return Delay Time") == 0
    assert bus.value(3, "Baud Rate") == 3
    again = planned(bus, widowx, 3)
    assert not again.changes


@pytest.mark.parametrize("baud", [9_600, 115_200, 4_000_000])
def test_it_is_found_at_rates_that_nobody_expects(widowx: ArmDescription, baud: int) -> None:
    bus = bench("xm430-w350:77", baud=baud)
    plan = planned(bus, widowx, 1)
    assert (plan.image.found.baud, plan.image.found.servo_id) == (baud, 77)
    carried_out(bus, plan)
    assert bus.ping(1) == (1020, 45)


@pytest.mark.fault(16)
def test_settings_that_a_driver_must_not_meet_are_put_right(widowx: ArmDescription) -> None:
    registers = {
        "Drive Mode": 0b1101,
        "Operating Mode": 4,
        "Secondary(Shadow) ID": 9,
        "Homing Offset": 1500,
        "Startup Configuration": 3,
        "Max Position Limit": 3000,
    }
    bus = arm_bench_of(widowx, 1, registers)
    bus.port.bus.servos[0].write(64, b"\0")  # its start-up configuration switched it on
    plan = planned(bus, widowx, 1)
    wanted = {change.name: change.wanted for change in plan.changes}
    assert wanted == {
        "Drive Mode": 0b0100,  # the time-based profile stays
        "Operating Mode": 3,
        "Secondary ID": 255,
        "Homing Offset": 0,
        "Startup Configuration": 2,
    }
    carried_out(bus, plan)
    assert bus.value(1, "Max Position Limit") == 3000


def arm_bench_of(arm: ArmDescription, servo_id: int, registers: dict[str, int]) -> SteppedLineBus:
    with tempfile.TemporaryDirectory() as folder:
        return arm_bench(Path(folder), [servo_of(arm, servo_id)], {servo_id: registers})


@pytest.mark.fault(23)
def test_a_homing_offset_that_counts_is_left_alone(widowx: ArmDescription) -> None:
    bus = arm_bench_of(widowx, 1, {"Homing Offset": -1024})
    assert not planned(bus, widowx, 1).changes


def test_a_gripper_with_a_current_limit_grips_by_current(widowx: ArmDescription) -> None:
    assert widowx.gripper is not None
    arm = msgspec.structs.replace(
        load_arm("openmanipulator_x", calibrated=False),
        gripper=msgspec.structs.replace(widowx.gripper, max_current=0.3),
    )
    bus = arm_bench_of(arm, 15, {})
    (change,) = planned(bus, arm, 15).changes
    assert (change.name, change.found, change.wanted) == ("Operating Mode", 3, 5)


def test_a_wheel_of_protocol_1_becomes_a_joint() -> None:
    arm = load_arm("reachy_right", calibrated=False)
    bus = arm_bench_of(
        arm, 14, {"CW Angle Limit": 0, "CCW Angle Limit": 0, "Status Return Level": 1}
    )
    plan = planned(bus, arm, 14)
    assert {c.name: c.wanted for c in plan.changes} == {
        "Status Return Level": 2,
        "Max Position Limit": 1023,
    }
    carried_out(bus, plan)
    assert bus.value(14, "CCW Angle Limit") == 1023


def test_a_classic_servo_gets_another_rate() -> None:
    arm = load_arm("reachy_right", calibrated=False)
    bus = bench("ax-18a:1", baud=57_600)
    plan = planned(bus, arm, 14)
    assert names(plan)[-2:] == ["ID", "Baud Rate"]
    now = carried_out(bus, plan)
    assert now.found == plan.target
    assert now.found.baud == servo_of(arm, 14).baud == bus.baudrate


def test_a_servo_that_speaks_protocol_1_is_taught_2(widowx: ArmDescription) -> None:
    bus = bench("xm430-w350:1", protocol=1)
    plan = planned(bus, widowx, 1)
    assert names(plan)[-2:] == ["Protocol Type", "Baud Rate"]
    carried_out(bus, plan)
    assert bus.port.bus.servos[0].protocol == 2
    assert bus.ping(1) == (1020, 45)


@pytest.mark.parametrize(
    ("servos", "faults", "said"),
    [
        (("xm430-w350:1", "xm430-w350:2"), (), "2 servos answer"),
        (("xm430-w350:1", "ax-12a:2"), (), "2 servos answer"),
        (("xm430-w350:1", "xl430-w250:3"), ("duplicate-id:id=3,as=1",), "two servos of that ID"),
        (("xl430-w250:1",), (), "is an xl430-w250, waist needs an xm430-w350"),
        (("mx-28:1",), (), "is an mx-28"),
    ],
)
def test_whoever_is_not_alone_or_another_is_refused(
    widowx: ArmDescription, servos: tuple[str, ...], faults: tuple[str, ...], said: str
) -> None:
    bus = bench(*servos, faults=faults)
    before = [bytes(servo.memory.data[:20]) for servo in bus.port.bus.servos]
    with pytest.raises(ServoMismatchError, match=said):
        planned(bus, widowx, 1)
    assert [bytes(servo.memory.data[:20]) for servo in bus.port.bus.servos] == before


def test_nobody_there_is_said(widowx: ArmDescription) -> None:
    bus = bench("xm430-w350:1", faults=["missing-servo:id=1"])
    with pytest.raises(ServoMissingError, match="at any baud rate"):
        find_lone_servo(bus, servo_of(widowx, 1), (57_600,))


@pytest.mark.fault(22)
def test_a_servo_under_torque_is_refused_and_keeps_it(widowx: ArmDescription) -> None:
    bus = bench("xm430-w350:1")
    bus.port.bus.servos[0].write(64, b"\1")
    with pytest.raises(TorqueOnError, match="armsyn release"):
        planned(bus, widowx, 2)
    assert bus.value(1, "Torque Enable") == 1
    assert bus.value(1, "ID") == 1


def test_torque_that_comes_on_after_the_question_is_refused_too(widowx: ArmDescription) -> None:
    bus = bench("xm430-w350:1")
    plan = planned(bus, widowx, 2)
    bus.port.bus.servos[0].write(64, b"\1")
    with pytest.raises(TorqueOnError):
        carried_out(bus, plan)
    assert bus.value(1, "Return Delay Time") == 250


@pytest.mark.fault(7)
def test_a_place_where_another_answers_is_refused(widowx: ArmDescription) -> None:
    bus = bench("xm430-w350:1", "xm430-w350:2")
    bus.port.bus.servos[1].memory.store("Baud Rate", 4)  # out of the first look's sight
    bus.port.bus.servos[1].take_identity()
    arm = msgspec.structs.replace(
        widowx,
        servo=tuple(msgspec.structs.replace(s, baud=2_000_000) for s in widowx.servo),
    )
    found = FoundServo(57_600, 2, 1, 1020, 45)
    with pytest.raises(ServoMismatchError, match="another servo answers there"):
        plan_servo(bus, arm, servo_of(arm, 2), found)


@pytest.mark.parametrize("after", range(5))
def test_a_power_cut_in_the_middle_is_said_and_the_next_run_finishes(
    widowx: ArmDescription, after: int
) -> None:
    bus = bench("xm430-w350:1")
    plan = planned(bus, widowx, 3)
    servo, written = bus.port.bus.servos[0], [0]
    original = servo.write

    def write(address: int, data: bytes, **options: bool) -> object:
        written[0] += 1
        error = original(address, data, **options)
        if written[0] == after + 1:
            servo.power_cycle(off_for=3.0)
        return error

    servo.write = write  # type: ignore[assignment, method-assign]
    with pytest.raises(HardwareFaultError, match=f"{after} of 5 settings written"):
        carried_out(bus, plan)
    bus.wait(4.0)
    again = planned(bus, widowx, 3)
    assert len(again.changes) < 5
    carried_out(bus, again)
    assert not planned(bus, widowx, 3).changes


def test_a_servo_that_is_gone_after_the_question_is_said(widowx: ArmDescription) -> None:
    bus = bench("xm430-w350:1")
    plan = planned(bus, widowx, 3)
    bus.port.simulation.inject("missing-servo:id=1")
    with pytest.raises(HardwareFaultError, match="0 of 5 settings written: check its power"):
        carried_out(bus, plan)


def test_a_value_that_the_servo_does_not_take_is_said(widowx: ArmDescription) -> None:
    bus = bench("xm430-w350:1")
    plan = planned(bus, widowx, 3)
    servo = bus.port.bus.servos[0]
    original = servo.write
    servo.write = lambda at, data, **o: 0 if at == 8 else original(at, data, **o)  # type: ignore[assignment, method-assign]
    with pytest.raises(HardwareFaultError, match=r"does not take 3 as its Baud Rate \(register 8"):
        carried_out(bus, plan)
    assert bus.value(3, "Baud Rate") == 1


def test_a_lost_port_is_said_as_such(widowx: ArmDescription) -> None:
    bus = bench("xm430-w350:1")
    plan = planned(bus, widowx, 3)

    def lost(_data: bytes) -> None:
        raise PortLostError("port stepped was lost")

    bus.line.write = lost  # type: ignore[method-assign]
    with pytest.raises(PortLostError):
        carried_out(bus, plan)


def test_an_arm_together_gets_only_what_differs(tmp_path: Path, widowx: ArmDescription) -> None:
    bus = arm_bench(tmp_path, widowx.servo, {4: {"Return Delay Time": 250}, 9: {"Drive Mode": 8}})
    plans = plan_arm(bus, widowx)
    assert [plan.servo.id for plan in plans] == [servo.id for servo in widowx.servo]
    assert {plan.servo.id: names(plan) for plan in plans if plan.changes} == {
        4: ["Return Delay Time"],
        9: ["Drive Mode"],
    }
    for plan in plans:
        carried_out(bus, plan)
    assert not any(plan.changes for plan in plan_arm(bus, widowx))


def test_an_arm_with_two_baud_rates_is_set_up_together(
    tmp_path: Path, widowx: ArmDescription
) -> None:
    bus = arm_bench(tmp_path, widowx.servo)
    for servo in bus.port.bus.servos[2:5]:
        servo.memory.store("Baud Rate", 1)
        servo.take_identity()
    bus.setBaudRate(57_600)
    plans = plan_arm(bus, widowx)
    rates = [plan.image.found.baud for plan in plans]
    assert rates == [57_600 if n in (2, 3, 4) else 1_000_000 for n in range(len(plans))]
    assert {p.servo.id: names(p) for p in plans if p.changes} == {
        servo.id: ["Baud Rate"] for servo in widowx.servo[2:5]
    }
    for plan in plans:
        carried_out(bus, plan)
    assert not any(plan.changes for plan in plan_arm(bus, widowx))


def test_who_is_missing_is_said_with_the_rates_tried(
    tmp_path: Path, widowx: ArmDescription
) -> None:
    bus = arm_bench(tmp_path, widowx.servo)
    bus.port.simulation.inject("missing-servo:id=3")
    bus.setBaudRate(57_600)
    with pytest.raises(ServoMissingError, match=r"servo 3 .* at 57600 or 1000000 baud"):
        plan_arm(bus, widowx)


def test_an_arm_together_must_be_whole(tmp_path: Path, widowx: ArmDescription) -> None:
    bus = arm_bench(tmp_path, widowx.servo)
    for servo_id in (3, 9):
        bus.port.simulation.inject(f"missing-servo:id={servo_id}")
    with pytest.raises(ServoMissingError, match=r"3 \(shoulder\), 9 \(gripper\)") as caught:
        plan_arm(bus, widowx)
    assert caught.value.servo_ids == (3, 9)


def test_two_protocols_on_one_bus(tmp_path: Path) -> None:
    arm = load_arm("reachy_right", calibrated=False)
    bus = arm_bench(
        tmp_path, arm.servo, {14: {"Return Delay Time": 9}, 10: {"Return Delay Time": 250}}
    )
    changed = {p.servo.id: names(p) for p in plan_arm(bus, arm) if p.changes}
    assert changed.pop(14) == ["Return Delay Time"]
    assert changed.pop(10) == ["Return Delay Time"]
    assert not changed
