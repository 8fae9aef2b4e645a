"""Opening ports: each way to fail has its own message, and a port is one program's alone."""

import contextlib
import errno
import os
import signal
import subprocess
import sys
import tempfile
import threading
import tty
from collections.abc import Iterator
from pathlib import Path

import pytest
import serial

from armsyn.driver import bus, serial_port
from armsyn.driver.port_lock import PortLock, lock_file, look
from armsyn.driver.serial_port import SerialPort
from armsyn.errors import PortError, PortLostError


@pytest.fixture
def terminal() -> Iterator[tuple[int, str]]:
    """A pseudo-terminal: its master and the port's path."""
    master, slave = os.openpty()
    tty.setraw(slave)
    yield master, os.ttyname(slave)
    for descriptor in (master, slave):
        with contextlib.suppress(OSError):  # the test has closed it
            os.close(descriptor)


def test_bytes_go_both_ways(terminal: tuple[int, str]) -> None:
    master, path = terminal
    port = SerialPort(path, 1_000_000)
    assert port.baud == 1_000_000
    port.write(b"out")
    assert os.read(master, 10) == b"out"
    os.write(master, b"in")
    assert port.read(port.now() + 5.0) == b"in"
    assert port.read(port.now()) == b""
    port.close()
    port.close()
    assert not port.is_open


def test_the_adapter_is_looked_at(
    terminal: tuple[int, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []
    monkeypatch.setattr(bus, "adapter_latency", lambda path: asked.append(path) or 0.004)
    opened = bus.BusPort(terminal[1], 1_000_000)
    assert opened.latency == 0.004
    assert asked == [terminal[1]]
    opened.close()


@pytest.mark.parametrize("what", ["fileno", "set_low_latency_mode"])
def test_what_fails_after_opening_gives_everything_back(
    terminal: tuple[int, str], monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    opened: list[serial.Serial] = []
    open_as_lock_went: list[bool] = []
    release = PortLock.release

    def fails(port: serial.Serial, *_: object) -> None:
        opened.append(port)
        raise KeyboardInterrupt

    def releases(lock: PortLock) -> None:
        open_as_lock_went.extend(port.is_open for port in opened)
        release(lock)

    with monkeypatch.context() as patched:
        patched.setattr(serial.Serial, what, fails)
        patched.setattr(PortLock, "release", releases)
        with pytest.raises(KeyboardInterrupt):
            SerialPort(terminal[1], 1_000_000)
    assert [port.is_open for port in opened] == [False]
    assert open_as_lock_went == [False]  # who waits for the lock then finds the port free
    SerialPort(terminal[1], 1_000_000).close()


def test_unusual_baud_rates(terminal: tuple[int, str]) -> None:
    port = SerialPort(terminal[1], 57_600)
    port.set_baud(1_234_567)
    assert port.baud == 1_234_567
    with pytest.raises(PortError, match="does not take -1 baud"):
        port.set_baud(-1)
    port.close()


@pytest.mark.fault(13)
def test_no_such_port() -> None:
    with pytest.raises(PortError, match="/dev/nothing does not exist: plug"):
        SerialPort("/dev/nothing", 1_000_000)


@pytest.mark.fault(12)
@pytest.mark.timeout(20)
def test_a_port_that_hangs_up_while_bytes_are_gathered(terminal: tuple[int, str]) -> None:
    master, path = terminal
    with contextlib.closing(SerialPort(path, 1_000_000)) as port:
        os.write(master, b"begin")
        assert port.gather(5, port.now()) == b"begin"
        os.close(master)
        with pytest.raises(PortLostError, match="was lost while in use"):
            port.gather(10, port.now() + 0.01)


@pytest.mark.fault(13)
def test_no_permission(terminal: tuple[int, str], monkeypatch: pytest.MonkeyPatch) -> None:
    # made up, for the user who runs the tests may be allowed everything
    def refuse(*_: object, **__: object) -> None:
        raise serial.SerialException(errno.EACCES, "could not open port")

    monkeypatch.setattr(serial, "Serial", refuse)
    with pytest.raises(PortError, match="may not be opened by this user: join the group"):
        SerialPort(terminal[1], 1_000_000)
    monkeypatch.undo()
    SerialPort(terminal[1], 1_000_000).close()  # its lock was given back


def test_a_file_is_no_serial_port(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("")
    with pytest.raises(PortError, match="cannot be used as a serial port"):
        SerialPort(str(file), 1_000_000)


def test_a_port_that_is_ours_already(terminal: tuple[int, str], tmp_path: Path) -> None:
    link = tmp_path / "link"
    link.symlink_to(terminal[1])
    port = SerialPort(terminal[1], 1_000_000)
    with pytest.raises(PortError, match=f"is taken by process {os.getpid()}: end it first"):
        SerialPort(str(link), 1_000_000)
    port.close()
    SerialPort(str(link), 1_000_000).close()


@pytest.mark.fault(40)
def test_a_port_that_a_stranger_has_locked(terminal: tuple[int, str]) -> None:
    stranger = serial.Serial(terminal[1], 57_600, exclusive=True)
    with pytest.raises(PortError, match="taken by another program"):
        SerialPort(terminal[1], 1_000_000)
    stranger.close()


HOLDER = """
import sys
from armsyn.driver.port_lock import PortLock
lock = PortLock(sys.argv[1])
print("held", flush=True)
sys.stdin.read()
"""


@pytest.mark.fault(40)
def test_another_process_and_its_death(tmp_path: Path) -> None:
    port = str(tmp_path / "port")
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER, port], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == b"held\n"
        with pytest.raises(PortError, match=f"taken by process {holder.pid}"):
            PortLock(port)
        holder.kill()
        holder.wait()
        lock = PortLock(port)  # the dead hold nothing
    assert lock.path.exists()
    lock.release()
    lock.release()
    assert not lock.path.exists()


def test_looking_who_holds_a_port_takes_nothing(tmp_path: Path) -> None:
    port = str(tmp_path / "port")
    assert look(port) is None
    assert not lock_file(port).exists()
    held = PortLock(port)
    assert f"is taken by process {os.getpid()}" in str(look(port))
    assert held.path.read_text() == f"{os.getpid()}\n"
    held.release()
    assert look(port) is None


def test_a_port_that_is_being_closed_is_asked_for_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    port = str(tmp_path / "port")
    held = PortLock(port)
    naps: list[float] = []

    def nap(seconds: float) -> None:
        naps.append(seconds)
        if len(naps) == 2:
            held.release()

    monkeypatch.setattr("armsyn.driver.port_lock.time.sleep", nap)
    PortLock(port).release()
    assert len(naps) == 2


@pytest.fixture
def anothers_files(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lock files are another user's: they can be read, but not be written."""
    # made up, for the user who runs the tests may be allowed everything
    original = os.open

    def refuse(path: object, flags: int, *mode: int) -> int:
        if flags & os.O_RDWR and str(path).endswith(".lock"):
            raise PermissionError(errno.EACCES, "Permission denied")
        return original(path, flags, *mode)  # type: ignore[arg-type]

    monkeypatch.setattr(os, "open", refuse)


@pytest.mark.usefixtures("anothers_files")
def test_a_lock_that_another_user_left_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    port = "/dev/ttyUSB9"
    lock = tmp_path / "armsyn-dev-ttyUSB9.lock"
    lock.write_text("123\n")
    with pytest.raises(PortError) as caught:
        PortLock(port)
    message = str(caught.value)
    assert f"{lock} was left behind by another user's program" in message
    assert message.endswith("have its owner (or root) remove the file")
    lock.unlink()
    with pytest.raises(PortError, match=f"may not open {lock}; have it removed"):
        PortLock(port)


def test_a_lock_that_another_user_holds(tmp_path: Path, request: pytest.FixtureRequest) -> None:
    port = str(tmp_path / "port")
    held = PortLock(port)
    request.getfixturevalue("anothers_files")
    with pytest.raises(PortError, match=f"is taken by process {os.getpid()}: end it first"):
        PortLock(port)
    held.release()


def test_a_port_that_takes_no_more_bytes(
    terminal: tuple[int, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serial_port, "WRITE_MARGIN", 0.02)
    port = SerialPort(terminal[1], 4_000_000)  # whose other end nobody reads
    with given_up_after(20.0), pytest.raises(PortLostError) as caught:
        port.write(bytes(100_000))
    message = str(caught.value)
    assert f"port {terminal[1]} takes no more bytes (" in message
    assert "\n" not in message
    port.close()


def test_a_port_that_is_full_for_a_while(terminal: tuple[int, str]) -> None:
    master, path = terminal
    port = SerialPort(path, 1_000_000)
    received = bytearray()

    def read_all() -> None:
        while len(received) < 200_000:
            received.extend(os.read(master, 4096))

    reader = threading.Thread(target=read_all, daemon=True)
    reader.start()
    sent = bytes(range(250)) * 800
    port.write(sent)
    reader.join()
    assert received == sent
    port.close()


@contextlib.contextmanager
def given_up_after(seconds: float) -> Iterator[None]:
    """Fail instead of hanging."""

    def give_up(*_: object) -> None:
        raise AssertionError("it hangs")

    previous = signal.signal(signal.SIGALRM, give_up)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, previous)


@pytest.mark.fault(12)
def test_a_port_that_hangs_up(terminal: tuple[int, str]) -> None:
    master, path = terminal
    port = SerialPort(path, 1_000_000)
    os.close(master)
    with pytest.raises(PortLostError, match="lost while in use"):
        port.read(port.now() + 5.0)
    with pytest.raises(PortLostError):
        port.write(b"x")
    port.close()
