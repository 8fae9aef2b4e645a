"""The control socket: who may speak, what can be asked, and that nothing disturbs it."""

import json
import select
import socket
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from firmware_sim.control import socket as control
from firmware_sim.control.client import send
from firmware_sim.control.file import ControlAddress, read_control_file
from firmware_sim.control.socket import CONNECTION_CAP, LINE_CAP, ControlSocket
from firmware_sim.errors import ControlError, OutputError
from tests.firmware_sim.faults_bench import FaultBench

TWO = ("xm430-w350:1", "ax-12a:2")


class Desk:
    """A control socket on a stepped bench, and the loop that serves it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.bench = FaultBench(servos=TWO)
        self.control = ControlSocket(self.bench.simulation, path, self.bench.clock)
        self.address = read_control_file(path)

    def connect(self) -> socket.socket:
        """A client that waits up to 5 s for an answer."""
        return self.address.connect(5.0)

    def serve(self) -> None:
        """Serve until nobody has anything more to say."""
        while ready := select.select(self.control.descriptors(), [], [], 0.01)[0]:
            self.control.serve(ready)

    def say(self, client: socket.socket, data: bytes) -> list[dict[str, Any]]:
        """Send bytes and return the answers, until the end where the socket was closed."""
        client.sendall(data)
        self.serve()
        return self.hear(client)

    @staticmethod
    def hear(client: socket.socket) -> list[dict[str, Any]]:
        """The answers that have come."""
        client.setblocking(False)
        heard = b""
        try:
            while chunk := client.recv(65_536):
                heard += chunk
        except (BlockingIOError, ConnectionResetError):
            pass
        client.settimeout(5.0)
        return [json.loads(line) for line in heard.splitlines()]

    def ask(self, **request: object) -> dict[str, Any]:
        """Ask with the right token on a connection of its own."""
        with self.connect() as client:
            (answer,) = self.say(client, self.line(**request))
        self.serve()
        return answer

    def line(self, **request: object) -> bytes:
        """A request with the right token."""
        return json.dumps({"token": self.address.token, **request}).encode() + b"\n"


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    made = Desk(tmp_path / "control")
    yield made
    made.control.close()


def is_closed(client: socket.socket) -> bool:
    """Whether the other end has closed, now."""
    try:
        return client.recv(1) == b""
    except ConnectionResetError:
        return True


def test_the_file_is_for_its_owner_alone(desk: Desk) -> None:
    assert desk.path.stat().st_mode & 0o777 == 0o600
    assert len(desk.address.token) >= 32
    assert desk.control._listener.getsockname()[0] == "127.0.0.1"


def test_a_fault_is_injected_listed_and_cleared(desk: Desk) -> None:
    answer = desk.ask(command="inject", fault="lost-replies:id=1")
    assert answer == {
        "ok": True,
        "number": 1,
        "fault": "lost-replies:id=1",
        "begin": 0.0,
        "strikes": 0,
    }
    assert desk.bench.ping() == b""
    (fault,) = desk.ask(command="list")["faults"]
    assert fault["strikes"] == 1
    assert desk.ask(command="clear", fault="lost-replies") == {"ok": True, "cleared": [1]}
    assert len(desk.bench.ping()) == 14
    (strike,) = desk.ask(command="log")["log"]
    assert (strike["fault"], strike["tick"], strike["id"]) == ("lost-replies", 0, 1)


def test_what_is_injected_begins_at_the_present(desk: Desk) -> None:
    desk.bench.clock.advance(7.0)
    assert desk.ask(command="inject", fault="reboot:after=0.5")["begin"] == 7.5


def test_status_tells_how_the_servos_are(desk: Desk) -> None:
    desk.bench.write(64, 1)
    desk.ask(command="inject", fault="overload:id=1")
    status = desk.ask(command="status")
    first, second = status["servos"]
    assert (first["id"], first["model"], first["protocol"]) == (1, "xm430-w350", 2)
    assert first["registers"]["Hardware Error Status"] == 0x20
    assert first["registers"]["Torque Enable"] == 0
    assert abs(first["registers"]["Present Position"] - 2048) <= 1
    assert (second["id"], second["model"], second["protocol"]) == (2, "ax-12a", 1)
    assert "Present Position" in second["registers"]
    assert status["strikes"] == {"overload": 1}
    assert status["unplugged"] is False


@pytest.mark.parametrize(
    ("request_", "words"),
    [
        ({}, "command is none of inject, clear, list, log, status"),
        ({"command": "quit"}, "command is none of"),
        ({"command": ["inject"]}, "command is none of"),
        ({"command": "inject"}, "inject needs fault"),
        ({"command": "inject", "fault": 3}, "inject takes fault, as text"),
        ({"command": "inject", "fault": "crc-eror"}, "crc-error"),
        ({"command": "inject", "fault": "crc-error:id=9"}, "no servo 9"),
        ({"command": "clear", "fault": "noise"}, "no fault 'noise' is in force"),
        ({"command": "status", "fault": "x"}, "status takes nothing"),
        ({"command": "list", "other": "x"}, "list takes nothing"),
    ],
)
def test_requests_that_make_no_sense_are_refused_in_a_line(
    desk: Desk, request_: dict[str, object], words: str
) -> None:
    answer = desk.ask(**request_)
    assert answer["ok"] is False
    assert words in answer["error"]
    assert desk.control.refused == 1
    assert not desk.bench.simulation.faults


@pytest.mark.parametrize(
    "line",
    [
        b"\n",
        b"garbage\n",
        b"{}\n",
        b"[]\n",
        b"3\n",
        b'{"token": 3, "command": "list"}\n',
        b'{"token": "wrong", "command": "list"}\n',
        b'{"token": "\\ud800", "command": "list"}\n',
        b'{"token": "wr\xc3\xb6ng", "command": "list"}\n',
        b"\xff\xfe\x00\n",
        b"[" * 4000 + b"\n",
        b"9" * 4000 + b"\n",
        b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n",
    ],
)
def test_whoever_does_not_know_the_token_is_disconnected(desk: Desk, line: bytes) -> None:
    with desk.connect() as client:
        assert desk.say(client, line) == [{"ok": False, "error": "no request with a valid token"}]
        assert is_closed(client)
    assert desk.ask(command="list")["ok"]


def test_a_line_without_end_is_cut_off(desk: Desk) -> None:
    with desk.connect() as client:
        answers = desk.say(client, b"x" * (LINE_CAP + 100))
        assert answers in ([{"ok": False, "error": "too much"}], [])  # a reset may swallow it
        assert is_closed(client)


def test_half_lines_wait_without_disturbing_others(desk: Desk) -> None:
    request = desk.line(command="list")
    with desk.connect() as slow:
        assert desk.say(slow, request[:20]) == []
        assert desk.ask(command="status")["ok"]
        assert len(desk.bench.ping()) == 14
        assert desk.say(slow, request[20:])[0]["ok"]


def test_several_requests_in_one_go_are_answered_one_a_turn(desk: Desk) -> None:
    with desk.connect() as client:
        client.sendall(desk.line(command="list") * 3)
        desk.control.serve(select.select(desk.control.descriptors(), [], [], 5.0)[0])  # accepts
        for _ in range(3):
            desk.control.serve(select.select(desk.control.descriptors(), [], [], 5.0)[0])
            assert len(desk.hear(client)) == 1


def test_the_longest_silent_connection_makes_room(desk: Desk) -> None:
    clients = []
    try:
        for _ in range(CONNECTION_CAP + 3):
            clients.append(desk.connect())
            desk.serve()
        assert [is_closed(client) for client in clients[:3]] == [True] * 3
        assert desk.say(clients[3], desk.line(command="list"))[0]["ok"]
        assert desk.ask(command="list")["ok"]
    finally:
        for client in clients:
            client.close()


def test_strangers_do_not_push_out_whoever_has_shown_the_token(desk: Desk) -> None:
    clients = [desk.connect()]
    try:
        desk.serve()
        assert desk.say(clients[0], desk.line(command="list"))[0]["ok"]
        for _ in range(2 * CONNECTION_CAP):
            clients.append(desk.connect())
            desk.serve()
        assert desk.say(clients[0], desk.line(command="list"))[0]["ok"]
        assert is_closed(clients[1])
    finally:
        for client in clients:
            client.close()


def test_a_client_that_goes_in_the_middle_is_forgotten(desk: Desk) -> None:
    for data in (b"", b"{", desk.line(command="status")):
        client = desk.connect()
        client.sendall(data)
        client.close()
        desk.serve()
    assert len(desk.control.descriptors()) == 1
    assert desk.ask(command="list")["ok"]


def test_a_client_that_does_not_read_is_dropped(desk: Desk) -> None:
    here, there = socket.socketpair()  # its buffers are small, and of a known kind
    with here, there:
        here.setblocking(False)
        connection = control._Connection(here)
        desk.control._connections[here.fileno()] = connection
        while connection.send({"ok": True, "filling": "x" * 1000}):
            pass
        there.sendall(desk.line(command="list"))
        desk.control.serve([here.fileno()])
        assert not connection.is_open
        assert len(desk.control.descriptors()) == 1


def test_a_connection_has_only_so_many_requests(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(control, "REQUEST_CAP", 3)
    with desk.connect() as client:
        answers = desk.say(client, desk.line(command="list") * 4)
        assert [answer["ok"] for answer in answers] == [True, True, True, False]
        assert is_closed(client)


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.lists(st.binary(max_size=300), max_size=5))
def test_no_bytes_of_strangers_disturb_it(desk: Desk, chunks: list[bytes]) -> None:
    with desk.connect() as client, suppress(ConnectionError):
        for chunk in chunks:
            client.sendall(chunk)
            desk.serve()
    desk.serve()
    assert len(desk.control.descriptors()) == 1
    assert not desk.bench.simulation.faults


def test_closing_removes_the_file_and_disconnects(desk: Desk) -> None:
    with desk.connect() as client:
        desk.serve()
        desk.control.close()
        desk.control.close()
        assert is_closed(client)
    assert not desk.path.exists()
    with pytest.raises(ConnectionRefusedError):
        desk.connect()


def test_a_file_that_is_there_already_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "notes"
    path.write_text("mine")
    simulation = FaultBench().simulation
    with pytest.raises(OutputError, match="exists already"):
        ControlSocket(simulation, path)
    assert path.read_text() == "mine"
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(OutputError, match="exists already"):
        ControlSocket(simulation, link)
    with pytest.raises(OutputError, match="cannot be made"):
        ControlSocket(simulation, tmp_path / "missing" / "file")


def test_the_file_of_a_living_simulator_is_left_and_of_a_dead_one_replaced(desk: Desk) -> None:
    simulation = FaultBench().simulation
    with pytest.raises(OutputError, match="exists already"):
        ControlSocket(simulation, desk.path)
    left = desk.path.read_bytes()
    desk.control.close()
    desk.path.write_bytes(left)
    desk.path.chmod(0o600)
    second = ControlSocket(simulation, desk.path)
    assert desk.path.read_bytes() != left
    second.close()
    assert not desk.path.exists()


def test_a_file_that_has_become_anothers_is_not_removed(desk: Desk) -> None:
    desk.path.unlink()
    desk.path.write_text("another's")
    desk.control.close()
    assert desk.path.read_text() == "another's"


def served(desk: Desk, path: Path, command: str, fault: str | None = None) -> Any:
    """What `send` returns or raises, while a thread serves the socket."""
    done = threading.Event()

    def loop() -> None:
        while not done.is_set():
            desk.control.serve(select.select(desk.control.descriptors(), [], [], 0.01)[0])

    server = threading.Thread(target=loop)
    server.start()
    try:
        return send(path, command, fault)
    except ControlError as error:
        return str(error)
    finally:
        done.set()
        server.join()


def test_the_client_function_asks_and_returns(desk: Desk) -> None:
    assert served(desk, desk.path, "inject", "noise")["number"] == 1
    assert served(desk, desk.path, "clear", "all") == {"cleared": [1]}
    assert "no fault 'nose'" in served(desk, desk.path, "inject", "nose")


def test_the_client_says_when_nobody_is_there(tmp_path: Path, desk: Desk) -> None:
    with pytest.raises(ControlError, match="cannot be read"):
        send(tmp_path / "none", "list")
    for content in ("", "{}", "[" * 3000, '{"schema": "firmware-sim-control-1", "port": 0}'):
        (tmp_path / "bad").write_text(content)
        with pytest.raises(ControlError, match="is not a control file"):
            send(tmp_path / "bad", "list")
    left = desk.path.read_text()
    desk.control.close()
    (tmp_path / "dead").write_text(left)
    with pytest.raises(ControlError, match="does not answer"):
        send(tmp_path / "dead", "list")


def test_the_client_does_not_believe_whatever_answers(tmp_path: Path) -> None:
    for answer in (b"HTTP/1.1 400 Bad Request\r\n", b"", b"3\n", b"{}\n"):
        with socket.create_server(("127.0.0.1", 0)) as other:
            address = ControlAddress(other.getsockname()[1], "t")
            file = tmp_path / "control"
            file.write_text(
                json.dumps({"schema": "firmware-sim-control-1", "port": address.port, "token": "t"})
            )

            def reply(data: bytes, server: socket.socket) -> None:
                client, _ = server.accept()
                with client:
                    client.recv(1000)
                    client.sendall(data)

            thread = threading.Thread(target=reply, args=(answer, other))
            thread.start()
            with pytest.raises(ControlError, match="no simulator"):
                send(file, "list")
            thread.join()


def test_nothing_stays_open(tmp_path: Path) -> None:
    before = sum(1 for _ in Path("/proc/self/fd").iterdir())
    made = Desk(tmp_path / "control")
    with made.connect():
        made.serve()
        made.control.close()
    assert sum(1 for _ in Path("/proc/self/fd").iterdir()) == before
