"""Grippers: widths, bounded force, and whether something is held."""

import msgspec
import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.driver.operate_grip import Gripper
from armsyn.errors import (
    DescriptionError,
    HardwareFaultError,
    InputError,
    ServoMismatchError,
    ServoMissingError,
)
from tests.driver.stepped import SteppedArm, deafen, without

OBSTACLE = "obstacle:id=15,tick=2100,side=above"  # 36.6 mm
GOAL_CURRENT = 102


@pytest.fixture(scope="session")
def omx() -> ArmDescription:
    return load_arm("openmanipulator_x")


@pytest.fixture
def stepped(omx: ArmDescription) -> SteppedArm:
    return SteppedArm(omx)


def gripper_of(stepped: SteppedArm) -> Gripper:
    return Gripper(stepped.bus, stepped.description, stepped)


def register(stepped: SteppedArm, name: str, servo_id: int = 15) -> int:
    return stepped.by_id[servo_id].memory.value(name)


@pytest.mark.parametrize("name", ["openmanipulator_x", "koch", "widowx_250s", "viperx_300s"])
@pytest.mark.parametrize("side", ["open", "closed"])
def test_grippers_open_and_close(name: str, side: str) -> None:
    stepped = SteppedArm(load_arm(name))
    gripper = gripper_of(stepped)
    width = getattr(gripper.description, f"width_{side}")
    found = gripper.move(width, gripper.force_of(None, None))
    assert found.arrived
    assert not found.held
    assert found.width == pytest.approx(width, abs=0.003)
    assert gripper.holds()


def test_a_gripper_of_protocol_1_opens() -> None:
    stepped = SteppedArm(load_arm("reachy_right"))
    gripper = gripper_of(stepped)
    assert gripper.mode_to_set() is None
    assert gripper.move(0.08, gripper.force_of(None, None)).arrived
    assert register(stepped, "Torque Limit", 17) == round(0.3 * 1023)


def test_the_current_limit_survives_the_change_of_mode(stepped: SteppedArm) -> None:
    gripper = gripper_of(stepped)
    assert register(stepped, "Operating Mode") == 3
    assert gripper.mode_to_set() == 5
    assert gripper.move(0.04, gripper.force_of(0.2, None)).arrived
    assert register(stepped, "Operating Mode") == 5
    assert register(stepped, "Goal Current") == round(0.2 / 2.69e-3)
    assert gripper.mode_to_set() is None


@pytest.mark.parametrize(
    ("address", "value", "said"),
    [(10, 1, "the other way round"), (12, 11, "follows the goals of servo 11")],
)
def test_a_gripper_that_is_not_set_up_is_refused(
    stepped: SteppedArm, address: int, value: int, said: str
) -> None:
    stepped.by_id[15].write(address, bytes([value]))
    with pytest.raises(ServoMismatchError, match=f"{said}.*armsyn setup"):
        gripper_of(stepped)
    assert register(stepped, "Torque Enable") == 0


def test_a_current_limit_that_is_not_taken_keeps_the_torque_off(stepped: SteppedArm) -> None:
    deafen(stepped.by_id[15], GOAL_CURRENT, round(0.2 / 2.69e-3))
    gripper = gripper_of(stepped)
    with pytest.raises(HardwareFaultError, match="does not take 74 as its Goal Current"):
        gripper.move(0.04, 0.2)
    assert not gripper.holds()


def test_something_between_the_fingers_is_held_with_the_current_asked_for(
    stepped: SteppedArm,
) -> None:
    gripper = gripper_of(stepped)
    stepped.port.simulation.inject(OBSTACLE)
    found = gripper.move(gripper.description.width_closed, gripper.force_of(0.3, None))
    assert found.held
    assert not found.arrived
    assert found.width == pytest.approx(0.0366, abs=0.001)
    assert found.current == pytest.approx(0.3, rel=0.1)
    stepped.clock.advance(5.0)
    assert abs(stepped.by_id[15].memory.value("Goal Current")) == round(0.3 / 2.69e-3)
    assert gripper.holds()
    assert gripper.width() == pytest.approx(0.0366, abs=0.001)


def test_a_servo_without_a_current_holds_with_bounded_duty() -> None:
    stepped = SteppedArm(load_arm("widowx_250s"))
    stepped.port.simulation.inject("obstacle:id=9,tick=2040,side=below")
    gripper = gripper_of(stepped)
    assert not gripper.measures_current
    found = gripper.move(gripper.description.width_closed, gripper.force_of(None, 0.2))
    assert found.held
    assert found.current is None
    assert register(stepped, "Goal PWM", 9) == round(0.2 * register(stepped, "PWM Limit", 9))


def test_widths_along_the_way_are_told(stepped: SteppedArm) -> None:
    widths: list[float] = []
    gripper = gripper_of(stepped)
    gripper.move(0.075, 0.5, widths.append)
    assert len(widths) > 5
    assert widths == sorted(widths)


def test_the_gripper_keeps_to_its_speed(stepped: SteppedArm, omx: ArmDescription) -> None:
    assert omx.gripper is not None
    slow = msgspec.structs.replace(omx.gripper, max_velocity=0.5)
    stepped = SteppedArm(msgspec.structs.replace(omx, gripper=slow))
    gripper = gripper_of(stepped)
    way = abs(omx.gripper.open)  # from tick 2048, the servo's zero
    began = stepped.now()
    gripper.move(gripper.description.width_open, 0.5)
    assert way / 0.5 < stepped.now() - began < way / 0.5 + 1.0


@pytest.mark.parametrize(
    ("current", "force", "said"),
    [
        (2.0, None, "described to take 0.5 A at most"),
        (0.0, None, "above 0 A"),
        (float("nan"), None, "above 0 A"),
        (None, 0.2, "measures its current: --current"),
    ],
)
def test_forces_that_cannot_be_are_refused(
    stepped: SteppedArm, current: float | None, force: float | None, said: str
) -> None:
    with pytest.raises(InputError, match=said):
        gripper_of(stepped).force_of(current, force)


def test_the_servos_own_limit_is_not_exceeded(stepped: SteppedArm) -> None:
    gripper = gripper_of(stepped)
    gripper.group.set("Current Limit", {15: 100})
    with pytest.raises(InputError, match=r"limited to 0\.27 A"):
        gripper.force_of(0.4, None)
    assert gripper.force_of(None, None) == pytest.approx(0.269)


def test_a_duty_is_of_servos_without_a_current() -> None:
    gripper = gripper_of(SteppedArm(load_arm("widowx_250s")))
    assert gripper.force_of(None, None) == 0.3
    with pytest.raises(InputError, match="measures no current: --force"):
        gripper.force_of(0.1, None)
    with pytest.raises(InputError, match="at most 100 percent"):
        gripper.force_of(None, 1.5)


@pytest.mark.parametrize("width", [0.0, 0.09, float("nan")])
def test_widths_that_it_does_not_have_change_nothing(stepped: SteppedArm, width: float) -> None:
    gripper = gripper_of(stepped)
    with pytest.raises(InputError, match="opens from 20 to 75 mm"):
        gripper.move(width, 0.3)
    assert register(stepped, "Operating Mode") == 3
    assert not gripper.holds()


def test_an_error_on_the_way_is_said(stepped: SteppedArm) -> None:
    gripper = gripper_of(stepped)
    stepped.at(0.1, lambda: stepped.port.simulation.inject("overload:id=15"))
    with pytest.raises(HardwareFaultError, match="hardware error: overload; see to the cause"):
        gripper.move(0.075, 0.5)


def test_a_person_may_stop_it(stepped: SteppedArm) -> None:
    gripper = gripper_of(stepped)

    def interrupted(width: float) -> None:
        if width > 0.05:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        gripper.move(0.075, 0.5, interrupted)
    gripper.stop()
    stepped.clock.advance(1.0)
    assert 0.05 < gripper.width() < 0.07
    assert gripper.holds()


def test_what_is_not_fit_to_grip_is_refused(stepped: SteppedArm, omx: ArmDescription) -> None:
    with pytest.raises(DescriptionError, match="no gripper"):
        Gripper(stepped.bus, msgspec.structs.replace(omx, gripper=None))
    stepped.by_id[15].memory.store("Bus Watchdog", 255)
    with pytest.raises(HardwareFaultError, match="armsyn clear"):
        gripper_of(stepped)
    stepped.by_id[15].memory.store("Bus Watchdog", 0)
    stepped.by_id[15].memory.store("Hardware Error Status", 0x20)
    with pytest.raises(HardwareFaultError, match="overload; see to the cause, then armsyn reboot"):
        gripper_of(stepped)
    stepped.damage = without(15)
    with pytest.raises(ServoMissingError, match=r"15 \(gripper\)"):
        gripper_of(stepped)


def test_lost_turns_are_refused(stepped: SteppedArm, omx: ArmDescription) -> None:
    servos = tuple(
        msgspec.structs.replace(s, zero_tick=0, rest_tick=0) if s.id == 15 else s for s in omx.servo
    )
    with pytest.raises(ServoMismatchError, match="lost its turns"):
        Gripper(stepped.bus, msgspec.structs.replace(omx, servo=servos))
