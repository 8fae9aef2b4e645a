"""The command ``firmware-sim`` as a process: its port, its link, its end, and bad input."""

import os
import pty
import re
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import serial

from firmware_sim.control.client import send
from firmware_sim.errors import SimulatorStartError
from firmware_sim.testing import SimulatorProcess, running, simulated
from firmware_sim.wire.packet import build_packet

COMMAND = [sys.executable, "-m", "firmware_sim"]
PING = build_packet(1, 0x01)


def ping(port: str, baud: int = 57_600) -> bytes:
    with serial.Serial(port, baud, timeout=2.0) as client:
        client.write(PING)
        return client.read(14)


def hung_up(client: int) -> bool:
    """Whether nobody serves an open port any more."""
    asked = select.poll()
    asked.register(client, 0)
    return any(event & select.POLLHUP for _, event in asked.poll(0))


def refused(*arguments: str) -> str:
    """Run the command with bad input; return its one line."""
    done = subprocess.run(
        [*COMMAND, *arguments],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        stdin=subprocess.DEVNULL,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    lines = done.stderr.splitlines(keepends=True)
    said = [line for line in lines if not line.startswith("firmware-sim: starting; ")]  # if slow
    assert [line[:14] for line in said] == ["firmware-sim: "]
    return said[0]


def test_the_first_line_is_the_port_and_a_client_can_open_it_again_and_again() -> None:
    with running("xm430-w350:1") as port:
        assert port.startswith("/dev/pts/")
        for _ in range(3):
            assert ping(port)[:5] == b"\xff\xff\xfd\x00\x01"
        client = os.open(port, os.O_RDWR | os.O_NOCTTY)
        assert not hung_up(client)
    try:  # whether the name is there says nothing: the next terminal takes its number
        assert hung_up(client)
    finally:
        os.close(client)


def test_it_says_that_it_is_a_simulation_and_ends_with_standard_input() -> None:
    done = subprocess.run(
        [*COMMAND, "--servo", "xm430-w350:1", "xl330-m288:2", "--exit-with-stdin"],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        stdin=subprocess.DEVNULL,
    )
    assert (done.returncode, done.stdout.count("\n")) == (0, 1)
    assert done.stderr == "firmware-sim: a simulation, no hardware: xm430-w350:1, xl330-m288:2\n"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_it_cleanly_and_removes_the_link(tmp_path: Path, number: int) -> None:
    link = tmp_path / "arm"
    simulator = SimulatorProcess("--servo", "xm430-w350:1", "--link", str(link))
    try:
        assert link.is_symlink()
        assert os.path.realpath(link) == simulator.port
        assert ping(str(link))
        simulator.process.send_signal(number)
        assert simulator.process.wait(10) == 0
    finally:
        simulator.stop()
    assert not os.path.lexists(link)


def test_a_taken_link_is_refused_and_left_alone(tmp_path: Path) -> None:
    taken = tmp_path / "taken"
    taken.write_text("mine")
    dangling = tmp_path / "dangling"
    dangling.symlink_to(tmp_path / "nowhere")
    for path in (taken, dangling):
        assert f"{path} exists already" in refused("--servo", "xm430-w350:1", "--link", str(path))
    assert taken.read_text() == "mine"
    assert dangling.readlink() == tmp_path / "nowhere"
    assert "cannot be made" in refused(
        "--servo", "xm430-w350:1", "--link", str(tmp_path / "no" / "folder")
    )


def test_a_link_left_by_a_killed_simulator_is_replaced(tmp_path: Path) -> None:
    link = tmp_path / "arm"
    first = SimulatorProcess("--servo", "xm430-w350:1", "--link", str(link))
    first.process.kill()
    first.process.wait(10)
    assert link.is_symlink()
    first.stop()
    with running("xm430-w350:1", arguments=("--link", str(link))) as port:
        assert os.path.realpath(link) == port
    assert not os.path.lexists(link)


def test_another_simulators_link_is_left_alone(tmp_path: Path) -> None:
    link = tmp_path / "arm"
    with running("xm430-w350:1", arguments=("--link", str(link))) as port:
        refused("--servo", "xm430-w350:1", "--link", str(link))
        assert os.path.realpath(link) == port
        assert ping(str(link))


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((), "say which servos: --servo, --arm or --rig"),
        (("--servo", "xm999:1"), "unknown servo model 'xm999'"),
        (("--servo", "xm430-w350:253"), "IDs go from 0 to 252"),
        (("--servo", "xm430-w350:1", "xl330-m288:1"), "ID 1 is given twice"),
        (("--servo", "xm430-w350:1", "--baud", "12345"), "baud = 12345 is none of"),
        (("--servo", "xm430-w350:1", "--baud", "12.345k"), "baud = 12345 is none of"),
        (("--servo", "xm430-w350:1", "--baud", "fast"), "'fast' is no baud rate"),
        (("--servo", "xl330-m288:1", "--baud", "4500000"), "baud = 4500000 is none of"),
        (("--servo", "xm430-w351:1"), "did you mean xm430-w350"),
        (("--servo", "xm430-w350@1000:1"), "is not of the form MODEL:ID"),
        (("--servo", "ax-12a:3", "--protocol", "2"), "ax-12a:3 speaks Protocol 1.0 only"),
        (("--servo", "xl-320:3", "--protocol", "1"), "xl-320:3 speaks Protocol 2.0 only"),
        (("--servo", "xm430-w350:1", "--protocol", "3"), "invalid choice: 3"),
        (("--servo", "xm430-w350:1", "--plant", "mujoco"), "--rig"),
        (("--servo", "xm430-w350:1", "--fault", "gremlins"), "no fault 'gremlins'"),
        (("--servo", "xm430-w350:1", "--fault", "jam:id=7"), "7"),
        (("--servo", "xm430-w350:1", "--scenario", "none.toml"), "none.toml cannot be read"),
        (("--servo", "xm430-w350:1", "--fault", "jam", "--seed", "-1"), "seed"),
        (("--servo", "xm430-w350:1", "--state", "/dev/null/state"), "/dev/null/state cannot be"),
        (("--servo", "xm430-w350:1", "--trace", "/dev/null/trace"), "/dev/null/trace cannot be"),
        (("--servo", "xm430-w350:1", "--control", "/dev/null/control"), "/dev/null/control"),
        (("--inject", "jam"), "need --control"),
        (("--control", "none", "--status"), "none cannot be read"),
        (("--control", "none", "--status", "--servo", "xm430-w350:1"), "runs already"),
        (("--servo", "xm430-w350:1", "--return-delay", "255"), "is not 0 to 254"),
        (("--servo", "xm430-w350:1", "--speed", "3"), "unrecognized arguments"),
        (("--rig", "no-such.toml"), "no-such.toml cannot be read"),
        (("--arm", "nobody"), "no arm 'nobody'"),
        (("--arm", "a", "--rig", "b"), "not allowed with argument"),
    ],
)
def test_bad_input_is_one_line_and_creates_nothing(
    tmp_path: Path, arguments: tuple[str, ...], says: str
) -> None:
    link = tmp_path / "arm"
    assert says in refused(*arguments, "--link", str(link))
    assert not os.path.lexists(link)


def test_an_arms_description_and_overrides(tmp_path: Path) -> None:
    (tmp_path / "thing.toml").write_text('[[servo]]\nid = 1\nmodel = "xl330-m288"\n')
    arguments = ("--arm", "thing", "--calibration", str(tmp_path))
    with running(arguments=arguments) as port:
        assert ping(port, 1_000_000)[9:11] == bytes((1200 & 0xFF, 1200 >> 8))
    with running(arguments=("--rig", str(tmp_path / "thing.toml"))) as port:
        assert ping(port, 57_600)[9:11] == bytes((1200 & 0xFF, 1200 >> 8))
    with running(arguments=(*arguments, "--baud", "4M")) as port:
        assert ping(port, 4_000_000)[9:11] == bytes((1200 & 0xFF, 1200 >> 8))


@pytest.mark.parametrize("client", [57_600, 1_000_000, 4_000_000])
def test_the_clients_baud_rate_counts(client: int) -> None:
    with (
        running("xm430-w350:1", arguments=("--baud", "4000000")) as port,
        serial.Serial(port, client, timeout=2.0) as line,
    ):
        line.write(PING)
        answer = line.read(14 if client == 4_000_000 else 1)
        assert answer.startswith(b"\xff\xff\xfd\x00\x01") == (client == 4_000_000)


@pytest.mark.parametrize("option", ["link", "state", "trace", "control", "scenario"])
@pytest.mark.parametrize("trouble", ["taken", "no/folder", "x" * 300])
def test_a_refused_start_leaves_no_file_at_all(tmp_path: Path, option: str, trouble: str) -> None:
    """One file cannot be: so none of the others may be there either."""
    taken = tmp_path / "taken"
    taken.mkdir()
    files = {name: tmp_path / name for name in ("state", "trace", "control", "link")}
    files[option] = tmp_path / trouble
    given = [f"--{name}={path}" for name, path in files.items()]
    assert str(files[option]) in refused("--servo", "xm430-w350:1", *given)
    assert [entry.name for entry in tmp_path.iterdir()] == ["taken"]


@pytest.mark.parametrize("one", ["rig", "scenario", "state", "control"])
@pytest.mark.parametrize("other", ["trace", "link"])
def test_one_file_cannot_be_two(tmp_path: Path, one: str, other: str) -> None:
    """Also by another name: what is read would be overwritten."""
    files = {name: tmp_path / name for name in (one, "rig")}
    files["rig"].write_text('[[servo]]\nid = 1\nmodel = "xm430-w350"\n')
    (tmp_path / "scenario").write_text("seed = 3\n")
    before = {entry: entry.read_text() for entry in tmp_path.iterdir()}
    files[other] = tmp_path / ".." / tmp_path.name / one
    says = refused(*(f"--{name}={path}" for name, path in files.items()))
    assert "cannot be both" in says
    assert f"--{one}" in says
    assert f"--{other}" in says
    assert {entry: entry.read_text() for entry in tmp_path.iterdir()} == before


def test_a_killed_simulators_link_is_replaced_though_its_port_is_somebody_elses(
    tmp_path: Path,
) -> None:
    link = tmp_path / "arm"
    simulator = SimulatorProcess("--servo", "xm430-w350:1", "--link", str(link))
    simulator.process.kill()
    simulator.stop()
    stale = str(link.readlink())
    others = []
    try:
        while not Path(stale).exists():
            others.append(pty.openpty())  # one of them gets its number
            assert len(others) < 100
        with running("xm430-w350:1", arguments=("--link", str(link))):
            assert ping(str(link))[4] == 1
        assert list(tmp_path.iterdir()) == []
    finally:
        for descriptor in (end for pair in others for end in pair):
            os.close(descriptor)


def test_a_live_simulators_link_is_not_replaced(tmp_path: Path) -> None:
    link = tmp_path / "arm"
    with running("xm430-w350:1", arguments=("--link", str(link))):
        says = refused("--servo", "xm430-w350:1", "--link", str(link))
        assert "another simulator's" in says
        assert ping(str(link))[4] == 1


def test_somebody_elses_link_to_a_terminal_is_left_alone(tmp_path: Path) -> None:
    link = tmp_path / "arm"
    master, slave = pty.openpty()
    try:
        link.symlink_to(os.ttyname(slave))
        assert "exists already" in refused("--servo", "xm430-w350:1", "--link", str(link))
        assert str(link.readlink()) == os.ttyname(slave)
    finally:
        os.close(master)
        os.close(slave)


def test_a_state_file_that_is_none_is_refused_and_left_alone(tmp_path: Path) -> None:
    state, link = tmp_path / "state.json", tmp_path / "arm"
    state.write_text("{}")
    says = refused("--servo", "xm430-w350:1", "--state", str(state), "--link", str(link))
    assert f"{state} is no state file" in says
    assert state.read_text() == "{}"
    assert not os.path.lexists(link)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_before_the_port_is_there_ends_it_cleanly(tmp_path: Path, number: int) -> None:
    link, state = tmp_path / "arm", tmp_path / "state.json"
    process = subprocess.Popen(
        [*COMMAND, "--arm", "human7", "--link", str(link), "--state", str(state)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    status = Path(f"/proc/{process.pid}/status")
    while not int(re.findall(r"SigCgt:\s*(\w+)", status.read_text())[0], 16) >> 14 & 1:
        pass  # until SIGTERM is caught; Python itself catches SIGINT from the first
    process.send_signal(number)
    _output, errors = process.communicate(timeout=60)
    assert process.returncode == 0
    assert "Traceback" not in errors
    assert not os.path.lexists(link)


def use_until_it_hangs_up(client: serial.Serial) -> None:
    while True:
        client.write(PING)
        client.read(1)


def test_what_is_left_of_an_unplugged_port_comes_back_under_its_link() -> None:
    with simulated("xm430-w350:1") as arm:
        with serial.Serial(arm.link, 57_600, timeout=2.0) as client:
            arm.inject("unplugged:for=0.3")
            assert not os.path.lexists(arm.link)
            with pytest.raises(OSError, match=r"."):
                use_until_it_hangs_up(client)
        while arm.status()["unplugged"]:
            time.sleep(0.01)
        assert ping(arm.link)[4] == 1


@pytest.mark.parametrize(
    ("servo", "protocol", "request_", "answer"),
    [
        ("ax-12a:1", None, "ffff010201fb", "ffff010200fc"),
        ("mx-28:1", "1", "ffff010201fb", "ffff010200fc"),
        ("xm430-w350:1", "1", "ffff010201fb", "ffff010200fc"),
        ("mx-28:1", "2", PING.hex(), "fffffd0001070055001e"),
    ],
)
def test_either_protocol_is_spoken(
    servo: str, protocol: str | None, request_: str, answer: str
) -> None:
    arguments = ("--baud", "1000000", *(("--protocol", protocol) if protocol else ()))
    with (
        running(servo, arguments=arguments) as port,
        serial.Serial(port, 1_000_000, timeout=2.0) as client,
    ):
        client.write(bytes.fromhex(request_))
        assert client.read(len(answer) // 2).hex() == answer


def test_the_firmware_asked_for_is_reported() -> None:
    with running("xm430-w350@42:1") as port:
        assert ping(port)[11] == 42


def test_models_faults_and_version_are_listed() -> None:
    for option, says in (
        ("--list-models", "xm430-w350    firmware  45  Protocol 2.0 or 1.0"),
        ("--list-models", "ax-12a        firmware  24  Protocol 1.0\n"),
        ("--list-faults", "crc-error [3]:"),
        ("--version", "firmware-sim "),
    ):
        done = subprocess.run(
            [*COMMAND, option], capture_output=True, text=True, timeout=60, check=True
        )
        assert says in done.stdout
        assert done.stderr == ""


def test_a_rate_without_a_name_is_understood() -> None:
    with running("xm430-w350:1", arguments=("--baud", "4500000")) as port:
        assert ping(port, 4_500_000)[4] == 1


def test_help_says_what_is_not_modelled() -> None:
    done = subprocess.run(
        [*COMMAND, "--help"], capture_output=True, text=True, timeout=60, check=True
    )
    assert "--servo MODEL[@FIRMWARE]:ID" in done.stdout
    assert "What is not modelled:" in done.stdout


def test_a_simulator_that_cannot_start_says_so() -> None:
    with pytest.raises(SimulatorStartError) as caught:
        SimulatorProcess("--servo", "nothing:1")
    assert caught.value.exit_status_seen == 2
    assert "'nothing'" in str(caught.value).partition(": firmware-sim: ")[2]


def test_what_it_says_is_taken_and_no_table_is_drawn() -> None:
    """However much that is: nobody reads it, and a pipe that is full would hold it up."""
    with simulated("xm430-w350:1") as arm:
        ping(arm.port)
        assert "a simulation, no hardware" in arm.last_words
        assert "--no-table" in Path(f"/proc/{arm.process.pid}/cmdline").read_text()
        assert os.getsid(arm.process.pid) == arm.process.pid


def test_a_client_that_never_reads_does_not_stop_it() -> None:
    with running("xm430-w350:1", arguments=("--baud", "4000000", "--return-delay", "0")) as port:
        with serial.Serial(port, 4_000_000, timeout=2.0) as deaf:
            read = build_packet(1, 0x02, bytes((0, 0, 0, 2)))
            for _ in range(100):
                deaf.write(read)
        assert ping(port, 4_000_000)[4] == 1


def test_a_killed_parent_leaves_nothing_behind(tmp_path: Path) -> None:
    link = tmp_path / "arm"
    program = (
        "import os, signal\n"
        "from firmware_sim.testing import SimulatorProcess\n"
        f"SimulatorProcess('--servo', 'xm430-w350:1', '--link', {str(link)!r})\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], timeout=60, check=False)
    assert done.returncode == -signal.SIGKILL
    deadline = time.monotonic() + 10.0
    while os.path.lexists(link):
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_a_flood_is_held_back_as_at_a_real_port() -> None:
    """A megabyte takes three minutes at 57600 bit/s: the client's write blocks meanwhile."""
    with running("xm430-w350:1") as port:
        with serial.Serial(port, 57_600, timeout=2.0, write_timeout=0.3) as client:
            with pytest.raises(serial.SerialTimeoutException):
                client.write(PING * 100_000)
            client.reset_output_buffer()
        assert Path(port).exists()


def test_a_port_whose_link_is_taken_meanwhile_complains_and_comes_back(tmp_path: Path) -> None:
    link, control = tmp_path / "arm", tmp_path / "control"
    simulator = SimulatorProcess(
        "--servo", "xm430-w350:1", "--link", str(link), "--control", str(control)
    )
    try:
        send(control, "inject", "unplugged:for=0.3")
        link.write_text("mine")
        deadline = time.monotonic() + 20.0
        while "exists already" not in " ".join(simulator.messages):
            assert time.monotonic() < deadline
            time.sleep(0.01)
        assert link.read_text() == "mine"
        link.unlink()
        while not link.is_symlink():
            assert time.monotonic() < deadline
            time.sleep(0.01)
        assert ping(str(link))[4] == 1
    finally:
        simulator.stop()
