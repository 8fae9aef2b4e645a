"""Two servos on one joint, as rig files and arms' descriptions ask for them."""

from pathlib import Path

import pytest

from firmware_sim.assembly import build_simulation
from firmware_sim.errors import PlantError, RigError
from firmware_sim.firmware.servo import Servo
from firmware_sim.firmware.world import World
from firmware_sim.rig.file import SET_UP, read_rig
from firmware_sim.rig.settings import Mount, Rig
from firmware_sim.rig.state_file import SavedState
from firmware_sim.wire.bus import Bus
from tests.firmware_sim.wire import Wire

DRIVE_MODE, SECONDARY_ID, TORQUE, WATCHDOG = 10, 12, 64, 98
GOAL, CURRENT, POSITION = 116, 126, 132

PAIR = """
[[servo]]
id = 2
model = "xm430-w350"
joint = "shoulder"
start_tick = 1500

[[servo]]
id = 3
model = "xm430-w350"
shadow_of = 2
"""
MIRRORED = PAIR + "drive_mode = 1\n"
FIGHTING = PAIR + "direction = -1\n"


def rig_of(folder: Path, text: str, **defaults: int) -> Rig:
    path = folder / "rig.toml"
    path.write_text(text)
    return read_rig(path, defaults)


def world_of(folder: Path, text: str) -> World:
    return build_simulation(rig_of(folder, text)).bus.world


def value(servo: Servo, address: int, size: int) -> int:
    _, data = servo.read(address, size)
    return int.from_bytes(data, "little", signed=size > 1)


def put(servo: Servo, address: int, size: int, number: int) -> None:
    assert not servo.write(address, number.to_bytes(size, "little", signed=True))


def send_goals(world: World, tick: int) -> None:
    """Give a goal to both, as a packet to the leader's ID does."""
    for servo in world.servos:
        put(servo, TORQUE, 1, 1)
        put(servo, GOAL, 4, tick)


def test_a_shadow_is_set_up_as_arms_are_delivered(tmp_path: Path) -> None:
    leader, shadow = rig_of(tmp_path, MIRRORED).servos
    assert (leader.shadow_of, shadow.shadow_of) == (None, 2)
    assert shadow.registers == {"Secondary(Shadow) ID": 2, "Drive Mode": 1}
    assert shadow.mount == Mount("shoulder", 1, 2048)
    assert shadow.start_tick == leader.start_tick == 1500
    world = world_of(tmp_path, MIRRORED)
    assert [value(servo, SECONDARY_ID, 1) for servo in world.servos] == [255, 2]


def test_a_shadow_that_nobody_has_set_up(tmp_path: Path) -> None:
    text = MIRRORED + 'registers = { "Secondary(Shadow) ID" = 255 }\n'
    world = world_of(tmp_path, text)
    assert value(world.servos[1], SECONDARY_ID, 1) == 255


def test_a_shadow_lies_where_its_leader_does_in_its_own_count(tmp_path: Path) -> None:
    text = PAIR + "direction = -1\nzero_tick = 1000\n"
    shadow = rig_of(tmp_path, text).servos[1]
    assert shadow.start_tick == 1000 + (2048 - 1500)
    placed = rig_of(tmp_path, MIRRORED + "start_tick = 1507\n").servos[1]
    assert placed.start_tick == 1507


def test_a_shadow_of_a_servo_on_no_named_joint(tmp_path: Path) -> None:
    world = world_of(tmp_path, MIRRORED.replace('joint = "shoulder"\n', ""))
    send_goals(world, 1700)
    world.advance(2.0)
    assert [value(servo, POSITION, 4) for servo in world.servos] == pytest.approx([1700] * 2, abs=4)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        (PAIR.replace("shadow_of = 2", "shadow_of = 4"), "shadow_of = 4 is no servo"),
        (PAIR.replace("shadow_of = 2", "shadow_of = 3"), "is no servo, or a shadow itself"),
        (PAIR.replace("shadow_of = 2", "shadow_of = 255"), "not a whole number from 0 to 252"),
        (PAIR + 'joint = "elbow"\n', "joint = 'elbow' is not that of servo 2"),
        (PAIR + "zero_tick = 100\n", "it would lie at -448: check zero_tick"),
        (PAIR + '[[servo]]\nid = 9\nmodel = "ax-12a"\nshadow_of = 3\n', "or a shadow itself"),
    ],
)
def test_shadows_of_nothing_are_refused(tmp_path: Path, text: str, what: str) -> None:
    with pytest.raises(RigError, match=rf"rig.toml: \[\[servo\]\] table \d: .*{what}"):
        rig_of(tmp_path, text)


def test_servos_that_lie_far_apart_are_refused(tmp_path: Path) -> None:
    with pytest.raises(
        PlantError, match=r"on the joint shoulder disagree: number 2 lies 0\.307 rad"
    ):
        world_of(tmp_path, MIRRORED + "start_tick = 1700\n")


def test_an_arms_other_tables_are_left_to_it(tmp_path: Path) -> None:
    text = (
        '[gripper]\nname = "jaw"\nopen = 1.0\n[[plane]]\nname = "table"\n[[box]]\n[[base_shape]]\n'
        '[[servo]]\nid = 1\nmodel = "xl430-w250"\njoint = "jaw"\nprotocol = 2\n'
    )
    rig = rig_of(tmp_path, text)
    assert rig.gripper == "jaw"
    assert rig_of(tmp_path, PAIR).gripper == "gripper"
    with pytest.raises(RigError, match="did you mean plant"):
        rig_of(tmp_path, "[plants]\n" + text)


def test_protocols_mix_on_the_bus_of_an_arm(tmp_path: Path) -> None:
    models = [("mx-106", 2), ("mx-64", 1), ("mx-28", 2), ("ax-18a", 1), ("xl-320", 2)]
    text = "".join(
        f'[[servo]]\nid = {k}\nmodel = "{model}"\nprotocol = {protocol}\ndrive_mode = 0\n\n'
        for k, (model, protocol) in enumerate(models)
    )
    servos = build_simulation(rig_of(tmp_path, text, **SET_UP)).bus.servos
    assert [servo.protocol for servo in servos] == [protocol for _, protocol in models]
    assert all(servo.baud_rate == 1_000_000 and servo.return_delay == 0.0 for servo in servos)


def test_a_mirrored_shadow_shares_the_load(tmp_path: Path) -> None:
    """Against a load each takes half the current, in its own count; without it neither any."""
    world = world_of(tmp_path, MIRRORED)
    send_goals(world, 1500)
    world.servos[0].apply_load(2.0)
    world.advance(1.0)
    currents = [value(servo, CURRENT, 2) for servo in world.servos]
    # Half of 2 N m, of 4.1 N m at 2.3 A, in counts of 2.69 mA; friction takes its part of it
    assert currents[0] == pytest.approx(1.0 / 4.1 * 2.3 / 0.00269, rel=0.1)
    assert currents[1] == pytest.approx(currents[0], abs=4)
    # The duty for it, 885 counts for all, comes from 800 / 128 counts a tick
    sag = round(1.0 / 4.1 * 885 / (800 / 128))
    assert [value(servo, POSITION, 4) for servo in world.servos] == pytest.approx(
        [1500 - sag] * 2, abs=4
    )


def test_a_shadow_that_counts_the_wrong_way_fights_its_leader(tmp_path: Path) -> None:
    """Both push with the joint between their goals; with these further apart they give up."""
    world = world_of(tmp_path, FIGHTING)
    assert [value(servo, POSITION, 4) for servo in world.servos] == [1500, 2596]
    send_goals(world, 2000)  # in the shadow's count, where the leader's is 4096 - 2000
    world.advance(1.0)
    assert [value(servo, POSITION, 4) for servo in world.servos] == pytest.approx([2048] * 2, abs=9)
    pushed = 48 * (800 / 128) / 885 * 2.3 / 0.00269  # of 48 ticks
    assert sum(value(servo, CURRENT, 2) for servo in world.servos) == pytest.approx(
        -2 * pushed, 0.1
    )
    assert not any(servo.alert for servo in world.servos)
    send_goals(world, 1700)
    world.advance(7.0)
    assert any(servo.alert for servo in world.servos)


def test_servos_that_only_name_one_joint_share_it_too(tmp_path: Path) -> None:
    text = "".join(
        f'[[servo]]\nid = {k}\nmodel = "ax-12a"\njoint = "knee"\ndirection = {d}\n'
        for k, d in ((1, 1), (2, -1))
    )
    world = world_of(tmp_path, text)
    world.servos[0].write(24, b"\x01")
    world.servos[0].write(30, (700).to_bytes(2, "little"))
    world.advance(2.0)
    assert value(world.servos[0], 36, 2) == pytest.approx(700, abs=4)
    assert value(world.servos[1], 36, 2) == pytest.approx(1024 - 700, abs=4)


def test_a_mounting_offset_stays(tmp_path: Path) -> None:
    world = world_of(tmp_path, MIRRORED + "start_tick = 1509\n")
    for goal in (1800, 1400):
        send_goals(world, goal)
        world.advance(world.now + 2.0)
        first, second = (value(servo, POSITION, 4) for servo in world.servos)
        assert second - first == pytest.approx(9, abs=1)


def test_a_horn_that_is_turned_turns_the_other(tmp_path: Path) -> None:
    """Only the leader has torque; the limp shadow is carried, without a current of its own."""
    world = world_of(tmp_path, MIRRORED)
    put(world.servos[0], TORQUE, 1, 1)
    put(world.servos[0], GOAL, 4, 2500)
    world.advance(0.3)
    moving = [value(servo, 128, 4) for servo in world.servos]
    assert moving[0] == moving[1] > 50
    world.advance(2.0)
    assert value(world.servos[1], POSITION, 4) == pytest.approx(2500, abs=4)
    assert value(world.servos[1], CURRENT, 2) == 0


def test_a_reboot_of_the_leader_leaves_the_shadow_on(tmp_path: Path) -> None:
    world = world_of(tmp_path, MIRRORED)
    send_goals(world, 1500)
    world.advance(0.5)
    world.servos[0].reboot()
    world.advance(1.0)
    assert [value(servo, TORQUE, 1) for servo in world.servos] == [0, 1]
    assert value(world.servos[1], SECONDARY_ID, 1) == 2


def test_what_is_written_later_turns_no_screw(tmp_path: Path) -> None:
    """A drive mode put right over the bus makes the counts agree; the shafts stay as they are."""
    world = world_of(tmp_path, FIGHTING)
    put(world.servos[1], DRIVE_MODE, 1, 1)
    assert [value(servo, POSITION, 4) for servo in world.servos] == [1500, 1500]
    send_goals(world, 1700)
    world.advance(2.0)
    assert [value(servo, POSITION, 4) for servo in world.servos] == pytest.approx([1700] * 2, abs=4)
    assert all(abs(value(servo, CURRENT, 2)) < 40 for servo in world.servos)


def wired(folder: Path) -> Wire:
    wire = Wire("xm430-w350:1")
    wire.world = build_simulation(rig_of(folder, MIRRORED, **SET_UP)).bus.world
    wire.servos = wire.world.servos
    wire.bus = Bus(wire.world)
    return wire


def test_one_packet_to_the_leader_moves_both_and_one_answers(tmp_path: Path) -> None:
    wire = wired(tmp_path)
    for address, data in ((TORQUE, b"\x01"), (GOAL, (1700).to_bytes(4, "little"))):
        answer = wire.ask(2, 0x03, bytes((address, 0)) + data)
        assert answer == [(2, 0)]
    wire.now = 2.0
    for number in (2, 3):
        ((servo_id, error, *data),) = wire.ask(number, 0x02, bytes((POSITION, 0, 4, 0)))
        assert (servo_id, error) == (number, 0)
        assert int.from_bytes(bytes(data), "little") == pytest.approx(1700, abs=4)


def test_a_reboot_of_the_leader_is_not_the_shadows(tmp_path: Path) -> None:
    wire = wired(tmp_path)
    assert wire.ask(2, 0x03, bytes((TORQUE, 0, 1))) == [(2, 0)]
    assert wire.ask(2, 0x08) == [(2, 0)]
    assert wire.ask(3, 0x02, bytes((TORQUE, 0, 1, 0))) == [(3, 0, 1)]
    wire.now += 0.2
    assert wire.ask(2, 0x02, bytes((TORQUE, 0, 1, 0))) == [(2, 0, 0)]


def test_the_watchdogs_of_both_are_armed_fed_and_cleared_by_the_leaders_id(tmp_path: Path) -> None:
    wire = wired(tmp_path)
    for address, number in ((TORQUE, 1), (WATCHDOG, 5)):
        assert wire.ask(2, 0x03, bytes((address, 0, number))) == [(2, 0)]
    for _ in range(4):  # what is asked of the leader alone feeds the shadow too
        wire.now += 0.09
        wire.ask(2, 0x02, bytes((POSITION, 0, 4, 0)))
    assert wire.ask(3, 0x02, bytes((WATCHDOG, 0, 1, 0))) == [(3, 0, 5)]
    wire.now += 0.11
    for number in (2, 3):
        assert wire.ask(number, 0x02, bytes((WATCHDOG, 0, 1, 0))) == [(number, 0, 255)]
    assert wire.ask(2, 0x03, bytes((WATCHDOG, 0, 0))) == [(2, 0)]
    assert wire.ask(3, 0x02, bytes((WATCHDOG, 0, 1, 0))) == [(3, 0, 0)]


def test_a_restored_state_turns_no_screw_either(tmp_path: Path) -> None:
    rig = rig_of(tmp_path, FIGHTING)
    before = build_simulation(rig).bus.world
    put(before.servos[1], DRIVE_MODE, 1, 1)
    snapshots = tuple(servo.snapshot() for servo in before.servos)
    state = SavedState("state.json", tuple(servo.name for servo in rig.servos), snapshots)
    world = build_simulation(rig, state=state).bus.world
    assert value(world.servos[1], DRIVE_MODE, 1) == 1
    send_goals(world, 1700)
    world.advance(2.0)
    assert [value(servo, POSITION, 4) for servo in world.servos] == pytest.approx([1700] * 2, abs=4)
