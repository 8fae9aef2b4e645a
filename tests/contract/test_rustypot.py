"""rustypot's controllers and bus, unmodified, at one running simulator of both protocols."""

import math
from collections.abc import Callable, Iterator
from typing import Any

import dynamixel_sdk as sdk
import pytest
import rustypot

from firmware_sim.testing import running

from .clients import BAUD_RATE, OK, SET_UP, opened, until

SERVOS = (
    *("ax-12a:1", "mx-28:2", "mx-64:3", "xl-320:6"),
    *("xl430-w250:4", "xm430-w350:7", "xm540-w270:8", "xl330-m288:5", "xl330-m077:10"),
)
KINDS = {
    "Ax": {1: 12},
    "Mx": {2: 29, 3: 310},
    "Xl320": {6: 350},
    "Xl430": {4: 1060, 7: 1020, 8: 1120},
    "Xl330": {5: 1200, 10: 1190},
}
V1, V2 = ("Ax", "Mx"), ("Xl320", "Xl430", "Xl330")
TURN = {"Ax": (1024, math.radians(300)), "Mx": (4096, math.tau), "Xl330": (4096, math.tau)}
"""Ticks and angle (rad) of a whole range; for the other kinds rustypot speaks of ticks."""
TIMEOUT = 0.2

NOT_OF_XL330 = {"acceleration_limit"}  # in rustypot's list, not in the manual's
NOT_OF_XL430 = {"current_limit", "goal_current"}  # of other models that share rustypot's list


def controller_of(kind: str) -> Any:
    return getattr(rustypot, f"{kind}PyController")


@pytest.fixture(scope="module")
def port_name() -> Iterator[str]:
    with running(*SERVOS, arguments=SET_UP) as name:
        yield name


@pytest.fixture
def connect(port_name: str) -> Iterator[Callable[[str], Any]]:
    """Make a controller, one at a time as the port is; all torque is off afterwards."""
    made: list[Any] = []

    def make(kind: str) -> Any:
        for client in made:
            client.close()
        made.append(controller_of(kind)(port_name, BAUD_RATE, TIMEOUT))
        return made[-1]

    yield make
    made[-1].close()
    with mixed(port_name) as bus:
        assert bus.set_torque([i for ids in KINDS.values() for i in ids], False) == {}


def mixed(port_name: str) -> rustypot.Bus:
    """Open a bus of all servos."""
    definitions = {i: controller_of(kind).definition() for kind, ids in KINDS.items() for i in ids}
    return rustypot.Bus(port_name, BAUD_RATE, TIMEOUT, definitions)


@pytest.mark.parametrize("kind", KINDS)
def test_ping_and_scan(connect: Callable[[str], Any], kind: str) -> None:
    client = connect(kind)
    assert [client.ping(servo_id) for servo_id in KINDS[kind]] == [True] * len(KINDS[kind])
    assert not client.ping(99)
    numbers = {i: n for one in (V1 if kind in V1 else V2) for i, n in KINDS[one].items()}
    # A scan gives each ID a few milliseconds only, which a busy machine may miss: never the answer.
    scans = [client.scan([*range(12)]) for _ in range(10)]
    assert all(scan.items() <= numbers.items() for scan in scans)
    assert {i: number for scan in scans for i, number in scan.items()} == numbers
    if kind in V1:
        with pytest.raises(ValueError, match="broadcast ping"):
            client.broadcast_scan([1])
    else:
        assert client.broadcast_scan() == numbers


@pytest.mark.parametrize("kind", KINDS)
def test_every_register_reads_as_the_sdk_reads_it(
    port_name: str, connect: Callable[[str], Any], kind: str
) -> None:
    servo_id = {"Xl430": 7}.get(kind, next(iter(KINDS[kind])))
    missing = NOT_OF_XL330 if kind == "Xl330" else set[str]()
    registers = {r.name: r for r in controller_of(kind).registers() if "tick" not in r.name}
    handler = sdk.Protocol1PacketHandler() if kind in V1 else sdk.Protocol2PacketHandler()
    expected = {}
    with opened(port_name) as port:
        for name, register in registers.items():
            data, result, error = handler.readTxRx(port, servo_id, register.addr, register.size)
            assert result == sdk.COMM_SUCCESS
            assert (error != 0) == (name in missing)
            expected[name] = data
    client = connect(kind)
    for name in registers.keys() - missing:
        register = registers[name]
        assert list(client.read_raw_data(servo_id, register.addr, register.size)) == expected[name]
        value = int.from_bytes(bytes(expected[name]), "little")
        assert client.read_register(servo_id, name) % 256**register.size == value


def test_registers_that_a_model_lacks(connect: Callable[[str], Any]) -> None:
    # The client takes an answer without data for 0; its methods of such registers' own names,
    # such as `read_current_limit`, panic.
    client = connect("Xl430")
    for name in NOT_OF_XL430:
        assert client.read_register_with_error(4, name) == (0, 7)
    assert client.read_register(7, "current_limit") == 1193


@pytest.mark.parametrize("kind", TURN)
def test_goals_in_radians(connect: Callable[[str], Any], kind: str) -> None:
    client = connect(kind)
    ticks, turn = TURN[kind]
    step = turn / ticks
    for servo_id in KINDS[kind]:
        for goal in (0.5, -0.25):
            client.write_torque_enable(servo_id, True)
            client.write_goal_position(servo_id, goal)
            assert client.read_goal_position(servo_id)[0] == pytest.approx(goal, abs=step)
            wanted = ticks // 2 + goal / step
            assert client.read_register(servo_id, "goal_position") == pytest.approx(wanted, abs=1)
            near = pytest.approx(goal, abs=6 * step)
            until(lambda i=servo_id, near=near: client.read_present_position(i)[0] == near)


@pytest.mark.parametrize("kind", ["Xl320", "Xl430"])
def test_goals_in_ticks(connect: Callable[[str], Any], kind: str) -> None:
    client = connect(kind)
    for servo_id in KINDS[kind]:
        before = client.read_register(servo_id, "present_position")
        client.write_register(servo_id, "torque_enable", 1)
        client.write_register(servo_id, "goal_position", before + 90)
        near = pytest.approx(before + 90, abs=6)
        until(lambda i=servo_id, near=near: client.read_register(i, "present_position") == near)


@pytest.mark.parametrize("kind", TURN)
def test_sync_writes_in_radians(connect: Callable[[str], Any], kind: str) -> None:
    client = connect(kind)
    ids = list(KINDS[kind])
    ticks, turn = TURN[kind]
    goals = [0.1 + 0.05 * index for index in range(len(ids))]
    client.sync_write_torque_enable(ids, [True] * len(ids))
    client.sync_write_goal_position(ids, goals)
    found = [client.read_goal_position(i)[0] for i in ids]
    assert found == pytest.approx(goals, abs=turn / ticks)


@pytest.mark.parametrize("kind", V2)
@pytest.mark.parametrize("fast", [False, True])
def test_sync_reads(connect: Callable[[str], Any], kind: str, fast: bool) -> None:
    client = connect(kind)
    client.set_fast_sync_read(fast)
    ids = list(KINDS[kind])[::-1]
    if kind == "Xl320" and fast:  # it does not know the instruction
        with pytest.raises(RuntimeError, match="Timeout"):
            client.sync_read_model_number(ids)
        return
    assert client.sync_read_model_number(ids) == [KINDS[kind][i] for i in ids]
    alone = [client.read_register(i, "present_position") for i in ids]
    assert client.sync_read_register(ids, "present_position") == pytest.approx(alone, abs=1)
    if not fast:
        found = client.sync_read_register_with_error(ids, "present_temperature")
        assert found == [(client.read_register(i, "present_temperature"), 0) for i in ids]
        with pytest.raises(RuntimeError):
            client.sync_read_model_number([ids[0], 99])


@pytest.mark.parametrize("kind", V1)
def test_protocol_1_has_no_sync_read(connect: Callable[[str], Any], kind: str) -> None:
    """The client offers it; the manual's list of Protocol 1.0's instructions does not."""
    client = connect(kind)
    with pytest.raises(RuntimeError, match="timed out"):
        client.sync_read_present_position(list(KINDS[kind]))
    assert client.ping(next(iter(KINDS[kind])))


@pytest.mark.parametrize(("kind", "read_only"), [("Ax", 0x08), ("Xl320", 7), ("Xl330", 7)])
def test_error_fields(connect: Callable[[str], Any], kind: str, read_only: int) -> None:
    client = connect(kind)
    servo_id = next(iter(KINDS[kind]))
    (present,) = [r for r in controller_of(kind).registers() if r.name == "present_position"]
    assert client.write_raw_data_with_error(servo_id, present.addr, [0] * present.size) == read_only
    assert client.write_register_with_error(servo_id, "led", 1) == 0
    assert client.read_register_with_error(servo_id, "led") == (1, 0)
    client.write_register(servo_id, "led", 0)


def test_reboots_and_resets(connect: Callable[[str], Any]) -> None:
    client = connect("Xl330")
    client.write_led(5, 1)
    assert client.reboot(5)
    until(lambda: bool(client.ping(5)))
    assert client.read_led(5) == [0]
    client.write_temperature_limit(5, 60)
    client.factory_reset(5, False, True)
    until(lambda: bool(client.ping(5)))
    assert client.read_temperature_limit(5) == [70]
    client.write_return_delay_time(5, 0)


def test_stuffing_both_ways(connect: Callable[[str], Any]) -> None:
    """A homing offset of -2 before a moving threshold of 253 reads as a header: FF FF FD 00.

    The client stuffs what it sends; it takes answers with and without stuffing.
    """
    client = connect("Xl430")
    before = client.read_raw_data(7, 20, 8)
    for offset in (-2, -257):
        payload = offset.to_bytes(4, "little", signed=True) + (253).to_bytes(4, "little")
        assert b"\xff\xfd\x00" in payload
        client.sync_write_raw_data([7], 20, [list(payload)])
        assert bytes(client.read_raw_data(7, 20, 8)) == payload
        assert [bytes(data) for data in client.sync_read_raw_data([7], 20, 8)] == [payload]
    client.write_raw_data(7, 20, before)


def test_a_bus_of_both_protocols(port_name: str) -> None:
    everyone = [i for ids in KINDS.values() for i in ids]
    with mixed(port_name) as bus:
        assert {i: bus.read_register(i, "model_number") for i in everyone} == {
            i: number for ids in KINDS.values() for i, number in ids.items()
        }
        # Different addresses and both protocols: one sync read each.
        assert bus.sync_read_register([8, 5, 4, 6, 10], "model_number") == [
            *(1120, 1200, 1060, 350, 1190)
        ]
        assert bus.set_torque(everyone, True) == {}
        assert [bus.read_register(i, "torque_enable") for i in everyone] == [1] * len(everyone)
        goals = {i: bus.read_register(i, "present_position") + 5 for i in everyone}
        bus.sync_write_register(everyone, "goal_position", [goals[i] for i in everyone])
        assert {i: bus.read_register(i, "goal_position") for i in everyone} == goals
        assert bus.set_torque(everyone, False) == {}
        assert bus.read_register_with_error(2, "led") == (0, 0)
        assert bus.write_register_with_error(7, "led", 1) == 0
        assert bus.sync_read_register_with_error([7, 4], "led") == [(1, 0), (0, 0)]
        bus.write_register(7, "led", 0)


def test_a_bus_that_renames_and_retunes(port_name: str) -> None:
    ax, xl430 = (controller_of(kind).definition() for kind in ("Ax", "Xl430"))
    with mixed(port_name) as bus:
        for definition, servo_id, number in ((ax, 1, 12), (xl430, 4, 1060)):
            bus.change_id(definition, servo_id, 77)
            until(lambda d=definition, n=number: bus.scan(d, [77]) == {77: n})
            bus.change_id(definition, 77, servo_id)
            until(lambda d=definition, i=servo_id, n=number: bus.scan(d, [i]) == {i: n})
        bus.change_baudrate(xl430, 4, 57_600)
        bus.set_baudrate(57_600)
        assert bus.broadcast_scan(xl430, [4]) == {4: 1060}
        bus.change_baudrate(xl430, 4, BAUD_RATE)
        bus.set_baudrate(BAUD_RATE)
        assert bus.scan(xl430, [4, 7]) == {4: 1060, 7: 1020}


def test_the_sdk_shares_the_wire_afterwards(port_name: str) -> None:
    with mixed(port_name) as bus:
        assert bus.is_open
    assert not bus.is_open
    with opened(port_name) as port:
        assert sdk.Protocol2PacketHandler().ping(port, 8) == (1120, *OK)
