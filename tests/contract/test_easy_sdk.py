"""The SDK's easy layer, unmodified, at a running simulator: it knows models by their numbers.

It reads addresses and sizes out of its own control tables, so that each setter and getter also
compares those with the simulator's. Its groups are in `test_easy_groups`.
"""

from collections.abc import Callable, Iterator

import dynamixel_easy_sdk as easy
import pytest
from dynamixel_easy_sdk import Direction, DxlError, DxlRuntimeError, OperatingMode
from dynamixel_easy_sdk import ProfileConfiguration as Profile

from firmware_sim.testing import running

from .clients import BAUD_RATE, OK, SET_UP, STICKS, Ledger, Recorder, public, until

MODELS = {
    1: "xm540-w270",
    2: "xm430-w350",
    3: "xl430-w250",
    4: "xl330-m288",
    5: "xc330-t288",
    6: "xh540-w150",
    7: "2xl430-w250",
    8: "xd540-t150",
    9: "mx-28",
    10: "mx-106",
}
NUMBERS = {1: 1120, 2: 1020, 3: 1060, 4: 1200, 5: 1220, 6: 1110, 7: 1090, 8: 1111, 9: 30, 10: 321}
WITH_CURRENT = (1, 2, 4, 5, 6, 8, 10)
XL_320 = 200
WRONG_MODE = DxlError.EASY_SDK_OPERATING_MODE_MISMATCH
WRONG_TORQUE = DxlError.EASY_SDK_TORQUE_STATUS_MISMATCH
NOT_SUPPORTED = DxlError.EASY_SDK_FUNCTION_NOT_SUPPORTED
GAINS = {"PositionP": 84, "PositionI": 82, "PositionD": 80, "VelocityP": 78, "VelocityI": 76}

motors = Recorder(None)
ledger = Ledger(motors)


@pytest.fixture(scope="module")
def port_name() -> Iterator[str]:
    servos = [f"{name}:{servo_id}" for servo_id, name in MODELS.items()]
    with running(*servos, f"xl-320:{XL_320}", arguments=(*SET_UP, "--protocol", "2")) as name:
        yield name


def settings_of(link: easy.Connector) -> list[tuple[list[int], int, int]]:
    """Return each servo's EEPROM, with its torque and LED."""
    return [link._packet_handler.readTxRx(link._port_handler, i, 0, 66) for i in MODELS]


@pytest.fixture
def connector(port_name: str) -> Iterator[easy.Connector]:
    """A connector to the one simulator, which every test leaves as it found it."""
    link = easy.Connector(port_name, BAUD_RATE)
    try:
        before = settings_of(link)
        yield link
        assert settings_of(link) == before
    finally:
        link.closePort()


@pytest.fixture(params=list(MODELS), ids=list(MODELS.values()))
def motor(connector: easy.Connector, request: pytest.FixtureRequest) -> Recorder:
    motors.target = connector.createMotor(request.param)
    return motors


def refusal(call: Callable[[], object]) -> DxlError | None:
    """Return the error that a call ends in."""
    with pytest.raises(DxlRuntimeError) as caught:
        call()
    error: DxlError | None = caught.value.dxl_error
    return error


def wait_for(link: easy.Connector, servo_id: int) -> None:
    """Wait until a servo has booted."""
    until(lambda: link._packet_handler.ping(link._port_handler, servo_id)[1:] == OK)


def test_connector(connector: easy.Connector) -> None:
    recorded = Recorder(connector)
    found = recorded.createAllMotors(0, 100)
    assert {one.id: one.model_number for one in found} == NUMBERS
    assert [one.model_name for one in found] == [
        f"{name.replace('-', '_')}.model" for name in MODELS.values()
    ]
    assert list(recorded.broadcastPing()) == [*MODELS, XL_320]
    assert recorded.ping(1) == recorded.createMotor(1).model_number == 1120
    assert isinstance(recorded.createGroupExecutor(), easy.GroupExecutor)
    for size, address, value in ((1, 65, 1), (2, 84, 600), (4, 116, 1234)):
        read = getattr(recorded, f"read{size}ByteData")
        write = getattr(recorded, f"write{size}ByteData")
        before = read(1, address)
        for wanted in (value, before):
            write(1, address, wanted)
            assert read(1, address) == wanted
    recorded.reboot(1)
    wait_for(connector, 1)
    recorded.factoryReset(1, 0x02)
    wait_for(connector, 1)
    connector.write1ByteData(1, 9, 0)
    assert recorded.called == public(easy.Connector) - {"closePort"}  # which the fixture calls


def test_errors_of_bus_and_servo(connector: easy.Connector) -> None:
    assert refusal(lambda: connector.ping(99)) == DxlError.SDK_COMM_RX_TIMEOUT
    assert refusal(lambda: connector.write1ByteData(1, 70, 1)) == DxlError.SDK_ERRNUM_ACCESS
    assert refusal(lambda: connector.write1ByteData(1, 65, 2)) == DxlError.SDK_ERRNUM_DATA_RANGE


def test_xl_320_has_no_operating_mode(connector: easy.Connector) -> None:
    """The easy layer finds the model and its table, but cannot make a motor of it."""
    assert connector.ping(XL_320) == 350
    assert refusal(lambda: connector.createMotor(XL_320)) == NOT_SUPPORTED


@ledger.calls("ping", "isTorqueOn", "isLEDOn", "getOperatingMode", "getPWMLimit")
@ledger.calls("getMinPositionLimit", "getMaxPositionLimit", "getVelocityLimit", "getCurrentLimit")
@ledger.calls("getPresentPosition", "getPresentVelocity", "getPresentCurrent", "getPresentPWM")
def test_what_a_motor_tells_of_itself(motor: Recorder) -> None:
    assert motor.ping() == motor.model_number
    assert (motor.isTorqueOn(), motor.isLEDOn()) == (0, 0)
    assert motor.getOperatingMode() == OperatingMode.POSITION
    assert (motor.getMinPositionLimit(), motor.getMaxPositionLimit()) == (0, 4095)
    assert motor.getPWMLimit() == 885
    assert 100 <= motor.getVelocityLimit() <= 480
    assert 0 <= motor.getPresentPosition() < 4096
    assert motor.getPresentVelocity() == motor.getPresentPWM() == 0
    if motor.id in WITH_CURRENT:
        assert motor.getPresentCurrent() == 0
        assert 900 <= motor.getCurrentLimit() <= 2352
    else:
        assert refusal(motor.getPresentCurrent) == NOT_SUPPORTED
        assert refusal(motor.getCurrentLimit) == NOT_SUPPORTED


@ledger.calls("setMaxPositionLimit", "setMinPositionLimit", "setPWMLimit", "setVelocityLimit")
@ledger.calls("setCurrentLimit", *(f"set{name}Gain" for name in GAINS))
def test_limits_and_gains(motor: Recorder, connector: easy.Connector) -> None:
    limits = {"MaxPosition": 3000, "MinPosition": 1000, "PWM": 500, "Velocity": 100}
    if motor.id in WITH_CURRENT:
        limits["Current"] = 300
    else:
        assert refusal(lambda: motor.setCurrentLimit(300)) == NOT_SUPPORTED
    for name, value in limits.items():
        get = getattr(motor, f"get{name}Limit")
        for wanted in (value, get()):
            getattr(motor, f"set{name}Limit")(wanted)
            assert get() == wanted
    for name, address in GAINS.items():
        before = connector.read2ByteData(motor.id, address)
        for wanted in (123, before):
            getattr(motor, f"set{name}Gain")(wanted)
            assert connector.read2ByteData(motor.id, address) == wanted


@ledger.calls("setHomingOffset", "setDirection", "setProfileConfiguration")
def test_homing_offset_direction_and_profile(motor: Recorder, connector: easy.Connector) -> None:
    before = motor.getPresentPosition()
    motor.setHomingOffset(-100)
    assert motor.getPresentPosition() == before - 100
    motor.setHomingOffset(0)
    motor.setDirection(Direction.REVERSE)
    motor.setProfileConfiguration(Profile.TIME_BASED)
    assert connector.read1ByteData(motor.id, 10) == 0b101
    assert (motor.getPresentPosition() + before) % 4096 == 0  # counted from the same zero
    motor.setDirection(Direction.NORMAL)
    motor.setProfileConfiguration(Profile.VELOCITY_BASED)
    assert connector.read1ByteData(motor.id, 10) == 0
    assert motor.getPresentPosition() == before


@ledger.calls("enableTorque", "disableTorque", "setOperatingMode", "setGoalPosition")
@ledger.calls("setGoalVelocity", "setGoalPWM")
def test_goals_of_every_mode(motor: Recorder) -> None:
    assert refusal(lambda: motor.setGoalPosition(0)) == WRONG_TORQUE
    motor.enableTorque()
    assert refusal(lambda: motor.setOperatingMode(OperatingMode.PWM)) == WRONG_TORQUE
    motor.setGoalPosition(2100)
    until(lambda: motor.getPresentPosition() == pytest.approx(2100, abs=STICKS))
    motor.disableTorque()
    motor.setOperatingMode(OperatingMode.VELOCITY)
    motor.enableTorque()
    assert refusal(lambda: motor.setGoalPosition(0)) == WRONG_MODE
    motor.setGoalVelocity(-50)
    until(lambda: motor.getPresentVelocity() == pytest.approx(-50, abs=5))
    motor.disableTorque()
    motor.setOperatingMode(OperatingMode.PWM)
    motor.enableTorque()
    motor.setGoalPWM(300)
    until(lambda: motor.getPresentPWM() == 300 and motor.getPresentVelocity() > 0)
    motor.disableTorque()
    motor.setOperatingMode(OperatingMode.EXTENDED_POSITION)
    motor.enableTorque()
    motor.setGoalPosition(-100)
    until(lambda: motor.getPresentPosition() == pytest.approx(-100, abs=STICKS))
    motor.disableTorque()
    motor.setOperatingMode(OperatingMode.POSITION)


@ledger.calls("setGoalCurrent")
def test_goals_of_current(motor: Recorder) -> None:
    if motor.id not in WITH_CURRENT:
        refused = refusal(lambda: motor.setOperatingMode(OperatingMode.CURRENT))
        assert refused == DxlError.SDK_ERRNUM_DATA_RANGE
        assert refusal(lambda: motor.setGoalCurrent(-200)) == WRONG_TORQUE
        return
    motor.setOperatingMode(OperatingMode.CURRENT)
    motor.enableTorque()
    motor.setGoalCurrent(-200)
    until(lambda: motor.getPresentVelocity() < 0)
    motor.disableTorque()
    motor.setOperatingMode(OperatingMode.CURRENT_BASED_POSITION)
    motor.enableTorque()
    motor.setGoalCurrent(300)
    motor.setGoalPosition(2000)
    until(lambda: motor.getPresentPosition() == pytest.approx(2000, abs=STICKS))
    motor.disableTorque()
    motor.setOperatingMode(OperatingMode.POSITION)


@ledger.calls("LEDOn", "LEDOff", "reboot")
def test_led_and_reboot(motor: Recorder, connector: easy.Connector) -> None:
    motor.LEDOn()
    assert motor.isLEDOn() == 1
    motor.LEDOff()
    assert motor.isLEDOn() == 0
    motor.LEDOn()
    motor.reboot()
    wait_for(connector, motor.id)
    assert motor.isLEDOn() == 0


@ledger.calls("changeID", "factoryResetExceptIDAndBaudRate")
def test_a_reset_that_keeps_a_changed_id(connector: easy.Connector) -> None:
    motors.target = connector.createMotor(5)
    motors.changeID(50)
    assert motors.ping() == connector.ping(50) == 1220
    motors.factoryResetExceptIDAndBaudRate()
    wait_for(connector, 50)
    motors.changeID(5)
    connector.write1ByteData(5, 9, 0)


@ledger.calls("factoryResetExceptID", "factoryResetAll")
def test_resets_that_forget_the_baud_rate(port_name: str, connector: easy.Connector) -> None:
    for reset, left in (("factoryResetExceptID", 5), ("factoryResetAll", 1)):
        motors.target = connector.createMotor(5)
        getattr(motors, reset)()
        slow = easy.Connector(port_name, 57_600)
        wait_for(slow, left)
        for address, value in ((7, 5), (9, 0), (8, 3)):
            slow.write1ByteData(left if address == 7 else 5, address, value)
        slow.closePort()
        connector._port_handler.setBaudRate(BAUD_RATE)
        assert connector.ping(5) == 1220


def test_every_public_method_of_a_motor_is_exercised() -> None:
    staging = {name for name in public(easy.Motor) if name.startswith("stage")}
    assert public(easy.Motor) - staging == ledger.listed
