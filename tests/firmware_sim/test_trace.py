"""The packet trace: what its lines say, in place and in order, and what a full disk does to it."""

import re
from io import FileIO
from pathlib import Path

import pytest

from firmware_sim.assembly import build_simulation
from firmware_sim.clock import SteppedClock
from firmware_sim.errors import OutputError
from firmware_sim.faults.parsing import parse_fault
from firmware_sim.rig.settings import Rig, parse_servo, with_baud_rate
from firmware_sim.testing import SteppedPort, running, simulated
from firmware_sim.trace.file import TraceFile
from firmware_sim.trace.record import TracedSimulation
from firmware_sim.wire.packet import build_packet


class Traced:
    """Servos on a stepped clock whose packets are traced."""

    def __init__(self, path: Path, *servos: str, faults: tuple[str, ...] = ()) -> None:
        settings = [with_baud_rate(parse_servo(servo), 1_000_000) for servo in servos]
        simulation = build_simulation(
            Rig([s.with_registers({"Return Delay Time": 0}) for s in settings]),
            faults=[parse_fault(text) for text in faults],
            trace=path,
        )
        assert isinstance(simulation, TracedSimulation)
        self.trace = simulation.trace
        self.path = path
        self.port = SteppedPort(simulation, SteppedClock(), 1_000_000)

    def ask(self, servo_id: int, instruction: int, params: bytes = b"") -> bytes:
        return self.port.exchange(build_packet(servo_id, instruction, params))

    def lines(self) -> list[str]:
        """Close the trace and return its lines, without the heading and the bytes."""
        self.trace.file.open()
        self.trace.close()
        _heading, *lines = self.path.read_text().splitlines()
        return [re.sub(r" +", " ", line.partition("|")[0]).strip() for line in lines]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "trace.txt"


def test_lines_name_registers_and_values(path: Path) -> None:
    bus = Traced(path, "xm430-w350:1", "xl330-m288:2")
    bus.ask(1, 0x03, bytes((116, 0)) + (1000).to_bytes(4, "little"))
    bus.ask(1, 0x02, bytes((144, 0, 3, 0)))
    bus.ask(1, 0x03, bytes((7, 0, 253)))
    bus.ask(254, 0x82, bytes((132, 0, 4, 0, 2, 1)))
    bus.ask(254, 0x8A, bytes((132, 0, 4, 0, 1, 2)))
    bus.ask(254, 0x83, bytes((65, 0, 1, 0, 1, 1, 2, 0)))
    bus.ask(2, 0x01)
    position = "Present Position = 2048 tick"
    assert [line.split(" ", 1)[1] for line in bus.lines()] == [
        "-> 2.0 ID 1 write Goal Position = 1000 tick",
        "<- 2.0 ID 1 status",
        "-> 2.0 ID 1 read Present Input Voltage, Present Temperature [144..146]",
        "<- 2.0 ID 1 status Present Input Voltage = 12 V, Present Temperature = 25 °C",
        "-> 2.0 ID 1 write ID = 253",
        "<- 2.0 ID 1 status ERROR data range",
        "-> 2.0 all sync read Present Position [132..135] of 2 1",
        f"<- 2.0 ID 2 status {position}",
        f"<- 2.0 ID 1 status {position}",
        "-> 2.0 all fast sync read Present Position [132..135] of 1 2",
        f"<- 2.0 all status 1: {position}; 2: {position}",
        "-> 2.0 all sync write 1: LED = 1; 2: LED = 0",
        "-> 2.0 ID 2 ping",
        "<- 2.0 ID 2 status model number 1200, firmware 53",
    ]


def test_both_protocols_are_read(path: Path) -> None:
    bus = Traced(path, "ax-12a:1", "xm430-w350:2")
    bus.port.exchange(bytes.fromhex("ffff0104022402d2"))  # the manual's form: read 36, 2 bytes
    bus.ask(2, 0x02, bytes((132, 0, 4, 0)))
    first, second, third, _ = bus.lines()
    assert first.endswith("-> 1.0 ID 1 read Present Position [36..37]")
    assert re.search(r"<- 1\.0 ID 1 status Present Position = 148\.\d+ °$", second)
    assert third.endswith("-> 2.0 ID 2 read Present Position [132..135]")


def test_the_bytes_are_there_and_times_are_ends_of_packets(path: Path) -> None:
    bus = Traced(path, "xm430-w350:1")
    bus.port.clock.advance(2.0)
    sent = build_packet(1, 0x01)
    answer = bus.ask(1, 0x01)
    bus.lines()
    _, request, reply = path.read_text().splitlines()
    assert request.endswith("| " + sent.hex(" ").upper())
    assert reply.endswith("| " + answer.hex(" ").upper())
    assert float(request.split()[0]) == pytest.approx(2.0 + 10 * 10e-6, abs=1e-6)
    assert float(reply.split()[0]) == pytest.approx(2.0 + 24 * 10e-6, abs=1e-6)


def test_damaged_and_dropped_bytes_are_shown_in_their_place(path: Path) -> None:
    bus = Traced(path, "xm430-w350:1")
    ping = build_packet(1, 0x01)
    bus.port.exchange(b"\x01\x02\x03" + ping)
    bus.port.exchange(ping[:-1] + bytes((ping[-1] ^ 1,)))
    bus.port.clock.advance(1.0)
    bus.port.exchange(b"\x09")
    lines = [line.split(" ", 1)[1] for line in bus.lines()]
    assert lines[0] == "?? 3 bytes in no frame, at 1000000 bit/s"
    assert lines[1] == "-> 2.0 ID 1 ping"
    assert lines[3] == "-> 2.0 ID 1 DAMAGED wrong checksum"
    assert lines[4] == "<- 2.0 ID 1 status ERROR crc"
    assert lines[5] == "?? 1 bytes in no frame, at 1000000 bit/s"
    assert len(lines) == 6
    assert "| 01 02 03" in path.read_text()


def test_bytes_at_a_rate_that_no_servo_has_are_shown(path: Path) -> None:
    bus = Traced(path, "xm430-w350:1")
    bus.port.baud_rate = 57_600
    bus.ask(1, 0x01)
    lines = bus.lines()
    assert "!! the client gets" in lines[0]
    assert lines[-1].endswith("?? 10 bytes in no frame, at 57600 bit/s")


def test_faults_that_strike_are_shown_where_they_strike(path: Path) -> None:
    bus = Traced(path, "xm430-w350:1", faults=("crc-error:id=1,count=1",))
    damaged = bus.ask(1, 0x01)
    bus.ask(1, 0x01)
    lines = [line.split(" ", 1)[1] for line in bus.lines()]
    assert lines[1:3] == ["-> 2.0 ID 1 ping", "<- 2.0 ID 1 status model number 1020, firmware 45"]
    assert lines[0].startswith("** tick 0: fault 1 crc-error strikes at servo 1: bytes ")
    assert lines[3] == "!! the client gets 14 bytes"
    assert len(lines) == 6
    assert "| " + damaged.hex(" ").upper() in path.read_text()


def test_a_lost_reply_is_shown_as_said_and_struck(path: Path) -> None:
    bus = Traced(path, "xm430-w350:1", faults=("lost-replies:id=1",))
    assert bus.ask(1, 0x01) == b""
    lines = bus.lines()
    assert "lost-replies strikes" in lines[0]
    assert "<- 2.0 ID 1 status" in lines[2]


@pytest.mark.parametrize("fault", ["crc-error", "late-reply:delay=0.1", "duplicate-reply"])
def test_within_an_exchange_lines_are_in_order_of_their_times(path: Path, fault: str) -> None:
    bus = Traced(path, "xm430-w350:1", faults=(fault,))
    for _ in range(3):
        bus.ask(1, 0x01)
    times = [float(line.split(" ", 1)[0]) for line in bus.lines()]
    assert len(times) > 6
    assert times == sorted(times)


def test_a_fault_that_lasts_ends_without_a_strike(path: Path) -> None:
    bus = Traced(path, "xm430-w350:1", faults=("silent-servo:for=0.5",))
    bus.port.wait_until(1.0)
    assert [line.split(" ", 2)[2] for line in bus.lines()] == [
        "tick 0: fault 1 silent-servo strikes: begins",
        "tick 500: fault 1 silent-servo ends",
    ]
    assert bus.port.simulation.strikes == {"silent-servo": 1}
    assert [strike.ends for strike in bus.port.simulation.log] == [False, True]


def test_what_servos_say_while_the_port_is_gone_does_not_pile_up(path: Path) -> None:
    bus = Traced(path, "xm430-w350:1", faults=("unplugged", "foreign-traffic:every=0.001"))
    bus.port.wait_until(3.0)
    bus.lines()
    assert len(bus.trace._spoken) <= 1000


def test_a_header_within_bytes_of_no_frame_is_pointed_at(path: Path) -> None:
    bus = Traced(path, "xm430-w350:1")
    unstuffed = bytes.fromhex("fffffd00 01 0b00 03 7400 fffffd 00 1111 2222")
    bus.port.write(unstuffed)
    bus.port.wait_until(1.0)
    assert "a header within it: stuffing missing?" in "\n".join(bus.lines())


def test_what_comes_faster_than_it_can_be_written_is_counted(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("firmware_sim.trace.record.RECORD_CAP", 4)
    bus = Traced(path, "xm430-w350:1")
    for _ in range(10):
        bus.ask(1, 0x01)
    assert bus.trace.lost_records > 0
    assert "missing" in bus.trace.problem
    assert f"# {bus.trace.lost_records} packets are missing here" in "\n".join(bus.lines())


def test_a_full_disk_is_flagged() -> None:
    full = TraceFile(Path("/dev/full"))
    full.open()
    full.write("one\ntwo\n")
    full.close()
    assert "No space left" in full.problem
    assert full.lost_lines == 2


def test_when_there_is_room_again_the_file_says_what_is_missing(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with path.open("wb", buffering=0) as real:
        disk = FillingDisk(real)
        file = TraceFile(path)
        with monkeypatch.context() as patch:
            patch.setattr(Path, "open", lambda *_, **__: disk)
            file.open()
        for text in ("one\n", "two\n", "three\n"):
            file.write(text)
        file.close()
    assert (file.problem, file.lost_lines) == ("", 1)
    assert path.read_bytes() == b"# 1 lines are missing here\ntwo\nthree\n"


class FillingDisk:
    """A file whose disk is full at its first write, and takes a few bytes at a time later."""

    def __init__(self, file: FileIO) -> None:
        self.file = file
        self.writes = 0

    def __enter__(self) -> "FillingDisk":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def write(self, data: bytes) -> int:
        self.writes += 1
        if self.writes == 1:
            raise OSError(28, "No space left on device")
        return self.file.write(data[:5])


def test_a_disk_that_takes_nothing_does_not_hold_anybody_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("firmware_sim.trace.file.BACKLOG_CAP", 10)
    file = TraceFile(tmp_path / "trace.txt")
    for number in range(4):
        file.write(f"line {number}\n")  # nobody writes yet
    assert file.lost_lines == 3
    file.open()
    file.close()
    assert (tmp_path / "trace.txt").read_text() == "# 3 lines are missing here\nline 0\n"


def test_a_file_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="cannot be written"):
        TraceFile(tmp_path / "no" / "trace.txt").open()


def test_the_command_serves_on_with_a_full_disk() -> None:
    import serial

    with (
        running("xm430-w350:1", arguments=("--trace", "/dev/full")) as port,
        serial.Serial(port, 57_600, timeout=2.0) as client,
    ):
        for _ in range(20):
            client.write(build_packet(1, 0x01))
            assert len(client.read(14)) == 14


def test_the_command_writes_it() -> None:
    import serial

    with (
        simulated("xm430-w350:1", faults=["lost-replies:count=1"]) as arm,
        serial.Serial(arm.port, 57_600, timeout=2.0) as client,
    ):
        client.write(build_packet(1, 0x03, bytes((65, 0, 1))))
        client.timeout = 0.2
        assert client.read(11) == b""
    assert "write          LED = 1" in arm.trace
    assert "fault 1 lost-replies strikes" in arm.trace
    assert arm.trace.endswith("\n")
