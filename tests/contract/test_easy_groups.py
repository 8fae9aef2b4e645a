"""Group commands of the SDK's easy layer, unmodified, at a running simulator."""

from collections.abc import Iterator

import dynamixel_easy_sdk as easy
import pytest
from dynamixel_easy_sdk import DxlError, DxlRuntimeError, OperatingMode

from firmware_sim.testing import running

from .clients import BAUD_RATE, SET_UP, STICKS, Ledger, Recorder, public, until

SERVOS = ("xm540-w270:1", "xm430-w350:2", "xl430-w250:3", "xl330-m288:4")
WITH_CURRENT = (1, 2, 4)

motors = Recorder(None)
ledger = Ledger(motors)


@pytest.fixture(scope="module")
def port_name() -> Iterator[str]:
    with running(*SERVOS, arguments=SET_UP) as name:
        yield name


@pytest.fixture
def connector(port_name: str) -> Iterator[easy.Connector]:
    """A connector to the one simulator, whose servos rest in position mode before and after."""
    link = easy.Connector(port_name, BAUD_RATE)
    try:
        yield link
        for servo_id in (1, 2, 3, 4):
            motor = link.createMotor(servo_id)
            assert (motor.torque_status, motor.operating_mode_status) == (0, OperatingMode.POSITION)
    finally:
        link.closePort()


class Group:
    """Motors that get the same commands; from one address, these go out as sync read or write."""

    def __init__(self, connector: easy.Connector, *servo_ids: int) -> None:
        self.members = [connector.createMotor(servo_id) for servo_id in servo_ids]
        self.connector = connector

    def _staged(self, name: str, *arguments: int) -> easy.GroupExecutor:
        executor = self.connector.createGroupExecutor()
        for member in self.members:
            motors.target = member
            executor.addCmd(getattr(motors, f"stage{name}")(*arguments))
        return executor

    def write(self, name: str, *arguments: int) -> None:
        self._staged(name, *arguments).executeWrite()

    def read(self, name: str) -> list[int | None]:
        return list(self._staged(name).executeRead())

    def switch(self, mode: OperatingMode) -> None:
        for member in self.members:
            member.setOperatingMode(mode)


@ledger.calls("stageLEDOn", "stageLEDOff", "stageIsLEDOn")
def test_leds(connector: easy.Connector) -> None:
    group = Group(connector, 4, 1, 3, 2)
    group.write("LEDOn")
    assert group.read("IsLEDOn") == [1, 1, 1, 1]
    group.write("LEDOff")
    assert group.read("IsLEDOn") == [0, 0, 0, 0]


@ledger.calls("stageEnableTorque", "stageDisableTorque", "stageIsTorqueOn")
@ledger.calls("stageSetGoalPosition", "stageGetPresentPosition")
def test_positions(connector: easy.Connector) -> None:
    group = Group(connector, 1, 2, 3, 4)
    with pytest.raises(DxlRuntimeError, match="Motor torque status mismatch"):
        group.write("SetGoalPosition", 2200)
    group.write("EnableTorque")
    assert group.read("IsTorqueOn") == [1, 1, 1, 1]
    for goal in (2200, 1900):
        group.write("SetGoalPosition", goal)
        near = pytest.approx([goal] * 4, abs=STICKS)
        until(lambda near=near: group.read("GetPresentPosition") == near)
    group.write("DisableTorque")
    assert group.read("IsTorqueOn") == [0, 0, 0, 0]


@ledger.calls("stageSetGoalVelocity", "stageGetPresentVelocity")
@ledger.calls("stageSetGoalPWM", "stageGetPresentPWM")
@ledger.calls("stageSetGoalCurrent", "stageGetPresentCurrent")
def test_negative_goals(connector: easy.Connector) -> None:
    cases = (
        (OperatingMode.VELOCITY, "Velocity", -60, 5, (1, 2, 3, 4)),
        (OperatingMode.PWM, "PWM", -300, 0, (1, 2, 3, 4)),
        (OperatingMode.CURRENT, "Current", -30, 5, WITH_CURRENT),
    )
    for mode, name, goal, tolerance, servo_ids in cases:
        group = Group(connector, *servo_ids)
        group.switch(mode)
        group.write("EnableTorque")
        group.write(f"SetGoal{name}", goal)
        near = pytest.approx([goal] * len(servo_ids), abs=tolerance)
        until(lambda group=group, near=near, name=name: group.read(f"GetPresent{name}") == near)
        group.write("DisableTorque")
        group.switch(OperatingMode.POSITION)


def test_an_executor_of_different_registers(connector: easy.Connector) -> None:
    """Commands to different addresses go out as bulk write and bulk read."""
    one, two, three = (connector.createMotor(servo_id) for servo_id in (1, 2, 3))
    executor = Recorder(connector.createGroupExecutor())
    for run in (executor.executeWrite, executor.executeRead):
        with pytest.raises(DxlRuntimeError) as caught:
            run()
        assert caught.value.dxl_error == DxlError.EASY_SDK_COMMAND_IS_EMPTY
    executor.addCmd(one.stageLEDOn())
    executor.addCmd(two.stageEnableTorque())
    executor.executeWrite()
    executor.addCmd(one.stageIsLEDOn())
    executor.addCmd(two.stageIsTorqueOn())
    executor.addCmd(three.stageGetPresentPWM())
    led, torque, duty = executor.executeRead()
    assert (led, torque, duty) == (1, 1, 0)
    assert two.torque_status == 1
    executor.clearStagedWriteCommands()
    executor.clearStagedReadCommands()
    executor.addCmd(one.stageLEDOff())
    executor.addCmd(two.stageDisableTorque())
    executor.executeWrite()
    assert (one.isLEDOn(), two.isTorqueOn()) == (0, 0)
    assert executor.called == public(easy.GroupExecutor)


def test_every_staging_method_is_exercised() -> None:
    assert {name for name in public(easy.Motor) if name.startswith("stage")} == ledger.listed
