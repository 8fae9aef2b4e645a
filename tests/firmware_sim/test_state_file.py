"""What servos remember without power, in a file: round trips, refusals, and disks that are full."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
import serial
from hypothesis import given
from hypothesis import strategies as st

from firmware_sim.errors import (
    FaultError,
    OutputError,
    RigError,
    SimulatorStartError,
    StateFileError,
)
from firmware_sim.faults.scenario import read_scenario
from firmware_sim.firmware.world import World, build_world
from firmware_sim.rig.file import read_rig
from firmware_sim.rig.settings import parse_servo
from firmware_sim.rig.state_file import StateKeeper, read_state, write_state
from firmware_sim.testing import SimulatorProcess, simulated, stepped
from firmware_sim.wire.packet import build_packet

COMMAND = [sys.executable, "-m", "firmware_sim"]
NAMES = ["xm430-w350:1", "ax-12a:2", "xl-320:3", "mx-28:4"]


def world(*names: str) -> World:
    return build_world([parse_servo(name) for name in names or NAMES])


def write_register(servos: World, place: int, name: str, value: int) -> None:
    servo = servos.servos[place]
    register = servo.model.table[name]
    assert not servo.write(register.address, value.to_bytes(register.size, "little"))


def keep(path: Path, servos: World) -> StateKeeper:
    keeper = StateKeeper(path, servos.servos, NAMES)
    assert not path.exists()
    keeper.begin()
    return keeper


def test_eeprom_and_angle_come_back(tmp_path: Path) -> None:
    path = tmp_path / "state.json"
    before = world()
    keeper = keep(path, before)
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
    keeper = keep(path, servos)
    first = path.read_bytes()
    keeper.work(0.0)
    assert path.read_bytes() == first
    write_register(servos, 0, "Max Position Limit", 3000)
    keeper.work(0.0)
    eeprom = json.loads(path.read_text())["servos"][0]["eeprom"]
    assert eeprom["Max Position Limit"] == 3000


def test_the_old_file_stays_whole_when_the_new_one_cannot_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "state.json"
    servos = world()
    keeper = keep(path, servos)
    before = path.read_bytes()

    def full(*_: object, **__: object) -> int:
        raise OSError(28, os.strerror(28))

    write_register(servos, 0, "Max Position Limit", 3000)
    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_text", full)
        keeper.work(0.0)
        assert "No space left" in keeper.problem
        assert path.read_bytes() == before
    keeper.work(0.0)
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
        (json.dumps(damaged(eeprom={"Operating Mode": 2})), "Operating Mode = 2 is none that"),
        (json.dumps(damaged(eeprom={"Drive Mode": 2})), "Drive Mode = 2 is none that"),
        (json.dumps(damaged(backup={"Operating Mode": 2})), "backup: Operating Mode = 2"),
        ('{"schema": 1, "schema": "firmware-sim-state-1"}', "'schema' stands twice"),
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


def test_a_faults_rate_and_id_are_not_kept() -> None:
    """They would outlast the fault; what a client writes meanwhile is kept."""
    port = stepped("xm430-w350:1", "xm430-w350:2", faults=("duplicate-id:id=2,as=1", "wrong-baud"))
    servos = port.simulation.bus.servos
    true = [{"ID": servo.model.table["ID"].default, "Baud Rate": 1} for servo in servos]
    true[1]["ID"] = 2
    port.simulation.inject("wrong-baud:baud=9600,id=1")
    assert [servo.servo_id for servo in servos] == [1, 1]
    assert {servo.baud_rate for servo in servos} == {9600}
    for servo, own in zip(servos, true, strict=True):
        eeprom = port.simulation.snapshot(servo)["eeprom"]
        assert {name: eeprom[name] for name in own} == own
    assert not servos[0].write(servos[0].model.table["Baud Rate"].address, bytes((3,)))
    assert port.simulation.snapshot(servos[0])["eeprom"]["Baud Rate"] == 3
    port.simulation.clear("all")
    assert [servo.servo_id for servo in servos] == [1, 2]
    assert [servo.memory.value("Baud Rate") for servo in servos] == [3, 1]


WRITE_LIMIT = build_packet(1, 0x03, (52).to_bytes(2, "little") + (1234).to_bytes(4, "little"))


def eeprom_of(state: Path, place: int = 0) -> dict[str, int]:
    found: dict[str, int] = json.loads(state.read_text())["servos"][place]["eeprom"]
    return found


def test_an_acknowledged_write_is_in_the_file_soon_whatever_happens_then(tmp_path: Path) -> None:
    """Among 253 servos, with a trace, and a client that leaves no pause; then kill -9."""
    state = tmp_path / "state.json"
    servos = [f"xl330-m288:{number}" for number in range(253)]
    with simulated(*servos, state=state, baud=4_000_000) as arm:
        port = arm.port
        with serial.Serial(port, 4_000_000, timeout=2.0) as client:
            client.write(WRITE_LIMIT)
            assert client.read(11)[8] == 0
            deadline = time.monotonic() + 10.0
            pings = 0
            while eeprom_of(state, 1)["Min Position Limit"] != 1234:
                client.write(build_packet(1, 0x01) * 20)
                client.read(10 * 14)  # the other ten are under way
                pings += 1
                assert time.monotonic() < deadline
            assert pings < 1000
            deadline = time.monotonic() + 10.0
            while arm.trace.count("ping") < 20:
                client.write(build_packet(1, 0x01))
                client.read(14)
                assert time.monotonic() < deadline
            arm.process.kill()
            arm.process.wait()
    (tmp_path / ".state.json.new").write_text("of one that was killed amid a write")
    with simulated(*servos, state=state, baud=4_000_000):
        assert eeprom_of(state, 1)["Min Position Limit"] == 1234
    assert [entry.name for entry in tmp_path.iterdir()] == ["state.json"]


def test_what_the_command_line_says_counts_more_than_the_state(tmp_path: Path) -> None:
    state = tmp_path / "state.json"
    with simulated("xm430-w350:1", state=state, baud=57_600):
        pass
    options = ("--return-delay", "7", "--protocol", "1")
    with simulated("xm430-w350:1", state=state, baud=4_000_000, arguments=options) as arm:
        assert arm.status()["servos"][0]["baud"] == 4_000_000
        assert arm.status()["servos"][0]["protocol"] == 1
    with simulated("xm430-w350:1", state=state) as arm:
        assert arm.status()["servos"][0]["baud"] == 4_000_000
    assert eeprom_of(state)["Return Delay Time"] == 7


def test_what_the_state_overrides_is_said(tmp_path: Path) -> None:
    state, rig = tmp_path / "state.json", tmp_path / "rig.toml"
    with simulated("xm430-w350:1", state=state, baud=4_000_000):
        pass
    rig.write_text('[[servo]]\nid = 1\nmodel = "xm430-w350"\nbaud = 57600\n')
    done = subprocess.run(
        [*COMMAND, "--rig", str(rig), "--state", str(state), "--exit-with-stdin"],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    assert f"as {state} says: xm430-w350:1 Baud Rate = 6, not 1" in done.stderr


def test_one_state_is_not_for_two(tmp_path: Path) -> None:
    state, other = tmp_path / "state.json", tmp_path / "other.json"
    other.symlink_to(state)
    with simulated("xm430-w350:1", state=state):
        before = state.read_bytes()
        for path in (state, other):
            with pytest.raises(SimulatorStartError, match="in use by another simulator"):
                SimulatorProcess("--servo", "xm430-w350:1", "--state", str(path))
        assert state.read_bytes() == before
    with simulated("xm430-w350:1", state=other):
        assert other.is_symlink()
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["other.json", "state.json"]


def test_fifos_and_devices_are_no_files_to_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "fifo")
    for path in (tmp_path / "fifo", Path("/dev/zero")):
        with pytest.raises(StateFileError, match="no regular file"):
            read_state(path, NAMES)
        with pytest.raises(RigError, match="no regular file"):
            read_rig(path)
        with pytest.raises(FaultError, match="no regular file"):
            read_scenario(path)
