"""What servos remember without power, in a file: round trips, refusals, and disks that are full."""

import json
import os
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_sim.errors import OutputError, StateFileError
from firmware_sim.packet import build_packet
from firmware_sim.rig import parse_servo
from firmware_sim.state_file import StateKeeper, read_state, write_state
from firmware_sim.testing import simulated
from firmware_sim.world import World, build_world

NAMES = ["xm430-w350:1", "ax-12a:2", "xl-320:3", "mx-28:4"]


def world(*names: str) -> World:
    return build_world([parse_servo(name) for name in names or NAMES])


def write_register(servos: World, place: int, name: str, value: int) -> None:
    servo = servos.servos[place]
    register = servo.model.table[name]
    assert not servo.write(register.address, value.to_bytes(register.size, "little"))


def work_through(keeper: StateKeeper) -> None:
    """Let it look at all servos, and write if any has changed."""
    for _ in range(2 * len(NAMES) + 2):
        keeper.work(0.0)


def test_eeprom_and_angle_come_back(tmp_path: Path) -> None:
    path = tmp_path / "state.json"
    before = world()
    keeper = StateKeeper(path, before.servos, NAMES)
    write_register(before, 0, "Min Position Limit", 123)
    write_register(before, 1, "CW Angle Limit", 45)
    write_register(before, 2, "CW Angle Limit", 46)
    write_register(before, 3, "CW Angle Limit", 47)
    keeper.close()

    after = world()
    restore(path, after)
    assert [servo.snapshot() for servo in after.servos] == [s.snapshot() for s in before.servos]
    assert after.servos[0].memory.value("Min Position Limit") == 123
    assert [s.memory.value("CW Angle Limit") for s in after.servos[1:]] == [45, 46, 47]


def test_a_changed_eeprom_is_written_while_it_runs_and_an_angle_only_at_the_end(
    tmp_path: Path,
) -> None:
    path = tmp_path / "state.json"
    servos = world()
    keeper = StateKeeper(path, servos.servos, NAMES)
    first = path.read_bytes()
    work_through(keeper)
    assert path.read_bytes() == first
    write_register(servos, 0, "Max Position Limit", 3000)
    work_through(keeper)
    eeprom = json.loads(path.read_text())["servos"][0]["eeprom"]
    assert eeprom["Max Position Limit"] == 3000


def test_the_old_file_stays_whole_when_the_new_one_cannot_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "state.json"
    servos = world()
    keeper = StateKeeper(path, servos.servos, NAMES)
    before = path.read_bytes()

    def full(*_: object, **__: object) -> int:
        raise OSError(28, os.strerror(28))

    write_register(servos, 0, "Max Position Limit", 3000)
    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_text", full)
        work_through(keeper)
        assert "No space left" in keeper.problem
        assert path.read_bytes() == before
    work_through(keeper)
    assert keeper.problem == ""
    assert path.read_bytes() != before
    assert [entry.name for entry in tmp_path.iterdir()] == ["state.json"]


def test_no_file_yet_is_no_error_and_a_folder_that_is_not_there_is(tmp_path: Path) -> None:
    assert read_state(tmp_path / "none.json", NAMES) is None
    with pytest.raises(OutputError, match="cannot be written"):
        StateKeeper(tmp_path / "no" / "state.json", world().servos, NAMES)


def restore(path: Path, servos: World) -> None:
    saved = read_state(path, NAMES)
    assert saved is not None
    saved.restore(servos.servos)


def document(**changes: Any) -> dict[str, Any]:
    servos = [{"place": n, **s.snapshot()} for n, s in zip(NAMES, world().servos, strict=True)]
    return {"schema": "firmware-sim-state-1", "servos": servos, **changes}


def damaged(**changes: Any) -> dict[str, Any]:
    """A document whose first servo has other fields."""
    found = document()
    found["servos"][0].update(changes)
    return found


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("", "is no state file"),
        ("{", "is no state file"),
        ("[" * 100_000, "is no state file"),
        ("3", "schema"),
        (json.dumps(document(schema="other")), "schema"),
        (json.dumps(document(servos=3)), "not a list of objects"),
        (json.dumps(document(servos=[3])), "not a list of objects"),
        (json.dumps(document(servos=[])), "is the state of none, not of xm430-w350:1"),
        (json.dumps(damaged(place="xm430-w350:9")), "is the state of xm430-w350:9"),
        (json.dumps(damaged(model="ax-12a")), "xm430-w350:1: the state is of a 'ax-12a'"),
        (json.dumps(damaged(angle=None)), "angle"),
        (json.dumps(damaged(angle=float("nan"))), "angle"),
        (json.dumps(damaged(eeprom={"Shutdown": 1000})), "Shutdown = 1000"),
        (json.dumps(damaged(eeprom={"Shutdown": True})), "Shutdown = True"),
        (json.dumps(damaged(eeprom={"Goal Position": 1})), "something else"),
        (json.dumps(damaged(eeprom=3)), "something else"),
        (json.dumps(damaged(backup=[1])), "something else"),
        (json.dumps(damaged(other=3)), "has the fields"),
    ],
)
def test_a_file_that_is_none_is_refused_in_one_line(
    tmp_path: Path, content: str, says: str
) -> None:
    path = tmp_path / "state.json"
    path.write_text(content)
    servos = world()
    before = [servo.snapshot() for servo in servos.servos]
    with pytest.raises(StateFileError) as caught:
        restore(path, servos)
    assert says in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.file == str(path)
    assert servos.servos[0].snapshot() == before[0]


def test_files_that_are_folders_binary_or_far_too_large_are_refused(tmp_path: Path) -> None:
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
    with (tmp_path / "large").open("wb") as file:
        file.truncate(10_000_001)
    for name, says in (("binary", "no state file"), ("large", "larger than"), ("", "cannot be")):
        with pytest.raises(StateFileError, match=says):
            read_state(tmp_path / name, NAMES)


TEXT = st.sampled_from(["", "ID", "Shutdown", "Goal Position", "xm430-w350", "\x00", "\udcff"])
PLAIN = st.none() | st.booleans() | st.integers() | st.floats() | TEXT
VALUES = PLAIN | st.lists(PLAIN, max_size=3) | st.dictionaries(TEXT, PLAIN, max_size=3)


@given(changes=st.dictionaries(st.sampled_from(["model", "eeprom", "backup", "angle"]), VALUES))
def test_whatever_a_file_says_a_servo_is_restored_or_the_file_refused(
    tmp_path_factory: pytest.TempPathFactory, changes: dict[str, Any]
) -> None:
    path = tmp_path_factory.mktemp("state") / "state.json"
    name = NAMES[0]
    servos = world(name)
    snapshot = {**servos.servos[0].snapshot(), **changes}
    write_state(path, [name], [snapshot])
    saved = read_state(path, [name])
    assert saved is not None
    try:
        saved.restore(servos.servos)
    except StateFileError:
        assert changes
    else:
        assert servos.servos[0].snapshot()["model"] == "xm430-w350"


def test_a_restart_keeps_the_eeprom_and_the_angle(tmp_path: Path) -> None:
    import serial

    state = tmp_path / "state.json"

    def ask(port: str, servo_id: int, instruction: int, params: bytes, size: int) -> bytes:
        with serial.Serial(port, 1_000_000, timeout=2.0) as client:
            client.write(build_packet(servo_id, instruction, params))
            return client.read(size)

    limits = bytes((52, 0)) + (500).to_bytes(4, "little")
    with simulated("xm430-w350:1", baud=1_000_000, state=state) as arm:
        assert ask(arm.port, 1, 0x03, limits, 11)[8] == 0
        assert ask(arm.port, 1, 0x03, bytes((7, 0, 9)), 11)[8] == 0  # its ID
    with simulated("xm430-w350:1", baud=1_000_000, state=state) as arm:
        answer = ask(arm.port, 9, 0x02, bytes((52, 0, 4, 0)), 15)
        assert int.from_bytes(answer[9:13], "little") == 500
