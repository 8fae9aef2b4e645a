"""Scattered registers read at once through indirect addresses of simulated servos."""

import pytest

from armsyn.driver import registers as reg
from armsyn.driver.indirect import IndirectArea, IndirectBlock, indirect_area
from armsyn.driver.transactions import Bus
from firmware_sim.testing import running

SCATTERED = (
    reg.TORQUE_ENABLE,
    reg.PRESENT_POSITION,
    reg.HARDWARE_ERROR_STATUS,
    reg.PROFILE_VELOCITY,
    reg.GOAL_POSITION,
)
SERVOS = {1: ("xm430-w350", 47), 2: ("xl330-m288", 52), 3: ("xl330-m288", 53)}


def test_areas_of_the_manual() -> None:
    # e-Manual, XM430-W350 and XL330-M288, "Indirect Address"
    assert indirect_area("xm430-w350", 40) == IndirectArea(168, 224, 28)
    assert indirect_area("xl330-m288", 52) == IndirectArea(168, 208, 20)
    assert indirect_area("xl330-m288", 53) == IndirectArea(168, 224, 28)


def test_a_block_of_scattered_registers() -> None:
    names = [f"{model}@{firmware}:{i}" for i, (model, firmware) in SERVOS.items()]
    with running(*names, arguments=("--baud", "1000000")) as path:
        bus = Bus(path, 1_000_000, 0.2)
        for servo_id, (model, firmware) in SERVOS.items():
            assert bus.ping(servo_id)[1] == firmware
            block = IndirectBlock(indirect_area(model, firmware), SCATTERED)
            block.point(bus, (servo_id,))
            bus.write(servo_id, reg.PROFILE_VELOCITY, 100 + servo_id)
            for kind in ("sync", "single"):
                plan = block.plan((servo_id,), kind)
                reply = bus.exchange(b"", [plan])[servo_id]
                expected = {r.name: bus.read(servo_id, r) for r in SCATTERED}
                assert block.decode(reply.parameters) == expected
                assert expected["Profile Velocity"] == 100 + servo_id
        bus.close()


def test_a_servo_that_has_them_elsewhere() -> None:
    with running("xl330-m288@52:1", arguments=("--baud", "1000000")) as path:
        bus = Bus(path, 1_000_000, 0.2)
        wrong = IndirectBlock(IndirectArea(146, 224, 28), SCATTERED)  # a read-only register
        assert wrong.point(bus, (1,)) == ()
        right = IndirectBlock(IndirectArea(168, 208, 20), SCATTERED)
        assert right.point(bus, (1,)) == (1,)
        bus.close()


def test_more_than_there_is_room_for() -> None:
    with pytest.raises(ValueError, match="24 bytes do not fit 20 indirect addresses"):
        IndirectBlock(indirect_area("xl330-m288", 52), [reg.GOAL_POSITION] * 6)
